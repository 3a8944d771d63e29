"""Migrations: what brings the tables of an earlier release to those of this one, one file each."""

from __future__ import annotations

from pathlib import Path

from sqlalchemy import Engine, inspect, text

from service.storage.tables import Base

LOCK = 0x63616D77  # any number that no other program locks in this database
# The numbers that the files of the migrations begin with, in order.
REVISIONS = sorted(each.name[:4] for each in Path(__file__).parent.glob("versions/[0-9]*.py"))
HEAD = REVISIONS[-1]
VERSION_TABLE = """create table alembic_version (
    version_num varchar(32) not null, constraint alembic_version_pkc primary key (version_num)
)"""  # as Alembic makes it


class ForeignDatabase(Exception):
    """The database holds tables that this version cannot work with."""


def migrate(engine: Engine, revision: str = HEAD) -> None:
    """Bring a database, empty or of an earlier release, to the tables of this one.

    Args:
        revision: an earlier one: back to the tables of that, of a database that is not empty.

    Raises:
        ForeignDatabase: its tables are of no release that this one knows.
    """
    with engine.begin() as connection:
        if engine.dialect.name == "postgresql":  # two processes may start at once
            connection.execute(text("select pg_advisory_xact_lock(:lock)"), {"lock": LOCK})
        else:
            connection.exec_driver_sql("BEGIN IMMEDIATE")
        tables = inspect(connection).get_table_names()
        # A development version before the first release had a table for each kind of answer.
        if "designs" in tables:
            raise ForeignDatabase(
                "it was written by a version of Camwright from before its first release, whose "
                "tables cannot be carried over. Move it away, or name another one; designs are "
                "computed anew from their specs"
            )
        if "alembic_version" not in tables:  # an empty database gets the tables as they are now
            Base.metadata.create_all(connection, checkfirst=False)
            connection.execute(text(VERSION_TABLE))
            connection.execute(text("insert into alembic_version values (:head)"), {"head": HEAD})
            return
        current = connection.scalar(text("select version_num from alembic_version"))
        if current == revision:
            return
        if current not in REVISIONS:
            raise ForeignDatabase(
                "it was written by a later version of Camwright (its tables are of revision "
                f"{current}, this version's of {HEAD}). Start that version, or have it run "
                f"`camwright admin downgrade {HEAD}`, or name another database"
            )
        # Imported here: few starts need it, and it takes a tenth of the time of all imports.
        from alembic import command
        from alembic.config import Config

        config = Config(attributes={"connection": connection})
        config.set_main_option("script_location", "service.storage:migrations")
        (command.upgrade if revision > current else command.downgrade)(config, revision)
