"""How a sweep runs, in this process: chunks, strikes, leases and writes, with an engine made up."""

from __future__ import annotations

import asyncio
import hashlib
import json
import zlib
from collections import Counter
from collections.abc import Awaitable, Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from sqlalchemy.exc import OperationalError

from service import work as work_module
from service.storage.store import Store
from service.storage.tables import LOCAL, SweepRow
from service.sweeps import sweeps as sweeps_module
from service.sweeps.chunks import CHAIN, Chunks
from service.sweeps.question import sweep_question
from service.sweeps.store import LeaseLost, design_of_item
from service.sweeps.sweeps import Progress, Sweeps
from service.sweeps.tasks import ItemAnswer, solve_items
from service.wire.errors import ProblemType, ServiceError
from service.workers.tasks import Answer
from synthesis import Design
from synthesis.design.identity import ENGINE_NUMBER
from synthesis.errors import Cancelled, TimeBudgetExceeded
from synthesis.studies.sweeps import SweepSpec
from tests.certify.second.test_values import given
from tests.service.conftest import settings_for
from tests.service.sweeps.test_sweep_store import a_sweep
from tests.service.sweeps.test_sweeps import sweep_of

Work = Callable[[list[int]], Awaitable[list[ItemAnswer]]]


class MadeUp:
    """An engine with two slots that answers as a function says, and counts what is at work."""

    slots, task = 2, None

    def __init__(self, work: Work) -> None:
        self._work, self.sent, self.at_work, self.most = work, list[list[int]](), 0, 0
        self.cancelled = list[str]()

    async def run(self, solve: Any, spec: bytes, items: Any, *_: Any,
                  **more: Any) -> tuple[list[ItemAnswer], Any]:  # fmt: skip
        assert solve is solve_items
        assert more["low_priority"]
        numbers = [number for number, _ in items]
        self.sent.append(numbers)
        self.at_work += 1
        self.most = max(self.most, self.at_work)
        try:
            await asyncio.sleep(0)
            return await self._work(numbers), ("warm", numbers[-1])
        finally:
            self.at_work -= 1

    async def cancel(self, names: list[str], ended: Any) -> bool:
        self.cancelled += names
        return False


async def solved(numbers: list[int]) -> list[ItemAnswer]:
    return [ItemAnswer(number, "optimal", 0.01) for number in numbers]


def run(
    folder: Path, work: Work, items: int = 23, started: Callable[[Sweeps], Any] | None = None,
    **more: Any,
) -> tuple[SweepRow, MadeUp, dict[int, int], set[int]]:  # fmt: skip
    """A sweep to its end: its row, the engine, strikes, and the items that are kept."""
    spec = SweepSpec.model_validate(sweep_of([f"item {i}" for i in range(items)], **more))
    settings, engine = settings_for(folder), MadeUp(work)
    store = Store(settings)

    async def whole() -> tuple[SweepRow, dict[int, int], set[int]]:
        sweeps = Sweeps(engine, store, settings)  # type: ignore[arg-type]
        row = await sweeps.accept(sweep_question(spec), LOCAL)
        if started is not None:
            await started(sweeps)
        for runner in list(sweeps.work.runners.values()):
            await asyncio.wait_for(runner.task, 60.0)
        found = await sweeps.store.find(row.id, None)  # before all leases are given back
        await sweeps.close()
        assert found is not None
        number = row.sequence
        return found, await sweeps.store.strikes(number), await sweeps.store.done_numbers(number)

    try:
        found, strikes, done = asyncio.run(whole())
    finally:
        store.dispose()
    return found, engine, strikes, done


@pytest.fixture(autouse=True)
def soon(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sweeps_module, "RETRY_S", 0.01)
    monkeypatch.setattr(work_module, "RETRY_S", 0.01)
    monkeypatch.setattr(work_module, "RENEWAL_S", 0.01)


def test_every_item_is_solved_once_and_the_lease_is_given_back(tmp_path: Path) -> None:
    row, engine, strikes, done = run(tmp_path, solved)
    assert (row.state, row.optimal, row.done, strikes) == ("successful", 23, 23, {})
    assert (row.leased_by, row.leased_until) == (None, None)
    assert row.started is not None
    assert done == set(range(23))
    assert Counter(n for sent in engine.sent for n in sent) == Counter(range(23))
    assert engine.most == 3  # one more than there are slots


def test_what_a_worker_had_no_time_for_is_sent_again(tmp_path: Path) -> None:
    async def first_alone(numbers: list[int]) -> list[ItemAnswer]:
        return (await solved(numbers))[:1]

    row, engine, _, _ = run(tmp_path, first_alone)
    assert (row.state, row.done) == ("successful", 23)
    assert Counter(sent[0] for sent in engine.sent) == Counter(range(23))


