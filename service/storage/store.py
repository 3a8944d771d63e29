"""Answers by id: SQLite by default, PostgreSQL by URL, the same code for both."""

from __future__ import annotations

import asyncio
import math
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from sqlalchemy import (
    Engine,
    Select,
    create_engine,
    delete,
    event,
    func,
    literal,
    select,
    text,
    true,
    update,
)
from sqlalchemy.dialects import postgresql, sqlite
from sqlalchemy.exc import DBAPIError, IntegrityError, SQLAlchemyError
from sqlalchemy.orm import Session, defer, sessionmaker

from service.settings import Settings
from service.storage.migrations import migrate
from service.storage.tables import AnswerRow, HoldingRow, KeyRow, StoredRow, UsageRow
from service.wire.fair_queue import FairQueue
from service.wire.tracing import span

if TYPE_CHECKING:
    from service.wire.observe import Metrics

UNANSWERED = ("accepted", "failed")
# What an answer that has ended says of itself, and that nobody works on it any more.
ENDED = (
    "created", "state", "status", "body", "etag", "summary", "problem", "leased_by", "leased_until",
)  # fmt: skip
THREADS = 8  # and connections to PostgreSQL: requests wait for the workers, not for the store
PROBE_S = 1.0  # that a look at the database is good for: anyone may ask, and each look is a write
T = TypeVar("T")
Row = TypeVar("Row", bound=StoredRow)
Lookup = Callable[[Session, str, str | None], AnswerRow | None]


class LeaseLost(Exception):
    """Another process works on the row now, or it was dismissed or deleted."""


def _make_durable(connection: Any, _record: Any) -> None:
    """What is committed survives a loss of power; a lock is waited for [ms]."""
    for pragma in ("journal_mode=WAL", "synchronous=FULL", "busy_timeout=5000"):
        connection.execute(f"PRAGMA {pragma}")


class Store:
    """Every method is one transaction in a thread of its own: the event loop never waits."""

    def __init__(self, settings: Settings, metrics: Metrics | None = None) -> None:
        url, threads = settings.database, THREADS
        if url.get_backend_name() == "sqlite":
            if url.database:
                Path(url.database).absolute().parent.mkdir(parents=True, exist_ok=True)
            threads = 1  # it lets one write at a time
            self._engine = create_engine(url, connect_args={"check_same_thread": False})
            event.listen(self._engine, "connect", _make_durable)
        else:
            self._engine = create_engine(url, pool_pre_ping=True, pool_size=threads)
        self._session = sessionmaker(self._engine, expire_on_commit=False)
        self._threads = ThreadPoolExecutor(threads, "store")
        self._metrics = metrics
        self._queue = FairQueue(lambda: threads)
        self._kept_for = timedelta(hours=settings.idempotency_hours)
        self._probing, self._probed, self._works = asyncio.Lock(), -math.inf, False
        migrate(self._engine)

    @property
    def engine(self) -> Engine:
        """What connections to the database are had from."""
        return self._engine

    async def do(self, work: Callable[[Session], T]) -> T:
        """Run a function of a session as one transaction.

        It is run again where another process was first to add a row with the same key.
        """

        def transaction() -> T:
            with self._session.begin() as session:
                return work(session)

        loop = asyncio.get_running_loop()
        async with self._queue.turn():
            began = time.perf_counter()
            with span("store", **{"code.function.name": work.__qualname__}):
                try:
                    return await loop.run_in_executor(self._threads, transaction)
                except IntegrityError:
                    return await loop.run_in_executor(self._threads, transaction)
                except DBAPIError:
                    if self._metrics is not None:
                        self._metrics.store_failures.inc()
                    raise
                finally:
                    if self._metrics is not None:
                        self._metrics.store.observe(time.perf_counter() - began)

    async def works(self) -> bool:
        """Whether the database takes what is written, as of at most ``PROBE_S`` ago.

        A row is written with the value that it has: a full, read-only or damaged database answers
        `select 1` still, and SQLite opens no file for that.
        """
        async with self._probing:  # whoever asks meanwhile waits for the same look
            now = time.monotonic()
            if now >= self._probed + PROBE_S:
                write = text("update alembic_version set version_num = version_num")
                try:
                    await self.do(lambda session: session.execute(write))
                    self._works = True
                except SQLAlchemyError:
                    self._works = False
                self._probed = now
        return self._works

    async def body_of_key(self, owner: str, key: str, body_hash: str) -> str:
        """Hash of the body that an owner's Idempotency-Key came with first: this, if it is new."""

        def work(session: Session) -> str:
            now = datetime.now(UTC)
            session.execute(delete(KeyRow).where(KeyRow.created < now - self._kept_for))
            row = session.get(KeyRow, (owner, key))
            if row is None:
                row = KeyRow(owner=owner, key=key, body_hash=body_hash, created=now)
                session.add(row)
            return row.body_hash

        return await self.do(work)

    def dispose(self) -> None:
        """Close the connections to the database."""
        self._threads.shutdown()
        self._engine.dispose()


