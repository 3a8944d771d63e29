"""`camwright design`, `analyse`, `costs` and so on: one question each, answered and printed.

What is printed of an answer is in `tables`; solvers and formats are imported where they are needed.
"""

from __future__ import annotations

import re
import time
from pathlib import Path
from typing import Annotated

import typer

from service.commands import tables
from service.commands.terminal import (
    AsJson,
    DesignFile,
    Folder,
    FolderOrNone,
    Url,
    answer,
    files_of,
    out,
    print_answer,
    read_spec,
    save,
    stop,
)
from service.settings import settings_from
from synthesis.design.design import WITHOUT_CAM
from synthesis.errors import CamwrightError, InputError
from synthesis.exporters.exporter import compact_json
from synthesis.machines.linkages import LINKAGES

SEPARATORS = re.compile(r"[,;\s]+")
COLUMNS = (("x_mm", "x"), ("y_mm", "y"))  # what a header may call them


def design(
    spec: Annotated[Path, typer.Argument(help="File with a DesignSpec, or a worked example.")],
    out_dir: Folder = Path(),
    url: Url = None,
) -> None:
    """Size one cam: base radius, offset or pivot and motion laws together, and prove it.

    Writes design.json (dimensions, motion, every limit with its extreme in its own unit, cam angle
    and margin, the proven lower bound), profile.* and motion.* in the usual formats, lengths in mm,
    angles in deg, and pictures. `camwright export` writes others. By a service the files are the
    same; design.json then has the links under which the design is kept there as well.

      camwright design spec.json --out results
      camwright design spec.json --out results --url http://127.0.0.1:8000

    Exit codes: 0 a certified cam; 2 the question is invalid, or time ended without a cam; 3 no
    cam fits: the limits that conflict are named, and design.json says what would help.
    """
    from synthesis.exporters import MOTION_FORMATS, PICTURES, PROFILE_FORMATS
    from synthesis.exporters.report import default_files

    started = time.perf_counter()
    design = answer("designs", spec, url)
    seconds = time.perf_counter() - started
    pictures = [each for each in PICTURES.values() if design.motion or each.without_cam]
    files = files_of("design.json", design, pictures)
    if design.motion:
        files |= default_files(design, PROFILE_FORMATS, MOTION_FORMATS)
    print_answer(design, tables.describe_design(design, seconds))
    save(files, out_dir)
    if design.conflict is not None:
        out.print(f"These limits cannot hold together: {', '.join(design.conflict.limits)}")
        raise typer.Exit(3)


def cam_set(
    spec: Annotated[Path, typer.Argument(help="File with a CamSetSpec, or a worked example.")],
    out_dir: Folder = Path(),
    url: Url = None,
) -> None:
    """Size the cams of one shaft, with their phases, and write all their files.

    Writes cam-set.json, the timing diagram and a folder for each cam, its points in the cam's own
    frame and, turned by its phase in deg, in the shaft's; lengths in mm.

      camwright cam-set openapi/examples/cam-sets/feeder-and-press.json --out results

    Exit codes: 0 every cam fits, or some do; 2 the question is invalid; 3 none fits.
    """
    from synthesis.exporters.bundle import BundleOptions, bundle_files

    cams = answer("cam-sets", spec, url)
    print_answer(cams, tables.describe_cam_set(cams))
    files = files_of("cam-set.json", cams)
    if cams.has_cams:
        files = dict(bundle_files(cams, BundleOptions()))
    save(files, out_dir, [f"{len(files)} files"])
    if cams.status in WITHOUT_CAM:
        raise typer.Exit(3)


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
    analysis = answer("analyses", spec, url)
    print_answer(analysis, tables.describe_analysis(analysis), as_json)
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
    print_answer(result, tables.describe_sensitivities(result), as_json)
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
    print_answer(confirmation, tables.describe_confirmation(confirmation), as_json)
    if confirmation.verdict != "confirmed":
        raise typer.Exit(3)


def proof(
    design: DesignFile,
    to: Annotated[Path, typer.Option("--out", help="The file to write.")] = Path("proof.json"),
) -> None:
    """Write a finished design's proof, which anyone can check without this program.

    The file holds the question, the cam, and every claim with its witness; or, for what the format
    does not cover, with why. Bounds are in mm, mm/s² and mm/s³ as in the design, and may be some
    millionths lower. checker/check.py needs Python alone. Takes 0.1 to 5 s.

      camwright proof results/design.json --out proof.json
      python3 -I -S checker/check.py proof.json

    Exit codes: 0 written, every claim proven; 2 the file is not a design, or cannot be written; 3
    written, and some claims are not covered: which and why is printed.
    """
    from synthesis.design.design import Design
    from synthesis.pipeline.proof_file import proof as proof_of

    try:
        found = proof_of(read_spec(design, Design))
    except CamwrightError as error:
        stop(str(error))
    for claim in found["claims"]:
        out.print(f"{claim['place']}: {'proven' if claim['proven'] else claim['reason']}")
    save({to.name: compact_json(found)}, to.parent)
    if not all(claim["proven"] for claim in found["claims"]):
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
    analysis = answer("profile-analyses", spec, url, given)
    print_answer(analysis, tables.describe_profile(analysis), as_json)


