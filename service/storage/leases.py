"""Leases: which process works on a row.

Several services may share a database, and one at a time works on a row: it holds a lease on it, and
renews it. When the lease has run out, the process is taken for dead, and another one takes the row.
If it was only slow, it finds its lease gone.
"""

from __future__ import annotations

import uuid
from collections.abc import Sequence
from typing import Any, Generic, TypeVar

from sqlalchemy import ColumnElement, Float, Select, and_, or_, select, update
from sqlalchemy.ext.compiler import compiles
from sqlalchemy.sql.functions import FunctionElement

from service.storage.store import Store
from service.storage.tables import LeasedRow
from synthesis.design.identity import ENGINE_NUMBER

Row = TypeVar("Row", bound=LeasedRow)
CLOCK_S = 1.0  # by which a clock is set back without notice, as it is trimmed [s]


class Now(FunctionElement[float]):
    """Seconds since 1970 by the database's clock, the only one that all processes share."""

    type = Float()
    inherit_cache = True
    name = "seconds_now"


@compiles(Now, "postgresql")
def _in_postgresql(*_: Any, **__: Any) -> str:
    return "cast(extract(epoch from clock_timestamp()) as double precision)"


@compiles(Now, "sqlite")
def _in_sqlite(*_: Any, **__: Any) -> str:
    return "(julianday('now') - 2440587.5) * 86400.0"


class Leases(Generic[Row]):
    """The leases of this process on rows of a table; every method is one transaction.

    ``process`` names this one in them; ``lease_s`` is how long one lasts unless renewed [s], the
    same for all services of a database.
    Only rows in a state of ``under_way`` are worked on, and none that a later engine began: what
    it has computed so far and what this one would add are not of one engine.
    """

    def __init__(
        self, rows: type[Row], under_way: Sequence[str], store: Store, lease_s: float
    ) -> None:
        self._rows, self._do, self.lease_s = rows, store.do, lease_s
        self._longest_s = lease_s
        self.process = uuid.uuid4().hex
        self._under_way = and_(rows.state.in_(under_way), rows.engine <= ENGINE_NUMBER)

    @property
    def _is_unleased(self) -> ColumnElement[bool]:
        """That no living process holds the lease.

        One that ends later than any could that is taken now was taken before the clock was set
        back: who holds it is dead, or renews it within moments.
        """
        until = self._rows.leased_until
        latest = Now() + self._longest_s + CLOCK_S
        return or_(self._rows.leased_by.is_(None), until < Now(), until > latest)

    async def take(self, sequence: int) -> bool:
        """Take the lease of a row that no living process holds; whether it was got."""
        change = update(self._rows).where(
            self._rows.sequence == sequence,
            self._under_way,
            or_(self._rows.leased_by == self.process, self._is_unleased),
        )
        change = change.values(leased_by=self.process, leased_until=Now() + self.lease_s)
        taken = change.returning(self._rows.sequence)
        return await self._do(lambda session: session.scalar(taken)) is not None

    async def renew(self) -> set[int]:
        """Renew all leases; the rows that are still held. The others ended, or are another's."""
        change = update(self._rows).where(self._rows.leased_by == self.process, self._under_way)
        change = change.values(leased_until=Now() + self.lease_s)
        held = change.returning(self._rows.sequence)
        return await self._do(lambda session: set(session.scalars(held)))

    async def release(self, sequence: int | None = None) -> None:
        """Give the lease of a row back; without one, all."""
        own = update(self._rows).where(self._rows.leased_by == self.process)
        if sequence is not None:
            own = own.where(self._rows.sequence == sequence)
        change = own.values(leased_by=None, leased_until=None)
        await self._do(lambda session: session.execute(change))

    async def unleased_rows(self) -> Sequence[Row]:
        """Rows under way that no living process works on."""
        query: Select[Row] = select(self._rows).where(self._under_way, self._is_unleased)
        query = query.order_by(self._rows.sequence)
        return await self._do(lambda session: session.scalars(query).all())
