"""`camwright confirm`: a certificate measured again by the second judge."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from service.commands.tables import confirmation_table
from service.commands.terminal import (
    AsJson,
    out,
    print_json,
    print_tables,
    read_spec,
    stop,
)
from synthesis.design.design import Design
from synthesis.errors import CamwrightError


def confirm(
    design: Annotated[Path, typer.Argument(help="File with a Design, as `design` writes it.")],
    as_json: AsJson = False,
) -> None:
    """Measure a finished design's certificate again, in ball arithmetic, to 25 digits."""
    from synthesis.certify.second import confirm as confirmed

    try:
        found = confirmed(read_spec(design, Design))
    except CamwrightError as error:
        stop(str(error))
    if as_json:
        print_json(found)
    else:
        out.print(confirmation_table.headline(found))
        print_tables([confirmation_table.table(found)], confirmation_table.WIDTH)
    if found.verdict != "confirmed":
        raise typer.Exit(3)