def spatial(
    spec: Annotated[Path, typer.Argument(help="File with a SpatialCamSpec, or a worked example.")],
    out_dir: FolderOrNone = None,
    as_json: AsJson = False,
    url: Url = None,
) -> None:
    """Design one spatial cam, globoidal or cylindrical.

    Prints its walls by roller and side, where in the turn (deg) each is met, and what was measured:
    pressure angle in deg, undercut, radii and ribs in mm, speeds in mm/s and rpm, each with cam
    angle, wall and place on the roller's axis in mm. --out writes the answer and its files.

      camwright spatial openapi/examples/spatial-cams/p4.json
      camwright spatial cam.json --out results

    Exit codes: 0 a cam that holds; 2 the question is invalid; 3 a wall is undercut, a rib cut
    through or a limit broken: which and where is printed.
    """
    from synthesis.machines.spatial.files import FORMATS, formats_of

    design = answer("spatial-cams", spec, url)
    nothing = design.status in WITHOUT_CAM
    print_answer(design, tables.describe_spatial_cam(design), as_json)
    if out_dir is not None:
        names = () if nothing else formats_of(design.machine)
        files = files_of("spatial.json", design, (FORMATS[name] for name in names))
        save(files, out_dir, () if as_json else None)
    if nothing:
        raise typer.Exit(3)


def linkage(
    kind: Annotated[str, typer.Argument(help=f"Which kind: {', '.join(LINKAGES)}.")],
    spec: Annotated[Path, typer.Argument(help="File with its spec, or a worked example.")],
    out_dir: Folder = Path(),
    url: Url = None,
) -> None:
    """Analyse or size a linkage: a six-bar shaper, or a palletising arm.

    Writes linkage.json, tables, diagrams and animations; lengths in mm, angles in deg, velocities
    in mm/s and deg/s, torques in N·m. A shaper's lengths left free are chosen for a stroke and a
    quick-return ratio, with a proven bound.

      camwright linkage six-bar-shapers openapi/examples/linkages/six-bar-shapers/p5.json
      camwright linkage palletising-arms openapi/examples/linkages/palletising-arms/irb-660.json

    Exit codes: 0 all requirements are met, all poses can be reached; 2 the question is invalid; 3
    not all, and what would help.
    """
    from synthesis.machines.linkages.files import LINKAGE_FILES

    if kind not in LINKAGES:
        stop(f"{kind} is not a kind of linkage. There are {', '.join(LINKAGES)}.")
    result = answer(f"linkages/{kind}", spec, url)
    quantities = LINKAGES[kind].summary(result)
    print_answer(result, tables.describe_linkage(result, quantities))
    formats = LINKAGE_FILES[kind].values() if quantities else ()
    files = files_of("linkage.json", result, (each for each in formats if each.suits(result)))
    save(files, out_dir)
    if result.status in WITHOUT_CAM:
        raise typer.Exit(3)


def respond(
    spec: Annotated[Path, typer.Argument(help="File with a TrainSpec, or a worked example.")],
    out_dir: FolderOrNone = None,
    url: Url = None,
) -> None:
    """Compute the response of an elastic follower train to a cam.

    The question is a cam and a chain of masses in kg, springs in N/mm and dampers in N s/mm. Prints
    the train's modes in Hz and, for every speed in rpm, the output's error in mm, the residual
    vibration in the dwells in mm, and the contact force in N. With --out it writes the whole
    answer, a table, diagrams and the residual spectrum.

      camwright respond openapi/examples/train-responses/press-feeder.json --out results

    Exit codes: 0 done; 2 the question is invalid, or no cam fits.
    """
    from synthesis.machines.dynamics.files import TRAIN_FILES

    response = answer("train-responses", spec, url)
    print_answer(response, tables.describe_response(response))
    if out_dir is not None:
        save(files_of("train-response.json", response, TRAIN_FILES), out_dir)


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
            # Where the header says nothing of x and y, they are the first two columns.
            header = {cell.strip('"').lower(): place for place, cell in enumerate(cells)}
            x, y = (next((header[n] for n in names if n in header), None) for names in COLUMNS)
            places = (0, 1) if x is None or y is None else (x, y)
    return points
