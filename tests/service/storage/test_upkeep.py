"""Backup, restore, verify and prune, by the command line, on a database that is in use."""

from __future__ import annotations

import asyncio
import hashlib
import json
import sqlite3
import zlib
from contextlib import closing
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from sqlalchemy import text
from typer.testing import CliRunner, Result

from service.cli import app
from service.storage import upkeep
from service.storage.answers import Answers
from service.storage.migrations import HEAD
from service.storage.store import Store
from service.sweeps.store import SweepStore
from service.sweeps.tasks import ItemAnswer
from tests.service.conftest import settings_for
from tests.service.postgres import PASSWORD, postgres
from tests.service.storage.test_answers import ONE, row
from tests.service.storage.test_store import FIRST_RELEASE
from tests.service.sweeps.test_sweep_store import a_sweep

BODY = json.dumps({"id": "done", "text": "π\n" * 999}).encode()
DUMP = "select * from {} order by 1"


@pytest.fixture
def used(tmp_path: Path) -> str:
    """A database with an answer, one under way, and a sweep of two items."""
    settings = settings_for(tmp_path)
    store = Store(settings)

    async def fill() -> None:
        answers, sweeps = Answers(ONE, store), SweepStore(store, 60.0)
        etag = hashlib.sha256(BODY).hexdigest()[:32]
        await answers.finish(row("done", state="done", body=BODY, etag=etag), accepted=False)
        await answers.accept(row("waiting", leased_by="a process"))
        await store.body_of_key("ada", "key", "hash")
        sweep = await sweeps.accept(a_sweep(size=2))
        assert await sweeps.take(sweep.sequence)
        done = [(ItemAnswer(n, "optimal", design=zlib.compress(b"{}")), [1.5]) for n in (0, 1)]
        await sweeps.record(sweep.sequence, done)
        await sweeps.end(sweep.sequence, "successful")

    asyncio.run(fill())
    store.dispose()
    return settings.database_url


def run(*words: str, code: int = 0) -> Result:
    result = CliRunner().invoke(app, ["admin", *words])
    assert result.exit_code == code, (result.output, result.exception)
    return result


def rows(file: Path | str, table: str) -> list[tuple[object, ...]]:
    with closing(sqlite3.connect(str(file).removeprefix("sqlite:///"))) as database:
        return database.execute(DUMP.format(table)).fetchall()


def test_a_backup_restored_elsewhere_is_the_same(used: str, tmp_path: Path) -> None:
    kept, elsewhere = tmp_path / "kept.camwright", f"sqlite:///{tmp_path}/elsewhere.db"
    said = run("backup", str(kept), "--database-url", used).output
    assert "answers 2, idempotency keys 1, sweep items 2, sweeps 1" in said
    assert [path.name for path in tmp_path.glob("kept*")] == ["kept.camwright"]
    run("backup", str(kept), "--database-url", used, code=2)
    run("restore", str(kept), "--database-url", elsewhere)
    run("restore", str(kept), "--database-url", elsewhere, code=2)  # it is not empty any more
    for table in ("sweep_items", "idempotency_keys"):
        assert rows(elsewhere, table) == rows(used, table) != []
    with closing(sqlite3.connect(tmp_path / "elsewhere.db")) as database:
        found = database.execute("select id, body, leased_by from answers order by id").fetchall()
        assert found == [("done", BODY, None), ("waiting", None, None)]
    assert "as it was kept" in run("verify", "--database-url", elsewhere).output


def test_a_backup_is_of_one_moment(used: str, tmp_path: Path) -> None:
    """What is committed while it is written is not in it."""
    source = Store(settings_for(tmp_path))
    with upkeep.snapshot(source.engine) as reading:
        assert reading.scalar(text("select count(*) from answers")) == 2
        with source.engine.begin() as writing:
            writing.execute(text("delete from answers"))
        assert reading.scalar(text("select count(*) from answers")) == 2
    source.dispose()
    assert rows(used, "answers") == []


def test_between_sqlite_and_postgresql(used: str, tmp_path: Path) -> None:
    kept, again = tmp_path / "kept", f"sqlite:///{tmp_path}/again.db"
    with postgres("camwright", "camwright") as port:
        url = f"postgresql+psycopg://camwright:{PASSWORD}@127.0.0.1:{port}/camwright"
        run("restore", used.removeprefix("sqlite:///"), "--database-url", url)
        run("verify", "--database-url", url)
        settings = settings_for(tmp_path, database_url=url)
        store = Store(settings)
        new = asyncio.run(Answers(ONE, store).accept(row("new")))
        store.dispose()
        assert new.sequence == 3  # numbered on from what was restored
        run("backup", str(kept), "--database-url", url)
    run("restore", str(kept), "--database-url", again)
    for table in ("sweep_items", "idempotency_keys"):
        assert rows(again, table) == rows(used, table)


def test_a_backup_of_the_first_release_is_read_and_left_alone(tmp_path: Path) -> None:
    kept = tmp_path / "kept.db"
    with closing(sqlite3.connect(kept)) as database:
        database.executescript(FIRST_RELEASE.read_text("utf-8"))
    before = kept.read_bytes()
    run("restore", str(kept), "--database-url", f"sqlite:///{tmp_path}/new.db")
    assert kept.read_bytes() == before


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("update answers set body = x'7b7d' where id = 'done'", "answer /v1/designs/done is not"),
        ("update sweep_items set design = x'00' where number = 1", "item 1 of sweep no. 1"),
        ("delete from sweep_items where number = 0", "counts 2 finished items and has 1"),
        ("delete from sweeps", "a sweep no. 1 that does not exist"),
    ],
)
def test_what_is_damaged_is_named(used: str, tmp_path: Path, change: str, words: str) -> None:
    with closing(sqlite3.connect(tmp_path / "designs.db")) as database, database:
        database.execute(change)
    result = run("verify", "--database-url", used, code=3)
    assert words in result.output
    assert "Restore a backup" in result.output


