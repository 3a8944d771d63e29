"""Workers of a Dask scheduler elsewhere, over TLS in which both sides show a certificate.

Dask runs whatever function it is sent. So nobody may speak to it who does not hold the key of the
cluster: an address without TLS is refused (`Settings.scheduler`), and Dask asks both sides for a
certificate that its authority has signed. Which ones, Dask's own settings say: docs/deployment.md.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager
from threading import Event
from typing import Any, TypeVar

import dask
from distributed import Client, KilledWorker, Security, Worker, WorkerPlugin
from distributed.client import FutureCancelledError
from distributed.comm.core import CommClosedError

from service.wire.errors import ProblemType
from service.workers.local import RETRY
from synthesis.numerics import clock

log = logging.getLogger("camwright.engine")
T = TypeVar("T")
CONFIGURATION = {
    "distributed.scheduler.work-stealing": False,
    "distributed.scheduler.allowed-failures": 0,  # who asked decides whether a task is repeated
    "distributed.scheduler.worker-saturation": 1.0,
    "distributed.comm.require-encryption": True,
}
WATCH_S = 2.0  # between looks at how many workers there are
REPAIR_S = 60.0  # at most, to wait for a restarted worker: long enough on a busy machine
BATCH_S = 0.001  # of messages to the scheduler; Dask's 10 ms is longer than many designs take
LOST = (OSError, CommClosedError, TimeoutError)  # the scheduler cannot be reached
_events: dict[str, Event] = {}  # of the work in this worker process, by name


def run_cancellable(name: str, work: Callable[..., T], *arguments: Any) -> T:
    """Run some work in a worker process; it ends with ``Cancelled`` after ``cancel``."""
    event = _events[name] = Event()
    try:
        with clock.cancellation_scope(event):
            return work(*arguments)
    finally:
        del _events[name]


def cancel(names: Sequence[str]) -> None:
    """Cancel the work of these names that runs in this process."""
    for name in names:
        event = _events.get(name)
        if event is not None:
            event.set()


class WarmUp(WorkerPlugin):
    """Prepares each worker when it starts, restarted ones too."""

    name = "camwright-warm-up"

    def __init__(self, prepare: Callable[[], None]) -> None:
        self.prepare = prepare

    def setup(self, worker: Worker) -> None:
        try:
            self.prepare()
        except Exception:  # the worker itself works; the first design will show what is wrong
            log.exception("warm-up failed")


class RemoteWorkers:
    """The workers of a scheduler; several services may share them."""

    def __init__(self, address: str, slots: int, prepare: Callable[[], None]) -> None:
        self._address, self._warm_up, self.slots = address, WarmUp(prepare), slots
        self._futures: dict[str, Any] = {}
        self._interrupted: set[str] = set()  # tasks whose worker is stopped for another's sake

    async def connect(self) -> None:
        """Connect to the scheduler."""
        make: Any = Client
        security: Any = Security
        self._client = await make(self._address, asynchronous=True, security=security())
        self._client.scheduler_comm.interval = BATCH_S
        await self._client.register_plugin(self._warm_up)

    async def run(self, key: str, work: Callable[..., T], *arguments: Any) -> T:
        tries = 0
        while True:
            if self._client.status != "running":
                raise ProblemType.ENGINE_UNREACHABLE(
                    "No worker can be reached. Try again shortly.", RETRY
                )
            self._futures[key] = future = self._client.submit(
                run_cancellable, key, work, *arguments, key=f"{key}-{tries}", pure=False
            )
            try:
                result: T = await future.result()
                return result
            except KilledWorker:
                tries += 1
                if key in self._interrupted:
                    continue
                self.slots = max(1, await self.count())
                raise ProblemType.WORKER_LOST(
                    "The process working on this design died, perhaps for lack of memory. "
                    "Other work goes on. Try again, or ask for a simpler design.",
                    RETRY,
                ) from None
            except (CommClosedError, FutureCancelledError):
                raise ProblemType.ENGINE_UNREACHABLE(
                    "The connection to the workers was lost. Try again.", RETRY
                ) from None
            finally:
                self._interrupted.discard(key)
                del self._futures[key]
                future.release()

    async def has_begun(self, key: str) -> bool:
        try:
            running = await self._client.processing()
        except LOST:
            return False  # waiting for the result will raise
        future = self._futures.get(key)
        return any(future is not None and future.key in keys for keys in running.values())

    async def cancel(self, keys: Sequence[str]) -> None:
        if self._client.status == "running":
            with contextlib.suppress(*LOST):
                await self._client.run(cancel, list(keys), on_error="ignore")

    async def stop(self, key: str) -> None:
        # The worker is restarted before the task is cancelled. As soon as a task is cancelled, the
        # scheduler counts its worker as idle and may send it another one, which the restart would
        # lose. What the worker has besides is interrupted, and run again.
        future = self._futures.get(key)
        if future is None or self._client.status != "running":
            return
        running = await self._client.processing()
        stuck = [address for address, keys in running.items() if future.key in keys]
        on_them = {each for address in stuck for each in running[address]}
        self._interrupted |= {
            other for other, each in self._futures.items() if each.key in on_them and other != key
        }
        if stuck:
            await self._client.restart_workers(stuck, raise_for_error=False)
        await self._client.cancel([future], force=True)
        await self._client.wait_for_workers(self.slots, timeout=REPAIR_S)

    async def count(self) -> int:
        try:
            identity = await asyncio.wait_for(self._client.scheduler.identity(n_workers=0), 2.0)
        except LOST:
            return 0
        return int(identity["n_workers"])

    async def watch(self) -> None:
        """Follow how many workers there are; connect again after the scheduler was away."""
        while True:
            await asyncio.sleep(WATCH_S)
            if self._client.status == "closed":
                with contextlib.suppress(*LOST):
                    await self.connect()
            self.slots = max(1, await self.count())

    async def close(self) -> None:
        """Disconnect."""
        await self._client.close()


@asynccontextmanager
async def remote_workers(
    address: str, slots: int, prepare: Callable[[], None]
) -> AsyncIterator[RemoteWorkers]:
    """The workers of a scheduler for as long as they are wanted; ``slots`` until it has counted."""
    with dask.config.set(CONFIGURATION):
        workers = RemoteWorkers(address, slots, prepare)
        await workers.connect()
        watcher = asyncio.create_task(workers.watch())
        try:
            yield workers
        finally:
            watcher.cancel()
            await asyncio.gather(watcher, return_exceptions=True)
            await workers.close()
