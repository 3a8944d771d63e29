"""The database: SQLite by default, PostgreSQL by URL, the same code for both."""

from __future__ import annotations

import asyncio
import logging
import math
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from datetime import UTC, datetime, timedelta
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from sqlalchemy import Engine, Select, bindparam, create_engine, delete, event, select, text
from sqlalchemy.exc import DBAPIError, IntegrityError, SQLAlchemyError
from sqlalchemy.orm import Session, sessionmaker

from service.settings import Settings
from service.storage.migrations import migrate
from service.storage.tables import AnswerRow, KeyRow, StoredRow
from service.wire.errors import is_damage
from service.wire.fair_queue import FairQueue
from service.wire.tracing import span

if TYPE_CHECKING:
    from service.wire.observe import Metrics

log = logging.getLogger("camwright.store")
THREADS = 8  # and connections to PostgreSQL: requests wait for the workers, not for the store
DAMAGED_S = 60.0  # that health tells of a damaged page: probes and alarms come more often
PROBE_S = 1.0  # that a look at the database is good for: anyone may ask, and each look is a write
# Settings of PostgreSQL; with any of them off a loss of power takes what was acknowledged with it.
LASTING = ("fsync", "full_page_writes", "synchronous_commit")
T = TypeVar("T")
Row = TypeVar("Row", bound=StoredRow)
Lookup = Callable[[Session, str, str | None], AnswerRow | None]


class LeaseLost(Exception):
    """Another process works on the row now, or it was dismissed or deleted."""


def _keep_a_log(connection: Any, _record: Any) -> None:
    """What is committed is appended to a log; a lock is waited for [ms]."""
    for pragma in ("journal_mode=WAL", "busy_timeout=5000"):
        connection.execute(f"PRAGMA {pragma}")


def _sync(connection: Any, *_: Any) -> None:
    """Transactions are kept through a loss of power, unless one says otherwise: see ``relax``."""
    connection.execute("PRAGMA synchronous=FULL")


def relax(session: Session) -> None:
    """Let a transaction end before the disk has it; called before anything is written in it.

    It outlives the process, but perhaps not a loss of power, unless a later transaction does. For
    what nobody is told of.
    """
    sqlite = session.get_bind().dialect.name == "sqlite"
    how = "PRAGMA synchronous=NORMAL" if sqlite else "SET LOCAL synchronous_commit = off"
    session.connection().exec_driver_sql(how)


def _tell_what_does_not_last(engine: Engine) -> None:
    """Warn of a PostgreSQL that does not wait for its disk; SQLite is told to at every checkout."""
    with engine.connect() as connection:
        values = {name: connection.exec_driver_sql(f"show {name}").scalar() for name in LASTING}
    if off := [name for name, value in values.items() if value == "off"]:
        log.warning(
            "what is acknowledged may be lost with the power: PostgreSQL has %s off",
            " and ".join(off),
        )


class Store:
    """Every method is one transaction in a thread of its own: the event loop never waits."""

    def __init__(self, settings: Settings, metrics: Metrics | None = None) -> None:
        url, threads = settings.database, THREADS
        if url.get_backend_name() == "sqlite":
            if url.database:
                Path(url.database).absolute().parent.mkdir(parents=True, exist_ok=True)
            threads = 1  # it lets one write at a time
            self._engine = create_engine(url, connect_args={"check_same_thread": False})
            event.listen(self._engine, "connect", _keep_a_log)
            event.listen(self._engine, "checkout", _sync)
        else:
            self._engine = create_engine(url, pool_pre_ping=True, pool_size=threads)
        self._session = sessionmaker(self._engine, expire_on_commit=False)
        self._threads = ThreadPoolExecutor(threads, "store")
        self._metrics = metrics
        self._queue = FairQueue(lambda: threads)
        self._kept_for = timedelta(hours=settings.idempotency_hours)
        self._probing, self._probed, self._works = asyncio.Lock(), -math.inf, False
        self._damaged = -math.inf  # when it was last found damaged
        migrate(self._engine)
        if url.get_backend_name() == "postgresql":
            _tell_what_does_not_last(self._engine)

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
        began = time.perf_counter()
        async with self._queue.turn():
            with span("store", **{"code.function.name": work.__qualname__}):
                try:
                    return await loop.run_in_executor(self._threads, transaction)
                except IntegrityError:
                    return await loop.run_in_executor(self._threads, transaction)
                except DBAPIError as error:
                    if is_damage(error):
                        log.error("the database is damaged: %s", error.orig)
                        self._damaged = time.monotonic()
                    if self._metrics is not None:
                        self._metrics.store_failures.inc()
                    raise
                finally:
                    if self._metrics is not None:
                        self._metrics.store.observe(time.perf_counter() - began)

    async def works(self) -> bool:
        """Whether the database takes what is written, as of at most ``PROBE_S`` ago.

        A row is written with the value that it has: a full, read-only or damaged database answers
        `select 1` still, and SQLite opens no file for that. A damaged page is where nobody looks:
        once one was met, the database counts as damaged for ``DAMAGED_S``.
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
        return self._works and now >= self._damaged + DAMAGED_S

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


def select_newest(
    rows: type[Row], before: int | None, size: int, **wanted: str | None
) -> Select[Row]:
    """Rows with these values (None: any), from the newest on, those before a sequence number."""
    query = select(rows).order_by(rows.sequence.desc()).limit(size)
    query = query.filter_by(**{name: value for name, value in wanted.items() if value is not None})
    return query if before is None else query.where(rows.sequence < before)


def find_or_add(session: Session, row: Row) -> Row:
    """The row with this one's id, locked; this one where there was none."""
    existing: Row | None = session.scalar(_locked(type(row)), {"id": row.id})
    if existing is None:
        session.add(row)
        session.flush()
    return existing or row


@cache
def _locked(rows: type[Row]) -> Any:
    """The row with an id, locked; built once, as in `service.storage.answers`."""
    return select(rows).where(rows.id == bindparam("id")).with_for_update()
