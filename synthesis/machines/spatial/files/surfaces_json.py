"""JSON for an animated 3D view: the cam's body as a grid, its rollers, and their motion.

Points are integers in units of a small length, little-endian 16-bit in base64: three for a point,
column by column, row by row. The grid's rows go once around the cam; the last row coincides with
the first, but with its columns shifted (a turret has advanced by some rollers).
"""

from __future__ import annotations

import base64
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from synthesis.exporters.exporter import FileFormat
from synthesis.machines.spatial.body import Blank, BlankOptions, Body, build_body
from synthesis.machines.spatial.cam import FRAME
from synthesis.machines.spatial.design import SpatialDesign
from synthesis.machines.spatial.files.identification import json_file
from synthesis.machines.spatial.grooves import GrooveSections
from synthesis.machines.spatial.machine import Seat
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE, FULL_TURN

DEPTHS, PARTS = 4, 5
LARGEST = 32767  # signed 16 bits
MOTION_ROWS = 361  # of the table of the motion
PLACES = 6  # decimals of lengths and directions


@dataclass(frozen=True, kw_only=True)
class SurfaceOptions(BlankOptions):
    """As ``BlankOptions``, and how fine the grid is.

    Attributes:
        points_per_degree: rows round the cam.
    """

    points_per_degree: Annotated[
        float, Field(ge=0.1, le=1.0, description="Rows of points per degree of cam angle.")
    ] = 0.75


def _surfaces(design: SpatialDesign, options: SurfaceOptions) -> bytes:
    cuts = GrooveSections.of(design.cam, design.spec.machine)
    blank = Blank.of(cuts, options, DEPTHS)
    parts = min(PARTS, blank.chart.parts)
    body = build_body(cuts, blank, round(360.0 * options.points_per_degree), parts)
    return json_file(
        design, "surfaces", FRAME, {"body": _grid(body), "follower": _follower(design)}
    )


def _grid(body: Body) -> dict[str, Any]:
    points = np.moveaxis(body.points, 0, -1)
    unit = float(np.max(np.abs(points))) / LARGEST
    whole = np.round(points / unit).astype("<i2")
    return {
        "rows": points.shape[0],
        "columns": points.shape[1],
        "unit_mm": unit,
        "points": base64.b64encode(whole.tobytes()).decode("ascii"),
        "strips": [
            {"kind": strip.kind, "first": strip.first, "last": strip.last} for strip in body.strips
        ],
        "bore_mm": 2.0 * body.blank.bore,
    }


def _follower(design: SpatialDesign) -> dict[str, Any]:
    """The rollers and their motion, in the frame of the cam at θ = 0.

    A point or direction is a + b cos q + c sin q + d q: rows a, b, c, d.
    """
    cam, machine = design.cam, design.spec.machine
    swept, axes = cam.swept, cam.axes
    theta = np.linspace(0.0, FULL_TURN, MOTION_ROWS)
    place = swept.joint.harmonics(swept.origin)
    place[0] -= swept.centre
    return {
        "cam_turns": swept.hand,
        "seats": [{"number": seat.number, "start": seat.start} for seat in machine.seats()],
        "radius_mm": swept.roller.radius,
        "inner_mm": swept.roller.inner,
        "outer_mm": swept.roller.outer,
        "origin_mm": _rounded(place @ axes.T),
        "along": _rounded(swept.joint.harmonics(swept.along, turning=True) @ axes.T),
        "unit": "rad" if machine.travel.unit == "deg" else "mm",
        "theta_deg": (theta / DEGREE).round(PLACES).tolist(),
        "q": _rounded(cam.place(Seat(0, 0.0), theta).q),
    }


def _rounded(values: Array) -> list[Any]:
    return (np.round(values, PLACES) + 0.0).tolist()  # type: ignore[no-any-return]


SURFACES = FileFormat(
    "surfaces.json", "Surfaces for an animated 3D view", "application/json", ".json",
    _surfaces, SurfaceOptions,
    "The cam's body as a grid of points, the rollers, the axis or guide on which they move, and "
    "their positions at every cam angle: what the studio draws.",
)  # fmt: skip