def test_an_item_that_kills_workers_is_alone_blamed(tmp_path: Path) -> None:
    async def deadly(numbers: list[int]) -> list[ItemAnswer]:
        if 11 in numbers:
            raise ProblemType.WORKER_LOST("killed")
        return await solved(numbers)

    row, engine, strikes, done = run(tmp_path, deadly)
    assert (row.state, row.optimal, row.failed) == ("successful", 22, 1)
    assert strikes[11] == 3
    assert all(count == 1 for number, count in strikes.items() if number != 11)
    assert engine.sent.count([11]) >= 2
    assert done == set(range(23))


def test_all_items_failed_is_a_failed_sweep(tmp_path: Path) -> None:
    async def failed(numbers: list[int]) -> list[ItemAnswer]:
        return [ItemAnswer(number, "failed", 0.01, problem={}) for number in numbers]

    row, *_ = run(tmp_path, failed, items=4)
    assert (row.state, row.failed) == ("failed", 4)


def test_an_engine_that_cannot_be_reached_is_waited_for(tmp_path: Path) -> None:
    tries = Counter[str]()

    async def later(numbers: list[int]) -> list[ItemAnswer]:
        tries["all"] += 1
        if tries["all"] < 5:
            raise ProblemType.ENGINE_UNREACHABLE("not yet")
        return await solved(numbers)

    row, _, strikes, _ = run(tmp_path, later)
    assert (row.state, row.done, strikes) == ("successful", 23, {})


def test_a_fault_of_the_engine_ends_the_sweep_as_failed(tmp_path: Path) -> None:
    async def broken(numbers: list[int]) -> list[ItemAnswer]:
        raise RuntimeError

    row, *_ = run(tmp_path, broken)
    assert (row.state, row.done, row.leased_by) == ("failed", 0, None)


def test_a_store_that_cannot_be_reached_is_written_to_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tries = Counter[str]()

    async def started(sweeps: Sweeps) -> None:
        record = sweeps.store.record

        async def unreliable(*given: Any) -> SweepRow:
            tries["record"] += 1
            if tries["record"] % 2:
                raise OperationalError("", {}, Exception())
            return await record(*given)

        monkeypatch.setattr(sweeps.store, "record", unreliable)

    row, _, _, done = run(tmp_path, solved, started=started)
    assert (row.state, row.done) == ("successful", 23)
    assert len(done) == 23


