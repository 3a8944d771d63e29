"""JSON for a picture that turns: the cam's body as a grid, its rollers, and where they go.

Points are whole numbers of a small length, little-endian in base64: three of 16 bits for a point,
column after column of a row, row after row. The grid's rows go once round the cam; the last one
has the place of the first, but other columns of it (a turret has gone on by some rollers).
"""

from __future__ import annotations

import base64
import json
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from synthesis.exporters.exporter import FileFormat, untold
from synthesis.numerics.piecewise import Array
from synthesis.spatial.blank import Blank, BlankOptions
from synthesis.spatial.body import Body, body_of
from synthesis.spatial.design import SpatialDesign
from synthesis.spatial.files.origin import origin
from synthesis.spatial.frame import TOLD, CamFrame
from synthesis.spatial.grooves import Cuts
from synthesis.spatial.machine import Seat
from synthesis.units import DEGREE, FULL_TURN

DEPTHS, PARTS = 4, 5
LARGEST = 32767  # of 16 bits
MOVED = 361  # places in the table of the motion
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
    cuts = Cuts.of(design.cam, design.spec.machine)
    blank = Blank.of(cuts, options, DEPTHS)
    parts = min(PARTS, blank.chart.parts)
    body = body_of(cuts, blank, round(360.0 * options.points_per_degree), parts)
    told = {
        "kind": "surfaces",
        "frame": TOLD,
        "design": origin(design),
        "body": _grid(body),
        "follower": _follower(design),
    }
    return json.dumps(told, ensure_ascii=False, allow_nan=False, separators=(",", ":")).encode()


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
    """What moves rollers, in the frame of the cam at θ = 0.

    A place is a + b cos q + c sin q + d q, a direction too: rows a, b, c, d.
    """
    cam, machine = design.cam, design.spec.machine
    swept, axes = cam.swept, CamFrame.of(cam.swept).axes
    theta = np.linspace(0.0, FULL_TURN, MOVED)
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
    "surfaces.json", "Surfaces for a picture that turns", "application/json", ".json",
    untold(_surfaces), SurfaceOptions,
    "The cam's body as a grid of points, the rollers, the axis or guide that they move on, and "
    "where they are at every cam angle: what the studio draws.",
)  # fmt: skip
