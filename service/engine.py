"""Where solves run: one Dask client, with a cluster of our own or a scheduler elsewhere.

Each design is one task on a worker process with one thread. Not more designs are sent than there
are workers, so that a design's clock starts when it starts, and what waits is counted here.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import uuid
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import Any

import dask
from distributed import Client, KilledWorker, LocalCluster, Worker, WorkerPlugin
from distributed.client import FutureCancelledError
from distributed.comm.core import CommClosedError

from service.errors import Busy, EngineUnreachable, WorkerLost
from service.settings import Settings
from service.solve import Answer, Task, solve, warm_up
from synthesis.errors import TimeBudgetExceeded

log = logging.getLogger("camwright.engine")

CONFIGURATION = {
    "distributed.scheduler.work-stealing": False,
    "distributed.scheduler.allowed-failures": 0,  # a design that kills its worker gets one
    "distributed.scheduler.worker-saturation": 1.0,
    "distributed.worker.profile.enabled": False,
    "distributed.admin.system-monitor.gil.enabled": False,
    "distributed.diagnostics.nvml": False,
}
WATCH_S = 2.0


class WarmUp(WorkerPlugin):
    """Prepares every worker when it starts, restarted ones too."""

    name = "camwright-warm-up"

    def __init__(self, prepare: Callable[[], None]) -> None:
        self.prepare = prepare

    def setup(self, worker: Worker) -> None:
        try:
            self.prepare()
        except Exception:  # the worker is sound; the first design will tell what is wrong
            log.exception("warm-up failed")


class Engine:
    """Runs designs on workers; refuses what would wait too long, and stops what overruns."""

    def __init__(self, client: Any, settings: Settings, task: Task, slots: int) -> None:
        self._client, self._settings, self._task = client, settings, task
        self._free, self._slots = asyncio.Semaphore(slots), slots
        self.waiting = 0
        self.running = 0

    @property
    def slots(self) -> int:
        """Designs that can run at the same time."""
        return self._slots

    def workers(self) -> int:
        """Workers that can be reached now."""
        if self._client.status != "running":
            return 0
        return len(self._client.scheduler_info(n_workers=-1)["workers"])

    def admit(self) -> None:
        """Refuse a design that would have to wait behind too many others."""
        if self.waiting >= self._settings.max_waiting and self._free.locked():
            raise Busy(
                f"{self.waiting} designs are waiting already. Try again in a few seconds.",
                {"Retry-After": "5"},
            )

    async def solve(self, spec: bytes, budget_s: float) -> Answer:
        """Run one design; raises what the core raised, or WorkerLost, or TimeBudgetExceeded."""
        self.waiting += 1
        try:
            await self._free.acquire()
        finally:
            self.waiting -= 1
        self.running += 1
        try:
            return await self._sent(spec, budget_s)
        finally:
            self.running -= 1
            self._free.release()

    async def _sent(self, spec: bytes, budget_s: float) -> Answer:
        if self._client.status != "running":
            raise EngineUnreachable("No worker can be reached. Try again shortly.", RETRY)
        future = self._client.submit(
            self._task, spec, budget_s, key=f"design-{uuid.uuid4().hex}", pure=False
        )
        result = asyncio.ensure_future(future.result())
        try:
            done, _ = await asyncio.wait({result}, timeout=budget_s + self._settings.grace_s)
            if not done:
                raise TimeBudgetExceeded(budget_s)
            answer: Answer = result.result()
            return answer
        except KilledWorker:
            raise WorkerLost(
                "The process working on this design died, perhaps for want of memory. "
                "Others go on. Try again, or ask for a simpler design.", RETRY,
            ) from None  # fmt: skip
        except (CommClosedError, FutureCancelledError):
            raise EngineUnreachable("The engine was lost meanwhile. Try again.", RETRY) from None
        finally:
            await self._stop(future, result)

    async def _stop(self, future: Any, result: asyncio.Task[Any]) -> None:
        """Forget a task; if a worker is still at it, start that worker anew."""
        if result.done():
            future.release()
            return
        result.cancel()
        with contextlib.suppress(Exception):
            at_work = await self._client.processing()
            stuck = [where for where, keys in at_work.items() if future.key in keys]
            await self._client.cancel([future], force=True)
            if stuck:
                log.warning("a worker overran its budget and is started anew")
                await self._client.restart_workers(stuck, raise_for_error=False)

    async def watch(self) -> None:
        """Follow a remote scheduler that gains workers: more slots."""
        while True:
            await asyncio.sleep(WATCH_S)
            for _ in range(self.workers() - self._slots):
                self._slots += 1
                self._free.release()


RETRY = {"Retry-After": "2"}


@asynccontextmanager
async def running_engine(
    settings: Settings, task: Task = solve, prepare: Callable[[], None] = warm_up
) -> AsyncIterator[Engine]:
    """An engine for as long as the service runs."""
    with dask.config.set(CONFIGURATION):
        async with contextlib.AsyncExitStack() as stack:
            address: Any = settings.scheduler
            if address is None:
                address = await stack.enter_async_context(_own_cluster(settings))
            connect: Any = Client
            client = await stack.enter_async_context(connect(address, asynchronous=True))
            await client.register_plugin(WarmUp(prepare))
            await client.wait_for_workers(1, timeout=60)
            engine = Engine(client, settings, task, settings.workers)
            watcher = asyncio.create_task(engine.watch())
            stack.callback(watcher.cancel)
            yield engine


def _own_cluster(settings: Settings) -> Any:
    cluster: Any = LocalCluster
    return cluster(
        n_workers=settings.workers,
        threads_per_worker=1,
        processes=True,
        host="127.0.0.1",
        dashboard_address=None,
        silence_logs=logging.CRITICAL,
        asynchronous=True,
    )
