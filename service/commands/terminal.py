"""What the commands have in common: reading a spec, solving it here, writing files, saying no."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NoReturn

import typer
from rich.console import Console

from service.settings import settings_from
from service.wire.body import Model, parsed, validated
from service.wire.errors import InvalidBody, ServiceError
from synthesis.design import Design
from synthesis.errors import CamwrightError, TimeBudgetExceeded
from synthesis.spec import DesignSpec

out = Console(highlight=False, markup=False, soft_wrap=True)
err = Console(highlight=False, markup=False, soft_wrap=True, stderr=True)


def read_spec(path: Path, model: type[Model], more: Mapping[str, Any] | None = None) -> Model:
    """The spec in a file, with ``more`` fields; a readable line for each thing that is wrong."""
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
            where = found["pointer"] or "the whole"
            err.print(f"{path}: {where} = {found['value']!r}: {found['rule']}. {found['way_out']}")
        raise typer.Exit(2) from None
    except ServiceError as error:
        stop(f"{path}: {error}")


def synthesise(spec: DesignSpec, *, deadline: float) -> Design:
    """The cam; the core is loaded only now, so that the other commands start at once."""
    from synthesis.pipeline import synthesise

    return synthesise(spec, deadline=deadline)


def synthesised(spec: Any, synthesise: Callable[..., Any]) -> Any:
    """The core's answer; where time ends, the best so far."""
    budget = settings_from().budget_s(spec.time_budget_s)
    try:
        return synthesise(spec, deadline=time.monotonic() + budget)
    except TimeBudgetExceeded as error:
        if error.best is None:
            stop(str(error))
        err.print(str(error))
        return error.best
    except CamwrightError as error:
        stop(str(error))


def save(files: Mapping[str, bytes], folder: Path) -> None:
    """Write files into a folder, which is made where it is missing."""
    try:
        for name, content in files.items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_bytes(content)
    except OSError as error:
        stop(f"{folder} cannot be written to: {error.strerror}.")


def stop(sentence: str) -> NoReturn:
    """Say why, and end with status 2."""
    err.print(sentence)
    raise typer.Exit(2)
