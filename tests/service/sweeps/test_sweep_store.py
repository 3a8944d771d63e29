"""Sweeps in the store, method by method: which rows each one reads, writes and leaves alone."""

from __future__ import annotations

import asyncio
import json
import zlib
from collections.abc import Callable, Coroutine
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import select

from service.storage.answers import Answers
from service.storage.store import Store
from service.storage.tables import LOCAL, ItemRow, StrikeRow, SweepRow, UsageRow
from service.sweeps import store as sweep_store
from service.sweeps.store import LeaseLost, SweepStore, design_of_item
from service.sweeps.tasks import ItemAnswer
from tests.service.conftest import settings_for


def a_sweep(id: str = "s", **more: Any) -> SweepRow:
    fields: dict[str, Any] = {
        "engine": 3, "id": id, "name": "", "created": datetime.now(UTC), "state": "accepted",
        "spec": b"{}", "size": 9, "axes": [], "quantities": [], "optimal": 0, "feasible": 0,
        "unsolved": 0, "infeasible": 0, "failed": 0,
    }  # fmt: skip
    return SweepRow(**{**fields, **more})


def on_store(
    folder: Path, work: Callable[[Store, SweepStore, SweepStore], Coroutine[Any, Any, None]]
) -> None:
    store = Store(settings_for(folder))
    try:
        asyncio.run(work(store, SweepStore(store, 60.0), SweepStore(store, 60.0)))
    finally:
        store.dispose()


def test_a_sweep_that_has_ended_cannot_be_taken_and_a_dismissed_one_continues(
    tmp_path: Path,
) -> None:
    async def work(_: Store, one: SweepStore, other: SweepStore) -> None:
        first, second = await one.accept(a_sweep("a")), await one.accept(a_sweep("b"))
        assert [each.id for each in await one.unleased_rows()] == ["a", "b"]
        await one.start(first.sequence)
        running = await one.find("a", None)
        assert running is not None
        assert (running.state, running.started is None) == ("running", False)
        assert (await one.find("b", None)).state == "accepted"  # type: ignore[union-attr]
        for row, state in ((first, "successful"), (second, "dismissed")):
            assert await one.take(row.sequence)
            ended = await one.end(row.sequence, state)
            assert ended is not None
            assert (ended.state, ended.finished is None) == (state, False)
            assert await one.end(row.sequence, "failed") is None
            assert row.sequence not in await one.renew()
            assert not await one.take(row.sequence)
        assert await one.unleased_rows() == []
        await one.start(first.sequence)
        assert (await one.accept(a_sweep("a"))).state == "successful"
        again = await one.accept(a_sweep("b"))
        assert (again.state, again.finished, again.sequence) == ("accepted", None, second.sequence)
        assert await one.find("c", None) is None
        assert await one.end(99, "failed") is None

    on_store(tmp_path, work)


def test_a_lease_is_one_process_s_and_of_one_sweep(tmp_path: Path) -> None:
    async def work(_: Store, one: SweepStore, other: SweepStore) -> None:
        first, second = await one.accept(a_sweep("a")), await one.accept(a_sweep("b"))
        assert first.sequence not in await one.renew()  # it has none yet
        assert await one.take(first.sequence)
        assert await one.take(first.sequence)  # its own
        assert [each.id for each in await other.unleased_rows()] == ["b"]
        assert await other.take(second.sequence)
        await other.release(first.sequence)  # not its own
        assert not await other.take(first.sequence)
        await one.release(first.sequence)
        assert [each.id for each in await one.unleased_rows()] == ["a"]
        released = await one.find("a", None)
        assert released is not None
        assert (released.leased_by, released.leased_until) == (None, None)
        assert second.sequence in await other.renew()
        assert await other.take(first.sequence)
        # ended by another process: the lease is gone
        ended = await one.end(first.sequence, "dismissed")
        assert ended is not None
        assert ended.leased_by is None
        assert ended.leased_until is None
        kept = await other.end(second.sequence, "failed")
        assert kept is not None
        assert kept.leased_by == other.process

    on_store(tmp_path, work)


