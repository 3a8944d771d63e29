"""`camwright design`, `analyse`, `costs` and so on: one question each, answered and printed.

What is printed of an answer is in `tables`; solvers and formats are imported where they are needed.
"""

from __future__ import annotations

import re
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from service.commands.terminal import (
    STREAM,
    AsJson,
    DesignFile,
    DisplayUnits,
    Folder,
    FolderOrNone,
    SpecFile,
    Units,
    Url,
    save,
    stop,
)
from synthesis.errors import CamwrightError, InputError

if TYPE_CHECKING:
    from synthesis.design.analysis import Sensitivities
    from synthesis.design.design import Design
    from synthesis.machines.spatial.design import SpatialDesign

SEPARATORS = re.compile(r"[,;\s]+")
PARTED = re.compile(r"\d(;\s*|\s+)[-+\d]")  # numbers that are separated without a comma
DECIMAL_COMMA = re.compile(r"(?<=\d),(?=\d)")
LinkageKind = Literal["six-bar-shapers", "palletising-arms"]  # the names of LINKAGES
COLUMNS = (("x_mm", "x"), ("y_mm", "y"))  # what a header may call them


def here_unless_given(folder: Path | None, question: Path) -> Path | None:
    """The folder of the results: left out, this one, but of questions of a pipe none."""
    return Path() if folder is None and question != STREAM else folder


def design(
    spec: SpecFile, out_dir: Folder = None, url: Url = None, units: DisplayUnits = Units.mm
) -> None:
    """Size one cam: base radius, offset or pivot and motion laws together, and prove it.

    Writes design.json (dimensions, motion, every limit with its extreme in its own unit, cam angle
    and margin, the proven lower bound), profile.* and motion.* in the usual formats, lengths in mm,
    angles in deg, and pictures. `camwright export` writes others. By a service the files are the
    same; design.json then has the links under which the design is kept there as well.

      camwright design spec.json --out results
      camwright design spec.json --out results --url http://127.0.0.1:8000
      camwright design - < specs.jsonl > designs.jsonl

    Exit codes: 0 a certified cam; 2 the question is invalid, or time ended without a cam; 3 no
    cam fits: the limits that conflict are named, and design.json says what would help.
    """
    from service.commands import answering, tables
    from synthesis.exporters import MOTION_FORMATS, PICTURES, PROFILE_FORMATS
    from synthesis.exporters.report import default_files

    def files(design: Design) -> dict[str, bytes]:
        pictures = [each for each in PICTURES.values() if design.motion or each.without_cam]
        written = answering.files_of("design.json", design, pictures)
        if design.motion:
            written |= default_files(design, PROFILE_FORMATS, MOTION_FORMATS)
        return written

    def conclusion(design: Design) -> str:
        conflict = design.conflict
        limits = "" if conflict is None else ", ".join(conflict.limits)
        return limits and f"These limits cannot hold together: {limits}"

    shown = answering.Shown(
        tables.describe_design, files, is_negative=lambda design: design.conflict is not None,
        conclusion=conclusion,
    )  # fmt: skip
    folder = here_unless_given(out_dir, spec)
    answering.run("designs", spec, shown, url=url, folder=folder, units=units)


def cam_set(
    spec: SpecFile, out_dir: Folder = None, url: Url = None, units: DisplayUnits = Units.mm
) -> None:
    """Size the cams of one shaft, with their phases, and write all their files.

    Writes cam-set.json, the timing diagram and a folder for each cam, its points in the cam's own
    frame and, turned by its phase in deg, in the shaft's; lengths in mm.

      camwright cam-set feeder-and-press --out results

    Exit codes: 0 every cam fits, or some do; 2 the question is invalid; 3 none fits.
    """
    from service.commands import answering, tables
    from synthesis.design.design import WITHOUT_CAM
    from synthesis.exporters.bundle import BundleOptions, bundle_files

    shown = answering.Shown(
        lambda cams, _: tables.describe_cam_set(cams),
        lambda cams: dict(bundle_files(cams, BundleOptions())) if cams.has_cams
        else answering.files_of("cam-set.json", cams),
        listed=lambda files: [f"{len(files)} files"],
        is_negative=lambda cams: cams.status in WITHOUT_CAM,
    )  # fmt: skip
    folder = here_unless_given(out_dir, spec)
    answering.run("cam-sets", spec, shown, url=url, folder=folder, units=units)


