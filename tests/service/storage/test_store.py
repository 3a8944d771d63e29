"""The store: tables are what the code says, and a database of another version is told about."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from pathlib import Path

import pytest
from alembic.autogenerate import compare_metadata
from alembic.runtime.migration import MigrationContext

from service.server import serve
from service.storage.store import Store
from service.storage.tables import Base
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