def test_items_are_kept_once_and_counted(tmp_path: Path) -> None:
    def answer(number: int, status: str, **quantities: float) -> tuple[ItemAnswer, list[Any]]:
        return ItemAnswer(number, status, 0.5, quantities, design_id=f"d{number}"), [number]  # type: ignore[arg-type]

    async def work(store: Store, one: SweepStore, other: SweepStore) -> None:
        first, second = await one.accept(a_sweep("a")), await one.accept(a_sweep("b"))
        for row in (first, second):
            assert await one.take(row.sequence)
        a, b = first.sequence, second.sequence
        await one.record(b, [answer(7, "failed")])
        await one.record(a, [answer(4, "optimal", mm=1.0), answer(2, "optimal", mm=2.0, deg=3.0)])
        whole = await one.record(
            a, [answer(4, "failed"), answer(0, "feasible", n=1.0), answer(5, "unsolved"),
                answer(6, "infeasible"), answer(8, "failed")],
        )  # fmt: skip
        counts = {name: getattr(whole, name) for name in sweep_store.STATUSES}
        assert counts == {"optimal": 2, "feasible": 1, "unsolved": 1, "infeasible": 1, "failed": 1}
        assert whole.done == 6
        used = await store.do(lambda s: {row.owner: row.core_seconds for row in s.query(UsageRow)})
        assert used == {LOCAL: 7 * 0.5}  # of items that are kept, those of b too
        found = await one.find("a", None)
        assert found is not None
        assert (found.quantities, found.done) == (["mm", "deg", "n"], 6)
        assert await one.done_numbers(a) == {4, 2, 0, 5, 6, 8}
        assert await one.done_numbers(b) == {7}
        assert [each.number for each in await one.items(a)] == [4, 2, 0, 5, 6, 8]
        assert [each.number for each in await one.items(a, size=2)] == [4, 2]
        optimal = await one.items(a, ItemRow.status == "optimal", order=ItemRow.number)
        assert [each.number for each in optimal] == [2, 4]
        item = await one.item(a, 4)
        assert item is not None
        assert (item.status, item.axis_values, item.quantities) == ("optimal", [4], {"mm": 1.0})
        assert await one.item(a, 7) is None
        assert await one.holder("d7", LOCAL) == ("b", 7)
        assert await one.holder("d9", LOCAL) is None
        with pytest.raises(LeaseLost):
            await other.record(a, [answer(1, "optimal")])
        with pytest.raises(LeaseLost):
            await one.record(99, [answer(1, "optimal")])
        await one.keep_strikes(a, {4: 1})
        await one.keep_strikes(a, {4: 2, 5: 1})
        await one.keep_strikes(b, {4: 3})
        assert await one.strikes(a) == {4: 2, 5: 1}
        await one.delete(a)
        assert await one.find("a", None) is None
        left = await store.do(lambda s: set(s.scalars(select(ItemRow.sweep))))
        struck = await store.do(lambda s: set(s.scalars(select(StrikeRow.sweep))))
        assert (left, struck) == ({b}, {b})
        assert (await one.find("b", None)).done == 1  # type: ignore[union-attr]
        assert await one.strikes(b) == {4: 3}

    on_store(tmp_path, work)


def test_pages_of_sweeps_and_of_items(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sweep_store, "PAGE", 3)

    async def work(_: Store, one: SweepStore, other: SweepStore) -> None:
        rows = [await one.accept(a_sweep(name)) for name in "abc"]
        newest = await one.page(None, 2, None, LOCAL)
        assert [each.id for each in newest] == ["c", "b"]
        assert [each.id for each in await one.page(newest[-1].sequence, 2, None, LOCAL)] == ["a"]
        await one.start(rows[1].sequence)
        assert [each.id for each in await one.page(None, 9, "running", LOCAL)] == ["b"]
        number = rows[0].sequence
        assert await one.take(number)
        order = [5, 0, 3, 1, 7, 2, 6, 4]
        await one.record(number, [(ItemAnswer(k, "optimal"), []) for k in order])
        pages = [[item.number for item in page] async for page in one.pages(number)]
        assert pages == [[0, 1, 2], [3, 4, 5], [6, 7]]

    on_store(tmp_path, work)


def test_an_item_s_design_is_an_answer_of_its_own(tmp_path: Path) -> None:
    async def work(store: Store, one: SweepStore, other: SweepStore) -> None:
        row, another = await one.accept(a_sweep("a")), await one.accept(a_sweep("b", engine=2))
        body = json.dumps({"name": "n", "spec": {"speed_rpm": 7.0}}).encode()
        for each, design_id in ((row, "mine"), (another, "other")):
            assert await one.take(each.sequence)
            done = ItemAnswer(3, "feasible", design_id=design_id, design=zlib.compress(body))
            await one.record(each.sequence, [(done, [])])
        answers = Answers("/v1/designs", store, design_of_item)
        found = await answers.find("mine", LOCAL)
        assert found is not None
        assert (found.id, found.engine, found.name, found.state, found.status, found.body) == (
            "mine", 3, "n", "done", "feasible", body,
        )  # fmt: skip
        assert json.loads(found.spec) == {"speed_rpm": 7.0}
        assert (await answers.find("other", None)).engine == 2  # type: ignore[union-attr]
        assert await answers.find("neither", None) is None
        assert await answers.find("mine", "another owner") is None

    on_store(tmp_path, work)
