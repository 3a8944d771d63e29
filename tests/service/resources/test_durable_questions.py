"""An accepted question outlives faults of workers, store, engine and process, and is answered."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy.exc import OperationalError

from service import work as work_module
from service.resources import jobs as jobs_module
from service.resources.jobs import Jobs, Questions, questions
from service.resources.records import DESIGNS, RESOURCES
from service.storage.store import Store
from service.storage.tables import LOCAL, AnswerRow
from service.wire.errors import ProblemType, ServiceError
from service.wire.observe import Metrics
from service.workers.tasks import Answer
from synthesis.errors import InputError
from synthesis.spec.design_spec import DesignSpec
from tests.service.conftest import settings_for
from tests.service.specs import spec

Solve = Callable[[], Awaitable[None]]
LONG_S = 600.0  # of a lease that does not end while a test runs, however busy the machine
LOST = ProblemType.WORKER_LOST("It died.", {"Retry-After": "2"})


class MadeUp:
    """An engine that answers after it has done as a function says, and counts how often."""

    def __init__(self, work: Solve) -> None:
        self._work, self.begun = work, 0

    def admit(self) -> None:
        """There is always room."""

    async def solve(self, *_: Any) -> Answer:
        self.begun += 1
        await self._work()
        return Answer(b"{}", "optimal", {}, 0.01)


class Service:
    """One process of those that share a store; its leases end when they are told to."""

    def __init__(self, folder: Path, store: Store, work: Solve, lease_s: float = 60.0) -> None:
        settings = settings_for(folder, lease_s=lease_s)
        self.engine, self._jobs = MadeUp(work), dict[str, Jobs]()
        self.accepted: Questions = questions(store, settings, self._jobs)
        for path, resource in RESOURCES.items():
            self._jobs[path] = Jobs(
                resource, self.engine, store, Metrics(), settings, self.accepted,  # type: ignore[arg-type]
            )  # fmt: skip
        self.designs = self._jobs[DESIGNS.path]

    async def accept(self, spec: Any) -> AnswerRow:
        """As when the local owner asks."""
        await self.designs.answers.claim(DESIGNS.id_of(spec), LOCAL)
        return await self.designs.accept(spec)

    async def answer(self, spec: Any, known: AnswerRow | None) -> AnswerRow:
        """As when the local owner waits for it."""
        return await self.designs.answer(spec, known, LOCAL)

    async def ends(self, id: str, *states: str) -> Any:
        """The row of a design, once it is in one of these states."""
        async with asyncio.timeout(60.0):
            while True:
                row = await self.designs.answers.find(id, LOCAL)
                if row is not None and row.state in states:
                    return row
                await asyncio.sleep(0.01)


@pytest.fixture(autouse=True)
def soon(monkeypatch: pytest.MonkeyPatch) -> None:
    for module in (work_module, jobs_module):
        for name in ("RETRY_S", "POLL_S"):
            monkeypatch.setattr(module, name, 0.01)
    monkeypatch.setattr(work_module, "RENEWAL_S", 0.01)


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    store = Store(settings_for(tmp_path))
    yield store
    store.dispose()


async def at_once() -> None:
    """As fast as a solve may be."""


async def forever() -> None:
    await asyncio.Event().wait()


def raising(*errors: Exception, then: Solve = at_once) -> Solve:
    """What raises these in turn, and then does something else."""
    left = list(errors)

    async def work() -> None:
        if left:
            raise left.pop(0)
        await then()

    return work


def question() -> DesignSpec:
    return DesignSpec.model_validate(spec("q"))


@pytest.mark.parametrize(
    ("errors", "begun"),
    [([LOST, LOST], 3), ([ProblemType.ENGINE_UNREACHABLE("away")] * 7, 8)],
    ids=["worker killed", "engine away"],
)
def test_who_did_nothing_wrong_is_tried_again_unseen(
    tmp_path: Path, store: Store, errors: list[Exception], begun: int
) -> None:
    async def story() -> None:
        one = Service(tmp_path, store, raising(*errors))
        row = await one.accept(question())
        row = await one.ends(row.id, "done", "failed")
        assert (row.state, row.leased_by, row.leased_until) == ("done", None, None)
        assert one.engine.begun == begun

    asyncio.run(story())


def test_what_kills_its_workers_is_given_up_and_can_be_asked_again(
    tmp_path: Path, store: Store
) -> None:
    """Its strikes outlive the process; asked again it has none."""

    async def story() -> None:
        spec = question()
        one = Service(tmp_path, store, raising(LOST, LOST, then=forever))
        id = (await one.accept(spec)).id
        while one.engine.begun < 3:  # noqa: ASYNC110 (a counter, of an engine made up)
            await asyncio.sleep(0.01)
        await one.accepted.close()
        other = Service(tmp_path, store, raising(LOST))
        await other.accepted.resume()
        failed = await other.ends(id, "failed", "done")
        assert (failed.state, failed.strikes, other.engine.begun) == ("failed", 3, 1)
        assert "taken 3 worker processes" in failed.problem["detail"]
        assert (await other.accept(spec)).state == "accepted"
        assert (await other.ends(id, "failed", "done")).state == "done"
        await other.accepted.close()

    asyncio.run(story())


def test_one_that_fails_again_while_somebody_waits_says_so(
    tmp_path: Path, store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def story() -> None:
        spec, wrong = question(), InputError("/lift", 1, "is too much", "Take less.")
        one = Service(tmp_path, store, raising(LOST, LOST, LOST, wrong))
        fail, noted = one.designs.answers.fail, asyncio.Event()

        async def fail_and_wait(*given: Any) -> None:
            await fail(*given)
            await noted.wait()

        monkeypatch.setattr(one.designs.answers, "fail", fail_and_wait)
        row = await one.accept(spec)
        row = await one.ends(row.id, "failed")
        again = asyncio.create_task(one.answer(spec, row))  # while the first is still at it
        while one.engine.begun < 4:  # noqa: ASYNC110 (a counter, of an engine made up)
            await asyncio.sleep(0.01)
        noted.set()
        with pytest.raises(InputError):
            await again
        assert (await one.ends(row.id, "failed")).problem["status"] == 422
        assert (await one.answer(spec, row)).state == "done"
        assert await one.designs.answers.find(row.id, LOCAL) is not None

    asyncio.run(story())


@pytest.mark.parametrize("name", ["finish", "fail", "add_strike"])
def test_what_is_at_hand_waits_for_the_store(
    tmp_path: Path, store: Store, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    async def story() -> None:
        errors = {"finish": [], "fail": [RuntimeError()], "add_strike": [LOST]}[name]
        one = Service(tmp_path, store, raising(*errors))
        write, tries = getattr(one.designs.answers, name), list[int]()

        async def unreliable(*given: Any) -> Any:
            tries.append(1)
            if len(tries) < 4:
                raise OperationalError("", {}, Exception("database or disk is full"))
            return await write(*given)

        monkeypatch.setattr(one.designs.answers, name, unreliable)
        row = await one.accept(question())
        ended = await one.ends(row.id, "done", "failed")
        assert ended.state == ("failed" if name == "fail" else "done")
        assert len(tries) == 4

    asyncio.run(story())


def test_another_process_goes_on_where_the_lease_has_ended(tmp_path: Path, store: Store) -> None:
    """The first stands still, as it were: it is not renewed; and stops when it sees that."""

    async def story() -> None:
        spec = question()
        first, second = Service(tmp_path, store, forever), Service(tmp_path, store, raising())
        id = (await first.accept(spec)).id
        await second.accepted.resume()
        asked = asyncio.create_task(second.answer(spec, await second.ends(id, "accepted")))
        waiting = asyncio.create_task(first.answer(spec, await first.ends(id, "accepted")))
        await asyncio.sleep(0.1)
        assert (second.engine.begun, asked.done()) == (0, False)  # it waits for the first
        first.accepted.leases.lease_s = -1.0
        await first.accepted.leases.renew()
        assert (await asked).state == "done"
        await first.accepted.resume()
        assert (await waiting).state == "done"  # that of the other
        assert (first.engine.begun, second.engine.begun) == (1, 1)
        await first.accepted.close()
        await second.accepted.close()

    asyncio.run(story())


def test_one_that_is_deleted_elsewhere_stops_and_does_not_come_back(
    tmp_path: Path, store: Store
) -> None:
    async def story() -> None:
        go_on, spec = asyncio.Event(), question()
        first = Service(tmp_path, store, go_on.wait)  # type: ignore[arg-type]
        second = Service(tmp_path, store, forever)
        id = (await first.accept(spec)).id
        waiting = asyncio.create_task(first.answer(spec, await first.ends(id, "accepted")))
        await asyncio.sleep(0.0)
        assert await second.designs.dismiss(id, LOCAL)
        go_on.set()  # finished before it has looked at its lease
        with pytest.raises(ServiceError, match="deleted"):
            await waiting
        assert await first.designs.answers.find(id, LOCAL) is None
        # and where it has looked
        go_on.clear()
        await first.accepted.resume()
        await first.accept(spec)
        (attempt,) = first.accepted.runners.values()
        assert await second.designs.dismiss(id, LOCAL)
        await asyncio.wait({attempt.task}, timeout=60.0)
        assert attempt.task.cancelled()
        await first.accepted.close()

    asyncio.run(story())


def test_whoever_asks_while_another_deletes_is_answered(
    tmp_path: Path, store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def story() -> None:
        spec, begun = question(), list[int]()

        async def once_forever() -> None:
            begun.append(1)
            if len(begun) == 1:
                await forever()

        one = Service(tmp_path, store, once_forever)
        id, answers = DESIGNS.id_of(spec), one.designs.answers

        async def answer(owner: str) -> AnswerRow:
            return await one.designs.answer(spec, await answers.claim(id, owner), owner)

        hers, release, his = asyncio.create_task(answer("ada")), answers.release, list[Any]()
        while not begun:  # noqa: ASYNC110 (a list, of an engine made up)
            await asyncio.sleep(0.01)

        async def release_and_ask(*given: Any) -> Any:
            released = await release(*given)
            his.append(asyncio.create_task(answer("bob")))
            while not await answers.is_held(id, "bob"):  # noqa: ASYNC110 (it is in the store)
                await asyncio.sleep(0.01)
            await asyncio.sleep(0.05)  # by then he waits for the same work
            return released

        monkeypatch.setattr(answers, "release", release_and_ask)
        assert await one.designs.dismiss(id, "ada")
        with pytest.raises(ServiceError, match="deleted"):
            await hers
        assert (await his[0]).state == "done"

    asyncio.run(story())


def test_a_lease_is_renewed_while_work_goes_on(tmp_path: Path, store: Store) -> None:
    async def story() -> None:
        first, second = (Service(tmp_path, store, forever, lease_s=LONG_S) for _ in range(2))
        await first.accepted.resume()
        id = (await first.accept(question())).id
        ends = set[Any]()
        for _ in range(1000):  # until it was taken, and renewed, and once more
            row = await first.designs.answers.find(id, LOCAL)
            assert row is not None
            ends |= {row.leased_until} - {None}
            if len(ends) == 3:
                break
            await asyncio.sleep(0.02)
        assert len(ends) == 3
        assert not await second.accepted.leases.take(row.sequence)
        await first.accepted.close()
        assert await second.accepted.leases.take(row.sequence)  # given back

    asyncio.run(story())
