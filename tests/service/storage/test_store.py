"""The store: tables are what the code says, and a database of another version is told about."""

from __future__ import annotations

import asyncio
import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest
from alembic.autogenerate import compare_metadata
from alembic.runtime.migration import MigrationContext
from sqlalchemy.orm import Session

from service.server import serve
from service.storage.answers import Answers
from service.storage.migrations import HEAD, REVISIONS, migrate
from service.storage.store import Store
from service.storage.tables import LOCAL, AnswerRow, Base, HoldingRow, ItemRow, SweepRow
from service.sweeps.store import SweepStore
from tests.service.conftest import settings_for
from tests.service.postgres import PASSWORD, postgres

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


@contextmanager
def database(folder: Path, backend: str) -> Iterator[dict[str, str]]:
    """Settings of an empty database."""
    if backend == "sqlite":
        yield {}
        return
    with postgres("camwright", "camwright") as port:
        address = f"camwright:{PASSWORD}@127.0.0.1:{port}/camwright"
        yield {"database_url": f"postgresql+psycopg://{address}"}


def some_rows() -> list[Any]:
    """What has been asked without a key, and is being worked on."""
    asked: dict[str, Any] = {
        "engine": 1, "name": "n", "created": datetime(2026, 1, 2, tzinfo=UTC), "spec": b"{}",
    }  # fmt: skip
    answer = AnswerRow(id="a", kind="/v1/designs", state="accepted", summary={}, **asked)
    sweep = SweepRow(
        id="s", state="running", size=1, axes=[], quantities=[], leased_by="p", **asked
    )
    holding = HoldingRow(owner=LOCAL, id="a", kind=answer.kind, created=answer.created)
    item = ItemRow(
        sweep=1, number=0, status="infeasible", axis_values=[], quantities={}, seconds=1.0
    )
    return [answer, sweep, holding, item]


@pytest.mark.parametrize("backend", ["sqlite", "postgresql"])
def test_a_database_of_any_earlier_schema_keeps_what_is_in_it(tmp_path: Path, backend: str) -> None:
    """Back to each of them and forth again, one migration after the other."""
    with database(tmp_path, backend) as named:
        store = Store(settings_for(tmp_path, **named))
        engine = store._engine
        with Session(engine) as session, session.begin():
            session.add_all(some_rows())
        assert len(REVISIONS) > 4
        for earlier in REVISIONS[-2::-1]:
            migrate(engine, earlier)
            with engine.connect() as connection:
                context = MigrationContext.configure(connection)
                assert context.get_current_revision() == earlier
            migrate(engine)
            with Session(engine) as session:
                context = MigrationContext.configure(session.connection())
                assert compare_metadata(context, Base.metadata) == []
                assert context.get_current_revision() == HEAD
                answer, sweep, holding, item = (
                    session.query(type(row)).one() for row in some_rows()
                )
                assert (answer.state, answer.spec, answer.leased_by) == ("accepted", b"{}", None)
                assert (holding.owner, holding.id, holding.kind) == (LOCAL, "a", answer.kind)
                assert (sweep.state, sweep.belongs_to, sweep.leased_by) == ("running", LOCAL, "p")
                assert (item.status, item.severity) == ("infeasible", "none")
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


@pytest.mark.parametrize("fsync", [True, False])
def test_a_postgresql_that_does_not_wait_for_its_disk_is_told(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, fsync: bool
) -> None:
    with postgres("camwright", "camwright", fsync=fsync) as port:
        address = f"camwright:{PASSWORD}@127.0.0.1:{port}/camwright"
        Store(settings_for(tmp_path, database_url=f"postgresql+psycopg://{address}")).dispose()
    told = [each.getMessage() for each in caplog.records if each.name == "camwright.store"]
    assert [each.endswith("PostgreSQL has fsync off") for each in told] == [True] * (not fsync)


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
