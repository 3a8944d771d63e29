"""What the commands share: options, reading a spec, printing, writing files, errors."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterable, Mapping
from pathlib import Path
from typing import Annotated, Any, NoReturn

import typer
from pydantic import BaseModel
from rich.console import Console
from rich.table import Table

from service.wire.body import Model, parsed, validated
from service.wire.errors import ServiceError

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


def read_spec(path: Path, model: type[Model], more: Mapping[str, Any] | None = None) -> Model:
    """The spec in a file, with ``more`` fields; a line for each error."""
    try:
        body = path.read_bytes()
        document = parsed(body)
        if isinstance(document, dict) and "value" in document:
            document = document["value"]
            body = json.dumps(document).encode()
        if more and isinstance(document, dict):
            body = json.dumps({**document, **more}).encode()
        return validated(body, model)
    except OSError as error:
        stop(f"{path} cannot be read: {error.strerror}.")
    except ServiceError as error:
        if not error.violations:
            stop(f"{path}: {error}")
        for violation in error.violations:
            where = violation["pointer"] or "the document"
            rule, remedy = violation["rule"], violation["remedy"]
            err.print(f"{path}: {where} = {violation['value']!r}: {rule}. {remedy}")
        raise typer.Exit(2) from None


def print_json(answer: BaseModel) -> None:
    """Print an answer as the service sends it, for other programs."""
    typer.echo(answer.model_dump_json(indent=1))


def print_tables(tables: Iterable[Table]) -> None:
    """Print tables, as wide as the widest of all needs it."""
    wide = Console(highlight=False, width=max(out.width, MIN_WIDTH))
    for table in tables:
        wide.print(table)


def json_of(answer: BaseModel) -> bytes:
    """An answer as the content of a file."""
    return answer.model_dump_json(indent=1).encode()


def written_by_default(formats: Iterable[Any], answer: Any) -> dict[str, bytes]:
    """The files of an answer that are written without being named, with default options."""
    return {each.name: each.write(answer, each.options()) for each in formats if each.by_default}


def save(files: Mapping[str, bytes], folder: Path) -> None:
    """Write files into a folder, which is created where it is missing."""
    try:
        for name, content in files.items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_bytes(content)
    except OSError as error:
        stop(f"{folder} cannot be written to: {error.strerror}.")


def report_files(names: Collection[str], folder: Path) -> None:
    """Print which files have been written."""
    out.print(f"Written to {folder}: {', '.join(names)}")


def stop(sentence: str) -> NoReturn:
    """Print why, and exit with status 2."""
    err.print(sentence)
    raise typer.Exit(2)
