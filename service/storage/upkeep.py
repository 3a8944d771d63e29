"""What an operator does to a database, while services use it: copy it, check it, prune it."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import tempfile
import zlib
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from sqlalchemy import Connection, Engine, Select, delete, exists, func, insert, select, text
from sqlalchemy.exc import DBAPIError
from sqlalchemy.orm import Session

from service.settings import Settings
from service.storage.store import Store
from service.storage.tables import (
    AnswerRow,
    Base,
    HoldingRow,
    ItemRow,
    LeasedRow,
    StrikeRow,
    SweepRow,
)  # fmt: skip

ROWS = 200  # that are held, or deleted in a transaction, at once: some MB at most
FREE = {"leased_by": None, "leased_until": None}  # of a row in a copy: nobody works on it there
TABLES = Base.metadata.sorted_tables
LEASED = {
    mapper.local_table for mapper in Base.registry.mappers if issubclass(mapper.class_, LeasedRow)
}
OVER = ("done", "failed", "superseded")  # states of questions that nobody works on


class NotEmpty(Exception):
    """The database that is to be restored into holds rows already."""


def back_up(settings: Settings, file: Path) -> dict[str, int]:
    """Write all rows, as they are at one moment, into a new SQLite file; rows by table.

    The file is there whole or not at all, and durable when this returns.
    """
    new = file.with_name(f"{file.name}.part")
    new.unlink(missing_ok=True)
    try:
        rows = _copy(settings, _at(new))
        with new.open("rb") as written:
            os.fsync(written.fileno())
        new.replace(file)
        _keep_names(file.absolute().parent)
    finally:
        new.unlink(missing_ok=True)
    return rows


def restore(file: Path, settings: Settings) -> dict[str, int]:
    """Read a backup, of this release or an earlier one, into an empty database; rows by table."""
    with tempfile.TemporaryDirectory() as folder:  # an earlier one is migrated, the file is not
        copied = Path(folder) / "backup.db"
        shutil.copyfile(file, copied)
        return _copy(_at(copied), settings)


def _at(file: Path) -> Settings:
    return Settings(database_url=f"sqlite:///{file.absolute()}")


def _keep_names(folder: Path) -> None:
    """Make the names in a folder durable."""
    opened = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(opened)
    finally:
        os.close(opened)


def _copy(source: Settings, target: Settings) -> dict[str, int]:
    there, here = Store(source), Store(target)
    try:
        with snapshot(there.engine) as reading, here.engine.begin() as writing:
            if any(writing.scalar(select(func.count()).select_from(each)) for each in TABLES):
                raise NotEmpty
            return copy_rows(reading, writing)
    finally:
        for each in (there, here):
            each.dispose()


def snapshot(engine: Engine) -> Connection:
    """A connection that sees the database as it is now, whatever is written meanwhile."""
    if engine.dialect.name == "postgresql":
        return engine.connect().execution_options(isolation_level="REPEATABLE READ")
    connection = engine.connect()
    connection.exec_driver_sql("begin")  # its driver begins none for reading
    return connection


def copy_rows(source: Connection, target: Connection) -> dict[str, int]:
    """Copy the rows of all tables; how many of each."""
    counts = {}
    for table in TABLES:
        counts[table.name] = 0
        query = select(table).order_by(*table.primary_key)
        found = source.execution_options(yield_per=ROWS).execute(query)
        for several in found.mappings().partitions():
            rows = [{name: _in_utc(value) for name, value in row.items()} for row in several]
            if table in LEASED:
                rows = [{**row, **FREE} for row in rows]
            target.execute(insert(table), rows)
            counts[table.name] += len(rows)
        if target.dialect.name == "postgresql" and "sequence" in table.columns:
            number = f"pg_get_serial_sequence('{table.name}', 'sequence')"
            most = f"(select max(sequence) from {table.name})"
            target.execute(text(f"select setval({number}, {most}) where {most} is not null"))
    return counts


def _in_utc(value: Any) -> Any:
    """Times as both databases keep them; others as they are."""
    if not isinstance(value, datetime):
        return value
    return value.replace(tzinfo=UTC) if value.tzinfo is None else value.astimezone(UTC)


def faults(engine: Engine) -> Iterator[str]:
    """What is wrong with a database, a sentence each; the last where it cannot be read on."""
    try:
        yield from _faults(engine)
    except DBAPIError as error:
        yield f"It cannot be read further: {str(error.orig).strip()}."


def _faults(engine: Engine) -> Iterator[str]:
    with snapshot(engine) as connection, Session(connection) as session:
        if engine.dialect.name == "sqlite":
            for (line,) in connection.exec_driver_sql("pragma integrity_check"):
                if line != "ok":
                    yield f"SQLite says: {line}."
        finished = select(AnswerRow).filter_by(state="done").execution_options(yield_per=ROWS)
        for row in session.scalars(finished):
            body = row.body or b""
            if hashlib.sha256(body).hexdigest()[:32] != row.etag:
                yield f"The answer {row.kind}/{row.id} is not what was kept: its hash differs."
            elif json.loads(body).get("id", row.id) != row.id:
                yield f"The answer {row.kind}/{row.id} belongs to another question."
            session.expunge(row)
        query = select(ItemRow).where(ItemRow.design.is_not(None))
        for item in session.scalars(query.execution_options(yield_per=ROWS)):
            try:
                json.loads(zlib.decompress(item.design or b""))
            except (ValueError, zlib.error) as error:
                which = f"item {item.number} of sweep no. {item.sweep}"
                yield f"The design of {which} cannot be read: {error}."
            session.expunge(item)
        counts = dict(
            session.execute(select(ItemRow.sweep, func.count()).group_by(ItemRow.sweep)).all()
        )
        for sweep in session.scalars(select(SweepRow)):
            kept = counts.pop(sweep.sequence, 0)
            if kept != sweep.done:
                yield f"Sweep {sweep.id} counts {sweep.done} finished items and has {kept}."
        for number in counts:
            yield f"There are items of a sweep no. {number} that does not exist."


def prune(engine: Engine, before: datetime, count_only: bool) -> dict[str, int]:
    """Delete answers and sweeps that ended before a moment, or count them; rows by table.

    Each transaction is short, so that services go on. What is under way stays, and an answer that
    somebody has asked for since then: for those who asked before, it is gone.
    """
    since_then = exists().where(HoldingRow.id == AnswerRow.id, HoldingRow.created >= before)
    old_answers = select(AnswerRow.sequence).where(
        AnswerRow.created < before, AnswerRow.state.in_(OVER), ~since_then
    )
    under_way = exists().where(HoldingRow.id == AnswerRow.id, AnswerRow.state.not_in(OVER))
    old_holdings = select(HoldingRow.sequence).where(HoldingRow.created < before, ~under_way)
    old_sweeps = select(SweepRow.sequence).where(SweepRow.finished < before)
    if count_only:
        with Session(engine) as session:
            return {
                name: session.scalar(select(func.count()).select_from(query.subquery())) or 0
                for name, query in (("answers", old_answers), ("sweeps", old_sweeps))
            }
    _delete(engine, HoldingRow, old_holdings)
    held = exists().where(HoldingRow.id == AnswerRow.id)
    counts = {"answers": _delete(engine, AnswerRow, old_answers.where(~held)), "sweeps": 0}
    with Session(engine) as session:
        sweeps = session.scalars(old_sweeps).all()
    for sweep in sweeps:
        with Session(engine) as session, session.begin():
            for rows in (ItemRow, StrikeRow):
                session.execute(delete(rows).filter_by(sweep=sweep))
            session.execute(delete(SweepRow).filter_by(sequence=sweep))
        counts["sweeps"] += 1
    return counts


def _delete(engine: Engine, rows: Any, which: Select[int]) -> int:
    """Delete rows with these sequence numbers, some at a time; how many."""
    count = 0
    while True:
        with Session(engine) as session, session.begin():
            # In one statement: what somebody asks for meanwhile stays.
            gone = delete(rows).where(rows.sequence.in_(which.limit(ROWS)))
            some = session.scalars(gone.returning(rows.sequence)).all()
        if not some:
            return count
        count += len(some)


def compact(engine: Engine) -> None:
    """Give the room of deleted rows back to the system; services wait meanwhile with SQLite."""
    with engine.connect().execution_options(isolation_level="AUTOCOMMIT") as connection:
        connection.exec_driver_sql("vacuum")