def test_a_lost_lease_ends_it_and_leaves_the_sweep(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def started(sweeps: Sweeps) -> None:
        async def lost(*_: Any) -> SweepRow:
            raise LeaseLost

        monkeypatch.setattr(sweeps.store, "record", lost)

    row, engine, *_ = run(tmp_path, solved, started=started)
    assert (row.state, row.done) == ("running", 0)
    assert len(engine.sent) <= 4


def test_a_dismissed_sweep_stops_and_keeps_what_is_done(tmp_path: Path) -> None:
    async def slow(numbers: list[int]) -> list[ItemAnswer]:
        if max(numbers) > 6:
            await asyncio.sleep(30.0)
        return await solved(numbers)

    async def dismissed(sweeps: Sweeps) -> None:
        (runner,) = sweeps.work.runners.values()
        for _ in range(3):
            await asyncio.wait_for(runner.progress.next_change.wait(), 10.0)
        row = await sweeps.dismiss(runner._row)
        assert row is not None
        assert row.state == "dismissed"
        assert row.leased_by is None  # any process may go on with it
        assert await sweeps.dismiss(row) is None
        assert sweeps.progress(row.id) is None

    row, _, _, done = run(tmp_path, slow, started=dismissed)
    assert row.state == "dismissed"
    assert done <= set(range(8))
    assert row.done == len(done)


def test_a_sweep_whose_process_has_died_is_continued(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Found under a lease that is still good: it is taken when that ends."""
    monkeypatch.setattr(work_module, "POLL_S", 0.02)
    settings = settings_for(tmp_path)
    store, engine = Store(settings), MadeUp(solved)
    spec = SweepSpec.model_validate(sweep_of(["a", "b", "c"]))

    async def work() -> SweepRow | None:
        first = Sweeps(engine, store, settings)  # type: ignore[arg-type]
        monkeypatch.setattr(first.work, "start", lambda row: asyncio.sleep(0))
        row = await first.accept(sweep_question(spec), LOCAL)
        first.store.lease_s = 0.4
        assert await first.store.take(row.sequence)
        second = Sweeps(engine, store, settings)  # type: ignore[arg-type]
        await second.resume()
        assert second.progress(row.id) is None
        found = None
        for _ in range(500):
            await asyncio.sleep(0.02)
            found = await second.store.find(row.id, None)
            if found is not None and found.state == "successful":
                break
        await second.close()
        return found

    try:
        found = asyncio.run(work())
    finally:
        store.dispose()
    assert found is not None
    assert (found.state, found.done) == ("successful", 3)


def test_a_sweep_of_an_earlier_engine_ends_and_its_question_begins_anew(tmp_path: Path) -> None:
    """One that had begun: no item goes into its table any more."""
    settings = settings_for(tmp_path)
    store, engine, old = Store(settings), MadeUp(solved), "of an earlier engine"
    spec = SweepSpec.model_validate(sweep_of(["a", "b", "c"]))

    async def work() -> list[tuple[str, int, int]]:
        sweeps = Sweeps(engine, store, settings)  # type: ignore[arg-type]
        row = a_sweep(
            old, engine=ENGINE_NUMBER - 1, state="running", spec=spec.model_dump_json().encode()
        )
        await sweeps.store.accept(row)
        await sweeps.resume()
        for runner in list(sweeps.work.runners.values()):
            await asyncio.wait_for(runner.task, 60.0)
        await sweeps.close()
        found = [await sweeps.store.find(id, None) for id in (old, sweep_question(spec).id)]
        return [(row.state, row.engine, row.done) for row in found if row is not None]

    try:
        found = asyncio.run(work())
    finally:
        store.dispose()
    assert found == [("dismissed", ENGINE_NUMBER - 1, 0), ("successful", ENGINE_NUMBER, 3)]


def test_a_sweep_too_many_is_told_when_another_will_have_ended(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """13 of 23 items are left, at 2.5 a second: 5.2 s, of which none may be cut off."""
    now = [0.0]
    clock = SimpleNamespace(monotonic=lambda: now[0])
    monkeypatch.setattr(sweeps_module, "time", clock)

    async def never(numbers: list[int]) -> list[ItemAnswer]:
        await asyncio.sleep(30.0)
        return await solved(numbers)

    async def ask_another(sweeps: Sweeps) -> None:
        sweeps._settings = sweeps._settings.model_copy(update={"max_sweeps": 1})
        (runner,) = sweeps.work.runners.values()
        await asyncio.wait_for(runner.progress.next_change.wait(), 10.0)
        for now[0], done in ((1.0, 2), (4.0, 10)):
            runner.progress.update(done)
        another = SweepSpec.model_validate(sweep_of(["another"]))
        with pytest.raises(ServiceError, match="1 sweeps are running already") as refused:
            await sweeps.accept(sweep_question(another), LOCAL)
        assert refused.value.problem is ProblemType.BUSY
        assert refused.value.headers == {"Retry-After": "6"}
        await sweeps.dismiss(runner._row)

    run(tmp_path, never, started=ask_another)


def test_a_chain_begins_where_the_one_before_has_ended(tmp_path: Path) -> None:
    row, engine, *_ = run(tmp_path, solved, items=20, warm_start=True)
    assert row.done == 20
    assert sorted(engine.sent) == [list(range(k, min(k + CHAIN, 20))) for k in range(0, 20, CHAIN)]


# -- progress and chunks by themselves ---------------------------------------------------------


def test_the_rate_is_that_of_the_last_commits(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [0.0]
    monkeypatch.setattr(sweeps_module.time, "monotonic", lambda: now[0])
    progress = Progress()
    change = progress.next_change
    assert progress.rate_per_s is None
    for after, done in ((0.0, 0), (0.0, 4), (2.0, 10), (5.0, 40)):
        now[0] = 300.0 + after
        progress.update(done)
        assert progress.rate_per_s == (None if after == 0.0 else done / after)
        assert progress.done == done
    assert change.is_set()
    assert not progress.next_change.is_set()


def test_chunks_grow_with_what_fits_and_shrink_at_the_end() -> None:
    chunks = Chunks(400, set(), 2, {})
    assert len(chunks.take()) == 1  # nothing is known of its items yet
    chunks.record_time(0.0805)  # 4.97 of them fit
    sizes = [len(chunks.take()) for _ in range(4)]
    assert sizes == [2, 4, 4, 4]
    for _ in range(50):
        chunks.record_time(0.0805)
    assert len(chunks.take()) == 4
    for _ in range(80):
        chunks.record_time(1e-4)
    sizes = []
    while taken := chunks.take():
        sizes.append(len(taken))
    assert max(sizes) == 50
    assert sizes[-1] == 1
    assert sorted(sizes, reverse=True)[0] <= 50
    # no more than half of a worker's share of what is left
    left = sum(sizes)
    for size in sizes:
        assert size <= max(-(-left // 4), 1)
        left -= size
    assert chunks.left == 0


def test_what_is_done_is_not_sent_and_suspects_are_sent_alone() -> None:
    chunks = Chunks(9, {0, 4}, 2, {4: 1, 6: 2})
    assert chunks.left == 7
    chunks.record_time(1e-3)
    assert chunks.take() == [6]
    assert chunks.left == 6
    taken = chunks.take()
    assert taken == [1, 2]
    chunks.put_back(taken)
    chunks.put_back([])
    assert chunks.left == 6
    assert chunks.take() == [1, 2]
    assert chunks.finish(1)
    assert not chunks.finish(1)
    assert not chunks.finish(4)
    assert chunks.unfinished([0, 1, 2, 4]) == [2]
    assert chunks.add_strikes([1, 2]) == {1: 1, 2: 1}
    assert chunks.add_strikes([2]) == {2: 2}
    assert chunks.add_strikes([6]) == {6: 3}
    assert chunks.add_strikes([3]) == {3: 1}


# -- what a worker does ------------------------------------------------------------------------


def test_a_worker_answers_item_by_item() -> None:
    spec = SweepSpec.model_validate(sweep_of(["a", "b", "c", "d"], warm_start=True))
    body = spec.model_dump_json().encode()
    begun = list[Any]()

    def solve(question: bytes, budget_s: float, quantities: Any, warm_start: Any) -> Answer:
        name = json.loads(question)["name"]
        begun.append((name, warm_start))
        if name == "b":
            raise TimeBudgetExceeded(budget_s)
        if name == "d":
            raise Cancelled
        return Answer(
            id=f"id of {name}",
            status="optimal",
            body=b"body",
            summary={"gap": 0.25, "severity": "stop"},
            seconds=0.5,
            quantities={"mm": 1.0},
            warm_start=f"left by {name}",
        )  # type: ignore[arg-type]

    items = [(k, [name]) for k, name in enumerate("abcd")]
    answers, left = solve_items(body, items, 3.0, solve, "given")
    assert begun == [("a", "given"), ("b", "left by a"), ("c", "left by a"), ("d", "left by c")]
    assert [(each.number, each.status) for each in answers] == [
        (0, "optimal"), (1, "failed"), (2, "optimal"),
    ]  # fmt: skip
    first, second, _ = answers
    assert (first.design_id, first.gap, first.quantities) == ("id of a", 0.25, {"mm": 1.0})
    assert (first.severity, second.severity) == ("stop", "none")
    assert zlib.decompress(first.design or b"") == b"body"
    assert (second.design_id, second.design) == (None, None)
    assert second.problem is not None
    assert second.problem["status"] == 504
    assert left == "left by c"


def test_when_time_ends_the_best_design_so_far_is_the_item_s_answer() -> None:
    body = SweepSpec.model_validate(sweep_of(["a"])).model_dump_json().encode()
    best = given()

    def solve(*_: Any) -> Answer:
        raise TimeBudgetExceeded(3.0, best)

    (answer,), _ = solve_items(body, [(0, ["a"])], 3.0, solve)
    assert (answer.status, answer.gap, answer.design_id) == (
        best.status, best.certificate.gap, None,
    )  # fmt: skip
    assert answer.quantities["base_radius_mm"] == pytest.approx(33.5)
    kept = Design.model_validate_json(zlib.decompress(answer.design or b""))
    assert kept.dimensions == best.dimensions
    assert answer.problem is not None
    assert (answer.problem["status"], "best" in answer.problem) == (504, False)


def test_an_item_s_etag_is_its_body_s(tmp_path: Path) -> None:
    body = json.dumps({"name": "n", "spec": {}}).encode()
    store = Store(settings_for(tmp_path))

    async def work() -> None:
        one = sweeps_module.SweepStore(store, 60.0)
        row = await one.accept(a_sweep())
        assert await one.take(row.sequence)
        done = ItemAnswer(3, "feasible", design_id="d", design=zlib.compress(body))
        await one.record(row.sequence, [(done, [])])
        found = await store.do(lambda session: design_of_item(session, "d", None))
        assert found is not None
        assert found.etag == hashlib.sha256(body).hexdigest()[:32]

    try:
        asyncio.run(work())
    finally:
        store.dispose()
