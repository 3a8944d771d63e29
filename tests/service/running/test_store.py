"""The store: databases from before are brought up to date, and tables are what the code says."""

from __future__ import annotations

import asyncio
import sqlite3
from pathlib import Path

import pytest
from alembic.autogenerate import compare_metadata
from alembic.runtime.migration import MigrationContext

from service.resources.resource import DESIGNS
from service.storage.store import Base, Store
from tests.service.conftest import settings_for

ANSWERS = """
CREATE TABLE {name} (sequence INTEGER NOT NULL, id VARCHAR(64) NOT NULL, name VARCHAR(200) NOT NULL,
 created DATETIME NOT NULL, state VARCHAR(16) NOT NULL, status VARCHAR(16), spec BLOB NOT NULL,
 design BLOB, etag VARCHAR(64), summary JSON NOT NULL, problem JSON, PRIMARY KEY (sequence),
 UNIQUE (id));
CREATE INDEX ix_{name}_state ON {name} (state);
"""
KEYS = """
CREATE TABLE idempotency_keys ("key" VARCHAR(255) NOT NULL, body_hash VARCHAR(64) NOT NULL,
 design_id VARCHAR(64) NOT NULL, created DATETIME NOT NULL, PRIMARY KEY ("key"));
CREATE INDEX ix_idempotency_keys_created ON idempotency_keys (created);
"""
A_DESIGN = """
INSERT INTO designs (id, name, created, state, status, spec, design, etag, summary) VALUES
 ('d1', 'an old one', '2026-01-02 03:04:05', 'done', 'optimal', x'7b7d', x'7b7d', 'e1', '{}');
"""
EARLIER = {  # what a service made before it knew of migrations, and what was made later
    "none": (),
    "designs alone": (ANSWERS.format(name="designs"), KEYS, A_DESIGN),
    "with cam sets": (
        ANSWERS.format(name="designs"), ANSWERS.format(name="cam_sets"), KEYS, A_DESIGN,
    ),
}  # fmt: skip


@pytest.mark.parametrize("earlier", EARLIER)
def test_a_database_from_before_is_brought_up_to_date(tmp_path: Path, earlier: str) -> None:
    with sqlite3.connect(tmp_path / "designs.db") as database:
        for statement in EARLIER[earlier]:
            database.executescript(statement)
    database.close()
    for _ in range(2):  # and starting again changes nothing
        store = Store(settings_for(tmp_path))
        try:
            found = asyncio.run(store.table(DESIGNS.row, DESIGNS.elsewhere).find("d1"))
            with store._engine.connect() as connection:
                context = MigrationContext.configure(connection)
                assert compare_metadata(context, Base.metadata) == []
        finally:
            store.dispose()
        if earlier == "none":
            assert found is None
        else:
            assert found is not None
            assert (found.name, found.design, found.etag) == ("an old one", b"{}", "e1")
