"""Run one sweep: chunks of items go to the workers, answers are stored, until no item is left."""

from __future__ import annotations

import asyncio
import logging
import time
from collections import deque
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field, replace
from typing import Any, TypeVar

from sqlalchemy.exc import InterfaceError, OperationalError

from service.settings import Settings
from service.sweeps.chunks import CHAIN, STRIKES, Chunks
from service.sweeps.lease import Leases
from service.sweeps.store import Done, LeaseLost, SweepRow, SweepStore
from service.sweeps.tasks import SLICE_S, ItemAnswer, solve_items
from service.wire.errors import ProblemType, ServiceError, problem_type
from service.wire.problem import problem_of
from service.workers.engine import Engine, new_task_name
from synthesis.errors import TimeBudgetExceeded
from synthesis.studies.sweeps import SweepSpec

log = logging.getLogger("camwright.sweeps")
RETRY_S = 0.5  # after the engine or the store could not be reached
RENEWAL_S = 0.5  # at most, between renewals: a sweep stopped elsewhere is noticed by then
WINDOW = 32  # commits over which the rate is taken
T = TypeVar("T")


@dataclass(eq=False)
class Progress:
    """Updated with every commit; notifies those who wait for a change."""

    _commits: deque[tuple[float, int]] = field(default_factory=lambda: deque(maxlen=WINDOW))
    _change: asyncio.Event = field(default_factory=asyncio.Event)

    def update(self, done: int) -> None:
        """Note how many items are in the store now."""
        self._commits.append((time.monotonic(), done))
        self.notify()

    def notify(self) -> None:
        """Wake those who wait for a change."""
        change, self._change = self._change, asyncio.Event()
        change.set()

    @property
    def next_change(self) -> asyncio.Event:
        """Set at the next change."""
        return self._change

    @property
    def rate_per_s(self) -> float | None:
        """Items a second over the last commits; None until there are two."""
        if len(self._commits) < 2:
            return None
        (start, first), (end, last) = self._commits[0], self._commits[-1]
        return (last - first) / (end - start) if end > start else None


