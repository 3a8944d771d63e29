"""`camwright spatial`, `linkage` and `respond`: machines other than one plane cam."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from service.commands.requests import Url, answer
from service.commands.tables import response_table, spatial_line, spatial_tables
from service.commands.terminal import (
    AsJson,
    Folder,
    FolderOrNone,
    json_of,
    out,
    print_json,
    print_tables,
    report_files,
    save,
    stop,
    written_by_default,
)
from synthesis.machines.linkages import LINKAGES

if TYPE_CHECKING:
    from synthesis.design.design import Relaxation
    from synthesis.machines.dynamics import TrainResponse
    from synthesis.machines.spatial.design import SpatialDesign


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
    design: SpatialDesign = answer("spatial-cams", spec, url)
    if as_json:
        print_json(design)
    else:
        out.print(spatial_line(design))
        print_tables(spatial_tables(design))
    if out_dir is not None:
        files = _spatial_files(design)
        save(files, out_dir)
        if not as_json:
            report_files(files, out_dir)
    if design.status == "infeasible":
        raise typer.Exit(3)


def _spatial_files(design: SpatialDesign) -> dict[str, bytes]:
    """All usual files of the cam; of an infeasible one the answer alone."""
    from synthesis.machines.spatial.files import FORMATS, formats_of

    files = {"spatial.json": json_of(design)}
    if design.status == "infeasible":
        return files
    formats = (FORMATS[name] for name in formats_of(design.machine))
    return files | written_by_default(formats, design)


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
    if kind not in LINKAGES:
        stop(f"{kind} is not a kind of linkage. There are {', '.join(LINKAGES)}.")
    result = answer(f"linkages/{kind}", spec, url)
    summary = LINKAGES[kind].summary(result)
    out.print(
        ", ".join([result.status, *(f"{name} {value:.6g}" for name, value in summary.items())])
    )
    for line in _conflicts(result):
        out.print(line)
    files = {"linkage.json": json_of(result)}
    if summary:
        from synthesis.machines.linkages.files import LINKAGE_FILES

        formats = (each for each in LINKAGE_FILES[kind].values() if each.suits(result))
        files |= written_by_default(formats, result)
    save(files, out_dir)
    report_files(files, out_dir)
    if result.status == "infeasible":
        raise typer.Exit(3)


def _conflicts(result: Any) -> list[str]:
    """What conflicts in an infeasible answer, a line each."""
    conflict = getattr(result, "conflict", None)
    changes: list[Relaxation] = [] if conflict is None else conflict.relaxations
    limits = [f"  {each.limit}: {each.requested:g} requested, {each.needed:.6g} {each.unit} needed"
            for each in changes if each.needed is not None]  # fmt: skip
    poses = [pose for pose in getattr(result, "poses", []) if not pose.reachable]
    return [*limits, *(f"  {pose.name or 'pose'}: {pose.note}" for pose in poses)]


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
    response: TrainResponse = answer("train-responses", spec, url)
    modes = (f"{m.natural_frequency_hz:.4g} Hz (ζ {m.damping_ratio:.3g})" for m in response.modes)
    out.print(f"Modes: {', '.join(modes)}")
    out.print(response_table(response))
    if response.float_onset_rpm is not None:
        out.print(f"Contact is lost from {response.float_onset_rpm:.4g} rpm on.")
    if out_dir is not None:
        from synthesis.machines.dynamics.files import TRAIN_FILES

        files = {"train-response.json": json_of(response)}
        files |= written_by_default(TRAIN_FILES, response)
        save(files, out_dir)
        report_files(files, out_dir)
