"""Answers by id, a table a kind: SQLite by default, PostgreSQL by URL, the same code for both."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any, Protocol, TypeVar

from sqlalchemy import (
    JSON,
    BigInteger,
    DateTime,
    Engine,
    Integer,
    LargeBinary,
    String,
    create_engine,
    delete,
    event,
    func,
    select,
    text,
    update,
)  # fmt: skip
from sqlalchemy.exc import IntegrityError
from sqlalchemy.orm import DeclarativeBase, Mapped, Session, defer, mapped_column, sessionmaker

from service.settings import Settings
from service.storage.migrations import migrate

T = TypeVar("T")


Lookup = Callable[[Session, str], "Row | None"]


class Do(Protocol):
    """Runs some work as one transaction."""

    async def __call__(self, work: Callable[[Session], T]) -> T: ...


class Base(DeclarativeBase):
    """The tables."""


class Row(Base):
    """One question with its answer: accepted, done or failed."""

    __abstract__ = True

    sequence: Mapped[int] = mapped_column(
        BigInteger().with_variant(Integer, "sqlite"), primary_key=True
    )
    id: Mapped[str] = mapped_column(String(64), unique=True)
    name: Mapped[str] = mapped_column(String(200))
    created: Mapped[datetime] = mapped_column(DateTime(timezone=True))
    state: Mapped[str] = mapped_column(String(16), index=True)
    status: Mapped[str | None] = mapped_column(String(16))
    spec: Mapped[bytes] = mapped_column(LargeBinary)
    design: Mapped[bytes | None] = mapped_column(LargeBinary)
    etag: Mapped[str | None] = mapped_column(String(64))
    summary: Mapped[dict[str, Any]] = mapped_column(JSON, default=dict)
    problem: Mapped[dict[str, Any] | None] = mapped_column(JSON)


class DesignRow(Row):
    """One design."""

    __tablename__ = "designs"


class CamSetRow(Row):
    """One set of cams; ``design`` holds the whole set."""

    __tablename__ = "cam_sets"


class AnalysisRow(Row):
    """One analysis of a given cam."""

    __tablename__ = "analyses"


class ProfileAnalysisRow(Row):
    """One motion read back from measured points."""

    __tablename__ = "profile_analyses"


class SixBarShaperRow(Row):
    """One six-bar shaper."""

    __tablename__ = "six_bar_shapers"


class PalletisingArmRow(Row):
    """One palletising arm."""

    __tablename__ = "palletising_arms"


class SpatialCamRow(Row):
    """One spatial cam."""

    __tablename__ = "spatial_cams"


class TrainResponseRow(Row):
    """One follower train on its cam."""

    __tablename__ = "train_responses"


class KeyRow(Base):
    """An Idempotency-Key: which body it came with, and which answer it led to."""

    __tablename__ = "idempotency_keys"

    key: Mapped[str] = mapped_column(String(255), primary_key=True)
    body_hash: Mapped[str] = mapped_column(String(64))
    design_id: Mapped[str] = mapped_column(String(64))
    created: Mapped[datetime] = mapped_column(DateTime(timezone=True), index=True)


class Store:
    """Every method is one transaction in a thread of its own: the event loop never waits."""

    def __init__(self, settings: Settings) -> None:
        self._engine = _connected(settings)
        self._session = sessionmaker(self._engine, expire_on_commit=False)
        threads = 1 if self._engine.dialect.name == "sqlite" else 8
        self._threads = ThreadPoolExecutor(threads, "store")
        self._kept_for = timedelta(hours=settings.idempotency_hours)
        migrate(self._engine)

    async def do(self, work: Callable[[Session], T]) -> T:
        """Some work as one transaction."""

        def transaction() -> T:
            with self._session.begin() as session:
                return work(session)

        return await asyncio.get_running_loop().run_in_executor(self._threads, transaction)

    async def reachable(self) -> bool:
        """Whether the database answers."""
        return await self.do(lambda session: session.execute(text("select 1")).scalar()) == 1

    def table(self, row: type[Row], elsewhere: Lookup | None = None) -> Table:
        """The answers of one kind; ``elsewhere`` finds those that are kept as part of others."""
        return Table(row, self.do, elsewhere)

    async def key(self, key: str, body_hash: str, design_id: str) -> KeyRow:
        """What the key stands for: what it was first used for, or this from now on."""

        def work(session: Session) -> KeyRow:
            now = datetime.now(UTC)
            session.execute(delete(KeyRow).where(KeyRow.created < now - self._kept_for))
            there = session.get(KeyRow, key)
            if there is None:
                there = KeyRow(key=key, body_hash=body_hash, design_id=design_id, created=now)
                session.add(there)
            return there

        try:
            return await self.do(work)
        except IntegrityError:
            return await self.do(work)

    def dispose(self) -> None:
        """Let go of the database."""
        self._threads.shutdown()
        self._engine.dispose()


class Table:
    """The answers of one kind; every method is one transaction of the store's."""

    def __init__(self, row: type[Row], do: Do, elsewhere: Lookup | None = None) -> None:
        self._row, self._do, self._elsewhere = row, do, elsewhere

    async def find(self, name: str) -> Row | None:
        """The answer with this id."""

        def work(session: Session) -> Row | None:
            found = session.scalar(select(self._row).filter_by(id=name))
            if found is None and self._elsewhere is not None:
                return self._elsewhere(session, name)
            return found

        return await self._do(work)

    async def put(self, row: Row) -> Row:
        """Keep an answer in place of what there was; one that is done already stays as it is."""

        def work(session: Session) -> Row:
            there = session.scalar(select(self._row).filter_by(id=row.id).with_for_update())
            if there is None:
                session.add(row)
                session.flush()
                return row
            if there.state != "done":
                for field in ("created", "state", "status", "design", "etag", "summary", "problem"):
                    setattr(there, field, getattr(row, field))
            return there

        try:
            return await self._do(work)
        except IntegrityError:  # another process was first
            return await self._do(work)

    async def fail(self, name: str, problem: dict[str, Any]) -> None:
        """Note why an accepted one failed; nothing where it was never accepted."""
        change = update(self._row).filter_by(id=name, state="accepted")
        await self._do(lambda s: s.execute(change.values(state="failed", problem=problem)))

    async def remove(self, name: str) -> bool:
        """Forget an answer; whether there was one."""
        gone = delete(self._row).filter_by(id=name).returning(self._row.sequence)
        return await self._do(lambda s: s.scalar(gone)) is not None

    async def page(self, before: int | None, size: int, status: str | None) -> Sequence[Row]:
        """Answers from the newest on, those with a smaller sequence than ``before``."""
        row = self._row
        listed = defer(row.design), defer(row.spec)
        asked = select(row).options(*listed).order_by(row.sequence.desc()).limit(size)
        if before is not None:
            asked = asked.where(row.sequence < before)
        if status is not None:
            asked = asked.filter_by(status=status)
        return await self._do(lambda session: session.scalars(asked).all())

    async def unfinished(self) -> Sequence[Row]:
        """What was accepted and is neither done nor failed."""
        asked = select(self._row).filter_by(state="accepted").order_by(self._row.sequence)
        return await self._do(lambda session: session.scalars(asked).all())

    async def counts(self) -> dict[str, int]:
        """How many there are by status, or by state where they have none."""
        named = func.coalesce(self._row.status, self._row.state)
        asked = select(named, func.count()).group_by(named)
        return await self._do(lambda session: dict(session.execute(asked).all()))


def _connected(settings: Settings) -> Engine:
    url = settings.database
    if url.get_backend_name() != "sqlite":
        return create_engine(url, pool_pre_ping=True, pool_size=8)
    if url.database:
        Path(url.database).absolute().parent.mkdir(parents=True, exist_ok=True)
    engine = create_engine(url, connect_args={"check_same_thread": False})
    event.listen(engine, "connect", _durable)
    return engine


def _durable(connection: Any, _record: Any) -> None:
    for pragma in ("journal_mode=WAL", "synchronous=FULL", "busy_timeout=5000"):
        connection.execute(f"PRAGMA {pragma}")
