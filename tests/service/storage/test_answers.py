"""Answers in the store, method by method: which rows each one reads, writes and leaves alone."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import event, inspect, select, text, update

from service.storage.answers import Answers
from service.storage.store import Store
from service.storage.tables import AnswerRow, KeyRow, UsageRow
from tests.service.conftest import settings_for

ONE, OTHER, ME = "/v1/designs", "/v1/analyses", "me"


def row(id: str, kind: str = ONE, state: str = "accepted", **more: Any) -> AnswerRow:
    fields: dict[str, Any] = {
        "id": id, "kind": kind, "engine": 7, "name": f"name of {id}", "created": datetime.now(UTC),
        "state": state, "status": None, "spec": b"{}", "body": None, "etag": None, "summary": {},
        "problem": None,
    }  # fmt: skip
    return AnswerRow(**{**fields, **more})


def on_store(folder: Path, work: Callable[[Store, Answers, Answers], Coroutine[Any, Any, None]],
             **settings: Any) -> None:  # fmt: skip
    store = Store(settings_for(folder, **settings))
    try:
        asyncio.run(work(store, Answers(ONE, store), Answers(OTHER, store)))
    finally:
        store.dispose()


def test_an_answer_is_found_under_its_kind_alone(tmp_path: Path) -> None:
    async def work(store: Store, one: Answers, other: Answers) -> None:
        await one.accept(row("a"))
        found = await one.find("a", None)
        assert found is not None
        assert found.name == "name of a"
        assert await other.find("a", None) is None
        assert await one.find("b", None) is None
        elsewhere = Answers(OTHER, store, lambda _, id, who: row(id, OTHER, name="from elsewhere"))
        for id, name in (("a", "from elsewhere"), ("c", "from elsewhere")):
            found = await elsewhere.find(id, None)
            assert found is not None
            assert found.name == name
        await elsewhere.accept(row("d", OTHER))
        assert (await elsewhere.find("d", None)).name == "name of d"  # type: ignore[union-attr]
        assert await store.works()

    on_store(tmp_path, work)


def test_what_is_done_stays_and_the_rest_is_replaced(tmp_path: Path) -> None:
    async def work(store: Store, one: Answers, other: Answers) -> None:
        moment = datetime(2024, 5, 6, 7, 8, 9, tzinfo=UTC)
        done: dict[str, Any] = {
            "created": moment, "status": "optimal", "body": b"body", "etag": "e",
            "summary": {"gap": 0.1}, "problem": None,
        }  # fmt: skip
        await one.accept(row("a"))
        await one.fail("a", {"title": "t"})
        await one.finish(row("a", state="done", **done), accepted=True)
        for _ in range(2):
            found = await one.find("a", None)
            assert found is not None
            assert found.created.replace(tzinfo=UTC) == moment
            assert {name: getattr(found, name) for name in done if name != "created"} == {
                name: value for name, value in done.items() if name != "created"
            }
            assert found.state == "done"
            kept = await one.finish(row("a", state="failed", body=b"later"), accepted=False)
            assert kept.state == "done"

    on_store(tmp_path, work)


def test_only_what_is_accepted_fails(tmp_path: Path) -> None:
    async def work(store: Store, one: Answers, other: Answers) -> None:
        for name, state in (("a", "accepted"), ("b", "accepted"), ("c", "done")):
            await one.accept(row(name, state=state))
        for name in ("a", "c", "never accepted"):
            await one.fail(name, {"title": "why"})
        states = {name: await one.find(name, None) for name in "abc"}
        assert {name: found.state for name, found in states.items() if found} == {
            "a": "failed", "b": "accepted", "c": "done",
        }  # fmt: skip
        assert states["a"].problem == {"title": "why"}  # type: ignore[union-attr]
        assert states["c"].problem is None  # type: ignore[union-attr]

    on_store(tmp_path, work)


def test_superseded_ones_lead_to_their_questions_and_are_not_listed(tmp_path: Path) -> None:
    async def work(store: Store, one: Answers, other: Answers) -> None:
        for name in "ab":
            await one.accept(row(name, state="done", body=b"x", problem={}, status="optimal"))
            await one.claim(name, ME)
        await other.supersede("a", "b")  # not its kind
        assert (await one.find("a", None)).body == b"x"  # type: ignore[union-attr]
        await one.supersede("a", "b")
        found = await one.find("a", None)
        assert found is not None
        assert (found.state, found.body, found.problem, found.spec) == (
            "superseded", None, None, b"{}",
        )  # fmt: skip
        assert [each.id for each in await one.page(None, 9, None, ME)] == ["b"]
        assert await one.counts() == {"optimal": 1}
        assert (await one.find("b", None)).body == b"x"  # type: ignore[union-attr]

    on_store(tmp_path, work)


def test_pages_counts_and_removal(tmp_path: Path) -> None:
    async def work(store: Store, one: Answers, other: Answers) -> None:
        for name, status in zip(
            "abcde", ("optimal", None, "optimal", "feasible", None), strict=True
        ):
            await one.accept(row(name, state="done" if status else "accepted", status=status))
            await one.claim(name, ME)
        await other.accept(row("z", OTHER))
        await other.claim("z", ME)
        newest = await one.page(None, 2, None, ME)
        assert [each.id for each in newest] == ["e", "d"]
        assert [each.id for each in await one.page(newest[-1].sequence, 2, None, ME)] == ["c", "b"]
        assert [each.id for each in await one.page(None, 9, "optimal", ME)] == ["c", "a"]
        assert await one.counts() == {"optimal": 2, "feasible": 1, "accepted": 2}
        assert not await one.remove("a")  # as long as somebody holds it
        assert await other.release("a", ME) == (False, True, False)
        assert await one.release("a", ME) == (True, False, True)  # and so it is deleted
        assert not await one.remove("a")
        await one.accept(row("a"))
        assert not await other.remove("a")
        assert await one.remove("a")
        assert not await one.remove("a")
        assert await one.find("a", None) is None
        assert [each.id for each in await one.page(None, 9, None, ME)] == ["e", "d", "c", "b"]

    on_store(tmp_path, work)


def test_an_owner_sees_what_he_has_asked_and_nothing_of_others(tmp_path: Path) -> None:
    async def work(store: Store, one: Answers, other: Answers) -> None:
        long_ago = datetime(2024, 5, 6, tzinfo=UTC)
        await one.accept(row("a", state="done", body=b"x", status="optimal", created=long_ago))
        await one.claim("a", ME)
        for hidden in (await one.find("a", "him"), *await one.page(None, 9, None, "him")):
            assert hidden is None
        mine, his = await one.find("a", ME), await one.claim("a", "him")
        assert mine is not None
        assert his is not None
        assert long_ago < mine.created.replace(tzinfo=UTC) < his.created.replace(tzinfo=UTC)
        (listed,) = await one.page(None, 9, None, "him")
        assert (listed.created, listed.sequence) == (his.created, 2)  # the second to ask
        assert await one.release("a", "she") == (False, True, True)
        assert await one.release("a", ME) == (True, True, True)
        assert await one.find("a", ME) is None
        assert not await one.remove("a")
        # what an earlier engine has answered leads all who hold it to the question of this one
        await one.accept(row("b"))
        await one.claim("b", "she")
        await one.supersede("a", "b")
        assert (await one.find("b", "him")).id == "b"  # type: ignore[union-attr]
        assert await one.find("b", ME) is None
        kept = await store.do(lambda session: session.scalar(select(AnswerRow).filter_by(id="a")))
        assert kept.created.replace(tzinfo=UTC) == long_ago  # what one is shown is not written

    on_store(tmp_path, work)


def test_a_question_is_held_from_its_claim_to_its_release(tmp_path: Path) -> None:
    """Whether it is answered or not; under its kind, and by who has asked it."""

    async def work(store: Store, one: Answers, other: Answers) -> None:
        assert not await one.is_held("a", ME)
        await one.claim("a", ME)
        assert await one.is_held("a", ME)
        await one.finish(row("a", state="done"), accepted=False)
        assert await one.is_held("a", ME)
        for answers, id, owner in ((one, "b", ME), (one, "a", "him"), (other, "a", ME)):
            assert not await answers.is_held(id, owner)
        await one.release("a", ME)
        assert not await one.is_held("a", ME)

    on_store(tmp_path, work)


def test_time_in_the_core_is_used_by_who_was_first_to_ask(tmp_path: Path) -> None:
    async def work(store: Store, one: Answers, other: Answers) -> None:
        for owner in (ME, "him"):
            await one.claim("a", owner)
        await one.accept(row("a"))
        await one.finish(row("a", state="done"), True, 2.5)
        await one.fail("a", {}, 0.5)
        used = await store.do(lambda session: session.scalars(select(UsageRow)).all())
        assert [(each.owner, each.core_seconds) for each in used] == [(ME, 3.0)]

    on_store(tmp_path, work)


def test_a_key_keeps_its_first_body_for_its_hours(tmp_path: Path) -> None:
    async def work(store: Store, one: Answers, other: Answers) -> None:
        assert await store.body_of_key(ME, "k", "first") == "first"
        assert await store.body_of_key(ME, "k", "second") == "first"
        assert await store.body_of_key(ME, "other", "second") == "second"

        def ages(hours: float) -> Any:
            created = datetime.now(UTC) - timedelta(hours=hours)
            return lambda session: session.execute(
                update(KeyRow).filter_by(owner=ME, key="k").values(created=created)
            )

        await store.do(ages(4.9))
        assert await store.body_of_key(ME, "k", "third") == "first"
        await store.do(ages(5.1))
        assert await store.body_of_key(ME, "new", "x") == "x"  # those that are too old go by then
        left = await store.do(lambda session: set(session.scalars(select(KeyRow.key))))
        assert left == {"other", "new"}
        assert await store.body_of_key(ME, "k", "third") == "third"

    on_store(tmp_path, work, idempotency_hours=5.0)


def test_a_transaction_that_fails_leaves_nothing(tmp_path: Path) -> None:
    async def work(store: Store, one: Answers, other: Answers) -> None:
        def broken(session: Any) -> None:
            session.add(row("a"))
            session.flush()
            raise RuntimeError

        with pytest.raises(RuntimeError):
            await store.do(broken)
        assert await one.find("a", None) is None

        # another process was first to add a row with this key: it is tried once more
        await one.accept(row("b"))
        tried = list[int]()

        def added(session: Any) -> str:
            tried.append(1)
            if len(tried) == 1:
                session.add(row("b"))
                session.flush()
            return "found"

        assert await store.do(added) == "found"
        assert len(tried) == 2

    on_store(tmp_path, work)


def test_only_what_nobody_is_told_of_may_wait_for_the_disk(tmp_path: Path) -> None:
    """That somebody asks what has no answer yet; every other transaction is on the disk."""

    async def work(store: Store, one: Answers, other: Answers) -> None:
        async def synchronous() -> int:
            return await store.do(lambda session: session.scalar(text("pragma synchronous")))

        seen: list[int] = []

        @event.listens_for(store.engine, "commit")
        def look(connection: Any) -> None:
            seen.append(connection.exec_driver_sql("pragma synchronous").scalar_one())

        full, normal = 2, 1
        await one.claim("a", ME)
        assert await synchronous() == full
        await one.finish(row("a", state="done", body=b"x"), accepted=False)
        await one.claim("a", "another")  # is told the answer
        assert seen[0] == normal
        assert set(seen[1:]) == {full}

    on_store(tmp_path, work)


def test_a_head_is_read_without_the_body(tmp_path: Path) -> None:
    async def work(store: Store, one: Answers, other: Answers) -> None:
        await one.claim("a", ME)
        await one.finish(row("a", state="done", body=b"x", etag="e"), accepted=False)
        head = await one.find("a", ME, with_body=False)
        assert head is not None
        assert head.etag == "e"
        assert {"body", "spec"} <= inspect(head).unloaded
        assert await one.body(head) == b"x"
        await one.release("a", ME)
        assert await one.body(head) is None

    on_store(tmp_path, work)
