"""One sweep under way: chunks go out, answers come back and are kept, until none is left."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Awaitable, Callable
from dataclasses import replace
from typing import Any, TypeVar

from sqlalchemy.exc import InterfaceError, OperationalError

from service.settings import Settings
from service.sweeps.chunks import CHAIN, STRIKES, Chunks
from service.sweeps.lease import Leases
from service.sweeps.progress import Progress
from service.sweeps.store import Done, NotOurs, SweepRow, SweepStore
from service.sweeps.work import SLICE_S, ItemAnswer, solve_items
from service.wire.errors import EngineUnreachable, WorkerLost
from service.wire.problem import described
from service.workers.engine import Engine, new_name
from synthesis.errors import TimeBudgetExceeded
from synthesis.sweeps import SweepSpec

log = logging.getLogger("camwright.sweeps")
AGAIN_S = 0.5  # after the engine or the store was not there
LOOK_S = 0.5  # between looks whether the sweep is still ours to work on
T = TypeVar("T")


class Run:
    """A sweep that this process works on, and holds the lease of."""

    def __init__(
        self, row: SweepRow, engine: Engine, store: SweepStore, leases: Leases, settings: Settings
    ) -> None:
        self._row, self._engine, self._store, self._leases = row, engine, store, leases
        self._spec = SweepSpec.model_validate_json(row.spec)
        self._budget_s = settings.budget_s(self._spec.base.time_budget_s)
        self._sent = self._spec.without_values().model_dump_json().encode()
        self._writing = asyncio.Lock()
        self._stopping = False
        self._flights: dict[asyncio.Task[None], str] = {}  # chunks under way, by name
        self._near: dict[int, Any] = {}  # what an item that was not begun goes on from
        self.progress = Progress()

    async def work(self) -> None:
        """Until every item is finished, or the sweep is stopped, or not ours any more."""
        number = self._row.sequence
        held = asyncio.create_task(self._held())
        try:
            done = await self._store.done_numbers(number)
            strikes = await self._store.strikes(number)
            chain = CHAIN if self._spec.warm_start else 1
            chunks = Chunks(self._row.size, done, self._engine.slots, strikes, chain)
            await self._store.start(number)
            self.progress.advanced(len(done))
            del done
            await self._sent_out(chunks)
            if not self._stopping:
                await self._ended()
        except NotOurs:
            log.info("a sweep is left to others")
        finally:
            held.cancel()
            for flight in self._flights:
                flight.cancel()
            self.progress.woken()

    async def _held(self) -> None:
        """Renew the lease, until it is gone: then the sweep was dismissed, or is another's."""
        while True:
            await asyncio.sleep(min(LOOK_S, 0.25 * self._leases.length_s))
            try:
                ours = await self._leases.renew(self._row.sequence)
            except (InterfaceError, OperationalError):
                continue  # nobody else can take it either
            if not ours:
                await self.stop()
                return

    async def stop(self) -> None:
        """Send nothing more, and stop what is being worked on: what is done of it is kept."""
        self._stopping = True
        if not self._flights:
            return
        landed = asyncio.gather(*self._flights, return_exceptions=True)
        if not await self._engine.stop(list(self._flights.values()), landed):
            for flight in self._flights:
                flight.cancel()

    async def _sent_out(self, chunks: Chunks) -> None:
        while True:
            chunks.workers = self._engine.slots
            # One more than there are workers: it waits while another's answers are being kept.
            while not self._stopping and len(self._flights) <= self._engine.slots:
                wanted = chunks.take()
                if not wanted:
                    break
                name = new_name()
                flight = asyncio.create_task(self._flown(chunks, wanted, name))
                self._flights[flight] = name
            if not self._flights:
                return
            landed, _ = await asyncio.wait(self._flights, return_when=asyncio.FIRST_COMPLETED)
            for flight in landed:
                del self._flights[flight]
                if not flight.cancelled():
                    flight.result()

    async def _flown(self, chunks: Chunks, numbers: list[int], name: str) -> None:
        """One chunk: there, back, and into the store."""
        wanted = [(number, self._spec.picks(number)) for number in numbers]
        try:
            answers = await self._engine.run(
                solve_items, self._sent, wanted, self._budget_s, self._engine.task,
                self._near.get(numbers[0]),
                budget_s=self._budget_s + SLICE_S, behind=True, name=name,
            )  # fmt: skip
        except EngineUnreachable:
            chunks.back(numbers)
            await asyncio.sleep(AGAIN_S)
            return
        except (WorkerLost, TimeBudgetExceeded) as error:
            suspects = chunks.undone(numbers)
            if not await self._to_blame(chunks, suspects):
                return
            answers, numbers = [_blamed(suspects[0], error)], suspects
        for answer in answers:
            chunks.took(answer.seconds)
        self._near.pop(numbers[0], None)
        left = numbers[len(answers) :]
        if left and answers:
            self._near[left[0]] = answers[-1].near
        chunks.back(left)
        values = dict(wanted)
        new = [answer for answer in answers if chunks.finish(answer.number)]
        if new:
            done = [(replace(answer, near=None), values[answer.number]) for answer in new]
            await self._kept(done)

    async def _to_blame(self, chunks: Chunks, numbers: list[int]) -> bool:
        """Keep that a worker was lost at these; whether for the last time, else they come again."""
        strikes = chunks.struck(numbers)
        await self._written(lambda: self._store.note_strikes(self._row.sequence, strikes))
        if max(strikes.values()) >= STRIKES:
            return True
        for number in numbers:
            chunks.back([number])
        return False

    async def _kept(self, done: list[Done]) -> None:
        number, owner = self._row.sequence, self._leases.owner
        async with self._writing:  # their order in the store is the order in which they are seen
            row = await self._written(lambda: self._store.record(number, owner, done))
            self.progress.advanced(row.done)

    async def _written(self, write: Callable[[], Awaitable[T]]) -> T:
        """Write to the store, when it is there again if need be; what is begun is waited for."""
        while True:
            writing = asyncio.ensure_future(write())
            try:
                return await asyncio.shield(writing)
            except asyncio.CancelledError:
                await asyncio.wait({writing})
                raise
            except (InterfaceError, OperationalError):
                log.exception("the store cannot be reached; finished items wait for it")
                await asyncio.sleep(AGAIN_S)

    async def _ended(self) -> None:
        row = await self._store.find(self._row.id)
        if row is not None:
            state = "failed" if row.failed == row.size else "successful"
            await self._store.end(row.sequence, state, self._leases.owner)


def _blamed(number: int, error: Exception) -> ItemAnswer:
    """An item that takes its worker with it every time, or that nothing stops in time."""
    problem = described(error)
    problem["detail"] = (
        f"Its worker was lost {STRIKES} times at this item, the last times at nothing else: it "
        "died, perhaps for want of memory, or overran its time budget and had to be stopped. "
        f"The last time: {error}"
    )
    return ItemAnswer(number, "failed", problem=problem)
