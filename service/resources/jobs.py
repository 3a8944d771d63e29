"""Work under way: the same question asked twice is worked on once, and the answer is kept."""

from __future__ import annotations

import asyncio
import hashlib
from datetime import UTC, datetime
from typing import Any

from service.resources.resource import Resource
from service.settings import Settings
from service.storage.store import Row, Store
from service.wire.errors import Dismissed
from service.wire.metrics import Metrics
from service.wire.problem import described
from service.workers.engine import Engine


class Jobs:
    """What is being worked on in this process of one kind, by id; and the kind's answers."""

    def __init__(
        self, kind: Resource, engine: Engine, store: Store, metrics: Metrics, settings: Settings
    ) -> None:
        self.kind, self.engine = kind, engine
        self.answers = store.table(kind.row, kind.elsewhere)
        self._metrics, self._settings = metrics, settings
        self._tasks: dict[str, asyncio.Task[Row]] = {}

    def start(self, spec: Any) -> asyncio.Task[Row]:
        """Work on a question, or join the work on it; the task ends when the answer is kept."""
        name = self.kind.name_of(spec)
        if name not in self._tasks:
            self.engine.admit()
        return self._begun(name, spec)

    async def accept(self, spec: Any) -> Row:
        """Note a question as accepted, so that it outlives this process, and start it."""
        name = self.kind.name_of(spec)
        if name not in self._tasks:
            self.engine.admit()
        row = await self.answers.put(self._row(name, spec, "accepted"))
        if row.state != "done":
            self._begun(name, spec)
        return row

    async def resume(self) -> None:
        """Start again what a process before this one had accepted and not finished."""
        for row in await self.answers.unfinished():
            self._begun(row.id, self.kind.spec.model_validate_json(row.spec))

    def _begun(self, name: str, spec: Any) -> asyncio.Task[Row]:
        task = self._tasks.get(name)
        if task is None:
            task = self._tasks[name] = asyncio.create_task(self._run(name, spec))
            task.add_done_callback(lambda done: self._over(name, done))
        return task

    async def dismiss(self, name: str) -> bool:
        """Stop and forget one; whether there was one."""
        task = self._tasks.get(name)
        if task is not None:
            task.cancel()
        return await self.answers.remove(name) or task is not None

    async def close(self) -> None:
        """Stop everything; what was accepted is resumed at the next start."""
        tasks = list(self._tasks.values())
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)

    async def _run(self, name: str, spec: Any) -> Row:
        row = self._row(name, spec, "done")
        try:
            budget = self._settings.budget_s(self.kind.budget_of(spec))
            answer = await self.engine.solve(row.spec, budget, self.kind.task)
        except Exception as error:
            await self._failed(name, error)
            raise
        self._metrics.solved(answer.status, answer.seconds)
        row.status, row.summary, row.design = answer.status, answer.summary, answer.design
        row.etag = hashlib.sha256(answer.design).hexdigest()[:32]
        return await self.answers.put(row)

    async def _failed(self, name: str, error: Exception) -> None:
        problem = described(error)
        self._metrics.failed(problem["type"].rpartition("/")[2])
        await self.answers.fail(name, problem)

    def _over(self, name: str, task: asyncio.Task[Row]) -> None:
        del self._tasks[name]
        if not task.cancelled():
            task.exception()  # seen: whoever waits gets it, and nobody has to

    def _row(self, name: str, spec: Any, state: str) -> Row:
        return self.kind.row(
            id=name,
            name=spec.name,
            created=datetime.now(UTC),
            state=state,
            spec=spec.model_dump_json().encode(),
            summary={},
        )


async def finished(task: asyncio.Task[Row]) -> Row:
    """The task's row; the work goes on when the caller who waits goes away."""
    try:
        return await asyncio.shield(task)
    except asyncio.CancelledError:
        if task.cancelled():
            raise Dismissed("It was deleted while it was being worked on.") from None
        raise