class SweepRunner:
    """Runs a sweep whose lease this process holds, in ``task``."""

    task: asyncio.Task[None]

    def __init__(
        self, row: SweepRow, engine: Engine, store: SweepStore, leases: Leases, settings: Settings
    ) -> None:
        self._row, self._engine, self._store, self._leases = row, engine, store, leases
        self._spec = SweepSpec.model_validate_json(row.spec)
        self._budget_s = settings.budget_s(self._spec.base.time_budget_s)
        self._spec_for_workers = self._spec.without_values().model_dump_json().encode()
        self._writing = asyncio.Lock()
        self._stopping = False
        self._running: dict[asyncio.Task[None], str] = {}  # chunks at the workers, with their names
        self._warm_starts: dict[int, Any] = {}  # for items that were not begun
        self.progress = Progress()

    async def run(self) -> None:
        """Run until every item is finished, or the sweep is stopped, or the lease is lost.

        The lease is released at the end.
        """
        number = self._row.sequence
        renewal = asyncio.create_task(self._renew_lease())
        try:
            done = await self._store.done_numbers(number)
            strikes = await self._store.strikes(number)
            chain = CHAIN if self._spec.warm_start else 1
            chunks = Chunks(self._row.size, done, self._engine.slots, strikes, chain)
            await self._store.start(number)
            self.progress.update(len(done))
            del done
            await self._run_chunks(chunks)
            if not self._stopping:
                await self._end()
        except LeaseLost:
            log.info("another process has the sweep now")
        except Exception:
            log.exception("a sweep has failed")
            await self._store.end(number, "failed", self._leases.owner)
        finally:
            renewal.cancel()
            for chunk in self._running:
                chunk.cancel()
            self.progress.notify()
            try:
                await self._leases.release(number)
            except (InterfaceError, OperationalError):
                log.warning("the store cannot be reached; the lease will expire")

    async def _renew_lease(self) -> None:
        """Renew the lease until it is lost: the sweep was dismissed, or another process has it."""
        while True:
            await asyncio.sleep(min(RENEWAL_S, 0.25 * self._leases.length_s))
            try:
                held = await self._leases.renew(self._row.sequence)
            except (InterfaceError, OperationalError):
                continue  # no other process can take it either
            if not held:
                await self.stop()
                return

    async def stop(self) -> None:
        """Send no more chunks, and cancel those at the workers: their finished items are kept."""
        self._stopping = True
        if not self._running:
            return
        ended = asyncio.gather(*self._running, return_exceptions=True)
        if not await self._engine.cancel(list(self._running.values()), ended):
            for chunk in self._running:
                chunk.cancel()

    async def _run_chunks(self, chunks: Chunks) -> None:
        while True:
            chunks.workers = self._engine.slots
            # One more than there are workers: it waits while the answers of another are stored.
            while not self._stopping and len(self._running) <= self._engine.slots:
                numbers = chunks.take()
                if not numbers:
                    break
                name = new_task_name()
                chunk = asyncio.create_task(self._run_chunk(chunks, numbers, name))
                self._running[chunk] = name
            if not self._running:
                return
            ended, _ = await asyncio.wait(self._running, return_when=asyncio.FIRST_COMPLETED)
            for chunk in ended:
                del self._running[chunk]
                if not chunk.cancelled():
                    chunk.result()

    async def _run_chunk(self, chunks: Chunks, numbers: list[int], name: str) -> None:
        """Solve the items of a chunk and store the answers; what was not begun is put back."""
        items = [(number, self._spec.item_values(number)) for number in numbers]
        try:
            answers = await self._engine.run(
                solve_items, self._spec_for_workers, items, self._budget_s, self._engine.task,
                self._warm_starts.get(numbers[0]),
                budget_s=self._budget_s + SLICE_S, low_priority=True, name=name,
            )  # fmt: skip
        except (ServiceError, TimeBudgetExceeded) as error:
            if problem_type(error) is ProblemType.ENGINE_UNREACHABLE:
                chunks.put_back(numbers)
                await asyncio.sleep(RETRY_S)
                return
            suspects = chunks.unfinished(numbers)
            strikes = chunks.add_strikes(suspects)
            await self._write(lambda: self._store.keep_strikes(self._row.sequence, strikes))
            if max(strikes.values()) < STRIKES:
                for number in suspects:
                    chunks.put_back([number])
                return
            answers, numbers = [_failed_item(suspects[0], error)], suspects
        for answer in answers:
            chunks.record_time(answer.seconds)
        self._warm_starts.pop(numbers[0], None)
        not_begun = numbers[len(answers) :]
        if not_begun and answers:
            self._warm_starts[not_begun[0]] = answers[-1].warm_start
        chunks.put_back(not_begun)
        values = dict(items)
        new = [answer for answer in answers if chunks.finish(answer.number)]
        if new:
            await self._record(
                [(replace(answer, warm_start=None), values[answer.number]) for answer in new]
            )

    async def _record(self, done: list[Done]) -> None:
        number, owner = self._row.sequence, self._leases.owner
        async with self._writing:  # items become visible in the order of their sequence numbers
            row = await self._write(lambda: self._store.record(number, owner, done))
            self.progress.update(row.done)

    async def _write(self, write: Callable[[], Awaitable[T]]) -> T:
        """Write to the store, again until it can be reached; a write that has begun is not lost."""
        while True:
            writing = asyncio.ensure_future(write())
            try:
                return await asyncio.shield(writing)
            except asyncio.CancelledError:
                await asyncio.wait({writing})
                raise
            except (InterfaceError, OperationalError):
                log.exception("the store cannot be reached; finished items wait for it")
                await asyncio.sleep(RETRY_S)

    async def _end(self) -> None:
        row = await self._store.find(self._row.id)
        if row is not None:
            state = "failed" if row.failed == row.size else "successful"
            await self._store.end(row.sequence, state, self._leases.owner)


def _failed_item(number: int, error: Exception) -> ItemAnswer:
    """The answer of an item whose worker dies every time, or that cannot be cancelled in time."""
    problem = problem_of(error)
    problem["detail"] = (
        f"Its worker was lost {STRIKES} times while it worked on this item, the last times on this "
        "item alone: it died, perhaps for lack of memory, or overran its time budget and had to be "
        f"stopped. The last time: {error}"
    )
    return ItemAnswer(number, "failed", problem=problem)
