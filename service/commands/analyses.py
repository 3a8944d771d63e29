"""`camwright analyse`, `costs`, `confirm` and `read-back`: what given and measured cams do."""

from __future__ import annotations

import re
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from service.commands.requests import Url, answer
from service.commands.tables import (
    analysis_lines,
    analysis_tables,
    confirmation_line,
    confirmation_table,
    profile_line,
    profile_tables,
)
from service.commands.terminal import (
    AsJson,
    DesignFile,
    out,
    print_json,
    print_tables,
    read_spec,
    stop,
)
from service.settings import settings_from
from synthesis.errors import CamwrightError, InputError

if TYPE_CHECKING:
    from synthesis.design.analysis import Analysis
    from synthesis.studies.measured import ProfileAnalysis

SEPARATORS = re.compile(r"[,;\s]+")
COLUMNS = (("x_mm", "x"), ("y_mm", "y"))  # what a header may call them


def analyse(
    spec: Annotated[
        Path, typer.Argument(help="File with a DesignSpec given in full, or a worked example.")
    ],
    as_json: AsJson = False,
    url: Url = None,
) -> None:
    """Analyse a given cam: its extremes, the limits that it breaks, and changes that help.

    Prints every limit with its extreme and cam angle in deg, extremes and jumps of all curves in
    mm, mm/s, mm/s², mm/s³ (deg on arms), undercut in mm, crossings, and the smallest base radius in
    mm with which all limits hold.

      camwright analyse openapi/examples/analyses/p2-as-given.json
      camwright analyse spec.json --json > analysis.json

    Exit codes: 0 every limit holds; 2 the question is invalid or leaves something free; 3 a
    limit is broken.
    """
    analysis: Analysis = answer("analyses", spec, url)
    if as_json:
        print_json(analysis)
    else:
        out.print(*analysis_lines(analysis), sep="\n")
        print_tables(analysis_tables(analysis))
    if not analysis.holds:
        raise typer.Exit(3)


def costs(design: DesignFile, as_json: AsJson = False) -> None:
    """Print what each limit of a design costs: the change of the objective for one unit more.

    As in: 1 deg more in /limits/0/rise_deg makes base_radius 1.02 mm smaller. For large numbers the
    change is 1 %. Derivatives come from multipliers, confirmed by solving again with the number a
    thousandth larger and smaller; what is not confirmed is listed as such. Takes 0.1 to 5 s.

      camwright costs results/design.json

    Exit codes: 0 done; 2 the file is not a design; 3 no sensitivity is known, and why.
    """
    from synthesis.design.design import Design
    from synthesis.studies.sensitivity import sensitivities

    known = read_spec(design, Design)
    result = sensitivities(known, time.monotonic() + settings_from().budget_s(None))
    if as_json:
        print_json(result)
    else:
        for each in result.sensitivities:
            out.print(each.sentence)
        for pointer in result.unconfirmed:
            out.print(f"{pointer}: not confirmed")
        out.print(f"Evidence: {result.evidence}.")
    if not result.sensitivities:
        raise typer.Exit(3)


def confirm(design: DesignFile, as_json: AsJson = False) -> None:
    """Verify a finished design's certificate again, in ball arithmetic, to 25 digits.

    The second verification shares neither formulas nor arithmetic with the first. It takes 0.05 to
    2 s, and the optional package `exact`: pip install 'camwright[exact]'.

      camwright confirm results/design.json

    Exit codes: 0 every line is confirmed; 2 the file is not a design, or the package is missing; 3
    a line is contradicted or not decided.
    """
    from synthesis.certify.second import confirm as confirmation_of
    from synthesis.design.design import Design

    try:
        confirmation = confirmation_of(read_spec(design, Design))
    except CamwrightError as error:
        stop(str(error))
    if as_json:
        print_json(confirmation)
    else:
        out.print(confirmation_line(confirmation))
        print_tables([confirmation_table(confirmation)])
    if confirmation.verdict != "confirmed":
        raise typer.Exit(3)


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
    """Read the motion back from measured points of a profile.

    Points are x y in mm, in the order of the profile, in the question or in a file of their own.
    Prints the motion's extremes in mm and mm per s, the base radius in mm, the scatter in µm and
    hollows that the follower does not reach.

      camwright read-back cam.json --points measured.csv

    Exit codes: 0 read; 2 a file cannot be read, or the points are of no cam.
    """
    try:
        given = None if points is None else {"points_mm": points_in(points)}
    except OSError as error:
        stop(f"{points} cannot be read: {error.strerror}.")
    except UnicodeDecodeError:
        stop(f"{points} is not text in UTF-8.")
    except CamwrightError as error:
        stop(str(error))
    analysis: ProfileAnalysis = answer("profile-analyses", spec, url, given)
    if as_json:
        print_json(analysis)
        return
    out.print(profile_line(analysis))
    print_tables(profile_tables(analysis))


def points_in(path: Path) -> list[list[float]]:
    """x and y of every row [mm]; further columns are left alone.

    A header names the columns; without one they are the first two. Rows may be separated by
    commas, semicolons or blanks; empty lines and what follows a # do not count.

    Raises:
        InputError: a row that is no row of numbers, with its line. OSError: no such file.
    """
    places = (0, 1)
    points: list[list[float]] = []
    for number, line in enumerate(path.read_text(encoding="utf-8-sig").splitlines(), start=1):
        cells = [cell for cell in SEPARATORS.split(line.partition("#")[0].strip()) if cell]
        if not cells:
            continue
        try:
            points.append([float(cells[place]) for place in places])
        except (ValueError, IndexError):
            if points:
                raise InputError(
                    f"{path.name}, line {number}", line[:80], "This is no row of numbers.",
                    "Give x and y in mm in every row, with decimal points.",
                ) from None  # fmt: skip
            places = _places([cell.strip('"').lower() for cell in cells])
    return points


def _places(header: list[str]) -> tuple[int, int]:
    """Where x and y stand; the first two columns where the header says nothing of them."""
    x, y = (next((header.index(n) for n in names if n in header), None) for names in COLUMNS)
    return (0, 1) if x is None or y is None else (x, y)
