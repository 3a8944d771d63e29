"""Work that begins before the store has looked: nothing is kept or told until it has."""

from __future__ import annotations

import asyncio
import sqlite3
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from pathlib import Path
from typing import Any

import httpx2
import pytest
from sqlalchemy.exc import OperationalError

from service.resources import jobs as jobs_module
from service.resources.records import DESIGNS
from service.storage.store import Store
from service.storage.tables import LOCAL, AnswerRow
from service.wire.access import Quotas
from service.wire.errors import ServiceError
from synthesis.errors import InputError
from tests.service.conftest import Running, wait_until_idle
from tests.service.fake_core import LOG, Gate
from tests.service.killing import answering, free_port, service
from tests.service.resources.test_durable_questions import (  # fixtures too
    LOST,
    MadeUp,
    Service,
    at_once,
    forever,
    question,
    raising,
    soon,
    store,
)
from tests.service.specs import spec

__all__ = ["soon", "store"]
LOCKED = OperationalError("", {}, Exception("database is locked"))


class Late(Service):
    """A process whose claims wait for ``let``; the first one then ends with an error, if any."""

    def __init__(self, *given: Any, error: Exception | None = None) -> None:
        super().__init__(*given)
        answers, self.let, errors = self.designs.answers, asyncio.Event(), [error]
        claim = answers.claim

        async def late(id: str, owner: str) -> AnswerRow | None:
            error = errors.pop() if errors else None
            await self.let.wait()
            if error is not None:
                raise error
            return await claim(id, owner)

        answers.claim = late  # type: ignore[method-assign]

    async def ask(self, spec: Any, owner: str = LOCAL) -> AnswerRow:
        """As when an owner waits for the answer and a worker is free."""
        row = await self.designs.claim(DESIGNS.id_of(spec), spec, owner, True)
        done = row is not None and row.state == "done"
        return row if done else await self.designs.answer(spec, row, owner)  # type: ignore[return-value]


async def begun(engine: MadeUp, times: int = 1) -> None:
    """Until work has begun so often, and whatever can follow at once has followed."""
    while engine.begun < times:  # noqa: ASYNC110 (a counter, of an engine made up)
        await asyncio.sleep(0.01)
    await asyncio.sleep(0.05)


def holders(folder: Path) -> list[tuple[str, str]]:
    """Who holds the answers that are kept, by the rows of the database: owner ("": nobody), id."""
    query = (
        "select coalesce(h.owner, ''), a.id from answers a left join holdings h on h.id = a.id"
        " order by h.owner"
    )
    with closing(sqlite3.connect(folder / "designs.db")) as database:
        return database.execute(query).fetchall()


def test_work_begins_before_the_claim_is_kept_and_its_answer_is_kept_after_it(
    tmp_path: Path, store: Store
) -> None:
    async def story() -> None:
        one, spec = Late(tmp_path, store, at_once), question()
        asked = asyncio.create_task(one.ask(spec))
        await begun(one.engine)  # and has ended, as far as the core goes
        assert not asked.done()
        assert holders(tmp_path) == []
        one.let.set()
        row = await asked
        assert (row.state, one.engine.begun) == ("done", 1)
        assert holders(tmp_path) == [(LOCAL, row.id)]

    asyncio.run(story())


def test_a_failure_is_told_and_charged_after_the_claim(tmp_path: Path, store: Store) -> None:
    async def story() -> None:
        wrong = InputError("/lift", 1, "is too much", "Take less.")
        one = Late(tmp_path, store, raising(wrong))
        asked = asyncio.create_task(one.ask(question()))
        await begun(one.engine)
        one.let.set()
        with pytest.raises(InputError):
            await asked
        assert one.engine.begun == 1
        with closing(sqlite3.connect(tmp_path / "designs.db")) as database:
            assert database.execute("select owner from usage").fetchall() == [(LOCAL,)]

    asyncio.run(story())


@pytest.mark.parametrize("work", [at_once, forever], ids=["it is answered", "it goes on"])
def test_where_the_store_fails_the_work_is_thrown_away(
    tmp_path: Path, store: Store, work: Any
) -> None:
    async def story() -> None:
        one, spec = Late(tmp_path, store, work, error=LOCKED), question()
        asked = asyncio.create_task(one.ask(spec))
        await begun(one.engine)
        one.let.set()
        with pytest.raises(OperationalError, match="locked"):
            await asked
        await asyncio.sleep(0.05)
        assert holders(tmp_path) == []
        assert not one.designs._attempts
        one.engine._work = at_once
        assert (await one.ask(spec)).state == "done"
        assert holders(tmp_path) == [(LOCAL, DESIGNS.id_of(spec))]

    asyncio.run(story())


