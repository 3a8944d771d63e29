"""Path of a cylindrical cutter as a table: tip and axis at every cam angle, for 4 or 5 axes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from synthesis.errors import InputError
from synthesis.exporters.exporter import FileFormat, Made
from synthesis.exporters.options import Options
from synthesis.exporters.samples.columns import Column, joined
from synthesis.exporters.tables.csv_table import table
from synthesis.machines.spatial.cam import SpatialCam, Wall
from synthesis.machines.spatial.cam_frame import CamFrame
from synthesis.machines.spatial.cutter_placement import (
    STEP,
    CutterPoses,
    envelope_error,
    flank_poses,
    roller_poses,
)
from synthesis.machines.spatial.design import SpatialDesign
from synthesis.machines.spatial.files.flanks import chosen
from synthesis.machines.spatial.files.options import MAX_ROWS, Density, Flank
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE

BOTH = 0  # side of a path that machines both walls


@dataclass(frozen=True, kw_only=True)
class CutterOptions(Options):
    """The cutter and the sampling of its path.

    Attributes:
        cutter_diameter_mm: of a cylindrical cutter; None: one of the roller's own form.
        flank: a wall's name; "": all. frame: fixed to the cam, or to the machine.
        points_per_degree: over the cam angle.
    """

    cutter_diameter_mm: Annotated[
        float | None,
        Field(
            gt=0.0,
            le=1e6,
            description="Diameter of a cylindrical cutter. Left out: a cutter of the roller's own "
            "form, which machines both walls at once, exactly; a thinner one machines each flank "
            "separately.",
        ),
    ] = None
    flank: Flank = ""
    frame: Annotated[
        Literal["cam", "machine"],
        Field(
            description="`cam`: positions and directions in the cam's frame, for a five-axis part "
            "program. `machine`: the same with the cam rotated by c_deg."
        ),
    ] = "cam"
    points_per_degree: Density = 1.0


@dataclass(frozen=True, eq=False)
class Path:
    """One pass of the cutter.

    Attributes:
        wall: the flank. side: its side, or BOTH. poses: of the cutter.
        error: largest deviation from the flank [mm].
    """

    wall: Wall
    side: int
    poses: CutterPoses
    error: float


def paths(design: SpatialDesign, options: CutterOptions) -> list[Path]:
    """The passes that machine the selected flanks.

    Raises:
        InputError: there is no such flank, the cutter is thicker than the roller, or there would
            be too many points.
    """
    cam = design.cam
    walls = chosen(cam, options.flank)
    radius = _radius(cam, options)
    if radius is None:
        walls = list({wall.seat.number: wall for wall in walls}.values())
    counts = [
        max(2, math.ceil((b - a) / DEGREE * options.points_per_degree - 1e-9) + 1)
        for wall in walls
        for a, b in wall.spans
    ]
    if sum(counts) > MAX_ROWS:
        raise InputError(
            "/points_per_degree",
            options.points_per_degree,
            f"This makes {sum(counts)} points; a file has at most {MAX_ROWS}.",
            f"Request at most {MAX_ROWS / sum(counts) * options.points_per_degree:.3g}.",
        )
    spans = [(wall, span) for wall in walls for span in wall.spans]
    return [
        _path(cam, wall, np.linspace(*span, count), radius)
        for (wall, span), count in zip(spans, counts, strict=True)
    ]


def _radius(cam: SpatialCam, options: CutterOptions) -> float | None:
    """Radius of a cutter thinner than the roller [mm]; None: a cutter of the roller's form."""
    roller = cam.swept.roller
    if options.cutter_diameter_mm is None:
        return None
    radius = 0.5 * options.cutter_diameter_mm
    thinnest = float(np.min(roller.profile(np.array([roller.inner, roller.outer]))[0]))
    if radius > roller.radius or (roller.crown and radius >= thinnest):
        most = 2.0 * (thinnest if roller.crown else roller.radius)
        raise InputError(
            "/cutter_diameter_mm",
            options.cutter_diameter_mm,
            f"A cylindrical cutter must be thinner than the roller, {most:.9g} mm at its "
            "thinnest, or it removes too much material.",
            "Choose a thinner one, or leave it out for a cutter of the roller's form.",
        )
    return None if radius == roller.radius else radius


def _path(cam: SpatialCam, wall: Wall, theta: Array, radius: float | None) -> Path:
    if radius is None:
        return Path(wall, BOTH, roller_poses(cam, wall, theta), 0.0)
    before, at, after = (
        flank_poses(cam, wall, theta + step, radius) for step in (-STEP, 0.0, STEP)
    )
    error = float(np.max(np.abs(envelope_error(cam, wall, (before, at, after), radius))))
    return Path(wall, wall.side, at, error)


def _columns(cam: SpatialCam, path: Path, options: CutterOptions) -> Sequence[Column]:
    swept, poses = cam.swept, path.poses
    frame = CamFrame.of(swept)
    # The tool axis points to the spindle, away from the cam's axis.
    outwards = math.copysign(1.0, float(frame.axes[0] @ swept.along))
    tool = outwards * poses.direction
    tip = poses.centre - 0.5 * (swept.roller.outer - swept.roller.inner) * tool
    if options.frame == "cam":
        tip = frame.points(poses.theta, tip[:, :, None])[:, :, 0]
        tool = frame.directions(poses.theta, tool[:, :, None])[:, :, 0]
    else:
        tip, tool = frame.axes @ (tip - swept.centre[:, None]), frame.axes @ tool
    count = len(poses.theta)
    return [
        Column("roller", "1", "number of the roller", np.full(count, path.wall.seat.number)),
        Column("side", "1", "R: 1, L: -1, both flanks at once: 0", np.full(count, path.side)),
        Column("theta_deg", "deg", "cam angle", poses.theta / DEGREE),
        Column("c_deg", "deg", "rotation of the cam about z", swept.hand * poses.theta / DEGREE),
        *(Column(f"{name}_mm", "mm", "tip of the cutter, at the roller's end", values)
          for name, values in zip("xyz", tip, strict=True)),
        *(Column(name, "1", "axis of the cutter, from its tip to the spindle", values)
          for name, values in zip("ijk", tool, strict=True)),
    ]  # fmt: skip


def _csv(design: SpatialDesign, options: CutterOptions) -> Made:
    found = paths(design, options)
    data = table(joined([_columns(design.cam, path, options) for path in found]))
    return Made(data, {"Wall-Error-Mm": f"{max(path.error for path in found):.3g}"})


CSV = FileFormat(
    "cutter.csv", "Cutter path, comma separated", "text/csv; charset=utf-8; header=present",
    ".csv", _csv, CutterOptions,
    "Tip and axis of a cutter at every cam angle, in the cam's or the machine's frame: a cutter of "
    "the roller's form, or a thinner one along each flank, tilted for the least deviation from the "
    "roller's wall. The header Camwright-Wall-Error-Mm gives that deviation.",
)  # fmt: skip
