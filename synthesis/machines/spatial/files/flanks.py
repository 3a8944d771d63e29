"""Points on the flanks of a spatial cam: grids, the error of splines through them, and their files.

``flanks.csv`` and ``flanks.json`` are tables of contacts. ``flanks.ibl`` holds datum curves for
Creo: a section for every flank, in it a curve for every depth, from the roller's inner end
outwards, all with increasing cam angle; the format allows no comments and no names.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from pydantic import Field
from scipy.interpolate import make_interp_spline

from synthesis.errors import InputError
from synthesis.exporters.exporter import FileContent, compact_json, machine_format
from synthesis.exporters.options import Decimals, Options
from synthesis.exporters.samples.columns import Column, concatenate
from synthesis.exporters.tables import csv_table
from synthesis.machines.spatial.cam import FRAME, SpatialCam, Wall
from synthesis.machines.spatial.design import SpatialDesign
from synthesis.numerics.geometry.swept_roller import Contacts, dot
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE

CUBIC = 3  # degree of the splines
MAX_ROWS = 200_000  # of a point file

Density = Annotated[float, Field(gt=0.0, le=100.0, description="Points per degree of cam angle.")]
Depths = Annotated[int, Field(ge=2, le=200)]
Flank = Annotated[
    str,
    Field(
        max_length=8,
        description="Name of one flank, as in `2R`: of roller 2, on the side towards which the "
        "follower moves as its travel grows. Left out: all flanks.",
    ),
]


@dataclass(frozen=True, kw_only=True)
class FlankOptions(Options):
    """The flanks and the sampling of their points; an empty ``flank`` stands for all."""

    flank: Flank = ""
    points_per_degree: Density = 1.0
    points: Annotated[int | None, Field(ge=2, le=36_001)] = None
    """Points of every curve, evenly over the cam angle; overrides points_per_degree."""
    depths: Depths = 5
    """Curves of a flank, evenly over the roller's width; the first and the last are its edges."""


@dataclass(frozen=True, kw_only=True)
class WrittenFlankOptions(FlankOptions):
    """As ``FlankOptions``, of two depths, and the decimals of a point file."""

    depths: Depths = 2
    decimals: Decimals = 10


@dataclass(frozen=True, eq=False)
class Patch:
    """A part of a flank in continuous mesh, as a grid.

    Attributes:
        wall: the flank. part: number of the part, from 1.
        theta: (n,) cam angles [rad]. rho: (m,) places on the roller's axis [mm].
        contacts: in the machine's frame. points, normals: (3, n, m) in the cam's frame, outward.
    """

    wall: Wall
    part: int
    theta: Array
    rho: Array
    contacts: Contacts
    points: Array
    normals: Array

    @property
    def name(self) -> str:
        """The flank's name, with the number of the part where there are several."""
        return self.wall.name if len(self.wall.spans) == 1 else f"{self.wall.name}-{self.part}"

    def distance(self, points: Array) -> float:
        """The largest distance of points (3, n, m) from the grid's, along the normals [mm]."""
        return float(np.max(np.abs(dot(points - self.points, self.normals))))


def patches(design: SpatialDesign, options: FlankOptions) -> list[Patch]:
    """The selected flanks, in parts.

    Raises:
        InputError: there is no such flank, or there would be too many points.
    """
    cam = design.cam
    rho = cam.swept.roller.places(options.depths)
    walls = select_walls(cam, options.flank)
    sampled = sample_angles(walls, options.points_per_degree, options.points, options.depths)
    return [patch(cam, wall, part, theta, rho) for wall, part, theta in sampled]


def sample_angles(
    walls: Sequence[Wall], density: float, points: int | None = None, depths: int = 1
) -> list[tuple[Wall, int, Array]]:
    """Cam angles over every interval of the walls, and the interval's number, from 1.

    Args:
        density: points per degree. points: of an interval, instead of the density.
        depths: points of a file at each angle.

    Raises:
        InputError: a file would have too many points (checked before anything is computed).
    """
    spans = [(wall, part, span) for wall in walls for part, span in enumerate(wall.spans, 1)]
    counts = [
        points or max(2, math.ceil((b - a) / DEGREE * density - 1e-9) + 1) for _, _, (a, b) in spans
    ]
    rows = depths * sum(counts)
    if rows > MAX_ROWS:
        field, now = ("points", float(points)) if points else ("points_per_degree", density)
        most = MAX_ROWS / rows * now
        allowed = f"{math.floor(most)}" if points else f"{math.floor(1000 * most) / 1000:g}"
        raise InputError(
            f"/{field}", points or density,
            f"With {depths} depths this makes {rows} points; a file has at most {MAX_ROWS}.",
            f"Request at most {allowed}, fewer depths, or one flank at a time.",
        )  # fmt: skip
    return [
        (wall, part, np.linspace(*span, count))
        for (wall, part, span), count in zip(spans, counts, strict=True)
    ]


