"""Sweeps and their finished items in the store. What has no row has still to be done."""

from __future__ import annotations

import hashlib
import json
import zlib
from collections.abc import AsyncIterator, Iterable, Mapping, Sequence
from datetime import UTC, datetime
from typing import Any

from sqlalchemy import (
    JSON,
    BigInteger,
    ColumnElement,
    DateTime,
    Float,
    Index,
    Integer,
    LargeBinary,
    String,
    delete,
    insert,
    select,
    update,
)  # fmt: skip
from sqlalchemy.orm import Mapped, Session, defer, mapped_column

from service.storage.store import AnswerRow, Base, Kept, Store, find_or_add, newest
from service.sweeps.tasks import ItemAnswer

STATUSES = ("optimal", "feasible", "infeasible", "failed")
UNDER_WAY = ("accepted", "running")
PAGE = 1000  # items that are read at once for tables and fronts
Done = tuple[ItemAnswer, list[Any]]  # an answer, and the values that the axes had


class SweepRow(Kept):
    """One sweep, with how many of its items came out how."""

    __tablename__ = "sweeps"

    started: Mapped[datetime | None] = mapped_column(DateTime(timezone=True))
    finished: Mapped[datetime | None] = mapped_column(DateTime(timezone=True))
    state: Mapped[str] = mapped_column(String(16), index=True)
    size: Mapped[int] = mapped_column(Integer)
    axes: Mapped[list[str]] = mapped_column(JSON)
    quantities: Mapped[list[str]] = mapped_column(JSON)
    optimal: Mapped[int] = mapped_column(Integer, default=0)
    feasible: Mapped[int] = mapped_column(Integer, default=0)
    infeasible: Mapped[int] = mapped_column(Integer, default=0)
    failed: Mapped[int] = mapped_column(Integer, default=0)
    owner: Mapped[str | None] = mapped_column(String(64))
    leased_until: Mapped[float | None] = mapped_column(Float)

    @property
    def done(self) -> int:
        """Items that are finished, whatever came out."""
        return self.optimal + self.feasible + self.infeasible + self.failed


class ItemRow(Base):
    """One finished item; ``sequence`` is the order in which they were finished."""

    __tablename__ = "sweep_items"
    __table_args__ = (
        Index("ix_sweep_items_number", "sweep", "number", unique=True),
        Index("ix_sweep_items_sequence", "sweep", "sequence"),
        Index("ix_sweep_items_status", "sweep", "status", "sequence"),
    )

    sequence: Mapped[int] = mapped_column(
        BigInteger().with_variant(Integer, "sqlite"), primary_key=True
    )
    sweep: Mapped[int] = mapped_column(BigInteger)
    number: Mapped[int] = mapped_column(Integer)
    status: Mapped[str] = mapped_column(String(16))
    axis_values: Mapped[list[Any]] = mapped_column(JSON)
    quantities: Mapped[dict[str, float]] = mapped_column(JSON)
    gap: Mapped[float | None] = mapped_column(Float)
    seconds: Mapped[float] = mapped_column(Float)
    design_id: Mapped[str | None] = mapped_column(String(64), index=True)
    design: Mapped[bytes | None] = mapped_column(LargeBinary)
    problem: Mapped[dict[str, Any] | None] = mapped_column(JSON)


class StrikeRow(Base):
    """How many workers an item has killed."""

    __tablename__ = "sweep_strikes"

    sweep: Mapped[int] = mapped_column(BigInteger, primary_key=True, autoincrement=False)
    number: Mapped[int] = mapped_column(Integer, primary_key=True, autoincrement=False)
    strikes: Mapped[int] = mapped_column(Integer)


UNREAD = defer(SweepRow.spec)
LISTED = defer(ItemRow.design)


class LeaseLost(Exception):
    """Another process works on the sweep now, or it was dismissed or deleted."""


class SweepStore:
    """Every method is one transaction of the store's."""

    def __init__(self, store: Store) -> None:
        self._do = store.do

    async def accept(self, row: SweepRow) -> SweepRow:
        """Keep a sweep; where there is one with its id, that one, which continues if dismissed."""

        def work(session: Session) -> SweepRow:
            there = find_or_add(session, row)
            if there.state == "dismissed":
                there.state, there.finished = "accepted", None
            return there

        return await self._do(work)

    async def find(self, name: str) -> SweepRow | None:
        """The sweep with this id."""
        return await self._do(lambda s: s.scalar(select(SweepRow).filter_by(id=name)))

    async def page(self, before: int | None, size: int, state: str | None) -> Sequence[SweepRow]:
        """Sweeps from the newest on, without their specs."""
        query = newest(SweepRow, before, size, state=state).options(UNREAD)
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

    async def record(self, sweep: int, owner: str, done: Iterable[Done]) -> SweepRow:
        """Keep finished items and count them, in one transaction; those kept already stay.

        Raises:
            LeaseLost: the sweep is not this owner's any more.
        """
        rows = {answer.number: _row(sweep, answer, values) for answer, values in done}

        def work(session: Session) -> SweepRow:
            whole = session.get(SweepRow, sweep, options=[UNREAD], with_for_update=True)
            if whole is None or whole.owner != owner:
                raise LeaseLost
            there = select(ItemRow.number).where(
                ItemRow.sweep == sweep, ItemRow.number.in_(list(rows))
            )
            known = set(session.scalars(there))
            new = [row for number, row in rows.items() if number not in known]
            if new:
                session.execute(insert(ItemRow), new)
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

    async def end(self, sweep: int, state: str, owner: str | None = None) -> SweepRow | None:
        """Mark a running sweep as ended; None where it was not running, or is deleted.

        A process other than ``owner`` that works on it writes nothing more.
        """

        def work(session: Session) -> SweepRow | None:
            whole = session.get(SweepRow, sweep, with_for_update=True)
            if whole is None or whole.state not in UNDER_WAY:
                return None
            whole.state, whole.finished = state, datetime.now(UTC)
            if whole.owner != owner:
                whole.owner = whole.leased_until = None
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
        query = select(ItemRow).options(LISTED).where(ItemRow.sweep == sweep, *where)
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

    async def holder(self, design_id: str) -> tuple[str, int] | None:
        """The sweep that has this design, and as which item; None where no sweep has."""
        query = select(SweepRow.id, ItemRow.number).join(
            ItemRow, ItemRow.sweep == SweepRow.sequence
        )
        query = query.where(ItemRow.design_id == design_id).limit(1)
        row = await self._do(lambda session: session.execute(query).first())
        return None if row is None else (row[0], row[1])


def _row(sweep: int, answer: ItemAnswer, values: list[Any]) -> dict[str, Any]:
    fields = {name: value for name, value in vars(answer).items() if name != "warm_start"}
    return {**fields, "sweep": sweep, "axis_values": values}


def design_of_item(session: Session, id: str) -> AnswerRow | None:
    """The design with this id as an answer of its own, where it came out of a sweep."""
    row = session.execute(
        select(ItemRow, SweepRow.engine)
        .join(SweepRow, ItemRow.sweep == SweepRow.sequence)
        .where(ItemRow.design_id == id)
        .limit(1)
    ).first()
    if row is None:
        return None
    item, engine = row
    if item.design is None:
        return None
    body = zlib.decompress(item.design)
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