def analyse(
    spec: SpecFile, as_json: AsJson = False, url: Url = None, units: DisplayUnits = Units.mm
) -> None:
    """Analyse a given cam: its extremes, the limits that it breaks, and changes that help.

    Prints every limit with its extreme and cam angle in deg, extremes and jumps of all curves in
    mm, mm/s, mm/s², mm/s³ (deg on arms), undercut in mm, crossings, and the smallest base radius in
    mm with which all limits hold.

      camwright analyse p2-as-given
      camwright analyse spec.json --json > analysis.json

    Exit codes: 0 every limit holds; 2 the question is invalid or leaves something free; 3 a
    limit is broken.
    """
    from service.commands import answering, tables

    shown = answering.Shown(
        lambda analysis, _: tables.describe_analysis(analysis),
        is_negative=lambda analysis: not analysis.holds,
    )
    answering.run("analyses", spec, shown, url=url, as_json=as_json, units=units)


def costs(design: DesignFile, as_json: AsJson = False, units: DisplayUnits = Units.mm) -> None:
    """Print what each limit of a design costs: the change of the objective for one unit more.

    As in: 1 deg more in /limits/0/rise_deg makes base_radius 1.02 mm smaller. For large numbers the
    change is 1 %. Derivatives come from multipliers, confirmed by solving again with the number a
    thousandth larger and smaller; what is not confirmed is listed as such. Takes 0.1 to 5 s.

      camwright costs results/design.json

    Exit codes: 0 done; 2 the file is not a design; 3 no sensitivity is known, and why.
    """
    from service.commands import answering, tables
    from service.settings import settings_from
    from synthesis.design.design import Design
    from synthesis.studies.sensitivity import sensitivities

    def ask(known: Design) -> Sensitivities:
        return sensitivities(known, time.monotonic() + settings_from().budget_s(None))

    shown = answering.Shown(
        lambda result, _: tables.describe_sensitivities(result),
        is_negative=lambda result: not result.sensitivities,
    )
    answering.run(answering.QuestionKind(Design, ask), design, shown, as_json=as_json, units=units)


def confirm(design: DesignFile, as_json: AsJson = False, units: DisplayUnits = Units.mm) -> None:
    """Verify a finished design's certificate again, in ball arithmetic, to 25 digits.

    The second verification shares neither formulas nor arithmetic with the first. It takes 0.05 to
    2 s, and an optional part (26 MB): pip install 'camwright[exact]'.

      camwright confirm results/design.json

    Exit codes: 0 every line is confirmed; 2 the file is not a design, or the package is missing; 3
    a line is contradicted or not decided.
    """
    from service.commands import answering, tables
    from synthesis.certify.second import confirm as confirmation_of
    from synthesis.design.design import Design

    shown = answering.Shown(
        lambda confirmation, _: tables.describe_confirmation(confirmation),
        is_negative=lambda confirmation: confirmation.verdict != "confirmed",
    )
    asked = answering.QuestionKind(Design, confirmation_of)
    answering.run(asked, design, shown, as_json=as_json, units=units)


