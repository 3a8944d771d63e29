"""Drawing of the development in true size: walls, grooves and paths of the rollers' axes.

Seen from outside with the cam's axis upwards, so that a print in true size can be wrapped around
the cam. The abscissa shows the cam angles at which points pass the roller's side.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from synthesis.exporters.drawing import canvas as svg
from synthesis.exporters.drawing.canvas import ratio, shown_at
from synthesis.exporters.exporter import FileContent, FileFormat
from synthesis.exporters.options import Colours
from synthesis.machines.spatial.design import SpatialDesign
from synthesis.machines.spatial.files.developed import (
    DevelopedOptions,
    Development,
    WallCurve,
    develop,
)
from synthesis.machines.spatial.files.motion import above
from synthesis.numerics.piecewise import Array
from synthesis.units import FULL_TURN

SHEET = 190.0  # units that a sheet is wide
LEFT, RIGHT, HEADER, FOOTER = 17.0, 6.0, 20.0, 27.0  # units
EVERY = 30  # degrees between ticks
INVISIBLE = 1e-9  # of a turn: shorter parts of a curve at the other end are not drawn
MARGIN = 0.08  # of the drawn height, above and below


@dataclass(frozen=True, kw_only=True)
class DrawnOptions(DevelopedOptions):
    """As ``DevelopedOptions``, and the colours of the drawing."""

    theme: Colours = "auto"


@dataclass(frozen=True)
class _Plane:
    """Position of the unrolled cylinder on the sheet.

    Attributes:
        radius: of the cylinder [mm]. low, high: z at the lower and upper edge [mm].
        hand: +1 where the cam turns about its axis, −1 against it. u: the sheet's unit [mm].
    """

    radius: float
    low: float
    high: float
    hand: int
    u: float

    @property
    def width(self) -> float:
        """Of the plane [mm]."""
        return FULL_TURN * self.radius

    @property
    def height(self) -> float:
        """Of the plane [mm]."""
        return self.high - self.low

    def x(self, phi: Array) -> Array:
        """Abscissae of places round the cylinder [rad]: to the right as seen from outside."""
        arc = self.radius * phi
        return np.asarray(LEFT * self.u + (self.width - arc if self.hand > 0 else arc))

    def y(self, z: Array) -> Array:
        """Ordinates of places along the axis [mm]."""
        return np.asarray(HEADER * self.u + self.high - z)


def _svg(design: SpatialDesign, options: DrawnOptions) -> FileContent:
    unrolled = develop(design, options)
    levels = np.concatenate([line.z for line in unrolled.curves])
    room = MARGIN * float(np.ptp(levels))
    u = FULL_TURN * unrolled.radius / (SHEET - LEFT - RIGHT)
    low, high = float(levels.min()) - room, float(levels.max()) + room
    plane = _Plane(unrolled.radius, low, high, design.cam.swept.hand, u)
    width, height = SHEET * u, (HEADER + FOOTER) * u + plane.height
    scale = shown_at(width)
    lines = unrolled.curves
    curves = (
        path
        for line in lines
        for path in _paths(plane, f"line {'outline' if line.side else 'pitch'}", line.phi, line.z)
    )
    body = [
        *above(design, LEFT * u, width - RIGHT * u, u),
        *_clipped(plane, [*_grooves(plane, lines), *curves]),
        *_axes(plane),
        *_legend(plane, unrolled, scale),
    ]
    title = f"Unrolled walls of {design.name or design.id}"
    shown = (
        f"The cylinder of radius {unrolled.radius:.9g} mm about the cam's axis, unrolled as seen "
        "from outside with the axis upwards. One unit of the coordinates is 1 mm of the cylinder."
    )
    return unrolled.file(svg.document(width, height, u, title, shown, body, scale, options.theme))


def _clipped(plane: _Plane, body: list[str]) -> list[str]:
    """An inner SVG that clips its content."""
    x, y = LEFT * plane.u, HEADER * plane.u
    box = " ".join(svg.num(value) for value in (x, y, plane.width, plane.height))
    place = f'x="{svg.num(x)}" y="{svg.num(y)}" width="{svg.num(plane.width)}"'
    inner = f'<svg {place} height="{svg.num(plane.height)}" viewBox="{box}" overflow="hidden">'
    return [inner, *body, "</svg>"]


def _paths(
    plane: _Plane, kind: str, phi: Array, z: Array, *, closed: bool = False
) -> Iterator[str]:
    """A curve, shifted by whole turns so that every part of it is shown once."""
    first = math.floor(float(phi.min()) / FULL_TURN + INVISIBLE)
    last = math.floor(float(phi.max()) / FULL_TURN - INVISIBLE)
    for k in range(first, last + 1):
        x, y = plane.x(phi - k * FULL_TURN), plane.y(z)
        yield svg.path(kind, svg.steps(x, y, 3, closed=closed))


def _grooves(plane: _Plane, lines: list[WallCurve]) -> Iterator[str]:
    """Grooves and ribs: the areas between two walls over the same cam angles."""
    for one in (line for line in lines if line.side > 0):
        for other in (line for line in lines if line.side < 0):
            alike = one.seat == other.seat or len(one.seat.sides) == 1  # a groove, or a rib
            if alike and np.array_equal(one.theta, other.theta):
                phi = np.concatenate([one.phi, other.phi[::-1]])
                z = np.concatenate([one.z, other.z[::-1]])
                kind = "rest" if one.seat == other.seat else "body"
                yield from _paths(plane, kind, phi, z, closed=True)


def _axes(plane: _Plane) -> list[str]:
    u = plane.u
    left, right = LEFT * u, LEFT * u + plane.width
    top, bottom = HEADER * u, HEADER * u + plane.height
    body = []
    for degrees in range(0, 361, EVERY):
        x = float(plane.x(np.array(math.radians(degrees))))
        body.append(svg.line("grid", x, top, x, bottom))
        body.append(svg.text("tick", x, bottom + 4.0 * u, f"{degrees}°", "middle"))
    for value in svg.ticks(plane.low, plane.high, 6):
        y = float(plane.y(np.array(value)))
        body.append(svg.line("axis" if value == 0.0 else "grid", left, y, right, y))
        body.append(svg.text("tick", left - 1.6 * u, y + 0.9 * u, svg.figure(value), "end"))
    body += [svg.line("axis", left, y, right, y) for y in (top, bottom)]
    body += [svg.line("axis", x, top, x, bottom) for x in (left, right)]
    middle, named = 0.5 * (left + right), "Cam angle at which a point passes the roller"
    body.append(svg.text("label", middle, bottom + 8.6 * u, named, "middle"))
    return [*body, svg.text("label", left - 1.6 * u, top - 1.4 * u, "z, mm", "end")]


def _legend(plane: _Plane, unrolled: Development, scale: float) -> list[str]:
    u = plane.u
    top, left = HEADER * u + plane.height + 13.0 * u, LEFT * u
    middle = left + 0.5 * plane.width
    walls = ", ".join(dict.fromkeys(line.name for line in unrolled.curves if line.side))
    lines = [
        ("line outline", f"walls {walls}"),
        ("line pitch", "path of the roller's axis"),
    ]
    body = []
    for k, (kind, meaning) in enumerate(lines):
        y = top + 5.0 * k * u
        body.append(svg.line(kind, left, y, left + 11.0 * u, y))
        name = svg.shorten(meaning, middle - left - 15.0 * u, svg.LABEL * u)
        body.append(svg.text("label", left + 13.0 * u, y + u, name))
    worst = unrolled.error
    remarks = [
        f"radius {svg.figure(plane.radius, 6)} mm, seen from outside, {ratio(scale)}",
        "" if worst is None else f"offset drawn in the plane: error {svg.figure(worst, 3)} mm",
    ]
    for k, remark in enumerate(remarks):
        line = svg.shorten(remark, left + plane.width - middle - 4.0 * u, svg.LABEL * u)
        body.append(svg.text("label", middle + 4.0 * u, top + (5.0 * k + 1.0) * u, line))
    return body


SVG = FileFormat(
    "developed.svg", "Unrolled walls, drawn", "image/svg+xml", ".svg", _svg, DrawnOptions,
    "The cylinder unrolled as seen from outside, in mm: a print in true size can be wrapped "
    "round the cam.",
)  # fmt: skip
