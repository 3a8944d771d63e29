"""Questions being worked on; work on the same question is shared."""

from __future__ import annotations

import asyncio
import hashlib
import time
from datetime import UTC, datetime
from typing import Any

from pydantic import ValidationError

from service.resources.resource import Resource
from service.settings import Settings
from service.storage.store import Answers, Store
from service.storage.tables import AnswerRow
from service.wire.errors import ProblemType, ServiceError
from service.wire.observe import Metrics
from service.wire.problem import problem_of
from service.workers.engine import Engine
from synthesis.design.identity import ENGINE_NUMBER


class Jobs:
    """What this process works on of one resource, by id; and the answers that are kept of it."""

    def __init__(
        self, resource: Resource, engine: Engine, store: Store, metrics: Metrics, settings: Settings
    ) -> None:
        self.resource, self.engine = resource, engine
        self.answers = Answers(resource.path, store, resource.elsewhere)
        self._metrics, self._settings = metrics, settings
        self._tasks: dict[str, asyncio.Task[AnswerRow]] = {}

    async def find(self, id: str, owner: str | None) -> AnswerRow:
        """The answer with this id, by this engine, if the owner holds it (None: in any case).

        Where an earlier engine gave it, its question is accepted anew and the answer dropped: the
        row returned has the id that the question has on this engine.
        ServiceError where there is none, or its spec cannot be read any more.
        """
        row = await self.answers.find(id, owner)
        if row is None:
            raise self.unknown(id)
        if row.engine >= ENGINE_NUMBER:
            return row
        try:
            spec = self.resource.spec.model_validate_json(row.spec)
        except ValidationError:
            raise self.resource.unknown(
                f"{self.resource.noun.capitalize()} {id} was made by an earlier engine, and this "
                f"one cannot read its spec. POST it to {self.resource.path} in today's form, as "
                "in /docs."
            ) from None
        current = await self.answers.find(self.resource.id_of(spec), owner)
        if current is None:
            current = await self._accept(spec)
        await self.answers.supersede(id, current.id)
        return current

    async def find_done(self, id: str, owner: str) -> tuple[AnswerRow, bytes]:
        """As ``find``, with its body; ServiceError too where it is not done, or failed."""
        row = await self.find(id, owner)
        if row.state != "done" or row.body is None:
            noun, path = self.resource.noun.capitalize(), self.resource.at(row.id)
            renewed = "" if row.id == id else " An earlier engine made it; it is being made anew."
            raise ProblemType.NOT_DONE(
                f"{noun} {row.id} is {row.state}: GET {path} says how it stands.{renewed}"
            )
        return row, row.body

    def unknown(self, id: str) -> ServiceError:
        """The error for an id that does not exist."""
        resource = self.resource
        return resource.unknown(
            f"There is no {resource.noun} {id[:64]!r}. GET {resource.path} lists those there are; "
            "POST the spec again to make it anew."
        )

    def start(self, spec: Any) -> asyncio.Task[AnswerRow]:
        """Work on a question, or join the work on it; the task ends when the answer is kept."""
        id = self.resource.id_of(spec)
        if id not in self._tasks:
            self.engine.admit()
        return self._task(id, spec)

    async def accept(self, spec: Any) -> AnswerRow:
        """Note a question as accepted, so that it outlives this process, and start it."""
        if self.resource.id_of(spec) not in self._tasks:
            self.engine.admit()
        return await self._accept(spec)

    async def _accept(self, spec: Any) -> AnswerRow:
        id = self.resource.id_of(spec)
        row = await self.answers.put(self._row(id, spec, "accepted"))
        if row.state != "done":
            self._task(id, spec)
        return row

    async def resume(self) -> None:
        """Start again what a process before this one had accepted and not finished."""
        for row in await self.answers.unfinished():
            if row.engine >= ENGINE_NUMBER:
                self._task(row.id, self.resource.spec.model_validate_json(row.spec))
                continue
            try:
                await self.find(row.id, None)
            except ServiceError as error:
                await self.answers.fail(row.id, problem_of(error))

    def _task(self, id: str, spec: Any) -> asyncio.Task[AnswerRow]:
        task = self._tasks.get(id)
        if task is None:
            task = self._tasks[id] = asyncio.create_task(self._run(id, spec))
            task.add_done_callback(lambda done: self._remove(id, done))
        return task

    def _remove(self, id: str, task: asyncio.Task[AnswerRow]) -> None:
        del self._tasks[id]
        if not task.cancelled():
            task.exception()  # retrieved, so that asyncio does not log it

    async def dismiss(self, id: str, owner: str) -> bool:
        """Stop and delete what an owner holds; whether there was one.

        What others hold too stays for them as it is.
        """
        there = await self.answers.find(id, owner) is not None
        held, by_others = await self.answers.release(id, owner)
        task = self._tasks.get(id) if held else None
        if held and not by_others:
            if task is not None:
                task.cancel()
            there = await self.answers.remove(id)
        return held and (there or task is not None)

    async def close(self) -> None:
        """Stop everything; what was accepted is resumed at the next start."""
        tasks = list(self._tasks.values())
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)

    async def _run(self, id: str, spec: Any) -> AnswerRow:
        row, began = self._row(id, spec, "done"), time.monotonic()
        try:
            budget = self._settings.budget_s(getattr(spec, "time_budget_s", None))
            answer = await self.engine.solve(row.spec, budget, self.resource.task)
        except Exception as error:
            problem = problem_of(error)
            self._metrics.failures.labels(problem["type"].rpartition("/")[2]).inc()
            await self.answers.fail(id, problem, time.monotonic() - began)
            raise
        self._metrics.solves.labels(answer.status).observe(answer.seconds)
        row.status, row.summary, row.body = answer.status, dict(answer.summary), answer.body
        row.etag = hashlib.sha256(answer.body).hexdigest()[:32]
        return await self.answers.put(row, answer.seconds)

    def _row(self, id: str, spec: Any, state: str) -> AnswerRow:
        return AnswerRow(
            id=id,
            kind=self.resource.path,
            engine=ENGINE_NUMBER,
            name=spec.name,
            created=datetime.now(UTC),
            state=state,
            spec=spec.model_dump_json().encode(),
            summary={},
        )


async def result_of(task: asyncio.Task[AnswerRow]) -> AnswerRow:
    """The row that a task ends with; the task continues if the caller is cancelled."""
    try:
        return await asyncio.shield(task)
    except asyncio.CancelledError:
        if task.cancelled():
            raise ProblemType.DISMISSED(
                "The question was deleted while it was being worked on."
            ) from None
        raise