def proof(
    design: DesignFile,
    to: Annotated[Path, typer.Option("--out", help="The file to write.")] = Path("proof.json"),
    checker: Annotated[
        Path | None, typer.Option(help="Write the checker too, to this file.", show_default=False)
    ] = None,
) -> None:
    """Write a finished design's proof, which anyone can check without this program.

    The file holds the question, the cam, and every claim with its witness; or, for what the format
    does not cover, with why. Bounds are in mm, mm/s² and mm/s³ as in the design, and may be some
    millionths lower. The checker is one file that needs Python alone. Takes 0.1 to 40 s.

      camwright proof results/design.json --out proof.json --checker check.py
      python3 -I -S check.py proof.json

    Exit codes: 0 written, every claim proven; 2 the file is not a design, or cannot be written; 3
    written, and some claims are not covered: which and why is printed.
    """
    from service.commands import answering
    from synthesis.design.design import Design
    from synthesis.exporters.exporter import compact_json
    from synthesis.pipeline.proof_file import proof as proof_of
    from synthesis.pipeline.proof_file.checker import checker_path

    if checker is not None:
        save({checker.name: checker_path().read_bytes()}, checker.parent, ())
    shown = answering.Shown(
        lambda found, _: (
            f"{claim['place']}: {'proven' if claim['proven'] else claim['reason']}"
            for claim in found["claims"]
        ),
        lambda found: {to.name: compact_json(found)},
        is_negative=lambda found: not all(claim["proven"] for claim in found["claims"]),
    )
    folder = None if design == STREAM else to.parent
    answering.run(answering.QuestionKind(Design, proof_of), design, shown, folder=folder)


def read_back(
    spec: Annotated[
        Path, typer.Argument(help="File with a MeasuredCam; its points_mm may be left out.")
    ],
    points: Annotated[
        Path | None, typer.Option(help="File of measured points: csv or columns x y, in mm.")
    ] = None,
    as_json: AsJson = False,
    url: Url = None,
    units: DisplayUnits = Units.mm,
) -> None:
    """Read the motion back from measured points of a profile.

    Points are x y in mm, in the order of the profile, in the question or in a file of their own.
    Prints the motion's extremes in mm and mm per s, the base radius in mm, the scatter in µm and
    hollows that the follower does not reach.

      camwright read-back cam.json --points measured.csv

    Exit codes: 0 read; 2 a file cannot be read, or the points are of no cam.
    """
    from service.commands import answering, tables

    try:
        given = None if points is None else {"points_mm": points_in(points)}
    except OSError as error:
        stop(f"{points} cannot be read: {error.strerror}.")
    except UnicodeDecodeError:
        stop(f"{points} is not text in UTF-8.")
    except CamwrightError as error:
        stop(str(error))
    shown = answering.Shown(lambda analysis, _: tables.describe_profile(analysis))
    answering.run(
        "profile-analyses", spec, shown, url=url, as_json=as_json, units=units, more=given
    )


def spatial(
    spec: SpecFile,
    out_dir: FolderOrNone = None,
    as_json: AsJson = False,
    url: Url = None,
    units: DisplayUnits = Units.mm,
) -> None:
    """Design one spatial cam, globoidal or cylindrical.

    Prints its walls by roller and side, where in the turn (deg) each is met, and what was measured:
    pressure angle in deg, undercut, radii and ribs in mm, speeds in mm/s and rpm, each with cam
    angle, wall and place on the roller's axis in mm. --out writes the answer and its files.

      camwright spatial p4
      camwright spatial cam.json --out results

    Exit codes: 0 a cam that holds; 2 the question is invalid; 3 a wall is undercut, a rib cut
    through or a limit broken: which and where is printed.
    """
    from service.commands import answering, tables
    from synthesis.design.design import WITHOUT_CAM
    from synthesis.machines.spatial.files import FORMATS, formats_of

    def files(design: SpatialDesign) -> dict[str, bytes]:
        names = () if design.status in WITHOUT_CAM else formats_of(design.machine)
        return answering.files_of("spatial.json", design, (FORMATS[name] for name in names))

    shown = answering.Shown(
        lambda design, _: tables.describe_spatial_cam(design), files,
        is_negative=lambda design: design.status in WITHOUT_CAM,
    )  # fmt: skip
    answering.run(
        "spatial-cams", spec, shown, url=url, folder=out_dir, as_json=as_json, units=units
    )