class Answers:
    """The answers of one kind; every method is one transaction of the store's.

    An ``owner`` sees the answers that he holds, as if there were no others: when he has asked is
    when they were created. None is the service itself, which sees all. ``elsewhere`` finds answers
    that are kept as part of others.
    """

    def __init__(self, kind: str, store: Store, elsewhere: Lookup | None = None) -> None:
        self._kind, self._do, self._elsewhere = kind, store.do, elsewhere

    async def find(self, id: str, owner: str | None) -> AnswerRow | None:
        """The answer with this id, if the owner holds it."""
        return await self._do(lambda session: self._find(session, id, owner))

    def _find(self, session: Session, id: str, owner: str | None) -> AnswerRow | None:
        if owner is None:
            row = session.scalar(select(AnswerRow).filter_by(id=id, kind=self._kind))
        else:
            found = session.execute(self._held(owner).where(AnswerRow.id == id)).first()
            row = None if found is None else _as_held(session, *found)
        if row is None and self._elsewhere is not None:
            return self._elsewhere(session, id, owner)
        return row

    def _held(self, owner: str) -> Select[AnswerRow, HoldingRow]:
        """The answers of this kind that an owner holds, with his holdings."""
        query = select(AnswerRow, HoldingRow).join(HoldingRow, HoldingRow.id == AnswerRow.id)
        return query.where(HoldingRow.owner == owner, HoldingRow.kind == self._kind)

    async def claim(self, id: str, owner: str) -> AnswerRow | None:
        """Let an owner hold the answer to a question that he has asked; the answer, if any."""

        def work(session: Session) -> AnswerRow | None:
            row = self._find(session, id, owner)
            if row is None:
                self._lock(session, id)
                if session.scalar(select(HoldingRow).filter_by(owner=owner, id=id)) is None:
                    now = datetime.now(UTC)
                    session.add(HoldingRow(owner=owner, id=id, kind=self._kind, created=now))
                    session.flush()
                row = self._find(session, id, owner)
            return row

        return await self._do(work)

    def _lock(self, session: Session, id: str) -> None:
        """Let nobody else begin or end to hold an answer until the transaction ends."""
        answer = select(AnswerRow.sequence).filter_by(id=id, kind=self._kind)
        session.execute(answer.with_for_update())

    async def first_owner(self, id: str) -> str:
        """Whoever was first to ask of those who hold it; "" where nobody does."""
        query = select(HoldingRow.owner).filter_by(id=id).order_by(HoldingRow.sequence).limit(1)
        return await self._do(lambda session: session.scalar(query)) or ""

    async def is_held(self, id: str, owner: str) -> bool:
        """Whether an owner has asked the question and not deleted it, answered or not."""
        query = select(HoldingRow.sequence).filter_by(owner=owner, id=id, kind=self._kind)
        return await self._do(lambda session: session.scalar(query)) is not None

    async def release(self, id: str, owner: str, seconds: float = 0.0) -> tuple[bool, bool, bool]:
        """Let an owner hold it no longer, and delete it where nobody else does.

        Whether he held it, whether others do, and whether there was an answer, or a question that
        was accepted. ``seconds``: that the core has worked on it so far; used by this owner if he
        was the last.
        """

        def work(session: Session) -> tuple[bool, bool, bool]:
            self._lock(session, id)
            own = delete(HoldingRow).filter_by(owner=owner, id=id, kind=self._kind)
            held = session.scalar(own.returning(HoldingRow.sequence)) is not None
            other = session.scalar(select(HoldingRow.sequence).filter_by(id=id).limit(1))
            kept = select(AnswerRow.sequence).filter_by(id=id, kind=self._kind)
            there = session.scalar(kept) is not None
            if held and other is None:
                if seconds:
                    charge(session, owner, seconds)
                session.execute(delete(AnswerRow).filter_by(id=id, kind=self._kind))
            return held, other is not None, there

        return await self._do(work)

    async def accept(self, row: AnswerRow) -> AnswerRow:
        """Keep a question; where there is one with its id, that one, asked again if it failed."""

        def work(session: Session) -> AnswerRow:
            existing = find_or_add(session, row)
            if existing.state in ("failed", "superseded"):
                existing.state, existing.created = row.state, row.created
                existing.problem, existing.strikes = None, 0
            return existing

        return await self._do(work)

    async def finish(self, row: AnswerRow, accepted: bool, seconds: float = 0.0) -> AnswerRow:
        """Keep an answer; one that is done already stays as it is.

        Args:
            accepted: whether its question is kept; LeaseLost where it has been deleted since.
            seconds: that the core took; they are used by whoever was first to ask.
        """

        def work(session: Session) -> AnswerRow:
            existing = find_or_add(session, row)
            if existing is row and accepted:
                raise LeaseLost
            if existing.state == "done" and existing is not row:
                return existing
            self._charge(session, row.id, seconds)
            for field in ENDED:
                setattr(existing, field, getattr(row, field))
            return existing

        return await self._do(work)

    async def fail(self, id: str, problem: dict[str, Any], seconds: float = 0.0) -> None:
        """Note why an accepted one failed, or failed again; nothing where it was never accepted."""
        change = update(AnswerRow).filter_by(id=id).where(AnswerRow.state.in_(UNANSWERED))
        change = change.values(state="failed", problem=problem, leased_by=None, leased_until=None)

        def work(session: Session) -> None:
            session.execute(change)
            self._charge(session, id, seconds)

        await self._do(work)

    async def add_strike(self, id: str) -> int:
        """Note that an accepted one has killed a worker; how many by now, 0 if not accepted."""
        change = update(AnswerRow).filter_by(id=id, state="accepted")
        change = change.values(strikes=AnswerRow.strikes + 1)
        strikes = change.returning(AnswerRow.strikes)
        return await self._do(lambda session: session.scalar(strikes)) or 0

    def _charge(self, session: Session, id: str, seconds: float) -> None:
        first = select(HoldingRow.owner, literal(_today()), literal(seconds)).filter_by(id=id)
        _add_usage(session, first.order_by(HoldingRow.sequence).limit(1))

    async def supersede(self, id: str, current: str) -> None:
        """Drop the answer of an earlier engine; its row still leads from its id to its question.

        Those who hold it hold the ``current`` one to their question as well.
        """
        change = update(AnswerRow).filter_by(id=id, kind=self._kind)
        change = change.values(
            state="superseded", body=None, problem=None, leased_by=None, leased_until=None
        )

        def work(session: Session) -> None:
            session.execute(change)
            known = set(session.scalars(select(HoldingRow.owner).filter_by(id=current)))
            for each in session.scalars(select(HoldingRow).filter_by(id=id, kind=self._kind)):
                if each.owner not in known:
                    session.add(
                        HoldingRow(
                            owner=each.owner, id=current, kind=self._kind, created=each.created
                        )
                    )

        await self._do(work)

    async def remove(self, id: str) -> bool:
        """Delete an answer that nobody holds; whether there was one."""

        def work(session: Session) -> bool:
            self._lock(session, id)
            if session.scalar(select(HoldingRow.sequence).filter_by(id=id).limit(1)) is not None:
                return False
            gone = delete(AnswerRow).filter_by(id=id, kind=self._kind)
            return session.scalar(gone.returning(AnswerRow.sequence)) is not None

        return await self._do(work)

    async def page(
        self, before: int | None, size: int, status: str | None, owner: str
    ) -> Sequence[AnswerRow]:
        """An owner's answers from the newest on, those with a smaller sequence than ``before``."""
        query = self._held(owner).where(AnswerRow.state != "superseded")
        query = query.options(defer(AnswerRow.body), defer(AnswerRow.spec))
        if status is not None:
            query = query.where(AnswerRow.status == status)
        if before is not None:
            query = query.where(HoldingRow.sequence < before)
        query = query.order_by(HoldingRow.sequence.desc()).limit(size)

        def work(session: Session) -> Sequence[AnswerRow]:
            found = session.execute(query).all()
            rows = [_as_held(session, *each) for each in found]
            for row, (_, holding) in zip(rows, found, strict=True):
                row.sequence = holding.sequence  # in line as he has asked
            return rows

        return await self._do(work)

    async def counts(self) -> dict[str, int]:
        """How many there are by status, or by state where they have none."""
        named = func.coalesce(AnswerRow.status, AnswerRow.state)
        query = select(named, func.count()).filter_by(kind=self._kind).group_by(named)
        query = query.where(AnswerRow.state != "superseded")
        return await self._do(lambda session: dict(session.execute(query).all()))


