"""Answers for commands: from a service, or computed here."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any
from urllib.parse import urlsplit

import typer
from pydantic import ValidationError
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

from service.client import Client, Refused, Unreachable
from service.commands.terminal import compute, err, stop
from service.wire.body import Model

Url = Annotated[
    str | None,
    typer.Option(
        "--url", envvar="CAMWRIGHT_URL", metavar="ADDRESS", show_default=False,
        help="Service to ask, such as http://127.0.0.1:8000. Left out, it is computed here.",
    ),
]  # fmt: skip
CONTINUES = "The service continues; the same command asks for the answer again."


@contextmanager
def report_errors(path: Path, url: str | None, stopped: str) -> Iterator[None]:
    """Print the errors of a client, each wrong field in a line, and exit.

    Args:
        path: file of the question. url: of the service; None: one started by this command.
        stopped: what happens to the question after Ctrl-C.
    """
    try:
        yield
    except Refused as error:
        for wrong in error.errors:
            err.print(f"{path}: {wrong['pointer']}: {wrong['rule']}. {wrong['remedy']}")
        stop(str(error))
    except Unreachable as error:
        stop(f"No answer from {url or 'the service started for this'} ({error}). Is it running?")
    except KeyboardInterrupt:
        err.print(f"Stopped waiting. {stopped}")
        raise typer.Exit(130) from None


def valid_address(url: str) -> str:
    """The address of a service; exits where it is not one."""
    parts = urlsplit(url)
    if parts.scheme not in {"http", "https"} or not parts.hostname:
        stop(
            f"{url} is not the address of a service, such as http://127.0.0.1:8000. See --url or "
            "CAMWRIGHT_URL."
        )
    return url


def answer(
    url: str | None,
    path: Path,
    model: type[Model],
    ask: Callable[[Client], dict[str, Any]],
    work: Callable[[float], Model],
    budget_s: float | None = None,
) -> Model:
    """The answer of a service, or computed here; where time ends, the best so far.

    Args:
        url: of the service; None: compute it. path: file of the question. model: of the answer.
        ask: the call of the client. work, budget_s: as in ``terminal.compute``.
    """
    if url is None:
        return compute(work, budget_s)
    with report_errors(path, url, CONTINUES), Client(valid_address(url)) as client, _waiting(url):
        try:
            document = ask(client)
        except Refused as error:
            if error.best is None:
                raise
            err.print(str(error))
            document = error.best
    try:
        return model.model_validate_json(json.dumps(document))
    except ValidationError as error:
        first = error.errors()[0]
        where = "/".join(str(part) for part in first["loc"])
        stop(
            f"The answer of {url} is not in the form that this command knows ({where}: "
            f"{first['msg']}). Compare GET /v1/version with camwright --version."
        )


@contextmanager
def _waiting(url: str) -> Iterator[None]:
    """A spinner on the terminal, with the elapsed time."""
    columns = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    with Progress(*columns, console=err, transient=True, disable=not err.is_terminal) as progress:
        progress.add_task(f"waiting for {url}", total=None)
        yield
