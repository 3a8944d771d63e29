"""What a command asks of a service: the address, the waiting, the answer, the no."""

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
from service.commands.terminal import err, stop
from service.wire.body import Model

Url = Annotated[
    str | None,
    typer.Option(
        "--url", envvar="CAMWRIGHT_URL", metavar="ADDRESS", show_default=False,
        help="Service to ask, such as http://127.0.0.1:8000. Left out, it is done here.",
    ),
]  # fmt: skip
STAYS = "It goes on there; the same command asks for it again."


@contextmanager
def refusals(path: Path, url: str | None, stopped: str) -> Iterator[None]:
    """What a service refuses, in sentences: each wrong field by itself, then the whole.

    Args:
        path: file that the question comes from. url: where it goes; None: to a service of our own.
        stopped: what becomes of it after Ctrl-C.
    """
    try:
        yield
    except Refused as error:
        for wrong in error.errors:
            err.print(f"{path}: {wrong['pointer']}: {wrong['rule']}. {wrong['way_out']}")
        stop(str(error))
    except Unreachable as error:
        stop(f"No answer from {url or 'the service started for this'} ({error}). Does it run?")
    except KeyboardInterrupt:
        err.print(f"Stopped waiting. {stopped}")
        raise typer.Exit(130) from None


def checked(url: str) -> str:
    """The address, if it is one."""
    parts = urlsplit(url)
    if parts.scheme not in {"http", "https"} or not parts.hostname:
        stop(
            f"{url} is no address of a service: it begins with http:// or https:// and names a "
            "host, as http://127.0.0.1:8000 does. See --url or CAMWRIGHT_URL."
        )
    return url


def asked(
    url: str, path: Path, model: type[Model], ask: Callable[[Client], dict[str, Any]]
) -> Model:
    """The answer of a service; where its time ended, the best so far, as here.

    Args:
        url: its address. path: file that the question comes from. model: of the answer.
        ask: the call.
    """
    with refusals(path, url, STAYS), Client(checked(url)) as client, _waiting(url):
        try:
            found = ask(client)
        except Refused as error:
            if error.best is None:
                raise
            err.print(str(error))
            found = error.best
    try:
        return model.model_validate_json(json.dumps(found))
    except ValidationError as error:
        first = error.errors()[0]
        where = "/".join(str(part) for part in first["loc"])
        stop(
            f"{url} answers in a way that this command does not know ({where}: {first['msg']}). "
            "Is it of another version? GET /v1/version says which it is, camwright --version ours."
        )


@contextmanager
def _waiting(url: str) -> Iterator[None]:
    """A sign of life on the terminal, with the time that went by."""
    told = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    with Progress(*told, console=err, transient=True, disable=not err.is_terminal) as progress:
        progress.add_task(f"waiting for {url}", total=None)
        yield
