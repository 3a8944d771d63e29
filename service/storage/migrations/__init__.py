"""Migrations: what brings the tables of an earlier release to those of this one, one file each."""

from __future__ import annotations

from alembic import command
from alembic.config import Config
from alembic.migration import MigrationContext
from alembic.script import ScriptDirectory
from sqlalchemy import Engine, inspect, text

from service.storage.tables import Base

LOCK = 0x63616D77  # any number that no other program locks in this database


class ForeignDatabase(Exception):
    """The database holds tables that this version cannot work with."""


def migrate(engine: Engine) -> None:
    """Bring a database, empty or of an earlier release, to the tables of this one.

    Raises:
        ForeignDatabase: its tables are of no release that this one knows.
    """
    config = Config()
    config.set_main_option("script_location", "service.storage:migrations")
    with engine.begin() as connection:
        if engine.dialect.name == "postgresql":  # two processes may start at once
            connection.execute(text("select pg_advisory_xact_lock(:lock)"), {"lock": LOCK})
        else:
            connection.exec_driver_sql("BEGIN IMMEDIATE")
        config.attributes["connection"] = connection
        # A development version before the first release had a table for each kind of answer.
        if "designs" in inspect(connection).get_table_names():
            raise ForeignDatabase(
                "it was written by a version of Camwright from before its first release, whose "
                "tables cannot be carried over. Move it away, or name another one; designs are "
                "computed anew from their specs"
            )
        known = {each.revision for each in ScriptDirectory.from_config(config).walk_revisions()}
        current = MigrationContext.configure(connection).get_current_revision()
        if current is None:  # an empty database gets the tables as they are now
            Base.metadata.create_all(connection, checkfirst=False)
            command.stamp(config, "head")
        elif current in known:
            command.upgrade(config, "head")
        else:
            raise ForeignDatabase(
                "it was written by a later version of Camwright (its tables are of revision "
                f"{current}). Start that version, or name another database"
            )
