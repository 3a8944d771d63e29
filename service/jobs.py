"""Designs under way: the same question asked twice is worked on once, and the answer is kept."""

from __future__ import annotations

import asyncio
import hashlib
from datetime import UTC, datetime

from service.engine import Engine
from service.errors import Dismissed
from service.metrics import Metrics
from service.problem import described
from service.settings import Settings
from service.store import DesignRow, Store
from synthesis.design import design_id
from synthesis.spec import DesignSpec


class Jobs:
    """What is being worked on in this process, by design id."""

    def __init__(self, engine: Engine, store: Store, metrics: Metrics, settings: Settings) -> None:
        self.engine, self.store = engine, store
        self._metrics, self._settings = metrics, settings
        self._tasks: dict[str, asyncio.Task[DesignRow]] = {}

    def start(self, spec: DesignSpec) -> asyncio.Task[DesignRow]:
        """Work on a design, or join the work on it; the task ends when the answer is kept."""
        name = design_id(spec)
        if name not in self._tasks:
            self.engine.admit()
        return self._begun(name, spec)

    async def accept(self, spec: DesignSpec) -> DesignRow:
        """Note a design as accepted, so that it outlives this process, and start it."""
        name = design_id(spec)
        if name not in self._tasks:
            self.engine.admit()
        row = await self.store.put(self._row(name, spec, "accepted"))
        if row.state != "done":
            self._begun(name, spec)
        return row

    async def resume(self) -> None:
        """Start again what a process before this one had accepted and not finished."""
        for row in await self.store.unfinished():
            self._begun(row.id, DesignSpec.model_validate_json(row.spec))

    def _begun(self, name: str, spec: DesignSpec) -> asyncio.Task[DesignRow]:
        task = self._tasks.get(name)
        if task is None:
            task = self._tasks[name] = asyncio.create_task(self._run(name, spec))
            task.add_done_callback(lambda done: self._over(name, done))
        return task

    async def dismiss(self, name: str) -> bool:
        """Stop and forget a design; whether there was one."""
        task = self._tasks.get(name)
        if task is not None:
            task.cancel()
        return await self.store.remove(name) or task is not None

    async def close(self) -> None:
        """Stop everything; what was accepted is resumed at the next start."""
        tasks = list(self._tasks.values())
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)

    async def _run(self, name: str, spec: DesignSpec) -> DesignRow:
        row = self._row(name, spec, "done")
        try:
            budget = self._settings.budget_s(spec.time_budget_s)
            answer = await self.engine.solve(row.spec, budget)
        except Exception as error:
            await self._failed(name, error)
            raise
        self._metrics.solved(answer.status, answer.seconds)
        row.status, row.summary, row.design = answer.status, answer.summary, answer.design
        row.etag = hashlib.sha256(answer.design).hexdigest()[:32]
        return await self.store.put(row)

    async def _failed(self, name: str, error: Exception) -> None:
        problem = described(error)
        self._metrics.failed(problem["type"].rpartition("/")[2])
        await self.store.fail(name, problem)

    def _over(self, name: str, task: asyncio.Task[DesignRow]) -> None:
        del self._tasks[name]
        if not task.cancelled():
            task.exception()  # seen: whoever waits gets it, and nobody has to

    @staticmethod
    def _row(name: str, spec: DesignSpec, state: str) -> DesignRow:
        return DesignRow(
            id=name,
            name=spec.name,
            created=datetime.now(UTC),
            state=state,
            spec=spec.model_dump_json().encode(),
            summary={},
        )


async def finished(task: asyncio.Task[DesignRow]) -> DesignRow:
    """The task's row; the work goes on when the caller who waits goes away."""
    try:
        return await asyncio.shield(task)
    except asyncio.CancelledError:
        if task.cancelled():
            raise Dismissed("The design was deleted while it was being worked on.") from None
        raise
