"""Questions being worked on; work on the same question is shared."""

from __future__ import annotations

import asyncio
import contextlib
import hashlib
import logging
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from datetime import UTC, datetime
from typing import Any

from pydantic import ValidationError

from service.resources.resource import Resource
from service.settings import Settings
from service.storage.answers import Answers
from service.storage.leases import Leases
from service.storage.store import LeaseLost, Store
from service.storage.tables import AnswerRow
from service.wire.errors import ProblemType, ServiceError, problem_type
from service.wire.fair_queue import current_owner
from service.wire.observe import Metrics
from service.wire.problem import problem_of
from service.wire.tracing import tracer
from service.wire.validation import kept_question
from service.work import POLL_S, RETRY_S, STRIKES, Work, retry_transaction
from service.workers.engine import Engine
from service.workers.tasks import Answer
from synthesis.design.identity import ENGINE_NUMBER

log = logging.getLogger("camwright.questions")
DELETED = "The question was deleted while it was being worked on."
MOST_NOTED = 10_000  # answered questions that are known without the store: some 2 MB


class Attempt:
    """The work on one question, in ``task``.

    ``keeping``: its answer, or why there is none, is being kept. ``failed``: there is none, and who
    asks again begins another attempt.
    ``budget_s`` is the time that the core may take for it. ``claimed``: the store has who holds the
    answer; before that nothing of it is kept.
    """

    sequence: int
    task: asyncio.Task[Any]
    keeping = failed = False

    def __init__(self, budget_s: float) -> None:
        self.budget_s, self._began = budget_s, time.monotonic()
        self.claimed = asyncio.Event()
        self.claimed.set()

    @property
    def seconds(self) -> float:
        """Time that the core may have taken for it so far, as it may have waited before [s]."""
        return min(time.monotonic() - self._began, self.budget_s)

    async def stop(self) -> None:
        """End it, unless it has ended but for the keeping: the store sees who may."""
        if not self.keeping:
            self.task.cancel()


Questions = Work[AnswerRow, Attempt]  # of all resources


def questions(store: Store, settings: Settings, jobs: Mapping[str, Jobs]) -> Questions:
    """The accepted questions that this process works on; ``jobs`` of each resource, by path."""
    leases = Leases(AnswerRow, ("accepted",), store, settings.lease_s)
    return Work(leases, lambda row: jobs[row.kind].begin(row))


