"""Answers for commands: from a service, or computed here by the tasks of its workers."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any
from urllib.parse import urlsplit

import typer
from pydantic import BaseModel, ValidationError
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

from service.client import Client, Refused, Unreachable
from service.commands.terminal import err, read_spec, stop
from service.settings import settings_from
from synthesis.errors import CamwrightError, TimeBudgetExceeded

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
    collection: str, path: Path, url: str | None = None, more: Mapping[str, Any] | None = None
) -> Any:
    """The answer of a service, or computed here; where time ends, the best so far.

    Args:
        collection: of the question, below /v1/. path: file of the question. more: fields of it.
        url: of the service; None: compute it.
    """
    # Imported here: it takes as long as all else that a command imports, and not all need it.
    from service.resources.registry import RESOURCES

    resource = RESOURCES[f"/v1/{collection}"]
    question = read_spec(path, resource.spec, more)
    if url is None:
        return _computed(resource, question)
    with report_errors(path, url, CONTINUES), Client(valid_address(url)) as client, _waiting(url):
        try:
            document = client.answer(resource.path, question)
        except Refused as error:
            if error.best is None:
                raise
            err.print(str(error))
            document = error.best
    try:
        return resource.answer.model_validate_json(json.dumps(document))
    except ValidationError as error:
        first = error.errors()[0]
        where = "/".join(str(part) for part in first["loc"])
        stop(
            f"The answer of {url} is not in the form that this command knows ({where}: "
            f"{first['msg']}). Compare GET /v1/version with camwright --version."
        )


def _computed(resource: Any, question: Any) -> BaseModel:
    """The answer to a question, without links: no service keeps it."""
    from service.workers.tasks import solve_design

    task = resource.task or solve_design
    budget_s = settings_from().budget_s(resource.budget_of(question))
    try:
        body = task(question.model_dump_json().encode(), budget_s).body
        result: BaseModel = resource.answer.model_validate_json(body)
    except TimeBudgetExceeded as error:
        if error.best is None:
            stop(str(error))
        err.print(str(error))
        result = error.best
    except CamwrightError as error:
        stop(str(error))
    return result.model_copy(update={"links": {}}) if hasattr(result, "links") else result


@contextmanager
def _waiting(url: str) -> Iterator[None]:
    """A spinner on the terminal, with the elapsed time."""
    columns = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    with Progress(*columns, console=err, transient=True, disable=not err.is_terminal) as progress:
        progress.add_task(f"waiting for {url}", total=None)
        yield
