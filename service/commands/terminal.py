"""What the commands share: reading a spec, computing, printing, writing files, errors."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Annotated, Any, NoReturn

import typer
from pydantic import BaseModel
from rich.console import Console
from rich.table import Table

from service.settings import settings_from
from service.wire.body import Model, parsed, validated
from service.wire.errors import InvalidBody, ServiceError
from synthesis.design.design import Design
from synthesis.errors import CamwrightError, TimeBudgetExceeded
from synthesis.spec.design_spec import DesignSpec

out = Console(highlight=False, markup=False, soft_wrap=True)
err = Console(highlight=False, markup=False, soft_wrap=True, stderr=True)

AsJson = Annotated[
    bool, typer.Option("--json", help="Print the whole as JSON, as the service answers it.")
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
    except InvalidBody as error:
        for found in error.violations:
            where = found["pointer"] or "the document"
            err.print(f"{path}: {where} = {found['value']!r}: {found['rule']}. {found['remedy']}")
        raise typer.Exit(2) from None
    except ServiceError as error:
        stop(f"{path}: {error}")


def compute(work: Callable[[float], Model], budget_s: float | None = None) -> Model:
    """The result of some work here, with a time budget; where time ends, the best result so far.

    Args:
        work: deadline, by ``time.monotonic()`` [s], to the result. It imports the solvers itself,
            so that other commands start at once.
    """
    try:
        return work(time.monotonic() + settings_from().budget_s(budget_s))
    except TimeBudgetExceeded as error:
        if error.best is None:
            stop(str(error))
        err.print(str(error))
        best: Model = error.best
        return best
    except CamwrightError as error:
        stop(str(error))


def synthesise(spec: DesignSpec) -> Design:
    """The cam of a spec, computed here."""

    def work(deadline: float) -> Design:
        from synthesis.pipeline.synthesise import synthesise

        return synthesise(spec, deadline=deadline)

    return compute(work, spec.time_budget_s)


def print_json(answer: BaseModel) -> None:
    """Print an answer as the service sends it, for other programs."""
    typer.echo(answer.model_dump_json(indent=1))


def print_tables(tables: Iterable[Table], width: int) -> None:
    """Print tables, at least ``width`` characters wide."""
    wide = Console(highlight=False, width=max(out.width, width))
    for table in tables:
        wide.print(table)


def save(files: Mapping[str, bytes], folder: Path) -> None:
    """Write files into a folder, which is created where it is missing."""
    try:
        for name, content in files.items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_bytes(content)
    except OSError as error:
        stop(f"{folder} cannot be written to: {error.strerror}.")


def stop(sentence: str) -> NoReturn:
    """Print why, and exit with status 2."""
    err.print(sentence)
    raise typer.Exit(2)