def test_what_is_old_goes_and_what_is_under_way_stays(used: str, tmp_path: Path) -> None:
    run("prune", "--older-than-days", "1", "--database-url", used)
    assert len(rows(used, "answers")) == 2
    store = Store(settings_for(tmp_path))
    asyncio.run(Answers(ONE, store).claim("waiting", "ada"))  # which keeps no other
    store.dispose()
    with closing(sqlite3.connect(tmp_path / "designs.db")) as database, database:
        old = (datetime.now(UTC) - timedelta(days=2)).replace(tzinfo=None).isoformat(" ")
        database.execute("update answers set created = ?", (old,))
        database.execute("update sweeps set finished = ?", (old,))
    said = run("prune", "--older-than-days", "1", "--dry-run", "--database-url", used).output
    assert said == "Would delete: answers 1, sweeps 1.\n"
    assert len(rows(used, "answers")) == 2
    run("prune", "--older-than-days", "1", "--compact", "--database-url", used)
    (left,) = rows(used, "answers")
    assert "waiting" in left
    assert rows(used, "sweeps") == rows(used, "sweep_items") == []


def test_an_old_sweep_goes_with_its_items_and_another_stays(used: str, tmp_path: Path) -> None:
    store = Store(settings_for(tmp_path))
    sweeps = SweepStore(store, 60.0)

    async def fill() -> tuple[int, int]:
        old, new = await sweeps.find("s", None), await sweeps.accept(a_sweep("new"))
        assert old is not None
        assert await sweeps.take(new.sequence)
        await sweeps.record(new.sequence, [(ItemAnswer(0, "optimal"), [1.5])])
        for each in (old, new):
            await sweeps.keep_strikes(each.sequence, {1: 2})
        return old.sequence, new.sequence

    async def left(sweep: int) -> tuple[set[int], dict[int, int]]:
        return await sweeps.done_numbers(sweep), await sweeps.strikes(sweep)

    old, new = asyncio.run(fill())
    with closing(sqlite3.connect(tmp_path / "designs.db")) as database, database:
        database.execute("update sweeps set finished = '2024-05-06' where id = 's'")
    said = run("prune", "--older-than-days", "1", "--database-url", used).output
    assert said == "Deleted: sweeps 1.\n"
    assert asyncio.run(left(old)) == (set(), {})
    assert asyncio.run(left(new)) == ({0}, {1: 2})
    assert asyncio.run(sweeps.find("new", None)) is not None
    store.dispose()


def test_what_somebody_has_asked_for_since_stays_for_him(used: str, tmp_path: Path) -> None:
    store = Store(settings_for(tmp_path))
    answers = Answers(ONE, store)
    for owner, id in (("ada", "done"), ("bob", "done"), ("ada", "waiting"), ("ada", "given up")):
        asyncio.run(answers.claim(id, owner))
    old = (datetime.now(UTC) - timedelta(days=2)).replace(tzinfo=None).isoformat(" ")
    with closing(sqlite3.connect(tmp_path / "designs.db")) as database, database:
        database.execute("update answers set created = ?", (old,))
        database.execute("update holdings set created = ? where owner = 'ada'", (old,))
    pruned = "prune", "--older-than-days", "1", "--database-url", used
    assert run(*pruned, "--dry-run").output == "Would delete: nothing.\n"
    assert run(*pruned).output == "Deleted: nothing.\n"
    held = {(owner, id) for _, owner, id, *_ in rows(used, "holdings")}
    assert held == {("bob", "done"), ("ada", "waiting")}
    with closing(sqlite3.connect(tmp_path / "designs.db")) as database, database:
        database.execute("update holdings set created = ?", (old,))
    assert run(*pruned, "--dry-run").output == "Would delete: answers 1.\n"
    assert run(*pruned).output == "Deleted: answers 1.\n"
    assert {(owner, id) for _, owner, id, *_ in rows(used, "holdings")} == {("ada", "waiting")}
    store.dispose()


def test_a_database_that_is_not_there_is_not_made(tmp_path: Path) -> None:
    assert (
        "no database"
        in run("verify", "--database-url", f"sqlite:///{tmp_path}/none.db", code=2).output
    )
    assert not (tmp_path / "none.db").exists()


def test_the_tables_go_back_to_an_earlier_release_and_forth_again(used: str) -> None:
    """Answers and sweeps stay; what is no revision changes nothing."""
    kept = {table: len(rows(used, table)) for table in ("answers", "sweeps", "sweep_items")}
    refused = run("downgrade", "4", "--database-url", used, code=2)
    assert "there are 0001, 0002" in refused.output
    assert rows(used, "alembic_version") == [(HEAD,)]
    run("downgrade", "0003", "--database-url", used)
    assert rows(used, "alembic_version") == [("0003",)]
    with pytest.raises(sqlite3.OperationalError, match="no such table"):
        rows(used, "holdings")
    assert {table: len(rows(used, table)) for table in kept} == kept
    assert "Everything is as it was kept" in run("verify", "--database-url", used).output
    assert rows(used, "alembic_version") == [(HEAD,)]
