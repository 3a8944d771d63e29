"""`camwright read-back`: measured points of a profile back to the motion."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from service.commands.points_file import points_in
from service.commands.requests import Url, answer
from service.commands.tables import analysis_table, reading_table
from service.commands.terminal import (
    AsJson,
    out,
    print_json,
    print_tables,
    read_spec,
    stop,
)
from synthesis.errors import CamwrightError
from synthesis.studies.measured.report import ProfileAnalysis
from synthesis.studies.measured.spec import MeasuredCam


def read_back(
    spec: Annotated[
        Path, typer.Argument(help="File with a MeasuredCam; its points_mm may be left out.")
    ],
    points: Annotated[
        Path | None, typer.Option(help="File of measured points: csv or columns x y, in mm.")
    ] = None,
    as_json: AsJson = False,
    url: Url = None,
) -> None:
    """Read the motion back from measured points of a profile."""
    try:
        given = None if points is None else {"points_mm": points_in(points)}
    except OSError as error:
        stop(f"{points} cannot be read: {error.strerror}.")
    except UnicodeDecodeError:
        stop(f"{points} is not text in UTF-8.")
    except CamwrightError as error:
        stop(str(error))
    found = _analysis(read_spec(spec, MeasuredCam, given), spec, url)
    if as_json:
        print_json(found)
        return
    out.print(reading_table.headline(found))
    print_tables(reading_table.tables(found), analysis_table.WIDTH)


def _analysis(question: MeasuredCam, path: Path, url: str | None) -> ProfileAnalysis:
    def work(_: float) -> ProfileAnalysis:
        from synthesis.studies.measured import read_back

        return read_back(question)

    return answer(url, path, ProfileAnalysis, lambda client: client.read_back(question), work)
