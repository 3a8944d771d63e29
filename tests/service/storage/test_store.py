"""The store: tables are what the code says, and a database of another version is told about."""

from __future__ import annotations

import asyncio
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest
from alembic.autogenerate import compare_metadata
from alembic.runtime.migration import MigrationContext

from service.server import serve
from service.storage.store import Answers, Store
from service.storage.tables import LOCAL, Base
from service.sweeps.store import SweepStore
from tests.service.conftest import settings_for

FIRST_RELEASE = Path(__file__).with_name("first_release.sql")


@pytest.mark.parametrize("script", ["", FIRST_RELEASE.read_text("utf-8")], ids=["new", "first"])
def test_a_database_gets_the_tables_of_the_code(tmp_path: Path, script: str) -> None:
    """A new one at once, that of the first release by migrations."""
    with closing(sqlite3.connect(tmp_path / "designs.db")) as database:
        database.executescript(script)
    for _ in range(2):  # and starting again changes nothing
        store = Store(settings_for(tmp_path))
        try:
            with store._engine.connect() as connection:
                context = MigrationContext.configure(connection)
                assert compare_metadata(context, Base.metadata) == []
        finally:
            store.dispose()


def test_what_there_was_belongs_to_the_local_owner(tmp_path: Path) -> None:
    """Answers in the order in which they were made, and sweeps; another owner sees none."""
    answers = ", ".join(
        f"({n}, 'a{n}', 7, 'n', '2024-05-0{n} 00:00:00', '{{}}', '/v1/designs', 'done', '{{}}')"
        for n in (3, 1, 2)
    )
    with closing(sqlite3.connect(tmp_path / "designs.db")) as database, database:
        database.executescript(FIRST_RELEASE.read_text("utf-8"))
        database.execute(
            "INSERT INTO answers (sequence, id, engine, name, created, spec, kind, state, summary)"
            f" VALUES {answers}"
        )
        database.execute(
            "INSERT INTO sweeps (id, engine, name, created, spec, state, size, axes, quantities,"
            " optimal, feasible, infeasible, failed)"
            " VALUES ('s', 7, 'n', '2024-05-01', '{}', 'successful', 1, '[]', '[]', 1, 0, 0, 0)"
        )
    store = Store(settings_for(tmp_path))

    async def work() -> None:
        designs, sweeps = Answers("/v1/designs", store), SweepStore(store, 5.0)
        listed = await designs.page(None, 9, None, LOCAL)
        assert [(each.id, each.created.day) for each in listed] == [("a3", 3), ("a2", 2), ("a1", 1)]
        assert [each.id for each in await sweeps.page(None, 9, None, LOCAL)] == ["s"]
        assert await designs.find("a1", "another") is None
        assert await sweeps.find("s", "another") is None

    try:
        asyncio.run(work())
    finally:
        store.dispose()


BEFORE_RELEASE = "CREATE TABLE designs (sequence INTEGER PRIMARY KEY, id VARCHAR(64))"
LATER = (
    "CREATE TABLE alembic_version (version_num VARCHAR(32))",
    "INSERT INTO alembic_version VALUES ('9999')",
)


@pytest.mark.parametrize(
    ("statements", "words"),
    [((BEFORE_RELEASE,), "before its first release"), (LATER, "a later version of Camwright")],
    ids=["before the first release", "later"],
)
def test_a_database_of_another_version_is_left_alone(
    tmp_path: Path, statements: tuple[str, ...], words: str
) -> None:
    """One sentence, with what to do; the service does not start."""
    path = tmp_path / "designs.db"
    with closing(sqlite3.connect(path)) as database, database:
        for statement in statements:
            database.execute(statement)
    settings = settings_for(tmp_path)
    with pytest.raises(SystemExit) as raised:
        serve(settings, None)  # type: ignore[arg-type]  # it does not come to listening
    assert words in str(raised.value)
    assert "CAMWRIGHT_DATABASE_URL" in str(raised.value)
    with closing(sqlite3.connect(path)) as database:
        tables = {name for (name,) in database.execute("SELECT name FROM sqlite_master")}
    assert "answers" not in tables
