"""The engine: runs tasks on worker processes.

The workers are processes of the service's own (`local`), or belong to a Dask scheduler elsewhere
(`remote`). Each design, or chunk of a sweep, is one task on a process with one thread. No more
tasks are sent than there are workers, so that a task's time budget begins when the task does; the
rest waits in a `FairQueue`, by owner. Of one owner single designs go before sweeps.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import uuid
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from typing import Any, Protocol, TypeVar

from service.settings import Settings
from service.wire.errors import ProblemType, ServiceError
from service.wire.fair_queue import FairQueue, Turn
from service.wire.logs import ids
from service.wire.observe import Metrics
from service.wire.tracing import past_span, span, traceparent
from service.workers.local import local_workers
from service.workers.measured import Solve, measured
from service.workers.tasks import Answer, Task, solve_design, warm_up
from synthesis.errors import TimeBudgetExceeded

log = logging.getLogger("camwright.engine")
T = TypeVar("T")
WATCH_S = 2.0  # from one look to the next at how many workers there are, and at a task that waits
CANCEL_AGAIN_S = 0.1  # from one request to cancel to the next: work not yet started ignores them
CANCEL_S = 0.5  # that cancelled work has to end in; after that its worker is stopped


class Workers(Protocol):
    """Processes that run tasks, each one at a time.

    ``slots`` is how many tasks they can work on at once. ``key`` names a task.
    """

    slots: int

    async def run(self, key: str, work: Callable[..., T], *arguments: Any) -> T:
        """Run some work on a free worker; again, where that was stopped for another's sake.

        ServiceError where the worker is lost with the work, or no worker can be reached.
        """

    async def has_begun(self, key: str) -> bool:
        """Whether a worker has this task."""

    async def cancel(self, keys: Sequence[str]) -> None:
        """Ask workers to end these tasks."""

    async def stop(self, key: str) -> None:
        """End the worker that has this task; another one takes its place."""

    async def count(self) -> int:
        """Workers that can be reached now."""


class Engine:
    """Runs tasks on workers; refuses what would wait too long, and cancels what overruns."""

    def __init__(self, workers: Workers, settings: Settings, task: Task, metrics: Metrics) -> None:
        self._workers, self._settings, self.task = workers, settings, task
        self._metrics = metrics
        self.queue = FairQueue(lambda: self.slots, settings.max_waiting, "questions")
        self._endings: set[asyncio.Task[None]] = set()
        self.closing = False

    @property
    def slots(self) -> int:
        """How many tasks the workers can work on at once."""
        return self._workers.slots

    async def workers(self) -> int:
        """Workers that can be reached now."""
        return await self._workers.count()

    async def solve(self, spec: bytes, budget_s: float, task: Task | None = None) -> Answer:
        """Run a task: that of designs, or another. Raises what the core does, or ServiceError."""
        return await self.run(task or self.task, spec, budget_s, budget_s=budget_s)

    async def run(
        self,
        work: Callable[..., T],
        *arguments: Any,
        budget_s: float,
        low_priority: bool = False,
        limited: bool = False,
        name: str = "",
    ) -> T:
        """Run some work on a worker; cancelled when it overruns its budget or its caller is.

        Args:
            work: a function that a worker can import. arguments: of it.
            budget_s: time that it has. low_priority: whether its owner's other work goes first.
            limited: whether it is refused where the queue is full.
            name: to cancel it by; unique.
        """
        kind = "sweep" if low_priority else "single"
        with span("queue"), self._metrics.queue.labels(kind).time():
            turn = await self.queue.acquire(urgent=not low_priority, limited=limited)
        key = name or new_task_name()
        with span("worker"), self._metrics.work.labels(kind).time():
            result: asyncio.Future[tuple[T, list[Solve]]] = asyncio.ensure_future(
                self._workers.run(key, measured, dict(ids.get()), traceparent(), work, *arguments)
            )
            try:
                value, solves = await self._wait_for(key, result, budget_s)
            except ServiceError as error:
                self._metrics.lost.inc(error.problem is ProblemType.WORKER_LOST)
                raise
            finally:
                # The slot is free again when the worker is.
                ending = asyncio.create_task(self._end(key, result, turn))
                self._endings.add(ending)
                ending.add_done_callback(self._endings.discard)
            for solve in solves:
                self._tell(solve)
        return value

    def _tell(self, solve: Solve) -> None:
        """Count what the core did, and put it into the trace."""
        self._metrics.solves.labels(solve.status).observe(solve.seconds)
        for stage in solve.stages:
            self._metrics.stages.labels(stage.kind).observe(stage.seconds)
        parts = [(stage.name, stage.seconds, stage.attributes) for stage in solve.stages]
        past_span("core", solve.ended_ns, solve.seconds, parts, status=solve.status)

    async def cancel(self, names: Sequence[str], result: asyncio.Future[Any]) -> bool:
        """Cancel work, repeatedly; whether its result is there within ``CANCEL_S``.

        ``names`` were given to ``run``.
        """
        for _ in range(round(CANCEL_S / CANCEL_AGAIN_S)):
            if result.done():
                break
            await self._workers.cancel(names)
            await asyncio.wait({result}, timeout=CANCEL_AGAIN_S)
        return result.done()

    async def _wait_for(self, key: str, result: asyncio.Future[T], budget_s: float) -> T:
        allowed = budget_s + self._settings.grace_s
        done, _ = await asyncio.wait({result}, timeout=allowed)
        # Where it waits for a worker, or behind another service's work, its time begins when it
        # does.
        if not done and not await self._workers.has_begun(key):
            while not done and not await self._workers.has_begun(key):
                done, _ = await asyncio.wait({result}, timeout=WATCH_S)
            if not done:
                done, _ = await asyncio.wait({result}, timeout=allowed)
        if not done:
            raise TimeBudgetExceeded(budget_s)
        return result.result()

    async def _end(self, key: str, result: asyncio.Future[Any], turn: Turn) -> None:
        """Cancel a task that nobody waits for, stop its worker if need be, and free its slot."""
        try:
            if not self.closing and not await self.cancel([key], result):
                log.warning("a worker did not end in time and is stopped")
                await self._workers.stop(key)
        except Exception:
            log.exception("a worker could not be stopped")
        finally:
            result.add_done_callback(ignore_result)  # stopping is what lost it
            result.cancel()
            self.queue.release(turn)

    async def close(self) -> None:
        """Wait for no task any more."""
        self.closing = True
        for ending in list(self._endings):
            ending.cancel()
        await asyncio.gather(*self._endings, return_exceptions=True)

    async def watch(self) -> None:
        """Let waiting work look again how many workers there are."""
        while True:
            await asyncio.sleep(WATCH_S)
            self.queue.look_again()


def new_task_name() -> str:
    """A unique name for some work."""
    return f"design-{uuid.uuid4().hex}"


def ignore_result(result: asyncio.Future[Any]) -> None:
    """Retrieve an exception, so that asyncio does not log it."""
    if not result.cancelled():
        result.exception()


@asynccontextmanager
async def running_engine(
    settings: Settings,
    metrics: Metrics,
    task: Task = solve_design,
    prepare: Callable[[], None] = warm_up,
) -> AsyncIterator[Engine]:
    """An engine for as long as the service runs."""
    async with _workers_of(settings, prepare) as workers:
        engine = Engine(workers, settings, task, metrics)
        watcher = asyncio.create_task(engine.watch())
        try:
            yield engine
        finally:
            watcher.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await watcher
            await engine.close()


def _workers_of(
    settings: Settings, prepare: Callable[[], None]
) -> AbstractAsyncContextManager[Workers]:
    if settings.scheduler is None:
        return local_workers(settings.workers, prepare, settings.worker_memory)
    from service.workers.remote import remote_workers  # Dask, for those who have a scheduler

    return remote_workers(settings.scheduler, settings.workers, prepare)
