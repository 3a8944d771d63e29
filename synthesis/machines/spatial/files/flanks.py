"""Points on the flanks of a spatial cam, and the error of splines through them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import make_interp_spline

from synthesis.errors import InputError
from synthesis.machines.spatial.cam import SpatialCam, Wall
from synthesis.machines.spatial.cam_frame import CamFrame
from synthesis.machines.spatial.design import SpatialDesign
from synthesis.machines.spatial.files.options import MAX_ROWS, FlankOptions
from synthesis.numerics.geometry.swept_roller import Contacts
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE

CUBIC = 3


@dataclass(frozen=True, eq=False)
class Patch:
    """A part of a flank in continuous mesh, as a grid.

    Attributes:
        wall: the flank. part: number of the part, from 1; parts: how many the flank has.
        theta: (n,) cam angles [rad]. rho: (m,) places on the roller's axis [mm].
        contacts: in the machine's frame. points, normals: (3, n, m) in the cam's frame, outward.
    """

    wall: Wall
    part: int
    parts: int
    theta: Array
    rho: Array
    contacts: Contacts
    points: Array
    normals: Array

    @property
    def name(self) -> str:
        """The flank's name, with the number of the part where there are several."""
        return self.wall.name if self.parts == 1 else f"{self.wall.name}-{self.part}"


def patches(design: SpatialDesign, options: FlankOptions) -> list[Patch]:
    """The selected flanks, in parts.

    Raises:
        InputError: there is no such flank, or there would be too many points.
    """
    cam = design.cam
    walls = chosen(cam, options.flank)
    counts = [[_count(options, b - a) for a, b in wall.spans] for wall in walls]
    _check(sum(map(sum, counts)), options)
    rho = np.linspace(cam.swept.roller.inner, cam.swept.roller.outer, options.depths)
    return [
        patch(cam, wall, part, np.linspace(*span, count), rho)
        for wall, each in zip(walls, counts, strict=True)
        for part, (span, count) in enumerate(zip(wall.spans, each, strict=True), 1)
    ]


def patch(cam: SpatialCam, wall: Wall, part: int, theta: Array, rho: Array) -> Patch:
    """A part of a flank at these cam angles and places."""
    found, frame = cam.contacts(wall, theta, rho), CamFrame.of(cam.swept)
    points = frame.points(theta, found.point)
    normals = frame.directions(theta, -found.normal)
    return Patch(wall, part, len(wall.spans), theta, rho, found, points, normals)


def spline_error(design: SpatialDesign, found: Sequence[Patch]) -> float:
    """Largest distance of cubic splines through the curves' points from the flanks [mm].

    Measured along the flanks' normals, midway between the points.
    """
    return max((_strays(design.cam, each) for each in found), default=0.0)


def _strays(cam: SpatialCam, each: Patch) -> float:
    middle = 0.5 * (each.theta[1:] + each.theta[:-1])
    degree = min(CUBIC, len(each.theta) - 1)
    spline = make_interp_spline(each.theta, each.points, k=degree, axis=1)
    true = patch(cam, each.wall, each.part, middle, each.rho)
    away = np.einsum("inm,inm->nm", spline(middle) - true.points, true.normals)
    return float(np.max(np.abs(away)))


def chosen(cam: SpatialCam, name: str) -> list[Wall]:
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


def _count(options: FlankOptions, span: float) -> int:
    if options.points is not None:
        return options.points
    return max(2, math.ceil(span / DEGREE * options.points_per_degree - 1e-9) + 1)


def _check(count: int, options: FlankOptions) -> None:
    """Refuse too many points before anything is computed."""
    rows = count * options.depths
    if rows <= MAX_ROWS:
        return
    by, now = ("points", options.points) if options.points else (
        "points_per_degree", options.points_per_degree
    )  # fmt: skip
    assert now is not None
    most = MAX_ROWS / rows * now
    allowed = f"{math.floor(most)}" if by == "points" else f"{math.floor(1000 * most) / 1000:g}"
    raise InputError(
        f"/{by}",
        now,
        f"With {options.depths} depths this makes {rows} points; a file has at most {MAX_ROWS}.",
        f"Request at most {allowed}, fewer depths, or one flank at a time.",
    )
