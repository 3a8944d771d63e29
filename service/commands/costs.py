"""`camwright costs`: what each limit of a design costs."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated

import typer

from service.commands.terminal import AsJson, out, print_json, read_spec
from service.settings import settings_from
from synthesis.design.design import Design


def costs(
    design: Annotated[Path, typer.Argument(help="File with a Design, as `design` writes it.")],
    as_json: AsJson = False,
) -> None:
    """Say what each limit of a design costs, in the limit's own units."""
    from synthesis.studies.sensitivity import sensitivities

    known = read_spec(design, Design)
    found = sensitivities(known, time.monotonic() + settings_from().budget_s(None))
    if as_json:
        print_json(found)
    else:
        for each in found.sensitivities:
            out.print(each.sentence)
        for pointer in found.unconfirmed:
            out.print(f"{pointer}: not confirmed")
        out.print(f"Evidence: {found.evidence}.")
    if not found.sensitivities:
        raise typer.Exit(3)
