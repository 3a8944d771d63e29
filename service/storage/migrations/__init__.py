"""How the tables came to be what they are: one step a file, run whenever the service starts."""

from __future__ import annotations

from alembic import command
from alembic.config import Config
from sqlalchemy import Engine, text

LOCK = 0x63616D77  # any number that nobody else locks in this database


def migrate(engine: Engine, to: str = "head") -> None:
    """Bring a database, empty or from an earlier version, to what this version works with."""
    config = Config()
    config.set_main_option("script_location", "service.storage:migrations")
    with engine.begin() as connection:
        if engine.dialect.name == "postgresql":  # two processes may start at once
            connection.execute(text("select pg_advisory_xact_lock(:lock)"), {"lock": LOCK})
        else:
            connection.exec_driver_sql("BEGIN IMMEDIATE")
        config.attributes["connection"] = connection
        command.upgrade(config, to)