def patch(cam: SpatialCam, wall: Wall, part: int, theta: Array, rho: Array) -> Patch:
    """A part of a flank at these cam angles and places."""
    contacts = cam.contacts(wall, theta, rho)
    points = cam.frame_points(theta, contacts.point)
    normals = cam.frame_directions(theta, -contacts.normal)
    return Patch(wall, part, theta, rho, contacts, points, normals)


def spline_error(design: SpatialDesign, flanks: Sequence[Patch]) -> float:
    """Largest distance of cubic splines through the curves' points from the flanks [mm].

    Measured along the flanks' normals, midway between the points.
    """
    largest = 0.0
    for each in flanks:
        middle = 0.5 * (each.theta[1:] + each.theta[:-1])
        degree = min(CUBIC, len(each.theta) - 1)
        spline = make_interp_spline(each.theta, each.points, k=degree, axis=1)
        true = patch(design.cam, each.wall, each.part, middle, each.rho)
        largest = max(largest, true.distance(spline(middle)))
    return largest


def select_walls(cam: SpatialCam, name: str) -> list[Wall]:
    """The flank of this name; for "", all flanks.

    Raises:
        InputError: there is none.
    """
    walls = [wall for wall in cam.walls if name in ("", wall.name)]
    if not walls:
        names = ", ".join(wall.name for wall in cam.walls)
        raise InputError(
            "/flank",
            name,
            f"The flanks of this cam are {names}.",
            "Name one of them, or leave it out.",
        )
    return walls


def _ibl(design: SpatialDesign, options: WrittenFlankOptions) -> FileContent:
    flanks, decimals = patches(design, options), options.decimals
    row = " ".join(["%d", *[f"%.{decimals}f"] * 3]) + "\n"
    lines = ["Open Arclength\n"]
    for section, each in enumerate(flanks, 1):
        lines.append(f"begin section ! {section}\n")
        for curve, points in enumerate(np.moveaxis(each.points, 0, -1).swapaxes(0, 1), 1):
            rounded = (np.round(points, decimals) + 0.0).tolist()
            values = [v for n, point in enumerate(rounded, 1) for v in (n, *point)]
            lines.append(f"begin curve ! {curve}\n" + row * len(rounded) % tuple(values))
    metadata = {
        "Sections": " ".join(each.name for each in flanks),
        "Spline-Error-Mm": f"{spline_error(design, flanks):.3g}",
    }
    return FileContent("".join(lines).encode("ascii"), metadata)


def _csv(design: SpatialDesign, options: FlankOptions) -> bytes:
    return csv_table(concatenate([_columns(each) for each in patches(design, options)]))


def _columns(each: Patch) -> list[Column]:
    """A row for every point: all places at one cam angle, then the next angle."""
    shape = each.points.shape[1:]
    theta, rho = np.repeat(each.theta, shape[1]), np.tile(each.rho, shape[0])
    return [
        Column("roller", "1", "number of the roller", np.full(len(rho), each.wall.seat.number)),
        Column("side", "1", "1: R, -1: L", np.full(len(rho), each.wall.side)),
        Column("theta_deg", "deg", "cam angle", theta / DEGREE),
        Column("rho_mm", "mm", "place on the roller's axis", rho),
        *(Column(f"{name}_mm", "mm", "point of the flank", values)
          for name, values in zip("xyz", each.points.reshape(3, -1), strict=True)),
        *(Column(f"normal_{name}", "1", "unit normal, out of the cam", values)
          for name, values in zip("xyz", each.normals.reshape(3, -1), strict=True)),
        Column(
            "pressure_angle_deg", "deg", "between the normal and the roller's velocity",
            each.contacts.pressure_angle.ravel() / DEGREE,
        ),
        Column(
            "regular", "1", "area of the flank to that of the surface which the roller's axis "
            "sweeps; 0 or less: undercut", each.contacts.regular.ravel(),
        ),
    ]  # fmt: skip


def _json(design: SpatialDesign, options: FlankOptions) -> bytes:
    def rows(points: Array) -> Any:
        """Nested lists by cam angle, then by place: x, y, z."""
        return np.moveaxis(points, 0, -1).tolist()

    flanks = [
        {
            "name": each.name,
            "roller": each.wall.seat.number,
            "side": each.wall.letter,
            "theta_deg": (each.theta / DEGREE).tolist(),
            "rho_mm": each.rho.tolist(),
            "points_mm": rows(each.points),
            "normals": rows(each.normals),
            "pressure_angle_deg": (each.contacts.pressure_angle / DEGREE).tolist(),
            "regular": each.contacts.regular.tolist(),
        }
        for each in patches(design, options)
    ]
    head = {"kind": "flanks", "frame": FRAME, "design": design.identification}
    return compact_json({**head, "flanks": flanks})


FLANKS = machine_format("spatial", "flanks.ibl", _ibl, WrittenFlankOptions)
CSV = machine_format("spatial", "flanks.csv", _csv, FlankOptions)
JSON = machine_format("spatial", "flanks.json", _json, FlankOptions)
