"""All sweeps: accepted, continued after a restart, stopped, deleted."""

from __future__ import annotations

import asyncio
import logging
from datetime import UTC, datetime

from pydantic import ValidationError
from sqlalchemy.exc import InterfaceError, OperationalError

from service.settings import Settings
from service.storage.store import Store
from service.sweeps.lease import Leases
from service.sweeps.runner import Progress, SweepRunner
from service.sweeps.store import SweepRow, SweepStore
from service.sweeps.tasks import item_spec
from service.wire.errors import ProblemType, ServiceError
from service.workers.engine import Engine
from synthesis.design.identity import ENGINE_NUMBER
from synthesis.studies.sweeps import SweepSpec
from synthesis.studies.sweeps.spec import sweep_id

log = logging.getLogger("camwright.sweeps")
POLL_S = 1.0  # between searches for sweeps that no process works on
SAMPLED = 8  # items that are validated before a sweep is accepted


class Sweeps:
    """The sweeps that this process runs, by id; and all that are stored."""

    def __init__(self, engine: Engine, store: Store, settings: Settings) -> None:
        self.engine, self.store, self._settings = engine, SweepStore(store), settings
        self._leases = Leases(store, settings.sweep_lease_s)
        self._polling: asyncio.Task[None] | None = None
        self._runners: dict[str, SweepRunner] = {}

    def check(self, spec: SweepSpec) -> None:
        """Refuse a sweep that is too large, or of which no item seems to be valid.

        Invalid items fail one by one when their turn comes: a corner of a grid may be out of reach.
        Where none of some that lie far apart is valid, the sweep is refused.
        """
        most = self._settings.max_sweep_items
        if spec.size > most:
            raise _too_large(spec.size, most)
        shares = (i / max(SAMPLED - 1, 1) for i in range(SAMPLED))
        sample = dict.fromkeys(round(share * (spec.size - 1)) for share in shares)
        first: ServiceError | None = None
        for number in sample:
            try:
                item_spec(spec, spec.item_values(number))
            except ServiceError as error:
                first = first or error
            else:
                return
        assert first is not None
        violations = [{**each, "pointer": f"/base{each['pointer']}"} for each in first.violations]
        raise ProblemType.INVALID_REQUEST(
            f"None of {len(sample)} items that were tried is valid. With the values of item 0: "
            f"{first.detail}", violations=violations,
        )  # fmt: skip

    async def accept(self, spec: SweepSpec) -> SweepRow:
        """Accept a sweep, or join it, or continue one that was dismissed."""
        running = len(self._runners)
        if sweep_id(spec) not in self._runners and running >= self._settings.max_sweeps:
            raise ProblemType.BUSY(
                f"{running} sweeps are running already. Try again when one has ended, or stop one.",
                {"Retry-After": "10"},
            )
        return await self._accept(spec)

    async def _accept(self, spec: SweepSpec) -> SweepRow:
        row = SweepRow(
            id=sweep_id(spec), engine=ENGINE_NUMBER, name=spec.name,
            created=datetime.now(UTC), state="accepted",
            spec=spec.model_dump_json().encode(), size=spec.size, quantities=[],
            axes=[axis.pointer for axis in spec.axes],
            optimal=0, feasible=0, infeasible=0, failed=0,
        )  # fmt: skip
        row = await self.store.accept(row)
        await self._start(row)
        return row

    async def resume(self) -> None:
        """Continue sweeps that no process works on: now, and whenever another process has died."""
        await self._continue_unowned()
        self._polling = asyncio.create_task(self._poll())

    async def _poll(self) -> None:
        while True:
            await asyncio.sleep(min(POLL_S, 0.5 * self._settings.sweep_lease_s))
            try:
                await self._continue_unowned()
            except (InterfaceError, OperationalError):
                log.warning("the store cannot be reached")

    async def _continue_unowned(self) -> None:
        for row in await self._leases.unowned():
            if row.engine < ENGINE_NUMBER:
                await self._renew(row)
            else:
                await self._start(row)

    async def _renew(self, row: SweepRow) -> None:
        """End a sweep that an earlier engine began, and begin its question anew.

        Items of two engines do not go into one table. What is done of the old one is kept.
        """
        await self.store.end(row.sequence, "dismissed")
        try:
            spec = SweepSpec.model_validate_json(row.spec)
        except ValidationError:
            log.warning("the spec of a sweep that an earlier engine began cannot be read")
            return
        await self._accept(spec)

    async def _start(self, row: SweepRow) -> None:
        if row.id in self._runners or not await self._leases.take(row.sequence):
            return
        if row.id in self._runners:  # started meanwhile
            return
        runner = SweepRunner(row, self.engine, self.store, self._leases, self._settings)
        self._runners[row.id] = runner
        runner.task = asyncio.create_task(runner.run())
        runner.task.add_done_callback(lambda _: self._runners.pop(row.id))

    def progress(self, name: str) -> Progress | None:
        """The progress of a sweep that this process runs."""
        runner = self._runners.get(name)
        return None if runner is None else runner.progress

    async def dismiss(self, row: SweepRow) -> SweepRow | None:
        """Stop a running sweep and keep what is done; None where it had ended already."""
        runner = self._runners.get(row.id)
        owner = None if runner is None else self._leases.owner
        ended = await self.store.end(row.sequence, "dismissed", owner)
        if runner is not None:
            await runner.stop()
            await asyncio.wait({runner.task})
        return None if ended is None else await self.store.find(row.id)

    async def close(self) -> None:
        """Stop everything; it is continued at the next start."""
        tasks = [runner.task for runner in self._runners.values()]
        tasks += [] if self._polling is None else [self._polling]
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)


def _too_large(size: int, most: int) -> ServiceError:
    rule = f"makes {size} items; this server takes {most} in a sweep"
    remedy = "Give fewer values, use a Latin hypercube, or split the sweep in parts."
    violation = {"pointer": "/axes", "value": size, "rule": rule, "remedy": remedy}
    return ProblemType.INVALID_REQUEST(f"/axes: {rule}. {remedy}", violations=[violation])
