"""`camwright serve`: the service."""

from __future__ import annotations

import gc
from typing import Annotated, Any

import typer


def serve(
    host: Annotated[
        str | None,
        typer.Option(metavar="ADDRESS", help="Address to listen on: 127.0.0.1; 0.0.0.0 for all."),
    ] = None,
    port: Annotated[
        int | None, typer.Option(help="Port to listen on: 8000; 0 takes any that is free.")
    ] = None,
    database_url: Annotated[
        str | None,
        typer.Option(
            metavar="URL", help="Where designs are kept: sqlite:///camwright.db, or PostgreSQL's."
        ),
    ] = None,
    scheduler: Annotated[
        str | None,
        typer.Option(
            metavar="ADDRESS", help="Dask scheduler to use, over TLS; left out, workers of its own."
        ),
    ] = None,
) -> None:
    """Start the service with its page, its API and its documentation; no internet is needed.

    Options left out come from the environment: CAMWRIGHT_HOST, CAMWRIGHT_PORT,
    CAMWRIGHT_DATABASE_URL, CAMWRIGHT_SCHEDULER, and further CAMWRIGHT_WORKERS (processes),
    CAMWRIGHT_TIME_BUDGET_S (seconds one question may take) and others, else from the defaults. It
    designs a textbook cam as a self-check and prints its addresses; Ctrl-C stops it.

      camwright serve
      camwright serve --host 0.0.0.0 --port 8080
      camwright serve --database-url postgresql+psycopg://user:secret@db/cams
      camwright serve --scheduler tls://10.0.0.5:8786

    Exit codes: 0 stopped by Ctrl-C; 1 the port, the database or a setting cannot be used, and why.
    """
    from service.settings import listening_socket, settings_from
    from service.workers import prefork

    options = {"host": host, "port": port, "database_url": database_url, "scheduler": scheduler}
    given: dict[str, Any] = {name: value for name, value in options.items() if value is not None}
    settings = settings_from(**given)
    with listening_socket(settings) as listener:
        if settings.scheduler is None:
            prefork.start_fork_server()
        gc.disable()  # collections take a sixth of the time of the imports, and free nothing
        from service.server import serve as run

        gc.freeze()
        gc.enable()
        run(settings, listener)