class Jobs:
    """What this process works on of one resource, by id; and the answers that are kept of it."""

    def __init__(
        self,
        resource: Resource,
        engine: Engine,
        store: Store,
        metrics: Metrics,
        settings: Settings,
        accepted: Questions,
    ) -> None:
        self.resource, self.engine = resource, engine
        self.answers = Answers(resource.path, store, resource.elsewhere)
        self._metrics, self._settings, self._accepted = metrics, settings, accepted
        self._attempts: dict[str, Attempt] = {}
        self._answered: dict[str, None] = {}  # ids of questions that were answered, of late

    async def find(self, id: str, owner: str | None, *, with_body: bool = True) -> AnswerRow:
        """The answer with this id, by this engine, if the owner holds it (None: in any case).

        ``with_body``: whether its body and spec are needed.
        Where an earlier engine gave it, its question is accepted anew and the answer dropped: the
        row returned has the id that the question has on this engine.
        ServiceError where there is none, or its spec cannot be read any more.
        """
        row = await self.answers.find(id, owner, with_body=with_body)
        if row is not None and row.engine < ENGINE_NUMBER and not with_body:
            row = await self.answers.find(id, owner)
        if row is None:
            raise self.unknown(id)
        if row.engine >= ENGINE_NUMBER:
            return row
        try:
            spec = await asyncio.to_thread(self.resource.spec.model_validate_json, row.spec)
        except ValidationError:
            raise self.resource.unknown(
                f"{self.resource.noun.capitalize()} {id} was made by an earlier engine, and this "
                f"one cannot read its spec. POST it to {self.resource.path} in today's form, as "
                "in /docs."
            ) from None
        current = await self.answers.find(self.resource.id_of(spec), owner)
        if current is None:
            current = await self.accept(spec)
        await self.answers.supersede(id, current.id)
        return current

    async def find_done(self, id: str, owner: str, *, with_body: bool = False) -> AnswerRow:
        """As ``find``, but for the body; ServiceError too where it is not done, or failed."""
        row = await self.find(id, owner, with_body=with_body)
        if row.state != "done":
            noun, path = self.resource.noun.capitalize(), self.resource.at(row.id)
            renewed = "" if row.id == id else " An earlier engine made it; it is being made anew."
            raise ProblemType.NOT_DONE(
                f"{noun} {row.id} is {row.state}: GET {path} says how it stands.{renewed}"
            )
        return row

    async def body(self, row: AnswerRow) -> bytes:
        """The body of an answer that is done; ServiceError where it was deleted just now."""
        body = await self.answers.body(row)
        if body is None:
            raise self.unknown(row.id)
        return body

    def unknown(self, id: str) -> ServiceError:
        """The error for an id that does not exist."""
        resource = self.resource
        return resource.unknown(
            f"There is no {resource.noun} {id[:64]!r}. GET {resource.path} lists those there are; "
            "POST the spec again to make it anew."
        )

    @contextmanager
    def room(self, id: str) -> Iterator[None]:
        """A place in the queue for a question that is being accepted; ServiceError: there is none.

        One that is in the queue already takes no other.
        """
        with contextlib.nullcontext() if id in self._attempts else self.engine.queue.room(id):
            yield

    async def claim(self, id: str, spec: Any, owner: str, at_once: bool) -> AnswerRow | None:
        """Let an owner hold the answer to a question that he has asked; the answer, if any.

        Args:
            at_once: there is a worker for it: the work begins before the store has looked whether
                there is an answer. Most are new. Nothing is written or answered before it has: if
                there is one, if another process works on it, or if the store fails, that work is
                cancelled.
        """
        if not at_once or id in self._attempts or id in self._answered:
            return self._note(await self.answers.claim(id, owner))
        unclaimed = self._attempt(id, spec, current_owner.get() or owner)
        unclaimed.claimed.clear()
        try:
            for _ in range(2):  # it begins, and sends its task to the worker
                await asyncio.sleep(0)
            row = await self.answers.claim(id, owner)
        except BaseException:
            unclaimed.task.cancel()
            raise
        if not self._is_open(row):
            unclaimed.task.cancel()
        elif unclaimed.task.cancelled() and not await self.answers.is_held(id, owner):
            raise ProblemType.DISMISSED(DELETED)  # between the store's answer and this line
        else:
            unclaimed.claimed.set()
        return self._note(row)

    def _is_open(self, row: AnswerRow | None) -> bool:
        """Whether it is for this process to work on what a claim has found."""
        if row is not None and row.state == "accepted":
            return row.id in self._accepted.runners  # else another one has its lease, or will have
        return row is None or row.state != "done"

    def _note(self, row: AnswerRow | None) -> AnswerRow | None:
        """Note that a question is answered: who asks it again waits for the store's answer."""
        if row is not None and row.state == "done":
            if len(self._answered) >= MOST_NOTED:
                del self._answered[next(iter(self._answered))]
            self._answered[row.id] = None
        return row

    async def answer(self, spec: Any, known: AnswerRow | None, owner: str) -> AnswerRow:
        """Work on a question, or wait for whoever does: its answer, or that it failed.

        ``known`` is its row in the store, which is not done. A question that nobody has accepted is
        not kept: whoever asks is still there, and asks again.
        """
        id, row = self.resource.id_of(spec), known
        while True:
            if row is not None and row.state == "accepted":
                await self._accepted.start(row)
            attempt = self._attempts.get(id)
            if attempt is not None or row is None or row.state != "accepted":
                attempt = self._attempt(id, spec, current_owner.get() or owner)
                try:
                    return await asyncio.shield(attempt.task)
                except asyncio.CancelledError:
                    if not attempt.task.cancelled():
                        raise  # who asks has gone; the work goes on
                except LeaseLost:
                    pass  # as when it is stopped: see who has it
            else:  # another process works on it
                await asyncio.sleep(POLL_S)
            row = await self.answers.find(id, owner)
            if row is None and not await self.answers.is_held(id, owner):
                raise ProblemType.DISMISSED(DELETED)
            if row is not None and row.state in ("done", "failed"):
                return row

    async def accept(self, spec: Any) -> AnswerRow:
        """Note a question as accepted, so that it outlives this process, and start it."""
        row = await self.answers.accept(self._row(self.resource.id_of(spec), spec, "accepted"))
        if row.state == "accepted":
            await self._accepted.start(row)
        return row

    async def begin(self, row: AnswerRow) -> Attempt | None:
        """Work on an accepted question, whose lease this process has."""
        if row.engine >= ENGINE_NUMBER:
            owner = current_owner.get() or await self.answers.first_owner(row.id)
            attempt = self._attempt(row.id, kept_question(row.name, row.spec), owner)
            attempt.sequence = row.sequence
            return attempt
        try:
            await self.find(row.id, None)
        except ServiceError as error:
            await self.answers.fail(row.id, problem_of(error))
        return None

    def _attempt(self, id: str, spec: Any, owner: str) -> Attempt:
        attempt = self._attempts.get(id)
        if attempt is None or attempt.failed:
            attempt = self._attempts[id] = Attempt(
                self._settings.budget_s(getattr(spec, "time_budget_s", None))
            )
            attempt.task = asyncio.create_task(self._run(attempt, id, spec, owner))
            begun = attempt
            begun.task.add_done_callback(lambda _: self._remove(id, begun))
        return attempt

    def _remove(self, id: str, ended: Attempt) -> None:
        if self._attempts.get(id) is ended:
            del self._attempts[id]
        if not ended.task.cancelled():
            ended.task.exception()  # retrieved, so that asyncio does not log it

    async def dismiss(self, id: str, owner: str) -> bool:
        """Stop and delete what an owner holds; whether there was one.

        What others hold too stays for them as it is.
        """
        attempt = self._attempts.get(id)
        seconds = 0.0 if attempt is None else attempt.seconds
        held, by_others, kept = await self.answers.release(id, owner, seconds)
        if held and not by_others and attempt is not None:
            attempt.task.cancel()
            await asyncio.wait({attempt.task})
            await self.answers.remove(id)  # what it may have kept meanwhile
        return held and (kept or attempt is not None)

    async def close(self) -> None:
        """Stop everything; what was accepted is resumed at the next start."""
        tasks = [attempt.task for attempt in self._attempts.values()]
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)

    async def _run(self, attempt: Attempt, id: str, spec: Any, owner: str) -> AnswerRow:
        current_owner.set(owner)
        with tracer.start_as_current_span("question", record_exception=False) as span:
            span.set_attributes({"kind": self.resource.path, "id": id})
            return await self._work_on(attempt, id, spec)

    async def _work_on(self, attempt: Attempt, id: str, spec: Any) -> AnswerRow:
        row = self._row(id, spec, "done")
        try:
            answer = await self._solve(row, attempt)
        except Exception as error:
            await attempt.claimed.wait()
            problem = problem_of(error)
            self._metrics.failures.labels(problem["type"].rpartition("/")[2]).inc()
            if problem_type(error) is ProblemType.INTERNAL and id in self._accepted.runners:
                log.error("unexpected", exc_info=error)
            attempt.keeping = attempt.failed = True
            await retry_transaction(lambda: self.answers.fail(id, problem, attempt.seconds))
            raise
        row.status, row.summary, row.body = answer.status, dict(answer.summary), answer.body
        row.etag = hashlib.sha256(answer.body).hexdigest()[:32]
        await attempt.claimed.wait()
        attempt.keeping = True
        accepted = id in self._accepted.runners
        kept = await retry_transaction(lambda: self.answers.finish(row, accepted, answer.seconds))
        self._note(kept)
        return kept

    async def _solve(self, row: AnswerRow, attempt: Attempt) -> Answer:
        """Have a worker answer; again, until it has killed too many of them."""
        strikes = 0
        while True:
            try:
                return await self.engine.solve(row.spec, attempt.budget_s, self.resource.task)
            except ServiceError as error:
                if error.problem is ProblemType.ENGINE_UNREACHABLE:
                    if row.id not in self._accepted.runners:
                        raise  # who asks is told to come back
                    await asyncio.sleep(RETRY_S)
                    continue
                if error.problem is not ProblemType.WORKER_LOST:
                    raise
                await attempt.claimed.wait()  # it may be for another process to count them
                kept = await retry_transaction(lambda: self.answers.add_strike(row.id))
                strikes = max(strikes + 1, kept)
                if strikes >= STRIKES:
                    raise ProblemType.WORKER_LOST(
                        f"It has taken {strikes} worker processes with it, and is not tried again "
                        f"by itself. The last time: {error.detail}",
                        error.headers,
                    ) from None

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
