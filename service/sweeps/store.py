"""Sweeps and their finished items in the store. What has no row has still to be done.

A process that has lost its lease on a sweep writes nothing more.
"""

from __future__ import annotations

import hashlib
import json
import zlib
from collections.abc import AsyncIterator, Iterable, Mapping, Sequence
from datetime import UTC, datetime
from typing import Any

from sqlalchemy import ColumnElement, bindparam, delete, insert, select, update
from sqlalchemy.orm import Session, defer

from service.storage.answers import charge
from service.storage.leases import Leases
from service.storage.store import LeaseLost, Store, find_or_add, select_newest
from service.storage.tables import AnswerRow, ItemRow, StrikeRow, SweepRow
from service.sweeps.tasks import ItemAnswer

STATUSES = ("optimal", "feasible", "unsolved", "infeasible", "failed")
UNDER_WAY = ("accepted", "running")
PAGE = 1000  # items read at once for events, tables and fronts: some MB at most
Done = tuple[ItemAnswer, list[Any]]  # an answer, and the values that the axes had
WITHOUT_SPEC = defer(SweepRow.spec)
WITHOUT_DESIGN = defer(ItemRow.design)
# Asked for every new design; built once, as in `service.storage.answers`.
ITEM_OF_DESIGN = select(ItemRow, SweepRow.engine).where(ItemRow.sweep == SweepRow.sequence)
ITEM_OF_DESIGN = ITEM_OF_DESIGN.where(ItemRow.design_id == bindparam("id")).limit(1)
OWN_ITEM_OF_DESIGN = ITEM_OF_DESIGN.where(SweepRow.belongs_to == bindparam("owner"))