def linkage(
    kind: Annotated[LinkageKind, typer.Argument(help="Which kind.")],
    spec: SpecFile,
    out_dir: Folder = None,
    url: Url = None,
    units: DisplayUnits = Units.mm,
) -> None:
    """Analyse or size a linkage: a six-bar shaper, or a palletising arm.

    Writes linkage.json, tables, diagrams and animations; lengths in mm, angles in deg, velocities
    in mm/s and deg/s, torques in N·m. A shaper's lengths left free are chosen for a stroke and a
    quick-return ratio, with a proven bound.

      camwright linkage six-bar-shapers p5
      camwright linkage palletising-arms irb-660

    Exit codes: 0 all requirements are met, all poses can be reached; 2 the question is invalid; 3
    not all, and what would help.
    """
    from service.commands import answering, tables
    from synthesis.design.design import WITHOUT_CAM
    from synthesis.machines.linkages import LINKAGES
    from synthesis.machines.linkages.files import LINKAGE_FILES

    summary = LINKAGES[kind].summary

    def files(result: Any) -> dict[str, bytes]:
        formats = LINKAGE_FILES[kind].values() if summary(result) else ()
        suitable = (each for each in formats if each.suits(result))
        return answering.files_of("linkage.json", result, suitable)

    shown = answering.Shown(
        lambda result, _: tables.describe_linkage(result, summary(result)), files,
        is_negative=lambda result: result.status in WITHOUT_CAM,
    )  # fmt: skip
    folder = here_unless_given(out_dir, spec)
    answering.run(f"linkages/{kind}", spec, shown, url=url, folder=folder, units=units)


def respond(
    spec: SpecFile, out_dir: FolderOrNone = None, url: Url = None, units: DisplayUnits = Units.mm
) -> None:
    """Compute the response of an elastic follower train to a cam.

    The question is a cam and a chain of masses in kg, springs in N/mm and dampers in N s/mm. Prints
    the train's modes in Hz and, for every speed in rpm, the output's error in mm, the residual
    vibration in the dwells in mm, and the contact force in N. With --out it writes the whole
    answer, a table, diagrams and the residual spectrum.

      camwright respond press-feeder --out results

    Exit codes: 0 done; 2 the question is invalid, or no cam fits.
    """
    from service.commands import answering, tables
    from synthesis.machines.dynamics.files import TRAIN_FILES

    shown = answering.Shown(
        lambda response, _: tables.describe_response(response),
        lambda response: answering.files_of("train-response.json", response, TRAIN_FILES),
    )
    answering.run("train-responses", spec, shown, url=url, folder=out_dir, units=units)


def points_in(path: Path) -> list[list[float]]:
    """x and y of every row [mm]; further columns are left alone.

    A header names the columns; without one they are the first two. Columns may be separated by
    commas, semicolons or blanks; between the latter two, numbers may have decimal commas. Empty
    lines and what follows a # do not count.

    Raises:
        InputError: a row that is no row of numbers, with its line. OSError: no such file.
    """
    places = (0, 1)
    points: list[list[float]] = []
    for number, line in enumerate(path.read_text(encoding="utf-8-sig").splitlines(), start=1):
        row = line.partition("#")[0].strip()
        if PARTED.search(row) and "." not in row:  # a comma parts no cells then
            row = DECIMAL_COMMA.sub(".", row)
        cells = [cell for cell in SEPARATORS.split(row) if cell]
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
            # Where the header says nothing of x and y, they are the first two columns.
            header = {cell.strip('"').lower(): place for place, cell in enumerate(cells)}
            x, y = (next((header[n] for n in names if n in header), None) for names in COLUMNS)
            places = (0, 1) if x is None or y is None else (x, y)
    return points
