"""`camwright read-back`: measured points of a profile back to the motion."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from service.commands.asking import Url, asked
from service.commands.points_file import points_in
from service.commands.showing import AsJson, as_document, widened
from service.commands.tables import analysis_table, reading_table
from service.commands.terminal import out, read_spec, stop
from synthesis.errors import CamwrightError
from synthesis.measured.reading import ProfileAnalysis
from synthesis.measured.spec import MeasuredCam


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
        stop(f"{points} is no text in UTF-8.")
    except CamwrightError as error:
        stop(str(error))
    found = _done(read_spec(spec, MeasuredCam, given), spec, url)
    if as_json:
        as_document(found)
        return
    out.print(reading_table.headline(found))
    widened(reading_table.tables(found), analysis_table.WIDTH)


def _done(question: MeasuredCam, path: Path, url: str | None) -> ProfileAnalysis:
    if url is not None:
        return asked(url, path, ProfileAnalysis, lambda client: client.read_back(question))
    from synthesis.measured import read_back as read

    try:
        return read(question)
    except CamwrightError as error:
        stop(str(error))
