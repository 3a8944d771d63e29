"""What the commands share: read a question, have it answered, print the answer, write its files.

A question is answered by a service, or here by the tasks of its workers.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any, NoReturn
from urllib.parse import urlsplit

import typer
from pydantic import BaseModel, ValidationError
from rich.console import Console
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn
from rich.table import Table

from service.client import Client, Refused, Unreachable
from service.client.exchange import sentences
from service.settings import settings_from
from service.wire.body import Model, parse_json, validate
from service.wire.errors import ServiceError
from synthesis.errors import CamwrightError, TimeBudgetExceeded

MIN_WIDTH = 120  # characters that the widest table needs
out = Console(highlight=False, markup=False, soft_wrap=True)
err = Console(highlight=False, markup=False, soft_wrap=True, stderr=True)

AsJson = Annotated[
    bool, typer.Option("--json", help="Print the whole as JSON, as the service answers it.")
]
DesignFile = Annotated[Path, typer.Argument(help="File with a Design, as `design` writes it.")]
Folder = Annotated[
    Path, typer.Option("--out", help="Folder for the results; made where it is missing.")
]
FolderOrNone = Annotated[
    Path | None, typer.Option("--out", help="Folder for the answer and its files; left out: none.")
]


Url = Annotated[
    str | None,
    typer.Option(
        "--url", envvar="CAMWRIGHT_URL", metavar="ADDRESS", show_default=False,
        help="Service to ask, such as http://127.0.0.1:8000. Left out, it is computed here.",
    ),
]  # fmt: skip
CONTINUES = "The service continues; the same command asks for the answer again."


def read_spec(path: Path, model: type[Model], more: Mapping[str, Any] | None = None) -> Model:
    """The spec in a file, with ``more`` fields; a line for each error."""
    try:
        body = path.read_bytes()
        document = parse_json(body)
        if isinstance(document, dict) and "value" in document:
            document = document["value"]
            body = json.dumps(document).encode()
        if more and isinstance(document, dict):
            body = json.dumps({**document, **more}).encode()
        return validate(body, model)
    except OSError as error:
        stop(f"{path} cannot be read: {error.strerror}.")
    except ServiceError as error:
        if not error.violations:
            stop(f"{path}: {error}")
        for violation in error.violations:
            where = violation["pointer"] or "the document"
            value = json.dumps(violation["value"], ensure_ascii=False)
            err.print(f"{path}: {where} = {value}: {sentences(violation)}")
        raise typer.Exit(2) from None


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
            where = wrong.get("pointer") or wrong.get("parameter") or "the document"
            err.print(f"{path}: {where}: {sentences(wrong)}")
        stop(str(error).partition("\n")[0])
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
    from service.resources.records import RESOURCES

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
    budget_s = settings_from().budget_s(getattr(question, "time_budget_s", None))
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


def print_answer(answer: BaseModel, parts: Iterable[str | Table], as_json: bool = False) -> None:
    """Print an answer in lines and tables, or as the service sends it, for other programs."""
    if as_json:
        typer.echo(answer.model_dump_json(indent=1))
        return
    wide = Console(highlight=False, width=max(out.width, MIN_WIDTH))
    for part in parts:
        (out if isinstance(part, str) else wide).print(part)


def files_of(name: str, answer: BaseModel, formats: Iterable[Any] = ()) -> dict[str, bytes]:
    """An answer as the file ``name``, and those of its formats that are written by default."""
    files = {each.name: each.write(answer, each.options()) for each in formats if each.by_default}
    return {name: answer.model_dump_json(indent=1).encode(), **files}


def save(files: Mapping[str, bytes], folder: Path, names: Collection[str] | None = None) -> None:
    """Write files into a folder, which is created where it is missing, and print their names.

    ``names``: printed instead of the files' own; nothing where it is empty.
    """
    try:
        for name, content in files.items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_bytes(content)
    except OSError as error:
        stop(f"{folder} cannot be written to: {error.strerror}.")
    names = files if names is None else names
    if names:
        out.print(f"Written to {folder}: {', '.join(names)}")


def stop(sentence: str) -> NoReturn:
    """Print why, and exit with status 2."""
    err.print(sentence)
    raise typer.Exit(2)
