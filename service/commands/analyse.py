"""`camwright analyse`: the analysis of a given cam."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from service.commands.requests import Url, answer
from service.commands.tables import analysis_table
from service.commands.terminal import AsJson, out, print_json, print_tables, read_spec
from synthesis.design.analysis import Analysis
from synthesis.spec.design_spec import DesignSpec


def analyse(
    spec: Annotated[
        Path, typer.Argument(help="File with a DesignSpec given in full, or a worked example.")
    ],
    as_json: AsJson = False,
    url: Url = None,
) -> None:
    """Analyse a cam that is given in full: what it does, what it breaks, and what mends it."""
    found = _analysis(read_spec(spec, DesignSpec), spec, url)
    if as_json:
        print_json(found)
    else:
        out.print(analysis_table.headline(found))
        out.print(analysis_table.undercut(found), analysis_table.self_crossing(found), sep="\n")
        print_tables(analysis_table.tables(found), analysis_table.WIDTH)
    if not found.holds:
        raise typer.Exit(3)


def _analysis(question: DesignSpec, path: Path, url: str | None) -> Analysis:
    def work(deadline: float) -> Analysis:
        from synthesis.studies.analyse import analyse

        return analyse(question, deadline=deadline)

    return answer(
        url, path, Analysis, lambda client: client.analyse(question), work, question.time_budget_s
    )
