"""What the commands share and needs no more than typer: options, lines printed, files written.

`--help` and completion load the modules of the commands, so that these import at their top only
what is as light as this one; `answering` has what takes longer to import.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Mapping
from enum import StrEnum
from functools import wraps
from inspect import Parameter, signature
from pathlib import Path
from typing import Annotated, Any, NoReturn

import typer

STREAM = Path("-")  # in place of a file: standard input, a question a line


class Units(StrEnum):
    """Units of lengths in what is printed."""

    mm = "mm"
    inch = "inch"


def complete_question(incomplete: str) -> list[str]:
    """Files and worked examples whose names begin so."""
    from service.contract.examples import example_paths

    files = [str(path) + "/" * path.is_dir() for path in Path().glob(f"{incomplete}*")]
    return [*sorted(files), *(name for name in example_paths() if name.startswith(incomplete))]


SpecFile = Annotated[
    Path,
    typer.Argument(
        help="File with the question, the name of a worked example, or - for standard input.",
        autocompletion=complete_question,
    ),
]
AsJson = Annotated[
    bool, typer.Option("--json", help="Print the whole as JSON, as the service answers it.")
]
DesignFile = Annotated[
    Path, typer.Argument(help="File with a Design, as `design` writes it, or - for standard input.")
]
Folder = Annotated[
    Path | None,
    typer.Option(
        "--out", show_default=False,
        help="Folder for the results, made where it is missing; left out, this one. With - a "
        "folder in it for each question, and left out: none.",
    ),
]  # fmt: skip
FolderOrNone = Annotated[
    Path | None, typer.Option("--out", help="Folder for the answer and its files; left out: none.")
]
DisplayUnits = Annotated[
    Units,
    typer.Option(
        "--units", help="Of lengths printed, per s as well; files and JSON are in mm always."
    ),
]
Url = Annotated[
    str | None,
    typer.Option(
        "--url", envvar="CAMWRIGHT_URL", metavar="ADDRESS", show_default=False,
        help="Service to ask, such as http://127.0.0.1:8000. Left out, it is computed here.",
    ),
]  # fmt: skip

KEY = "CAMWRIGHT_KEY"  # as the client reads it
GivenKey = Annotated[
    str | None,
    typer.Option(
        "--key", envvar=KEY, metavar="KEY", show_default=False,
        help="Key to the service of --url. Others on this machine may see options: rather set the "
        "variable.",
    ),
]  # fmt: skip


def with_key(command: Callable[..., Any]) -> Callable[..., Any]:
    """A command that asks a service, with an option for the key to it, which the client reads."""

    @wraps(command)
    def keyed(*, key: str | None = None, **options: Any) -> None:
        if key is not None:
            os.environ[KEY] = key
        command(**options)

    known = signature(command, eval_str=True)
    given = Parameter("key", Parameter.KEYWORD_ONLY, default=None, annotation=GivenKey)
    keyed.__signature__ = known.replace(  # type: ignore[attr-defined]
        parameters=[*known.parameters.values(), given]
    )
    return keyed


def say(text: str) -> None:
    """Print a line."""
    typer.echo(text)


def complain(text: str) -> None:
    """Print a line where errors go."""
    typer.echo(text, err=True)


def stop(sentence: str) -> NoReturn:
    """Print why, and exit with status 2."""
    complain(sentence)
    raise typer.Exit(2)


def save(files: Mapping[str, bytes], folder: Path, names: Collection[str] | None = None) -> None:
    """Write files into a folder, which is created where it is missing, and print their names.

    ``names``: printed instead of the files' own; nothing where it is empty.
    """
    write(files, folder)
    name_files(files if names is None else names, folder)


def write(files: Mapping[str, bytes], folder: Path) -> None:
    """Write files into a folder, which is created where it is missing."""
    try:
        for name, content in files.items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_bytes(content)
    except OSError as error:
        stop(f"{folder} cannot be written to: {error.strerror}.")


def name_files(names: Collection[str], folder: Path) -> None:
    """Print what was written into a folder; nothing where there are no names."""
    if names:
        say(f"Written to {folder}: {', '.join(names)}")