class SweepStore(Leases[SweepRow]):
    """The sweeps, and this process's leases on them; every method is one transaction."""

    def __init__(self, store: Store, lease_s: float) -> None:
        super().__init__(SweepRow, UNDER_WAY, store, lease_s)

    async def accept(self, row: SweepRow) -> SweepRow:
        """Keep a sweep; where there is one with its id, that one, which continues if dismissed."""

        def work(session: Session) -> SweepRow:
            existing = find_or_add(session, row)
            if existing.state == "dismissed":
                existing.state, existing.finished = "accepted", None
            return existing

        return await self._do(work)

    async def find(self, name: str, owner: str | None) -> SweepRow | None:
        """The sweep with this id, if it belongs to the owner (None: in any case)."""
        query = select(SweepRow).where(SweepRow.id == name, *_belonging_to(owner))
        return await self._do(lambda s: s.scalar(query))

    async def page(
        self, before: int | None, size: int, state: str | None, owner: str
    ) -> Sequence[SweepRow]:
        """An owner's sweeps from the newest on, without their specs."""
        query = select_newest(SweepRow, before, size, state=state, belongs_to=owner)
        query = query.options(WITHOUT_SPEC)
        return await self._do(lambda session: session.scalars(query).all())

    async def done_numbers(self, sweep: int) -> set[int]:
        """Which items of a sweep are finished."""
        query = select(ItemRow.number).filter_by(sweep=sweep)
        return await self._do(lambda session: set(session.scalars(query)))

    async def strikes(self, sweep: int) -> dict[int, int]:
        """Items of a sweep that have killed workers, and how many."""
        query = select(StrikeRow).filter_by(sweep=sweep)
        rows = await self._do(lambda session: session.scalars(query).all())
        return {row.number: row.strikes for row in rows}

    async def keep_strikes(self, sweep: int, strikes: Mapping[int, int]) -> None:
        """Keep how many workers these items have killed."""

        def work(session: Session) -> None:
            for number, count in strikes.items():
                session.merge(StrikeRow(sweep=sweep, number=number, strikes=count))

        await self._do(work)

    async def start(self, sweep: int) -> None:
        """Mark a sweep as running."""
        change = update(SweepRow).filter_by(sequence=sweep, state="accepted")
        now = datetime.now(UTC)
        await self._do(lambda s: s.execute(change.values(state="running", started=now)))

    async def record(self, sweep: int, done: Iterable[Done]) -> SweepRow:
        """Keep finished items and count them; those kept already stay.

        LeaseLost where the sweep is not this process's any more.
        """
        rows = {
            answer.number: {**vars(answer), "sweep": sweep, "axis_values": values}
            for answer, values in done
        }

        def work(session: Session) -> SweepRow:
            whole = session.get(SweepRow, sweep, options=[WITHOUT_SPEC], with_for_update=True)
            if whole is None or whole.leased_by != self.process:
                raise LeaseLost
            finished = select(ItemRow.number).where(
                ItemRow.sweep == sweep, ItemRow.number.in_(list(rows))
            )
            known = set(session.scalars(finished))
            new = [row for number, row in rows.items() if number not in known]
            if new:
                session.execute(insert(ItemRow), new)
                charge(session, whole.belongs_to, sum(row["seconds"] for row in new))
            for status in STATUSES:
                more = sum(row["status"] == status for row in new)
                setattr(whole, status, getattr(whole, status) + more)
            names = dict.fromkeys(
                [*whole.quantities, *(q for row in new for q in row["quantities"])]
            )
            if len(names) > len(whole.quantities):
                whole.quantities = list(names)
            return whole

        return await self._do(work)

    async def end(self, sweep: int, state: str) -> SweepRow | None:
        """Mark a running sweep as ended; None where it was not running, or is deleted.

        Another process that works on it writes nothing more.
        """

        def work(session: Session) -> SweepRow | None:
            whole = session.get(SweepRow, sweep, with_for_update=True)
            if whole is None or whole.state not in UNDER_WAY:
                return None
            whole.state, whole.finished = state, datetime.now(UTC)
            if whole.leased_by != self.process:
                whole.leased_by = whole.leased_until = None
            return whole

        return await self._do(work)

    async def delete(self, sweep: int) -> None:
        """Delete a sweep and its items."""

        def work(session: Session) -> None:
            for rows in (ItemRow, StrikeRow):
                session.execute(delete(rows).filter_by(sweep=sweep))
            session.execute(delete(SweepRow).filter_by(sequence=sweep))

        await self._do(work)

    async def items(
        self,
        sweep: int,
        *where: ColumnElement[bool],
        size: int | None = None,
        order: Any = ItemRow.sequence,
    ) -> Sequence[ItemRow]:
        """Finished items without their designs; by default in the order they were finished."""
        query = select(ItemRow).options(WITHOUT_DESIGN).where(ItemRow.sweep == sweep, *where)
        query = query.order_by(order).limit(size)
        return await self._do(lambda session: session.scalars(query).all())

    async def pages(self, sweep: int) -> AsyncIterator[Sequence[ItemRow]]:
        """All finished items in the order of their numbers, a page at a time."""
        above = -1
        while page := await self.items(
            sweep, ItemRow.number > above, size=PAGE, order=ItemRow.number
        ):
            yield page
            above = page[-1].number

    async def item(self, sweep: int, number: int) -> ItemRow | None:
        """One finished item with its design."""
        query = select(ItemRow).filter_by(sweep=sweep, number=number)
        return await self._do(lambda session: session.scalar(query))

    async def holder(self, design_id: str, owner: str) -> tuple[str, int] | None:
        """The owner's sweep that has this design, and as which item; None where none of his has."""
        query = select(SweepRow.id, ItemRow.number).where(
            ItemRow.sweep == SweepRow.sequence, ItemRow.design_id == design_id,
            *_belonging_to(owner),
        )  # fmt: skip
        row = await self._do(lambda session: session.execute(query).first())
        return None if row is None else (row[0], row[1])


def _belonging_to(owner: str | None) -> tuple[ColumnElement[bool], ...]:
    """That a sweep is this owner's; nothing for the service itself."""
    return () if owner is None else (SweepRow.belongs_to == owner,)


def design_of_item(session: Session, id: str, owner: str | None) -> AnswerRow | None:
    """The design with this id as an answer of its own, where it came out of a sweep of the owner's.

    None of ``owner``: of any.
    """
    query = ITEM_OF_DESIGN if owner is None else OWN_ITEM_OF_DESIGN
    row = session.execute(query, {"id": id, "owner": owner}).first()
    if row is None:
        return None
    item, engine = row
    body = zlib.decompress(item.design or b"")  # an item with the id of a design has the design
    design = json.loads(body)
    return AnswerRow(
        sequence=0,
        id=id,
        kind="/v1/designs",
        engine=engine,
        name=design["name"],
        created=datetime.now(UTC),
        state="done",
        status=item.status,
        spec=json.dumps(design["spec"]).encode(),
        body=body,
        etag=hashlib.sha256(body).hexdigest()[:32],
        summary={},
    )
