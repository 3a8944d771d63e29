"""All sweeps of this process: taken on, gone on with after a restart, stopped, forgotten."""

from __future__ import annotations

import asyncio
import logging
from datetime import UTC, datetime

from sqlalchemy.exc import InterfaceError, OperationalError

from service.settings import Settings
from service.storage.store import Store
from service.sweeps.lease import Leases
from service.sweeps.progress import Progress
from service.sweeps.run import Run
from service.sweeps.store import SweepRow, SweepStore
from service.sweeps.work import item_spec
from service.wire.errors import Busy, InvalidBody
from service.workers.engine import Engine
from synthesis.design import engine_version
from synthesis.sweeps import SweepSpec
from synthesis.sweeps.spec import sweep_id

log = logging.getLogger("camwright.sweeps")
LOOK_S = 1.0  # between looks for sweeps that nobody works on
TRIED = 8  # items looked at before a sweep is taken on


class Sweeps:
    """What is being swept in this process, by id; and all sweeps that are kept."""

    def __init__(self, engine: Engine, store: Store, settings: Settings) -> None:
        self.engine, self.store, self._settings = engine, SweepStore(store.do), settings
        self._leases = Leases(store.do, settings.sweep_lease_s)
        self._looking: asyncio.Task[None] | None = None
        self._runs: dict[str, Run] = {}
        self._tasks: dict[str, asyncio.Task[None]] = {}

    @staticmethod
    def name_of(spec: SweepSpec) -> str:
        """The sweep's id on this engine."""
        return sweep_id(spec, engine_version())

    def check(self, spec: SweepSpec) -> None:
        """Refuse what is too large, and what makes no sense anywhere.

        Items that make no sense are told one by one when their turn comes: a corner of a grid may
        be out of reach. Where none of some that lie far apart makes sense, the sweep is refused.
        """
        most = self._settings.max_sweep_items
        if spec.size > most:
            raise _too_large(spec.size, most)
        shares = (i / max(TRIED - 1, 1) for i in range(TRIED))
        tried = dict.fromkeys(round(share * (spec.size - 1)) for share in shares)
        first: InvalidBody | None = None
        for number in tried:
            try:
                item_spec(spec, spec.picks(number))
            except InvalidBody as error:
                first = first or error
            else:
                return
        assert first is not None
        found = [{**each, "pointer": f"/base{each['pointer']}"} for each in first.violations]
        raise InvalidBody(
            f"None of {len(tried)} items that were tried makes sense. With the values of item 0: "
            f"{first.detail}", found,
        )  # fmt: skip

    async def accept(self, spec: SweepSpec) -> SweepRow:
        """Take a sweep on, or join it, or go on with one that was dismissed."""
        name = self.name_of(spec)
        if name not in self._runs and len(self._runs) >= self._settings.max_sweeps:
            raise Busy(
                f"{len(self._runs)} sweeps are under way already. Try again when one has ended, "
                "or dismiss one.",
                {"Retry-After": "10"},
            )
        row = SweepRow(
            id=name, name=spec.name, created=datetime.now(UTC), state="accepted",
            spec=spec.model_dump_json().encode(), size=spec.size, quantities=[],
            axes=[axis.pointer for axis in spec.axes],
            optimal=0, feasible=0, infeasible=0, failed=0,
        )  # fmt: skip
        kept = await self.store.accept(row)
        await self._begin(kept)
        return kept

    async def resume(self) -> None:
        """Go on with what nobody works on: now, and whenever another process has died."""
        await self._adopt()
        self._looking = asyncio.create_task(self._look())

    async def _look(self) -> None:
        while True:
            await asyncio.sleep(min(LOOK_S, 0.5 * self._settings.sweep_lease_s))
            try:
                await self._adopt()
            except (InterfaceError, OperationalError):
                log.warning("the store cannot be reached")

    async def _adopt(self) -> None:
        for row in await self._leases.nobodys():
            await self._begin(row)

    async def _begin(self, row: SweepRow) -> None:
        if row.id in self._runs or not await self._leases.take(row.sequence):
            return
        if row.id in self._runs:  # begun meanwhile
            return
        run = Run(row, self.engine, self.store, self._leases, self._settings)
        self._runs[row.id] = run
        self._tasks[row.id] = asyncio.create_task(self._worked(row, run))

    async def _worked(self, row: SweepRow, run: Run) -> None:
        try:
            await run.work()
        except Exception:
            log.exception("a sweep cannot go on")
            await self.store.end(row.sequence, "failed", self._leases.owner)
        finally:
            try:
                await self._leases.release(row.sequence)
            except (InterfaceError, OperationalError):
                log.warning("the store cannot be reached; a lease runs out by itself")
            finally:
                del self._runs[row.id], self._tasks[row.id]

    def progress(self, name: str) -> Progress | None:
        """How one that is under way here gets on."""
        run = self._runs.get(name)
        return None if run is None else run.progress

    async def dismiss(self, row: SweepRow) -> SweepRow | None:
        """Stop one that is under way and keep what is done; None where it was over already."""
        run, task = self._runs.get(row.id), self._tasks.get(row.id)
        here = None if run is None else self._leases.owner
        ended = await self.store.end(row.sequence, "dismissed", here)
        if run is not None and task is not None:
            await run.stop()
            await asyncio.wait({task})
        return None if ended is None else await self.store.find(row.id)

    async def close(self) -> None:
        """Stop everything; it is gone on with at the next start."""
        if self._looking is not None:
            self._looking.cancel()
        tasks = list(self._tasks.values())
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)


def _too_large(size: int, most: int) -> InvalidBody:
    rule = f"makes {size} items; this server takes {most} in a sweep"
    way_out = "Give fewer values, use a Latin hypercube, or split the sweep in parts."
    found = {"pointer": "/axes", "value": size, "rule": rule, "way_out": way_out}
    return InvalidBody(f"/axes: {rule}. {way_out}", [found])