def test_who_has_joined_is_answered_though_the_first_claim_fails(
    tmp_path: Path, store: Store
) -> None:
    async def story() -> None:
        one, spec = Late(tmp_path, store, at_once, error=LOCKED), question()
        first = asyncio.create_task(one.ask(spec))
        await begun(one.engine)
        second = asyncio.create_task(one.ask(spec, "ada"))  # his own claim is kept
        await asyncio.sleep(0.05)
        assert one.engine.begun == 1
        one.let.set()
        with pytest.raises(OperationalError):
            await first
        assert (await second).state == "done"
        assert holders(tmp_path) == [("ada", DESIGNS.id_of(spec))]

    asyncio.run(story())


def test_what_is_answered_already_is_sent_and_is_not_begun_again(
    tmp_path: Path, store: Store
) -> None:
    """This process did not know; from then on it does."""

    async def story() -> None:
        spec = question()
        kept = await Service(tmp_path, store, at_once).answer(spec, None)
        one, ended = Late(tmp_path, store, forever), list[str]()

        async def work() -> None:
            try:
                await forever()
            finally:
                ended.append("stopped")

        one.engine._work = work
        asked = asyncio.create_task(one.ask(spec, "ada"))
        await begun(one.engine)
        one.let.set()
        assert (await asked).etag == kept.etag
        await asyncio.sleep(0.05)
        assert (ended, one.designs._attempts) == (["stopped"], {})
        assert (await one.ask(spec, "bob")).etag == kept.etag
        assert one.engine.begun == 1
        assert {owner for owner, _ in holders(tmp_path)} == {"ada", "bob"}

    asyncio.run(story())