def _as_held(session: Session, row: AnswerRow, holding: HoldingRow) -> AnswerRow:
    """An answer as its holder sees it: created when he has asked."""
    session.expunge(row)  # so that what is set here is not written
    row.created = holding.created
    return row


def charge(session: Session, owner: str, seconds: float) -> None:
    """Note time in the core [s] as used by an owner today."""
    # Without a condition SQLite would take "on conflict" for one of a join.
    _add_usage(session, select(literal(owner), literal(_today()), literal(seconds)).where(true()))


def _today() -> str:
    return datetime.now(UTC).date().isoformat()


def _add_usage(session: Session, used: Select[Any, Any, Any]) -> None:
    """Add to what owners have used: rows of owner, day and seconds."""
    insert = postgresql.insert if session.get_bind().dialect.name == "postgresql" else sqlite.insert
    new = insert(UsageRow).from_select(["owner", "day", "core_seconds"], used)
    more = UsageRow.core_seconds + new.excluded.core_seconds
    change = new.on_conflict_do_update(index_elements=["owner", "day"], set_={"core_seconds": more})
    session.execute(change)


def select_newest(
    rows: type[Row], before: int | None, size: int, **wanted: str | None
) -> Select[Row]:
    """Rows with these values (None: any), from the newest on, those before a sequence number."""
    query = select(rows).order_by(rows.sequence.desc()).limit(size)
    query = query.filter_by(**{name: value for name, value in wanted.items() if value is not None})
    return query if before is None else query.where(rows.sequence < before)


def find_or_add(session: Session, row: Row) -> Row:
    """The row with this one's id, locked; this one where there was none."""
    existing = session.scalar(select(type(row)).filter_by(id=row.id).with_for_update())
    if existing is None:
        session.add(row)
        session.flush()
    return existing or row
