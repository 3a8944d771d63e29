"""Where solves run: one Dask client, with a cluster of our own or a scheduler elsewhere.

Each design, or chunk of a sweep, is one task on a worker process with one thread. Not more are sent
than there are workers, so that a design's clock starts when it starts, and what waits is counted
here. Sweeps let single designs go first.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import signal
import uuid
from collections.abc import AsyncIterator, Awaitable, Callable, Sequence
from contextlib import asynccontextmanager
from functools import partial
from typing import Any, TypeVar

import dask
from distributed import Client, KilledWorker, Worker, WorkerPlugin
from distributed.client import FutureCancelledError
from distributed.comm.core import CommClosedError
from distributed.utils import get_mp_context

from service.settings import Settings
from service.wire.errors import Busy, EngineUnreachable, WorkerLost
from service.workers import forks
from service.workers.cluster import DIED, Keeper, OwnCluster
from service.workers.solve import Answer, Task, solve, warm_up
from service.workers.stopping import stop, stoppable
from synthesis.errors import TimeBudgetExceeded

log = logging.getLogger("camwright.engine")
T = TypeVar("T")
Connect = Callable[[], Awaitable[Any]]
Ended = Callable[[Any], Awaitable[str]]  # a worker's name to what ended it

CONFIGURATION = {
    "distributed.scheduler.work-stealing": False,
    "distributed.scheduler.allowed-failures": 0,  # a design that kills its worker gets one
    "distributed.scheduler.worker-saturation": 1.0,
    "distributed.worker.multiprocessing-method": forks.METHOD,
    "distributed.worker.profile.enabled": False,
    "distributed.admin.system-monitor.gil.enabled": False,
    "distributed.admin.system-monitor.interval": "5s",
    "distributed.admin.low-level-log-length": 100,  # for Dask's developers, in every process
    "distributed.admin.log-length": 100,
    "distributed.admin.system-monitor.log-length": 10,
    "distributed.admin.tick.interval": "500ms",  # 20 ms otherwise, in every process
    "distributed.diagnostics.nvml": False,
    "distributed.scheduler.http.routes": [],
    "distributed.worker.http.routes": [],
}
WATCH_S = 2.0
REPAIR_S = 60.0
ASK_S = 0.1  # between words to work that is to stop: it may not have begun at the first
STOP_S = 0.5  # that work gets to stop in; then its worker is started anew
BATCH_S = 0.001  # Dask gathers messages for 10 ms before it sends them: longer than many designs


class WarmUp(WorkerPlugin):
    """Prepares every worker when it starts, restarted ones too."""

    name = "camwright-warm-up"

    def __init__(self, prepare: Callable[[], None], ours: bool) -> None:
        self.prepare, self.ours = prepare, ours

    def setup(self, worker: Worker) -> None:
        if self.ours:  # Ctrl-C in a terminal reaches our workers too; we stop them in order
            signal.signal(signal.SIGINT, signal.SIG_IGN)
        try:
            self.prepare()
        except Exception:  # the worker is sound; the first design will tell what is wrong
            log.exception("warm-up failed")


class Engine:
    """Runs designs on workers; refuses what would wait too long, and stops what overruns."""

    def __init__(
        self, connect: Connect, client: Any, settings: Settings, task: Task, how_it_ended: Ended
    ) -> None:
        self._connect, self._client, self._how_it_ended = connect, client, how_it_ended
        self._settings, self.task = settings, task
        self._turn = asyncio.Condition()
        self._repairs: set[asyncio.Task[None]] = set()
        self.slots = settings.workers
        self.waiting = 0
        self.running = 0
        self.closing = False

    async def workers(self) -> int:
        """Workers that can be reached now."""
        try:
            told = await asyncio.wait_for(self._client.scheduler.identity(n_workers=0), 2.0)
        except (OSError, CommClosedError, TimeoutError):
            return 0
        return int(told["n_workers"])

    def admit(self) -> None:
        """Refuse a design that would have to wait behind too many others."""
        if self.waiting >= self._settings.max_waiting and self.running >= self.slots:
            raise Busy(
                f"{self.waiting} designs are waiting already. Try again in a few seconds.",
                {"Retry-After": "5"},
            )

    async def solve(self, spec: bytes, budget_s: float, task: Task | None = None) -> Answer:
        """Run one design, or another task in its place.

        Raises what the core raised, or WorkerLost, or TimeBudgetExceeded.
        """
        return await self.run(task or self.task, spec, budget_s, budget_s=budget_s)

    async def run(
        self,
        work: Callable[..., T],
        *given: Any,
        budget_s: float,
        behind: bool = False,
        name: str = "",
    ) -> T:
        """Run some work on a worker, stopped when it overruns its budget or nobody waits for it.

        Args:
            work: a function that a worker can import. given: what it is called with.
            budget_s: time it has. behind: let everybody else go first.
            name: to stop it by; nobody else's.
        """
        await self._enter(behind)
        if self._client.status != "running":
            await self._leave()
            raise EngineUnreachable("No worker can be reached. Try again shortly.", RETRY)
        key = name or new_name()
        future = self._client.submit(stoppable, key, work, *given, key=key, pure=False)
        result = asyncio.ensure_future(future.result())
        try:
            answer: T = await self._answer(future, result, budget_s)
            return answer
        finally:
            # A place is free again when its worker is: a lost one has to be replaced first.
            if result.done() and _sound(result):
                future.release()
                ending = self._leave()
            else:
                ending = self._repaired(future, result)
            repair = asyncio.create_task(ending)
            self._repairs.add(repair)
            repair.add_done_callback(self._repairs.discard)

    async def stop(self, names: Sequence[str], result: asyncio.Future[Any]) -> bool:
        """Tell work of these names to stop, again and again; whether the result is there in time.

        Args:
            names: given to ``run``. result: what it leads to.
        """
        for _ in range(round(STOP_S / ASK_S)):
            if self._client.status != "running":
                break
            told = asyncio.ensure_future(self._client.run(stop, list(names), on_error="ignore"))
            told.add_done_callback(_heard)
            done, _ = await asyncio.wait({result}, timeout=ASK_S)
            if done:
                return True
        return result.done()

    async def _enter(self, behind: bool) -> None:
        async with self._turn:
            self.waiting += not behind
            try:
                await self._turn.wait_for(
                    lambda: self.running < self.slots and not (behind and self.waiting)
                )
                self.running += 1
            finally:
                self.waiting -= not behind
                self._turn.notify_all()

    async def _answer(self, future: Any, result: asyncio.Task[Any], budget_s: float) -> Any:
        allowed = budget_s + self._settings.grace_s
        done, _ = await asyncio.wait({result}, timeout=allowed)
        if not done and not await self._begun(future):  # another service's work was before it
            while not done and not await self._begun(future):
                done, _ = await asyncio.wait({result}, timeout=WATCH_S)
            if not done:
                done, _ = await asyncio.wait({result}, timeout=allowed)
        if not done:
            raise TimeBudgetExceeded(budget_s)
        try:
            return result.result()
        except KilledWorker as error:
            ended = await self._how_it_ended(error.last_worker.name)
            raise WorkerLost(
                f"The process working on this design {ended}, perhaps for want of memory. "
                "Others go on. Try again, or ask for a simpler design.",
                RETRY,
            ) from None
        except (CommClosedError, FutureCancelledError):
            raise EngineUnreachable("The engine was lost meanwhile. Try again.", RETRY) from None

    async def _begun(self, future: Any) -> bool:
        """Whether a worker has this task: several services may share the workers elsewhere."""
        try:
            at_work = await self._client.processing()
        except (OSError, CommClosedError):
            return False  # the result will say so
        return any(future.key in keys for keys in at_work.values())

    async def _leave(self) -> None:
        async with self._turn:
            self.running -= 1
            self._turn.notify_all()

    async def _repaired(self, future: Any, result: asyncio.Task[Any]) -> None:
        """Stop a task, start its worker anew if need be, and give its place back after that."""
        try:
            if not self.closing and not (await self.stop([future.key], result) and _sound(result)):
                await self._restart_whoever_runs(future)
                await self._client.wait_for_workers(self.slots, timeout=REPAIR_S)
        except Exception:
            log.exception("a worker could not be started anew")
        finally:
            result.cancel()
            future.release()
            await self._leave()

    async def _restart_whoever_runs(self, future: Any) -> None:
        at_work = await self._client.processing()
        stuck = [where for where, keys in at_work.items() if future.key in keys]
        await self._client.cancel([future], force=True)
        if stuck:
            log.warning("a worker is stopped and started anew")
            await self._client.restart_workers(stuck, raise_for_error=False)

    async def close(self) -> None:
        """End what is being repaired, and let go of the workers."""
        self.closing = True
        for repair in list(self._repairs):
            repair.cancel()
        await asyncio.gather(*self._repairs, return_exceptions=True)
        await self._client.close()

    async def watch(self, cluster: Any = None) -> None:
        """Replace workers that our own cluster has lost; follow how many a remote one has."""
        while True:
            await asyncio.sleep(WATCH_S)
            if self._client.status == "closed":  # the scheduler was lost, and may be back
                with contextlib.suppress(OSError):
                    self._client = await self._connect()
            there = await self.workers()
            if cluster is None:
                self.slots = max(1, there)
                async with self._turn:
                    self._turn.notify_all()
            else:
                cluster.replace_the_lost()


RETRY = {"Retry-After": "2"}


def new_name() -> str:
    """A name for some work that nothing else has."""
    return f"design-{uuid.uuid4().hex}"


def _sound(result: asyncio.Future[Any]) -> bool:
    """Whether the worker that this finished result came from is still there."""
    return not isinstance(result.exception(), KilledWorker)


def _heard(told: asyncio.Future[Any]) -> None:
    """Whether a word reached every worker is seen by what the work does."""
    if not told.cancelled():
        told.exception()


async def _unseen(name: Any) -> str:
    """How a worker elsewhere ended."""
    return DIED


@asynccontextmanager
async def running_engine(
    settings: Settings, task: Task = solve, prepare: Callable[[], None] = warm_up
) -> AsyncIterator[Engine]:
    """An engine for as long as the service runs."""
    with dask.config.set(CONFIGURATION):
        async with contextlib.AsyncExitStack() as stack:
            cluster, address = None, settings.scheduler
            if address is None:
                cluster = await stack.enter_async_context(_own_cluster(settings))
                address = await cluster.within()
            connect = partial(_connected, address, WarmUp(prepare, ours=cluster is not None))
            client = await connect()
            engine = Engine(
                connect, client, settings, task, cluster.how_it_ended if cluster else _unseen
            )
            stack.push_async_callback(engine.close)
            if cluster is not None:
                await client.wait_for_workers(settings.workers)
            watcher = asyncio.create_task(engine.watch(cluster))
            stack.callback(watcher.cancel)
            yield engine


async def _connected(address: str, warming: WarmUp) -> Any:
    connect: Any = Client
    client = await connect(address, asynchronous=True)
    client.scheduler_comm.interval = BATCH_S
    await client.register_plugin(warming)
    return client


@asynccontextmanager
async def _own_cluster(settings: Settings) -> AsyncIterator[Any]:
    name_modules: Any = get_mp_context
    name_modules()  # what is to be imported before forks: Dask does once, and then we do
    forks.prepare()
    make: Any = OwnCluster
    cluster = make(
        n_workers=settings.workers,
        threads_per_worker=1,
        processes=True,
        worker_class=Keeper,
        host="127.0.0.1",
        dashboard_address="127.0.0.1:0",  # nothing is shown there; without one it takes 8787
        silence_logs=logging.CRITICAL,
        asynchronous=True,
    )
    try:
        await cluster
        yield cluster
    finally:
        await cluster.close()
