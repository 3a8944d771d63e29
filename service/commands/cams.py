"""`camwright design` and `cam-set`: cams and their files."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from service.commands.requests import Url, answer
from service.commands.tables import force_lines, sizes
from service.commands.terminal import Folder, json_of, out, report_files, save, written_by_default

if TYPE_CHECKING:
    from synthesis.design.cam_set import CamSet
    from synthesis.design.design import Design


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
    started = time.perf_counter()
    design: Design = answer("designs", spec, url)
    seconds = time.perf_counter() - started
    files = _design_files(design)
    save(files, out_dir)
    gap = "" if design.certificate.gap is None else f", gap {100.0 * design.certificate.gap:.2f} %"
    out.print(f"{design.status}{gap}, {1e3 * seconds:.0f} ms: {sizes(design.dimensions)}")
    if design.forces is not None:
        for line in force_lines(design.forces):
            out.print(line)
    if design.free_parameters:
        values = (f"{name} {value:.6g}" for name, value in design.free_parameters.items())
        out.print(f"Chosen: {', '.join(values)}")
    report_files(files, out_dir)
    if design.conflict is not None:
        out.print(f"These limits cannot hold together: {', '.join(design.conflict.limits)}")
        raise typer.Exit(3)


def _design_files(design: Design) -> dict[str, bytes]:
    from synthesis.exporters import MOTION_FORMATS, PICTURES, PROFILE_FORMATS
    from synthesis.exporters.report import default_files

    files = {"design.json": json_of(design)}
    if design.motion:
        files |= default_files(design, PROFILE_FORMATS, MOTION_FORMATS)
    pictures = (each for each in PICTURES.values() if design.motion or each.without_cam)
    return files | written_by_default(pictures, design)


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

    result: CamSet = answer("cam-sets", spec, url)
    time_ms = 1e3 * result.seconds
    out.print(f"{result.status}, {time_ms:.0f} ms: {len(result.cams)} cams on one shaft")
    for cam in result.cams:
        dimensions = sizes(cam.design.dimensions)
        out.print(
            f"  {cam.name}: {cam.design.status}, phase {cam.phase_deg:g}°, keyway at "
            f"{cam.keyway_deg:g}°{': ' if dimensions else ''}{dimensions}"
        )
    files = {"cam-set.json": json_of(result)}
    if result.has_cams:
        files = dict(bundle_files(result, BundleOptions()))
    save(files, out_dir)
    report_files([f"{len(files)} files"], out_dir)
    if result.status == "infeasible":
        raise typer.Exit(3)
