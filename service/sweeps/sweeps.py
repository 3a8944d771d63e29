"""Sweeps that this process runs: accepted, continued after a restart, stopped.

`Sweeps` has all of them, a `SweepRunner` runs one: chunks of items go to the workers, answers are
stored, until no item is left.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import math
import time
from collections import deque
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Any

from pydantic import ValidationError
from sqlalchemy.exc import DBAPIError

from service.settings import Settings
from service.storage.store import LeaseLost, Store
from service.storage.tables import LOCAL, SweepRow
from service.sweeps.chunks import CHAIN, Chunks
from service.sweeps.question import SweepQuestion, sweep_question
from service.sweeps.store import STATUSES, SweepStore
from service.sweeps.tasks import SLICE_S, ItemAnswer, solve_items
from service.wire.errors import ProblemType, ServiceError, problem_type
from service.wire.fair_queue import current_owner
from service.wire.problem import problem_of
from service.wire.tracing import separate_span
from service.work import RETRY_S, STRIKES, Work, retry_transaction
from service.workers.engine import Engine, new_task_name
from synthesis.design.identity import ENGINE_NUMBER, identity
from synthesis.errors import TimeBudgetExceeded
from synthesis.studies.sweeps import SweepSpec

log = logging.getLogger("camwright.sweeps")
UNKNOWN_S = 10.0  # Retry-After [s] where no sweep is under way for long enough to tell
WINDOW = 32  # commits over which the rate is taken


async def spec_of(row: SweepRow) -> SweepSpec:
    """The spec of a sweep, read in a thread: it may be long."""

    def read() -> SweepSpec:
        spec = SweepSpec.model_validate_json(row.spec)
        spec.item_values(0)  # the values of a Latin hypercube are drawn here, not in the event loop
        return spec

    return await asyncio.to_thread(read)


@dataclass(eq=False)
class Progress:
    """Updated with every commit; notifies those who wait for a change."""

    _commits: deque[tuple[float, int]] = field(default_factory=lambda: deque(maxlen=WINDOW))
    next_change: asyncio.Event = field(default_factory=asyncio.Event)  # set at the next change

    def update(self, done: int) -> None:
        """Note how many items are in the store now."""
        self._commits.append((time.monotonic(), done))
        self.notify()

    def notify(self) -> None:
        """Wake those who wait for a change."""
        change, self.next_change = self.next_change, asyncio.Event()
        change.set()

    @property
    def done(self) -> int:
        """How many items are in the store."""
        return self._commits[-1][1] if self._commits else 0

    @property
    def rate_per_s(self) -> float | None:
        """Items a second over the last commits; None until there are two."""
        if len(self._commits) < 2:
            return None
        (start, first), (end, last) = self._commits[0], self._commits[-1]
        return (last - first) / (end - start) if end > start else None


class SweepRunner:
    """Runs a sweep whose lease this process holds, in ``task``."""

    _spec: SweepSpec
    _spec_for_workers: bytes
    _budget_s: float

    def __init__(
        self, row: SweepRow, engine: Engine, store: SweepStore, settings: Settings
    ) -> None:
        self._row, self._engine, self._store, self._settings = row, engine, store, settings
        self._writing = asyncio.Lock()
        self._stopping = False
        self._running: dict[asyncio.Task[None], str] = {}  # chunks at the workers, with their names
        self._warm_starts: dict[int, Any] = {}  # for items that were not begun
        self.progress = Progress()
        self.sequence = row.sequence
        self.task: asyncio.Task[Any] = asyncio.create_task(self._run())

    @property
    def owner(self) -> str:
        """To whom it belongs."""
        return self._row.belongs_to

    @property
    def seconds_left(self) -> float | None:
        """Time until its last item, by how fast the last ones came [s]; None where few have."""
        rate = self.progress.rate_per_s
        return (self._row.size - self.progress.done) / rate if rate else None

    async def _run(self) -> None:
        """Run until every item is finished, or the sweep is stopped, or the lease is lost."""
        number = self._row.sequence
        current_owner.set(current_owner.get() or self._row.belongs_to)
        try:
            self._spec = await spec_of(self._row)
            self._budget_s = self._settings.budget_s(self._spec.base.time_budget_s)
            self._spec_for_workers = self._spec.without_values().model_dump_json().encode()
            done = await retry_transaction(lambda: self._store.done_numbers(number))
            strikes = await retry_transaction(lambda: self._store.strikes(number))
            chain = CHAIN if self._spec.warm_start else 1
            chunks = Chunks(self._row.size, done, self._engine.slots, strikes, chain)
            await retry_transaction(lambda: self._store.start(number))
            self.progress.update(len(done))
            del done
            await self._run_chunks(chunks)
            row = await retry_transaction(lambda: self._store.find(self._row.id, None))
            if row is not None and not self._stopping:
                state = "failed" if row.failed == row.size else "successful"
                await retry_transaction(lambda: self._store.end(number, state))
        except LeaseLost:
            log.info("another process has the sweep now")
        except Exception:
            log.exception("a sweep has failed")
            await retry_transaction(lambda: self._store.end(number, "failed"))
        finally:
            for chunk in self._running:
                chunk.cancel()
            self.progress.notify()
            with contextlib.suppress(DBAPIError):  # then the lease will expire
                await self._store.release(number)

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
                chunk = asyncio.create_task(self._trace_chunk(chunks, numbers, name))
                self._running[chunk] = name
            if not self._running:
                return
            ended, _ = await asyncio.wait(self._running, return_when=asyncio.FIRST_COMPLETED)
            for chunk in ended:
                del self._running[chunk]
                if not chunk.cancelled():
                    chunk.result()

    async def _trace_chunk(self, chunks: Chunks, numbers: list[int], name: str) -> None:
        with separate_span("chunk of a sweep"):
            await self._run_chunk(chunks, numbers, name)

    async def _run_chunk(self, chunks: Chunks, numbers: list[int], name: str) -> None:
        """Solve the items of a chunk and store the answers; what was not begun is put back."""
        items = [(number, self._spec.item_values(number)) for number in numbers]
        # Send them. A worker answers those that it had time for; the others go to any worker later.
        try:
            answers, warm_start = await self._engine.run(
                solve_items, self._spec_for_workers, items, self._budget_s, self._engine.task,
                self._warm_starts.get(numbers[0]),
                budget_s=self._budget_s + SLICE_S, low_priority=True, name=name,
            )  # fmt: skip
        except (ServiceError, TimeBudgetExceeded) as error:
            if problem_type(error) is ProblemType.ENGINE_UNREACHABLE:
                chunks.put_back(numbers)
                await asyncio.sleep(RETRY_S)
                return
            # The worker died or was stopped: one of the unfinished items may have caused it. Each
            # is sent again alone, until one has failed alone too often and is given up.
            suspects = chunks.unfinished(numbers)
            strikes = chunks.add_strikes(suspects)
            await retry_transaction(lambda: self._store.keep_strikes(self._row.sequence, strikes))
            if max(strikes.values()) < STRIKES:
                for number in suspects:
                    chunks.put_back([number])
                return
            problem = problem_of(error) | {
                "detail": f"Its worker was lost {STRIKES} times while it worked on this item, the "
                "last times on this item alone: it died, perhaps for lack of memory, or overran "
                f"its time budget and had to be stopped. The last time: {error}"
            }
            answers, warm_start = [ItemAnswer(suspects[0], "failed", problem=problem)], None
            numbers = suspects
        # Learn how long items take, and where the chain goes on that this chunk has interrupted.
        for answer in answers:
            chunks.record_time(answer.seconds)
        self._warm_starts.pop(numbers[0], None)
        not_begun = numbers[len(answers) :]
        if not_begun and answers:
            self._warm_starts[not_begun[0]] = warm_start
        chunks.put_back(not_begun)
        values = dict(items)
        new = [(each, values[each.number]) for each in answers if chunks.finish(each.number)]
        if not new:
            return
        async with self._writing:  # items become visible in the order of their sequence numbers
            row = await retry_transaction(lambda: self._store.record(self._row.sequence, new))
            self.progress.update(row.done)


def id_of(question: str, owner: str) -> str:
    """The id of an owner's sweep, by that of its question.

    Every owner has a sweep of his own, though another may have asked the same: what one stops or
    deletes, the other goes on with.
    """
    return question if owner == LOCAL else identity(owner, question)


class Sweeps:
    """The sweeps that this process runs, by id; and all that are stored."""

    def __init__(self, engine: Engine, store: Store, settings: Settings) -> None:
        self.engine, self._settings = engine, settings
        self.store = SweepStore(store, settings.lease_s)
        self.work: Work[SweepRow, SweepRunner] = Work(self.store, self._begin)

    async def accept(self, question: SweepQuestion, owner: str) -> SweepRow:
        """Accept an owner's sweep, or join it, or continue one that was dismissed."""
        runners, id = self.work.runners, id_of(question.id, owner)
        most, own = self._settings.max_sweeps, [r for r in runners.values() if r.owner == owner]
        owners = len({owner, *(runner.owner for runner in runners.values())})
        if id not in runners and len(runners) >= most and len(own) >= most // owners:
            left = [runner.seconds_left for runner in own or runners.values()]
            again_s = math.ceil(min((s for s in left if s is not None), default=UNKNOWN_S))
            raise ProblemType.BUSY(
                f"{len(runners)} sweeps are running already, {len(own)} of them yours. Try again "
                f"in {again_s} s, when one may have ended, or stop one.",
                {"Retry-After": str(max(1, again_s))},
            )
        return await self._accept(question, owner)

    async def _accept(self, question: SweepQuestion, owner: str) -> SweepRow:
        row = SweepRow(
            id=id_of(question.id, owner), belongs_to=owner, engine=ENGINE_NUMBER,
            name=question.name, created=datetime.now(UTC), state="accepted",
            spec=question.text.encode(), size=question.size, quantities=[], axes=question.axes,
            **dict.fromkeys(STATUSES, 0),
        )  # fmt: skip
        row = await self.store.accept(row)
        await self.work.start(row)
        return row

    async def resume(self) -> None:
        """Continue sweeps that no process works on: now, and whenever another process has died."""
        await self.work.resume()

    async def _begin(self, row: SweepRow) -> SweepRunner | None:
        if row.engine < ENGINE_NUMBER:
            await self._renew(row)
            return None
        return SweepRunner(row, self.engine, self.store, self._settings)

    async def _renew(self, row: SweepRow) -> None:
        """End a sweep that an earlier engine began, and begin its question anew.

        Items of two engines do not go into one table. What is done of the old one is kept.
        """
        await self.store.end(row.sequence, "dismissed")
        try:
            spec = await spec_of(row)
        except ValidationError:
            log.warning("the spec of a sweep that an earlier engine began cannot be read")
            return
        await self._accept(sweep_question(spec), row.belongs_to)

    def progress(self, name: str) -> Progress | None:
        """The progress of a sweep that this process runs."""
        runner = self.work.runners.get(name)
        return None if runner is None else runner.progress

    async def dismiss(self, row: SweepRow) -> SweepRow | None:
        """Stop a running sweep and keep what is done; None where it had ended already."""
        runner = self.work.runners.get(row.id)
        ended = await self.store.end(row.sequence, "dismissed")
        if runner is not None:
            await runner.stop()
            await asyncio.wait({runner.task})
        return None if ended is None else await self.store.find(row.id, None)

    async def close(self) -> None:
        """Stop everything; it is continued at the next start."""
        await self.work.close()
