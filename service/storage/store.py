"""Answers by id: SQLite by default, PostgreSQL by URL, the same code for both."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any, TypeVar

from sqlalchemy import Engine, Select, create_engine, delete, event, func, select, text, update
from sqlalchemy.exc import IntegrityError
from sqlalchemy.orm import Session, defer, sessionmaker

from service.settings import Settings
from service.storage.migrations import migrate
from service.storage.tables import AnswerRow, KeyRow, StoredRow

UNANSWERED = ("accepted", "failed")
# What an answer that has ended says of itself, and that nobody works on it any more.
ENDED = (
    "created", "state", "status", "body", "etag", "summary", "problem", "owner", "leased_until",
)  # fmt: skip
THREADS = 8  # and connections to PostgreSQL: requests wait for the workers, not for the store
T = TypeVar("T")
Row = TypeVar("Row", bound=StoredRow)
Lookup = Callable[[Session, str], AnswerRow | None]


class LeaseLost(Exception):
    """Another process works on the row now, or it was dismissed or deleted."""


def _make_durable(connection: Any, _record: Any) -> None:
    """What is committed survives a loss of power; a lock is waited for [ms]."""
    for pragma in ("journal_mode=WAL", "synchronous=FULL", "busy_timeout=5000"):
        connection.execute(f"PRAGMA {pragma}")


class Store:
    """Every method is one transaction in a thread of its own: the event loop never waits."""

    def __init__(self, settings: Settings) -> None:
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
        self._kept_for = timedelta(hours=settings.idempotency_hours)
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
        try:
            return await loop.run_in_executor(self._threads, transaction)
        except IntegrityError:
            return await loop.run_in_executor(self._threads, transaction)

    async def reachable(self) -> bool:
        """Whether the database answers."""
        return await self.do(lambda session: session.execute(text("select 1")).scalar()) == 1

    async def body_of_key(self, key: str, body_hash: str) -> str:
        """Hash of the body that an Idempotency-Key came with first: this one, if it is new."""

        def work(session: Session) -> str:
            now = datetime.now(UTC)
            session.execute(delete(KeyRow).where(KeyRow.created < now - self._kept_for))
            row = session.get(KeyRow, key)
            if row is None:
                row = KeyRow(key=key, body_hash=body_hash, created=now)
                session.add(row)
            return row.body_hash

        return await self.do(work)

    def dispose(self) -> None:
        """Close the connections to the database."""
        self._threads.shutdown()
        self._engine.dispose()


class Answers:
    """The answers of one kind; every method is one transaction of the store's.

    ``elsewhere`` finds answers that are kept as part of others.
    """

    def __init__(self, kind: str, store: Store, elsewhere: Lookup | None = None) -> None:
        self._kind, self._do, self._elsewhere = kind, store.do, elsewhere

    async def find(self, id: str) -> AnswerRow | None:
        """The answer with this id."""

        def work(session: Session) -> AnswerRow | None:
            row = session.scalar(select(AnswerRow).filter_by(id=id, kind=self._kind))
            if row is None and self._elsewhere is not None:
                return self._elsewhere(session, id)
            return row

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

    async def finish(self, row: AnswerRow, accepted: bool) -> AnswerRow:
        """Keep an answer; one that is done already stays as it is.

        ``accepted``: whether its question is kept; LeaseLost where it has been deleted since.
        """

        def work(session: Session) -> AnswerRow:
            existing = find_or_add(session, row)
            if existing is row and accepted:
                raise LeaseLost
            if existing.state != "done" and existing is not row:
                for field in ENDED:
                    setattr(existing, field, getattr(row, field))
            return existing

        return await self._do(work)

    async def fail(self, id: str, problem: dict[str, Any]) -> None:
        """Note why an accepted one failed, or failed again; nothing where it was never accepted."""
        change = update(AnswerRow).filter_by(id=id).where(AnswerRow.state.in_(UNANSWERED))
        change = change.values(state="failed", problem=problem, owner=None, leased_until=None)
        await self._do(lambda session: session.execute(change))

    async def add_strike(self, id: str) -> int:
        """Note that an accepted one has killed a worker; how many by now, 0 if not accepted."""
        change = update(AnswerRow).filter_by(id=id, state="accepted")
        change = change.values(strikes=AnswerRow.strikes + 1)
        strikes = change.returning(AnswerRow.strikes)
        return await self._do(lambda session: session.scalar(strikes)) or 0

    async def supersede(self, id: str) -> None:
        """Drop the answer of an earlier engine; its row still leads from its id to its question."""
        change = update(AnswerRow).filter_by(id=id, kind=self._kind)
        change = change.values(
            state="superseded", body=None, problem=None, owner=None, leased_until=None
        )
        await self._do(lambda s: s.execute(change))

    async def remove(self, id: str) -> bool:
        """Delete an answer; whether there was one."""
        gone = delete(AnswerRow).filter_by(id=id, kind=self._kind).returning(AnswerRow.sequence)
        return await self._do(lambda s: s.scalar(gone)) is not None

    async def page(self, before: int | None, size: int, status: str | None) -> Sequence[AnswerRow]:
        """Answers from the newest on, those with a smaller sequence than ``before``."""
        query = select_newest(AnswerRow, before, size, kind=self._kind, status=status)
        query = query.options(defer(AnswerRow.body), defer(AnswerRow.spec))
        query = query.where(AnswerRow.state != "superseded")
        return await self._do(lambda session: session.scalars(query).all())

    async def counts(self) -> dict[str, int]:
        """How many there are by status, or by state where they have none."""
        named = func.coalesce(AnswerRow.status, AnswerRow.state)
        query = select(named, func.count()).filter_by(kind=self._kind).group_by(named)
        query = query.where(AnswerRow.state != "superseded")
        return await self._do(lambda session: dict(session.execute(query).all()))


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