def test_so_many_answered_questions_are_remembered(
    tmp_path: Path, store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(jobs_module, "MOST_NOTED", 2)

    async def story() -> None:
        one, asked = Service(tmp_path, store, at_once), [question() for _ in range(3)]
        for each in asked:
            await one.answer(each, None)
        assert list(one.designs._answered) == [DESIGNS.id_of(each) for each in asked[1:]]

    asyncio.run(story())


def test_what_another_process_works_on_is_left_to_it(tmp_path: Path, store: Store) -> None:
    async def story() -> None:
        spec, go_on = question(), asyncio.Event()

        async def work() -> None:
            await go_on.wait()

        other, one = Service(tmp_path, store, work), Late(tmp_path, store, at_once)
        await other.accept(spec)
        await begun(other.engine)
        asked = asyncio.create_task(one.ask(spec))
        await begun(one.engine)
        one.let.set()
        await asyncio.sleep(0.1)
        assert not asked.done()  # nothing of its own was kept, though it had been answered
        go_on.set()
        assert (await asked).state == "done"
        assert (one.engine.begun, other.engine.begun) == (1, 1)
        await other.accepted.close()

    asyncio.run(story())


def test_a_worker_that_dies_before_the_claim_is_no_strike_for_another_process(
    tmp_path: Path, store: Store
) -> None:
    async def story() -> None:
        spec, go_on = question(), asyncio.Event()

        async def work() -> None:
            await go_on.wait()

        def strikes() -> list[tuple[int]]:
            with closing(sqlite3.connect(tmp_path / "designs.db")) as database:
                return database.execute("select strikes from answers").fetchall()

        other, one = Service(tmp_path, store, work), Late(tmp_path, store, raising(LOST))
        await other.accept(spec)
        await begun(other.engine)
        asked = asyncio.create_task(one.ask(spec))
        await begun(one.engine)
        assert strikes() == [(0,)]
        one.let.set()
        await asyncio.sleep(0.1)
        go_on.set()
        assert (await asked).state == "done"
        assert (strikes(), one.engine.begun) == ([(0,)], 1)
        await other.accepted.close()

    asyncio.run(story())


def test_deleted_between_the_stores_answer_and_the_next_step(tmp_path: Path, store: Store) -> None:
    async def story() -> None:
        spec = question()
        one, id = Late(tmp_path, store, forever), DESIGNS.id_of(spec)
        one.let.set()
        claim = one.designs.answers.claim

        async def deleted(id: str, owner: str) -> AnswerRow | None:
            row = await claim(id, owner)
            assert await one.designs.dismiss(id, owner)
            return row

        one.designs.answers.claim = deleted  # type: ignore[method-assign]
        with pytest.raises(ServiceError, match="deleted"):
            await one.ask(spec)
        assert one.engine.begun == 1
        assert (holders(tmp_path), one.designs._attempts) == ([], {})
        assert id not in one.designs._answered

    asyncio.run(story())


def test_what_is_accepted_meanwhile_goes_on(tmp_path: Path, store: Store) -> None:
    """Somebody asks for the same without waiting, and is told that it is accepted."""

    async def story() -> None:
        spec, go_on = question(), asyncio.Event()

        async def work() -> None:
            await go_on.wait()

        one = Late(tmp_path, store, work)
        asked = asyncio.create_task(one.ask(spec))
        await begun(one.engine)
        await one.designs.accept(spec)
        one.let.set()
        await asyncio.sleep(0.05)
        go_on.set()
        assert (await asked).state == "done"
        assert one.engine.begun == 1
        await one.accepted.close()

    asyncio.run(story())


@pytest.mark.parametrize("claimed", [True, False], ids=["after the claim", "before it"])
def test_deleted_meanwhile(tmp_path: Path, store: Store, claimed: bool) -> None:
    """After the claim it is gone; before it there was nothing that could be deleted."""

    async def story() -> None:
        spec, go_on = question(), asyncio.Event()

        async def work() -> None:
            await go_on.wait()

        one, id = Late(tmp_path, store, work), DESIGNS.id_of(spec)
        asked = asyncio.create_task(one.ask(spec))
        await begun(one.engine)
        if claimed:
            one.let.set()
            while not await one.designs.answers.is_held(id, LOCAL):  # noqa: ASYNC110 (a row)
                await asyncio.sleep(0.01)
        assert await one.designs.dismiss(id, LOCAL) is claimed
        one.let.set()
        go_on.set()
        if claimed:
            with pytest.raises(ServiceError, match="deleted"):
                await asked
            assert holders(tmp_path) == []
        else:
            assert (await asked).state == "done"
            assert holders(tmp_path) == [(LOCAL, id)]

    asyncio.run(story())


def test_the_service_killed_before_the_first_commit(tmp_path: Path) -> None:
    """Nothing is left of it, and the same key and body get one answer after that."""
    port, gate, log = free_port(), Gate(tmp_path / "gate"), tmp_path / "log"
    log.touch()
    running = service(tmp_path, port, **{LOG: str(log)})
    body, key = spec(gate.names(1)[0]), dict[str, str]()

    def post() -> httpx2.Response:
        with httpx2.Client(base_url=f"http://127.0.0.1:{port}", timeout=180.0) as mine:
            return mine.post("/v1/designs", json=body, headers=key)

    with httpx2.Client(base_url=f"http://127.0.0.1:{port}", timeout=180.0) as client:
        try:
            answering(client)
            with closing(sqlite3.connect(tmp_path / "designs.db")) as locked:
                with ThreadPoolExecutor(1) as waiting:
                    locked.execute("begin immediate")
                    lost = waiting.submit(post)
                    while body["name"] not in log.read_text():
                        time.sleep(0.01)
                    running.kill()
                    assert isinstance(lost.exception(), httpx2.TransportError)
                locked.rollback()
            gate.open()
            running.start()
            answering(client)
            assert client.get("/v1/designs").json()["items"] == []
            key["Idempotency-Key"] = "the same"
            answers = [post(), post()]
            assert [each.status_code for each in answers] == [200, 200]
            assert len({each.content for each in answers}) == 1
            assert log.read_text().count(body["name"]) == 2  # the lost one, and one after that
            assert len(holders(tmp_path)) == 1
        finally:
            running.stop()


def test_two_callers_with_one_idempotency_key_share_the_work(
    service: Running, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    gate, key = Gate(tmp_path / "gate"), {"Idempotency-Key": f"of {tmp_path}"}
    body = spec(gate.names(1)[0])
    wait_until_idle(service.client)

    def post(_: int) -> httpx2.Response:
        with httpx2.Client(base_url=service.url, timeout=180.0) as mine:
            return mine.post("/v1/designs", json=body, headers=key)

    with ThreadPoolExecutor(2) as callers:
        both = callers.map(post, range(2))
        gate.let(1)  # a second run of the core would wait for ever
        first, second = both
    assert (first.status_code, second.status_code) == (200, 200)
    assert first.content == second.content
    other = {**body, "speed_rpm": 99.0}
    assert service.client.post("/v1/designs", json=other, headers=key).status_code == 422


def test_what_is_kept_is_sent_where_new_work_is_refused(service: Running, tmp_path: Path) -> None:
    gate, client, kept = Gate(tmp_path / "gate"), service.client, spec("kept")
    wait_until_idle(client)
    first = client.post("/v1/designs", json=kept)
    try:
        for name in gate.names(6):  # two at work and four that wait
            headers = {"Prefer": "respond-async"}
            accepted = client.post("/v1/designs", json=spec(name), headers=headers)
            assert accepted.status_code == 202
        assert client.post("/v1/designs", json=spec("one too many")).status_code == 429
        again = client.post("/v1/designs", json=kept)
        assert (again.status_code, again.content) == (200, first.content)
    finally:
        gate.open()
        wait_until_idle(client)


def test_what_is_kept_is_sent_though_a_quota_is_used_up(service: Running) -> None:
    key = service.new_key("used up", quotas=Quotas(core_seconds_per_day=1e-9))
    headers, kept = {"Authorization": f"Bearer {key}"}, spec("kept")
    first = service.client.post("/v1/designs", json=kept, headers=headers)
    assert first.status_code == 200
    new = service.client.post("/v1/designs", json=spec("new"), headers=headers)
    assert new.status_code == 429
    again = service.client.post("/v1/designs", json=kept, headers=headers)
    assert (again.status_code, again.content) == (200, first.content)
