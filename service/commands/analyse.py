"""`camwright analyse`: what a given cam does, what it breaks, what mends it."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated

import typer

from service.commands.asking import Url, asked
from service.commands.showing import AsJson, as_document, widened
from service.commands.tables import analysis_table
from service.commands.terminal import out, read_spec, stop
from service.settings import settings_from
from synthesis.errors import CamwrightError
from synthesis.findings import Analysis
from synthesis.spec import DesignSpec


def analyse(
    spec: Annotated[
        Path, typer.Argument(help="File with a DesignSpec given in full, or a worked example.")
    ],
    as_json: AsJson = False,
    url: Url = None,
) -> None:
    """Analyse a cam that is given in full: what it does, what it breaks, and what mends it."""
    found = _done(read_spec(spec, DesignSpec), spec, url)
    if as_json:
        as_document(found)
    else:
        out.print(analysis_table.headline(found))
        out.print(analysis_table.undercut(found), analysis_table.self_crossing(found), sep="\n")
        widened(analysis_table.tables(found), analysis_table.WIDTH)
    if not found.holds:
        raise typer.Exit(3)


def _done(question: DesignSpec, path: Path, url: str | None) -> Analysis:
    if url is not None:
        return asked(url, path, Analysis, lambda client: client.analyse(question))
    from synthesis.analysis import analyse

    budget = settings_from().budget_s(question.time_budget_s)
    try:
        return analyse(question, deadline=time.monotonic() + budget)
    except CamwrightError as error:
        stop(str(error))
