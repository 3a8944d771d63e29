"""What this process works on, under leases: questions and sweeps alike.

A row that was accepted is worked on until it has ended. Its lease is renewed meanwhile; when it is
lost, because the row was deleted or another process has taken it, work on it stops. Rows that no
living process works on are adopted: at the start, and whenever a lease has run out.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Awaitable, Callable
from typing import Any, Generic, Protocol, TypeVar

from sqlalchemy.exc import (
    DataError,
    DBAPIError,
    IntegrityError,
    NotSupportedError,
    ProgrammingError,
)

from service.storage.leases import Leases, Row

log = logging.getLogger("camwright.work")
T = TypeVar("T")
POLL_S = 1.0  # between looks at rows that no process, or another one, works on
RENEWAL_S = 0.5  # at most, between renewals: a row that was deleted elsewhere is noticed by then
RETRY_S = 0.5  # after the engine or the store could not be reached
STRIKES = 3  # workers that a question may kill, until it is given up
NOT_THE_STORE = (DataError, IntegrityError, NotSupportedError, ProgrammingError)


async def retry_transaction(transaction: Callable[[], Awaitable[T]]) -> T:
    """The result of a transaction; where the store fails, of one of the next.

    The store may be away, full, read-only or damaged: what is at hand waits until somebody has
    mended it. A transaction that has begun is not interrupted.
    """
    while True:
        running = asyncio.ensure_future(transaction())
        try:
            return await asyncio.shield(running)
        except asyncio.CancelledError:
            await asyncio.wait({running})
            raise
        except DBAPIError as error:
            if isinstance(error, NOT_THE_STORE):
                raise
            log.error("the store fails, and work waits for it: %s", error.orig)
            await asyncio.sleep(RETRY_S)


class Runner(Protocol):
    """The work on one row: ``task`` does it. ``sequence``: the row's number in its table, which the
    lease is of; its ``id`` is that of the question, which a deleted row and a new one share.
    """

    sequence: int
    task: asyncio.Task[Any]

    async def stop(self) -> None:
        """End it: the row is not this process's any more."""


AnyRunner = TypeVar("AnyRunner", bound=Runner)


class Work(Generic[Row, AnyRunner]):
    """The rows of a table that this process works on: ``runners``, by the row's id.

    Args:
        leases: of the table. begin: begins to work on a row whose lease was taken; None: there is
            nothing to do.
    """

    def __init__(
        self, leases: Leases[Row], begin: Callable[[Row], Awaitable[AnyRunner | None]]
    ) -> None:
        self.leases, self._begin = leases, begin
        self.runners: dict[str, AnyRunner] = {}
        self._starting: set[str] = set()
        self._polling: asyncio.Task[None] | None = None

    async def start(self, row: Row) -> None:
        """Work on a row, unless this process does already or another one holds its lease."""
        if row.id in self.runners or row.id in self._starting:
            return
        self._starting.add(row.id)
        try:
            if await self.leases.take(row.sequence):
                runner = await self._begin(row)
                if runner is not None:
                    self.runners[row.id] = runner
                    runner.task.add_done_callback(lambda task: self._remove(row.id, task))
        finally:
            self._starting.discard(row.id)

    def _remove(self, id: str, task: asyncio.Task[Any]) -> None:
        del self.runners[id]
        if not task.cancelled():
            task.exception()  # retrieved, so that asyncio does not log it

    async def resume(self) -> None:
        """Adopt what no living process works on: now, and from now on.

        Where the store fails now, as with a damaged page, later: what it has still is served.
        """
        try:
            await self._adopt()
        except DBAPIError as error:
            log.error("work cannot be adopted yet: %s", error.orig)
        self._polling = asyncio.create_task(self._poll())

    async def _adopt(self) -> None:
        for row in await self.leases.unleased_rows():
            await self.start(row)

    async def _renew(self) -> None:
        before = list(self.runners.values())
        held = await self.leases.renew() if before else set()
        for runner in before:
            if runner.sequence not in held and not runner.task.done():
                await runner.stop()
        # Work that has ended without its row, such as by a fault: let it be adopted.
        if not self._starting:
            for sequence in held - {runner.sequence for runner in self.runners.values()}:
                await self.leases.release(sequence)

    async def _poll(self) -> None:
        looked = asyncio.get_running_loop().time()
        while True:
            await asyncio.sleep(min(RENEWAL_S, 0.25 * self.leases.lease_s))
            try:
                await self._renew()
                now = asyncio.get_running_loop().time()
                if now - looked >= min(POLL_S, 0.5 * self.leases.lease_s):
                    looked = now
                    await self._adopt()
            except DBAPIError as error:
                log.warning("leases could not be renewed: %s", error.orig)
            except Exception:
                log.exception("leases could not be renewed")

    async def close(self) -> None:
        """Stop everything, and give it to whoever comes next."""
        tasks = [runner.task for runner in self.runners.values()]
        tasks += [] if self._polling is None else [self._polling]
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        try:
            await self.leases.release()
        except DBAPIError:
            log.warning("the store cannot be reached; the leases will expire")
