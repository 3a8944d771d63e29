"""A store that fails, and a clock that is set: health says so, and nothing waits for ever."""

from __future__ import annotations

import asyncio
import re
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import update
from sqlalchemy.exc import DBAPIError, OperationalError

from service.storage import store as store_module
from service.storage.answers import Answers
from service.storage.leases import Leases
from service.storage.store import Store
from service.storage.tables import AnswerRow
from service.storage.upkeep import faults
from service.wire.errors import is_damage
from service.wire.observe import Metrics
from service.wire.problem import problem_of
from service.work import Work
from tests.service.conftest import settings_for
from tests.service.storage.test_answers import ME, ONE, row

HOUR_S = 3600.0


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    store = Store(settings_for(tmp_path))
    yield store
    store.dispose()


def test_a_store_that_takes_no_writes_does_not_work(
    store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It answers what is read still; once mended it works, and nothing is half-written."""
    monkeypatch.setattr(store_module, "PROBE_S", 0.0)

    async def story() -> None:
        answers = Answers(ONE, store)
        assert await store.works()
        await store.do(lambda session: session.connection().exec_driver_sql("pragma query_only=1"))
        assert not await store.works()
        with pytest.raises(OperationalError, match="readonly"):
            await answers.accept(row("a"))
        assert await answers.find("a", None) is None
        await store.do(lambda session: session.connection().exec_driver_sql("pragma query_only=0"))
        assert await store.works()
        assert (await answers.accept(row("a"))).state == "accepted"

    asyncio.run(story())


def test_the_metrics_tell_how_long_transactions_take(tmp_path: Path) -> None:
    """The second of two waits for the first: SQLite has one thread."""
    metrics = Metrics()
    store, began = Store(settings_for(tmp_path), metrics), time.perf_counter()

    async def two() -> None:
        await asyncio.gather(*(store.do(lambda session: time.sleep(0.02)) for _ in range(2)))

    asyncio.run(two())
    most = time.perf_counter() - began
    store.dispose()
    page = metrics.page({}, 0, 0, 0, 0).decode()
    count, seconds = (
        float(re.findall(rf"^camwright_store_seconds_{name} (.*)$", page, re.MULTILINE)[0])
        for name in ("count", "sum")
    )
    assert count == 2
    assert 0.06 <= seconds <= 2.0 * most


def test_a_lease_from_before_the_clock_was_set_back_holds_nobody_up(store: Store) -> None:
    """The process that had it is dead: its lease ends an hour after it would have, by the clock."""

    async def story() -> None:
        await Answers(ONE, store).accept(row("a"))
        dead, other = (Leases(AnswerRow, ("accepted",), store, 60.0) for _ in range(2))
        (waiting,) = await other.unleased_rows()
        assert await dead.take(waiting.sequence)
        assert not await other.take(waiting.sequence)
        later = AnswerRow.leased_until + HOUR_S
        await store.do(
            lambda session: session.execute(update(AnswerRow).values(leased_until=later))
        )
        assert [each.id for each in await other.unleased_rows()] == ["a"]
        assert await other.take(waiting.sequence)
        assert await dead.renew() == set()

    asyncio.run(story())


def test_a_damaged_page_is_told_and_the_rest_is_served(tmp_path: Path) -> None:
    """As a block that the disk has lost: what lies on other pages is answered still."""
    settings, file = settings_for(tmp_path), tmp_path / "designs.db"
    page, bodies = 4096, {f"{number}": f"{number:04d}".encode() * 5000 for number in range(20)}

    async def fill(store: Store) -> None:
        answers = Answers(ONE, store)
        for name, body in bodies.items():
            await answers.claim(name, ME)
            await answers.finish(row(name, state="done", body=body, etag="e"), accepted=False)

    async def read(store: Store) -> list[DBAPIError]:
        answers, errors = Answers(ONE, store), list[DBAPIError]()
        assert await store.works()
        for name, body in bodies.items():
            try:
                kept = await answers.find(name, ME)
            except DBAPIError as error:
                errors.append(error)
            else:
                assert kept is not None
                assert kept.body == body
        assert not await store.works()
        nothing: Any = None
        work = Work(Leases(AnswerRow, ("accepted",), store, 1.0), nothing)
        await work.resume()  # a service starts with it
        await work.close()
        return errors

    whole = Store(settings)
    asyncio.run(fill(whole))
    whole.dispose()
    content = bytearray(file.read_bytes())
    middle = content.index(bodies["10"][:100]) // page * page + page  # in the midst of a body
    content[middle : middle + page] = b"\xff" * page
    file.write_bytes(content)
    damaged = Store(settings)
    errors = asyncio.run(read(damaged))
    assert len(errors) == 1
    assert is_damage(errors[0])
    assert "damaged" in problem_of(errors[0])["detail"]
    assert any("malformed" in sentence for sentence in faults(damaged.engine))
    damaged.dispose()
