"""Leases: one process at a time works on a sweep.

Several services may share a database. The one that works on a sweep holds a lease on its row and
renews it. When the lease has run out, the process is taken for dead, and another one takes the
sweep. If it was only slow, it finds its lease gone, and writes nothing more.
"""

from __future__ import annotations

import uuid
from collections.abc import Sequence
from typing import Any

from sqlalchemy import ColumnElement, Float, or_, select, update
from sqlalchemy.ext.compiler import compiles
from sqlalchemy.sql.functions import FunctionElement

from service.storage.store import Store
from service.sweeps.store import UNDER_WAY, SweepRow


class _Now(FunctionElement[float]):
    """Seconds since 1970 by the database's clock, the only one that all processes share."""

    type = Float()
    inherit_cache = True
    name = "seconds_now"


@compiles(_Now, "postgresql")
def _in_postgresql(*_: Any, **__: Any) -> str:
    return "cast(extract(epoch from clock_timestamp()) as double precision)"


@compiles(_Now, "sqlite")
def _in_sqlite(*_: Any, **__: Any) -> str:
    return "(julianday('now') - 2440587.5) * 86400.0"


class Leases:
    """The leases that this process holds; every method is one transaction of the store's."""

    def __init__(self, store: Store, length_s: float) -> None:
        self._do, self.length_s = store.do, length_s
        self.owner = uuid.uuid4().hex

    async def take(self, sweep: int) -> bool:
        """Take the lease of a running sweep that no living process holds; whether it was got."""
        return await self._update(
            SweepRow.sequence == sweep,
            or_(SweepRow.owner == self.owner, _is_unowned()),
            owner=self.owner,
            leased_until=_Now() + self.length_s,
        )

    async def renew(self, sweep: int) -> bool:
        """Renew the lease; False where the sweep has ended or another process holds it."""
        return await self._update(
            SweepRow.sequence == sweep,
            SweepRow.owner == self.owner,
            leased_until=_Now() + self.length_s,
        )

    async def _update(self, *where: ColumnElement[bool], **values: Any) -> bool:
        change = update(SweepRow).where(SweepRow.state.in_(UNDER_WAY), *where).values(**values)
        change = change.returning(SweepRow.sequence)
        return await self._do(lambda session: session.scalar(change)) is not None

    async def release(self, sweep: int) -> None:
        """Give the lease back."""
        own = update(SweepRow).filter_by(sequence=sweep, owner=self.owner)
        await self._do(lambda session: session.execute(own.values(owner=None, leased_until=None)))

    async def unowned(self) -> Sequence[SweepRow]:
        """Running sweeps that no living process works on."""
        query = select(SweepRow).where(SweepRow.state.in_(UNDER_WAY), _is_unowned())
        return await self._do(lambda s: s.scalars(query.order_by(SweepRow.sequence)).all())


def _is_unowned() -> ColumnElement[bool]:
    return or_(SweepRow.owner.is_(None), SweepRow.leased_until < _Now())
