"""The engine: runs tasks on worker processes, by a Dask client.

The workers are a cluster of the service's own, or belong to a scheduler elsewhere. Each design, or
chunk of a sweep, is one task on a process with one thread. No more tasks are sent than there are
workers, so that a task's time budget begins when the task does; the rest waits here. Single designs
go before sweeps.
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
from threading import Event
from typing import Any, TypeVar

import dask
from distributed import Client, KilledWorker, Worker, WorkerPlugin
from distributed.client import FutureCancelledError
from distributed.comm.core import CommClosedError
from distributed.utils import get_mp_context

from service.settings import Settings
from service.wire.errors import ProblemType
from service.workers import prefork
from service.workers.cluster import DIED, OwnCluster, WorkerNanny
from service.workers.tasks import Answer, Task, solve_design, warm_up
from synthesis.errors import TimeBudgetExceeded
from synthesis.numerics import clock

log = logging.getLogger("camwright.engine")
T = TypeVar("T")
Connect = Callable[[], Awaitable[Any]]
_events: dict[str, Event] = {}  # of the work in this worker process, by name

CONFIGURATION = {
    "distributed.scheduler.work-stealing": False,
    "distributed.scheduler.allowed-failures": 0,  # a task that kills its worker is not repeated
    "distributed.scheduler.worker-saturation": 1.0,
    "distributed.worker.multiprocessing-method": prefork.METHOD,
    "distributed.worker.profile.enabled": False,
    "distributed.admin.system-monitor.gil.enabled": False,
    "distributed.admin.system-monitor.interval": "5s",
    # Logs for Dask's developers, in every process.
    "distributed.admin.low-level-log-length": 100,
    "distributed.admin.log-length": 100,
    "distributed.admin.system-monitor.log-length": 10,
    "distributed.admin.tick.interval": "500ms",  # 20 ms otherwise, in every process
    "distributed.diagnostics.nvml": False,
    "distributed.scheduler.http.routes": [],
    "distributed.worker.http.routes": [],
}
WATCH_S = 2.0  # from one look to the next at lost workers, and at a task that has not started
REPAIR_S = 60.0  # at most, to wait for a restarted worker: long enough on a busy machine
CANCEL_AGAIN_S = 0.1  # from one request to cancel to the next: work not yet started ignores them
CANCEL_S = 0.5  # that cancelled work has to end in; after that its worker is restarted
RETRY = {"Retry-After": "2"}  # [s]: by then a lost worker has been replaced
BATCH_S = 0.001  # of messages to the scheduler; Dask's 10 ms is longer than many designs take


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

    def __init__(self, prepare: Callable[[], None], own: bool) -> None:
        self.prepare, self.own = prepare, own

    def setup(self, worker: Worker) -> None:
        if self.own:  # Ctrl-C in a terminal reaches them too, but the service stops them in order
            signal.signal(signal.SIGINT, signal.SIG_IGN)
        try:
            self.prepare()
        except Exception:  # the worker itself works; the first design will show what is wrong
            log.exception("warm-up failed")


class Engine:
    """Runs tasks on workers; refuses what would wait too long, and cancels what overruns."""

    def __init__(
        self, connect: Connect, client: Any, cluster: Any, settings: Settings, task: Task
    ) -> None:
        self._connect, self._client, self._cluster = connect, client, cluster
        self._settings, self.task = settings, task
        self._slot_free = asyncio.Condition()
        self._repairs: set[asyncio.Task[None]] = set()
        self.slots = settings.workers
        self.waiting = 0
        self.running = 0
        self.closing = False

    async def workers(self) -> int:
        """Workers that can be reached now."""
        try:
            identity = await asyncio.wait_for(self._client.scheduler.identity(n_workers=0), 2.0)
        except (OSError, CommClosedError, TimeoutError):
            return 0
        return int(identity["n_workers"])

    def admit(self) -> None:
        """Refuse a design that would have to wait behind too many others."""
        if self.waiting >= self._settings.max_waiting and self.running >= self.slots:
            raise ProblemType.BUSY(
                f"{self.waiting} designs are waiting already. Try again in a few seconds.",
                {"Retry-After": "5"},
            )

    async def solve(self, spec: bytes, budget_s: float, task: Task | None = None) -> Answer:
        """Run a task: that of designs, or another. Raises what the core does, or ServiceError."""
        return await self.run(task or self.task, spec, budget_s, budget_s=budget_s)

    async def run(
        self,
        work: Callable[..., T],
        *arguments: Any,
        budget_s: float,
        low_priority: bool = False,
        name: str = "",
    ) -> T:
        """Run some work on a worker; cancelled when it overruns its budget or its caller is.

        Args:
            work: a function that a worker can import. arguments: of it.
            budget_s: time that it has. low_priority: whether all other work goes first.
            name: to cancel it by; unique.
        """
        await self._acquire_slot(low_priority)
        if self._client.status != "running":
            await self._release_slot()
            raise ProblemType.ENGINE_UNREACHABLE(
                "No worker can be reached. Try again shortly.", RETRY
            )
        key = name or new_task_name()
        future = self._client.submit(run_cancellable, key, work, *arguments, key=key, pure=False)
        result = asyncio.ensure_future(future.result())
        try:
            answer: T = await self._wait_for(future, result, budget_s)
            return answer
        finally:
            # The slot is free again when its worker is: a lost worker has to be replaced first.
            if result.done() and _worker_survived(result):
                future.release()
                ending = self._release_slot()
            else:
                ending = self._repair(future, result)
            repair = asyncio.create_task(ending)
            self._repairs.add(repair)
            repair.add_done_callback(self._repairs.discard)

    async def cancel(self, names: Sequence[str], result: asyncio.Future[Any]) -> bool:
        """Cancel work, repeatedly; whether its result is there within ``CANCEL_S``.

        ``names`` were given to ``run``.
        """
        for _ in range(round(CANCEL_S / CANCEL_AGAIN_S)):
            if self._client.status != "running":
                break
            sent = asyncio.ensure_future(self._client.run(cancel, list(names), on_error="ignore"))
            sent.add_done_callback(_ignore_result)
            done, _ = await asyncio.wait({result}, timeout=CANCEL_AGAIN_S)
            if done:
                return True
        return result.done()

    async def _acquire_slot(self, low_priority: bool) -> None:
        async with self._slot_free:
            self.waiting += not low_priority
            try:
                await self._slot_free.wait_for(
                    lambda: self.running < self.slots and not (low_priority and self.waiting)
                )
                self.running += 1
            finally:
                self.waiting -= not low_priority
                self._slot_free.notify_all()

    async def _wait_for(self, future: Any, result: asyncio.Task[Any], budget_s: float) -> Any:
        allowed = budget_s + self._settings.grace_s
        done, _ = await asyncio.wait({result}, timeout=allowed)
        # Where it waits behind another service's work, its time begins when it does.
        if not done and not await self._has_started(future):
            while not done and not await self._has_started(future):
                done, _ = await asyncio.wait({result}, timeout=WATCH_S)
            if not done:
                done, _ = await asyncio.wait({result}, timeout=allowed)
        if not done:
            raise TimeBudgetExceeded(budget_s)
        try:
            return result.result()
        except KilledWorker as error:
            name, cluster = error.last_worker.name, self._cluster
            reason = DIED if cluster is None else await cluster.exit_reason(name)
            raise ProblemType.WORKER_LOST(
                f"The process working on this design {reason}, perhaps for lack of memory. "
                "Other work goes on. Try again, or ask for a simpler design.",
                RETRY,
            ) from None
        except (CommClosedError, FutureCancelledError):
            raise ProblemType.ENGINE_UNREACHABLE(
                "The connection to the workers was lost. Try again.", RETRY
            ) from None

    async def _has_started(self, future: Any) -> bool:
        """Whether a worker has this task: several services may share remote workers."""
        try:
            running = await self._client.processing()
        except (OSError, CommClosedError):
            return False  # waiting for the result will raise
        return any(future.key in keys for keys in running.values())

    async def _release_slot(self) -> None:
        async with self._slot_free:
            self.running -= 1
            self._slot_free.notify_all()

    async def _repair(self, future: Any, result: asyncio.Task[Any]) -> None:
        """Cancel a task, restart its worker if need be, and free its slot after that."""
        try:
            if not self.closing and not (
                await self.cancel([future.key], result) and _worker_survived(result)
            ):
                # The worker is restarted before the task is cancelled. As soon as a task is
                # cancelled, the scheduler counts its worker as idle and may send it another design,
                # which the restart would lose.
                running = await self._client.processing()
                stuck = [address for address, keys in running.items() if future.key in keys]
                if stuck:
                    log.warning("a worker did not end in time and is restarted")
                    await self._client.restart_workers(stuck, raise_for_error=False)
                await self._client.cancel([future], force=True)
                await self._client.wait_for_workers(self.slots, timeout=REPAIR_S)
        except Exception:
            log.exception("a worker could not be restarted")
        finally:
            result.add_done_callback(_ignore_result)  # the restart is what lost its worker
            result.cancel()
            future.release()
            await self._release_slot()

    async def close(self) -> None:
        """End repairs, and disconnect from the workers."""
        self.closing = True
        for repair in list(self._repairs):
            repair.cancel()
        await asyncio.gather(*self._repairs, return_exceptions=True)
        await self._client.close()

    async def watch(self) -> None:
        """Replace workers that the own cluster has lost; follow how many a remote one has."""
        while True:
            await asyncio.sleep(WATCH_S)
            if self._client.status == "closed":  # the scheduler was lost, and may be back
                with contextlib.suppress(OSError):
                    self._client = await self._connect()
            workers = await self.workers()
            if self._cluster is None:
                self.slots = max(1, workers)
                async with self._slot_free:
                    self._slot_free.notify_all()
            else:
                self._cluster.replace_lost_workers()


def new_task_name() -> str:
    """A unique name for some work."""
    return f"design-{uuid.uuid4().hex}"


def _worker_survived(result: asyncio.Future[Any]) -> bool:
    """Whether the worker of this finished result is still there."""
    return not isinstance(result.exception(), KilledWorker)


def _ignore_result(sent: asyncio.Future[Any]) -> None:
    """Retrieve an exception, so that asyncio does not log it."""
    if not sent.cancelled():
        sent.exception()


@asynccontextmanager
async def running_engine(
    settings: Settings, task: Task = solve_design, prepare: Callable[[], None] = warm_up
) -> AsyncIterator[Engine]:
    """An engine for as long as the service runs."""
    with dask.config.set(CONFIGURATION):
        async with contextlib.AsyncExitStack() as stack:
            cluster, address = None, settings.scheduler
            if address is None:
                cluster = await stack.enter_async_context(_own_cluster(settings))
                address = await cluster.in_process_address()
            connect = partial(_connect, address, WarmUp(prepare, own=cluster is not None))
            client = await connect()
            engine = Engine(connect, client, cluster, settings, task)
            stack.push_async_callback(engine.close)
            if cluster is not None:
                await client.wait_for_workers(settings.workers)
            watcher = asyncio.create_task(engine.watch())
            stack.callback(watcher.cancel)
            yield engine


async def _connect(address: str, warm_up_plugin: WarmUp) -> Any:
    make: Any = Client
    client = await make(address, asynchronous=True)
    client.scheduler_comm.interval = BATCH_S
    await client.register_plugin(warm_up_plugin)
    return client


@asynccontextmanager
async def _own_cluster(settings: Settings) -> AsyncIterator[Any]:
    set_preload: Any = get_mp_context
    set_preload()  # Dask sets what is imported before forks, once; ours replaces it
    prefork.start_fork_server()
    make: Any = OwnCluster
    cluster = make(
        n_workers=settings.workers,
        threads_per_worker=1,
        processes=True,
        worker_class=WorkerNanny,
        host="127.0.0.1",
        dashboard_address="127.0.0.1:0",  # unused, but without an address Dask takes port 8787
        silence_logs=logging.CRITICAL,
        asynchronous=True,
    )
    try:
        await cluster
        yield cluster
    finally:
        await cluster.close()
