"""`camwright serve`: the service."""

from __future__ import annotations

import gc
from typing import Annotated, Any

import typer

from service.listening import bound
from service.settings import settings_from
from service.workers import forks


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
            metavar="ADDRESS", help="Dask scheduler to use; left out, workers of its own."
        ),
    ] = None,
) -> None:
    """Start the service, with its page, its API and its documentation."""
    asked = {"host": host, "port": port, "database_url": database_url, "scheduler": scheduler}
    given: dict[str, Any] = {name: value for name, value in asked.items() if value is not None}
    settings = settings_from(**given)
    listening = bound(settings)
    if settings.scheduler is None:
        forks.prepare()
    gc.disable()  # it takes a sixth of the time of imports, and finds nothing
    from service.run import serve as run

    gc.freeze()
    gc.enable()
    run(settings, listening)
