"""Path of a cylindrical cutter as a table: end and axis at every cam angle, for 4 or 5 axes."""

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
from synthesis.numerics.piecewise import Array
from synthesis.spatial.cam import SpatialCam, Wall
from synthesis.spatial.cutting import STEP, Poses, along_wall, wall_error, with_roller
from synthesis.spatial.design import SpatialDesign
from synthesis.spatial.files.flanks import chosen
from synthesis.spatial.files.options import MAX_ROWS, Density, Flank
from synthesis.spatial.frame import CamFrame
from synthesis.units import DEGREE

BOTH = 0  # the side of a path that leaves both walls


@dataclass(frozen=True, kw_only=True)
class CutterOptions(Options):
    """Which cutter, and where its path is told.

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
            description="Of a cylindrical cutter. Left out, it has the roller's own form and "
            "leaves both walls at once, exactly; a thinner one runs along each flank by itself.",
        ),
    ] = None
    flank: Flank = ""
    frame: Annotated[
        Literal["cam", "machine"],
        Field(
            description="`cam`: positions and directions on the cam, for a part program of five "
            "axes. `machine`: the same while the cam stands turned by c_deg."
        ),
    ] = "cam"
    points_per_degree: Density = 1.0


@dataclass(frozen=True, eq=False)
class Path:
    """One pass of the cutter.

    Attributes:
        wall: the flank. side: of it, or BOTH. poses: of the cutter. error: off the flank [mm].
    """

    wall: Wall
    side: int
    poses: Poses
    error: float


def paths(design: SpatialDesign, options: CutterOptions) -> list[Path]:
    """The passes that leave the flanks asked for.

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
            f"Ask for at most {MAX_ROWS / sum(counts) * options.points_per_degree:.3g}.",
        )
    spans = [(wall, span) for wall in walls for span in wall.spans]
    return [
        _path(cam, wall, np.linspace(*span, count), radius)
        for (wall, span), count in zip(spans, counts, strict=True)
    ]


def _radius(cam: SpatialCam, options: CutterOptions) -> float | None:
    """Of a cutter that is thinner than the roller [mm]; None of one that has its form."""
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
            f"A cylindrical cutter has to be thinner than the roller, {most:.9g} mm at its "
            "thinnest, or it cuts away more than the roller needs.",
            "Take a thinner one, or leave it out for a cutter of the roller's form.",
        )
    return None if radius == roller.radius else radius


def _path(cam: SpatialCam, wall: Wall, theta: Array, radius: float | None) -> Path:
    if radius is None:
        return Path(wall, BOTH, with_roller(cam, wall, theta), 0.0)
    before, at, after = (along_wall(cam, wall, theta + step, radius) for step in (-STEP, 0.0, STEP))
    error = float(np.max(np.abs(wall_error(cam, wall, (before, at, after), radius))))
    return Path(wall, wall.side, at, error)


def _columns(cam: SpatialCam, path: Path, options: CutterOptions) -> Sequence[Column]:
    swept, poses = cam.swept, path.poses
    frame = CamFrame.of(swept)
    # towards the spindle: away from the cam's axis
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
        Column("c_deg", "deg", "turn of the cam about z", swept.hand * poses.theta / DEGREE),
        *(Column(f"{name}_mm", "mm", "end of the cutter, where the roller ends", values)
          for name, values in zip("xyz", tip, strict=True)),
        *(Column(name, "1", "axis of the cutter, from its end to the spindle", values)
          for name, values in zip("ijk", tool, strict=True)),
    ]  # fmt: skip


def _csv(design: SpatialDesign, options: CutterOptions) -> Made:
    found = paths(design, options)
    data = table(joined([_columns(design.cam, path, options) for path in found]))
    return Made(data, {"Wall-Error-Mm": f"{max(path.error for path in found):.3g}"})


CSV = FileFormat(
    "cutter.csv", "Cutter path, comma separated", "text/csv; charset=utf-8; header=present",
    ".csv", _csv, CutterOptions,
    "End and axis of a cutter at every cam angle, on the cam or as the machine stands: of one of "
    "the roller's form, or of a thinner one along each flank, tilted so that it leaves the "
    "roller's wall as nearly as a cylinder can. The header Camwright-Wall-Error-Mm: how nearly.",
)  # fmt: skip
