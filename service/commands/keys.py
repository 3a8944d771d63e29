"""`camwright keys`: keys to a service, made and revoked where its database is."""

from __future__ import annotations

from collections.abc import Callable, Coroutine
from typing import Annotated, Any, TypeVar

import typer

from service.commands.terminal import complain, say, stop

KEYS = """Keys to a service: made, listed, rotated and revoked where its database is.

A service that others reach asks for a key, and opens with it what its owner has asked. The database
is that of CAMWRIGHT_DATABASE_URL or --database-url, as of `camwright serve`; the service may be
running meanwhile. What is made, rotated or revoked is told by a line of the audit log on standard
error.

  camwright keys create "Ada's laptop" --owner ada --days 365
  camwright keys list
  camwright keys rotate 1f2e3d4c --overlap-days 7
  camwright keys revoke 1f2e3d4c

Exit codes: 0 done; 1 the database or a setting cannot be used; 2 there is no such key."""
T = TypeVar("T")
LOCAL = "local"  # as in `service.storage.tables`, which takes long to import
app = typer.Typer(no_args_is_help=True, pretty_exceptions_enable=False, rich_markup_mode=None)
Id = Annotated[str, typer.Argument(help="Id of the key, as `camwright keys list` shows it.")]
Database = Annotated[
    str | None, typer.Option(metavar="URL", show_default=False, help="As of `camwright serve`.")
]
Days = Annotated[
    float | None,
    typer.Option(
        "--days", min=0.0, show_default=False,
        help="After so many days it is refused. Left out: it does not expire.",
    ),
]  # fmt: skip


@app.command()
def create(
    name: Annotated[str, typer.Argument(help="What it is for, such as a person or a program.")],
    owner: Annotated[
        str,
        typer.Option(
            help="Whose answers it opens: keys of one owner see the same. local: those that were "
            "made without a key."
        ),
    ] = LOCAL,
    days: Days = None,
    operator: Annotated[
        bool, typer.Option("--operator", help="It may read /metrics, which counts all owners.")
    ] = False,
    requests_per_minute: Annotated[
        int | None, typer.Option(min=1, show_default=False, help="With this key.")
    ] = None,
    core_seconds_per_day: Annotated[
        float | None, typer.Option(min=0.0, show_default=False, help="Of the owner, days by UTC.")
    ] = None,
    storage_mb: Annotated[
        float | None, typer.Option(min=0.0, show_default=False, help="Of the owner's answers.")
    ] = None,
    concurrent: Annotated[
        int | None,
        typer.Option(min=1, show_default=False, help="Questions of the owner worked on at a time."),
    ] = None,
    database_url: Database = None,
) -> None:
    """Make a key and print it, this once: only its hash is kept.

    The key goes to standard output, what there is to say of it to standard error. Quotas left out
    are those of the settings CAMWRIGHT_QUOTA_REQUESTS_PER_MINUTE and so on, else there are none.

      camwright keys create "Ada's laptop" --owner ada --days 90
      camwright keys create prometheus --operator > /run/secrets/metrics-key
    """
    from service.wire.access import Quotas

    if not name.strip() or len(name) > 200:
        stop("A name has 1 to 200 characters.")
    if not owner.strip() or len(owner) > 64 or not owner.isprintable():
        stop("The name of an owner has 1 to 64 printable characters.")
    quotas = Quotas(requests_per_minute, core_seconds_per_day, storage_mb, concurrent)
    row, text = _do(
        database_url, lambda keys: keys.create(name, owner, days, operator=operator, quotas=quotas)
    )
    _audit("create", made=row.id, owner=row.owner)
    _show(row, text)


@app.command("list")
def list_keys(database_url: Database = None) -> None:
    """List the keys: id, owner, name, and until when they are valid; not the keys themselves."""
    from service.storage.keys import is_valid

    for row in _do(database_url, lambda keys: keys.all()):
        if row.revoked is not None:
            state = f"revoked {row.revoked:%Y-%m-%d}"
        elif row.expires is not None:
            state = f"{'until' if is_valid(row) else 'expired'} {row.expires:%Y-%m-%d %H:%M} UTC"
        else:
            state = "valid"
        may = [*(f"{key}={value:g}" for key, value in row.quotas.items())]
        may += ["operator"] if row.operator else []
        say("  ".join([row.id, row.owner, row.name, state, *may]))


@app.command()
def revoke(id: Id, database_url: Database = None) -> None:
    """Refuse a key from now on: a running service notices within a second."""
    if not _do(database_url, lambda keys: keys.revoke(id)):
        stop(f"There is no key {id} that is not revoked: see camwright keys list.")
    _audit("revoke", key=id)
    complain(f"Key {id} is revoked. What its owner has stays, for his other keys.")


@app.command()
def rotate(
    id: Id,
    overlap_days: Annotated[
        float, typer.Option(min=0.0, help="So long the old key stays valid beside the new one.")
    ] = 1.0,
    days: Days = None,
    database_url: Database = None,
) -> None:
    """Make a key in place of another one; both are valid until the old one ends.

    The new one has the old one's name, owner and quotas, and is printed as `create` prints it. The
    service need not be stopped: give the new key to the program, and let the old one expire.
    """
    try:
        row, text, end = _do(database_url, lambda keys: keys.rotate(id, overlap_days, days))
    except LookupError:
        stop(f"There is no valid key {id}: see camwright keys list.")
    _audit("rotate", key=id, made=row.id, owner=row.owner)
    complain(f"Key {id} stays valid until {end:%Y-%m-%d %H:%M} UTC.")
    _show(row, text)


def _show(row: Any, text: str) -> None:
    until = "without end" if row.expires is None else f"until {row.expires:%Y-%m-%d %H:%M} UTC"
    complain(f"Key {row.id} of {row.owner}, {row.name!r}, {until}. It is shown this once:")
    say(text)


def _audit(action: str, **fields: str) -> None:
    """A line of the audit log, as the service writes them: what became of which key, and by whom.

    ``user`` is the account on this machine: who may write to the database needs no key.
    """
    import getpass
    import logging
    import os

    from service.wire.access import audit
    from service.wire.logs import configure_logs

    try:
        user = getpass.getuser()
    except (ImportError, KeyError, OSError):  # the account has no name, as in some containers
        user = str(os.getuid())
    configure_logs("warning")
    audit.setLevel(logging.INFO)
    audit.info("audit", extra={"fields": {"action": f"{action} key", **fields, "user": user}})


def _do(database_url: str | None, work: Callable[[Any], Coroutine[Any, Any, T]]) -> T:
    """Do something with the keys in the database; one sentence, exit 1 where it is not usable."""
    import asyncio

    from service.server import open_database
    from service.settings import settings_from
    from service.storage.keys import ApiKeys

    given = {} if database_url is None else {"database_url": database_url}
    settings = settings_from(**given)
    store = open_database(settings)
    try:
        return asyncio.run(work(ApiKeys(store, settings)))
    finally:
        store.dispose()
