"""`camwright admin`: back a database up, restore, verify, prune it, or take its tables back."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from service.commands.terminal import say, stop

if TYPE_CHECKING:
    from service.settings import Settings

DatabaseUrl = Annotated[
    str | None,
    typer.Option(
        metavar="URL",
        help="The database; left out, that of CAMWRIGHT_DATABASE_URL, or sqlite:///camwright.db.",
    ),
]
ADMIN = """The database: backed up, restored, verified, pruned, taken back to an earlier release.

Services may run on meanwhile, but for the last; what is restored into is empty. The database is
that of CAMWRIGHT_DATABASE_URL or --database-url, as of `camwright serve`.

  camwright admin backup kept.db
  camwright admin restore kept.db --database-url postgresql+psycopg://user:secret@db/cams
  camwright admin verify --database-url sqlite:///kept.db
  camwright admin prune --older-than-days 365 --dry-run
  camwright admin downgrade 0004

Exit codes: 0 done; 1 a setting makes no sense; 2 the database or the file cannot be used; 3 the
database is damaged."""
app = typer.Typer(no_args_is_help=True, pretty_exceptions_enable=False, rich_markup_mode=None)


def _settings(database_url: str | None) -> Settings:
    from service.settings import settings_from

    return settings_from(**({} if database_url is None else {"database_url": database_url}))


def _open_store(settings: Settings, must_exist: bool = True) -> Any:
    """The database's store, or exit 2 with why not."""
    from sqlalchemy.exc import SQLAlchemyError

    from service.storage.migrations import ForeignDatabase
    from service.storage.store import Store

    url = settings.database
    if must_exist and url.get_backend_name() == "sqlite" and not Path(url.database or "").exists():
        stop(f"There is no database at {url.database}: name it by --database-url.")
    try:
        return Store(settings)
    except (SQLAlchemyError, OSError, ImportError, ForeignDatabase) as error:
        reason = str(getattr(error, "orig", error)).partition("\n")[0]
        stop(f"The database {url.render_as_string(hide_password=True)} cannot be used: {reason}.")


def _told(counts: dict[str, int]) -> str:
    return ", ".join(f"{name.replace('_', ' ')} {count}" for name, count in counts.items() if count)


@app.command()
def backup(
    file: Annotated[Path, typer.Argument(help="File to write; it must not exist.")],
    database_url: DatabaseUrl = None,
) -> None:
    """Write the whole database, as it is at one moment, into one file.

    The file is a SQLite database, whichever the source is: restore reads it into either.
    """
    from sqlalchemy.exc import DBAPIError

    from service.storage.upkeep import back_up

    if file.exists():
        stop(f"{file} exists. Name a new file.")
    settings = _settings(database_url)
    _open_store(settings).dispose()
    try:
        counts = back_up(settings, file)
    except OSError as error:
        stop(f"{file} cannot be written: {error.strerror}.")
    except DBAPIError as error:
        stop(
            f"The database cannot be read: {str(error.orig).strip()}. There is no backup; see what "
            "`camwright admin verify` says, and restore an earlier one."
        )
    say(f"{file}: {_told(counts) or 'nothing is kept yet'}; {file.stat().st_size:,} bytes.")


@app.command()
def restore(
    file: Annotated[Path, typer.Argument(help="File that backup has written.")],
    database_url: DatabaseUrl = None,
) -> None:
    """Read a backup, of this release or an earlier one, into an empty database.

    What was being worked on is worked on by the first service that starts there.
    """
    from service.storage.upkeep import NotEmpty
    from service.storage.upkeep import restore as read

    if not file.is_file():
        stop(f"There is no file {file}.")
    settings = _settings(database_url)
    _open_store(settings, must_exist=False).dispose()
    try:
        counts = read(file, settings)
    except NotEmpty:
        stop("The database holds answers already. Restore into an empty one.")
    say(f"Restored: {_told(counts) or 'nothing was kept'}.")


@app.command()
def verify(database_url: DatabaseUrl = None) -> None:
    """Check that every answer is what was kept, and every sweep has the items that it counts.

    Of a backup: --database-url sqlite:///FILE. Exit code 3 where something is wrong.
    """
    from service.storage.upkeep import faults

    store, wrong = _open_store(_settings(database_url)), 0
    try:
        for sentence in faults(store.engine):
            say(sentence)
            wrong += 1
    finally:
        store.dispose()
    say("Everything is as it was kept." if not wrong else f"Wrong: {wrong}. Restore a backup.")
    raise typer.Exit(3 if wrong else 0)


@app.command()
def prune(
    older_than_days: Annotated[
        float, typer.Option(min=0.0, help="Delete what was kept longer than this ago [days].")
    ],
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Only say how much would be deleted.")
    ] = False,
    compact: Annotated[
        bool,
        typer.Option(
            "--compact", help="Give the room back to the system; with SQLite, services wait."
        ),
    ] = False,
    database_url: DatabaseUrl = None,
) -> None:
    """Delete old answers and sweeps. What is waiting or being worked on stays.

    The same question, asked again, is answered anew.
    """
    from datetime import UTC, datetime, timedelta

    from service.storage import upkeep

    store = _open_store(_settings(database_url))
    try:
        before = datetime.now(UTC) - timedelta(days=older_than_days)
        counts = upkeep.prune(store.engine, before, dry_run)
        if compact and not dry_run:
            upkeep.compact(store.engine)
    finally:
        store.dispose()
    say(f"{'Would delete' if dry_run else 'Deleted'}: {_told(counts) or 'nothing'}.")


@app.command()
def downgrade(
    revision: Annotated[
        str, typer.Argument(help="That the earlier release names where it refuses the database.")
    ],
    database_url: DatabaseUrl = None,
) -> None:
    """Take the tables back to those of an earlier release, with what they hold of what is kept.

    Stop the services before, and make a backup: what an earlier release knows nothing of, such as
    keys and owners, is dropped. A later release brings the tables forward when it starts.
    """
    from service.storage.migrations import HEAD, REVISIONS, migrate

    if revision not in REVISIONS:
        stop(f"There is no revision {revision}: there are {', '.join(REVISIONS)}.")
    store = _open_store(_settings(database_url))
    try:
        migrate(store.engine, revision)
    finally:
        store.dispose()
    say(f"The tables are of revision {revision}; this release's are of {HEAD}.")
