"""What commands that show an answer have in common: as tables, or the whole as JSON."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated

import typer
from pydantic import BaseModel
from rich.console import Console
from rich.table import Table

from service.commands.terminal import out

AsJson = Annotated[
    bool, typer.Option("--json", help="Print the whole as JSON, as the service answers it.")
]


def as_document(found: BaseModel) -> None:
    """The whole, for other programs."""
    typer.echo(found.model_dump_json(indent=1))


def widened(tables: Iterable[Table], width: int) -> None:
    """Tables, never narrower than they can be read."""
    wide = Console(highlight=False, width=max(out.width, width))
    for table in tables:
        wide.print(table)
