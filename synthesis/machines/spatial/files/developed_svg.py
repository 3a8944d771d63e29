"""Drawing of the development in true size: walls, grooves and paths of the rollers' axes.

Seen from outside with the cam's axis upwards, so that a print in true size can be wrapped around
the cam. The abscissa shows the cam angles at which points pass the roller's side.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np

from synthesis.exporters.diagrams.plot import Frame
from synthesis.exporters.drawing import canvas as svg
from synthesis.exporters.drawing.canvas import ratio, shown_at
from synthesis.exporters.exporter import FileContent, machine_format
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


def _svg(design: SpatialDesign, options: DrawnOptions) -> FileContent:
    unrolled = develop(design, options)
    lines, around = unrolled.curves, FULL_TURN * unrolled.radius
    levels = np.concatenate([line.z for line in lines])
    room, u = MARGIN * float(np.ptp(levels)), around / (SHEET - LEFT - RIGHT)
    low, high = float(levels.min()) - room, float(levels.max()) + room
    # Seen from outside, angles run to the left where the cam turns about its axis.
    turn = (FULL_TURN, 0.0) if design.cam.swept.hand > 0 else (0.0, FULL_TURN)
    frame = Frame(LEFT * u, HEADER * u, around, high - low, low, high, *turn)
    width, height = SHEET * u, (HEADER + FOOTER) * u + frame.height
    scale = shown_at(width)
    curves = (
        path
        for line in lines
        for path in _paths(frame, f"line {'outline' if line.side else 'pitch'}", line.phi, line.z)
    )
    body = [
        *above(design, LEFT * u, width - RIGHT * u, u),
        *_clipped(frame, [*_grooves(frame, lines), *curves]),
        *_axes(frame, u),
        *_legend(frame, unrolled, scale, u),
    ]
    title = f"Unrolled walls of {design.name or design.id}"
    shown = (
        f"The cylinder of radius {unrolled.radius:.9g} mm about the cam's axis, unrolled as seen "
        "from outside with the axis upwards. One unit of the coordinates is 1 mm of the cylinder."
    )
    return unrolled.file(svg.document(width, height, u, title, shown, body, scale, options.theme))


def _clipped(frame: Frame, body: list[str]) -> list[str]:
    """An inner SVG that clips its content."""
    x, y, width, height = map(svg.num, (frame.left, frame.top, frame.width, frame.height))
    place = f'x="{x}" y="{y}" width="{width}" height="{height}"'
    box = f'viewBox="{x} {y} {width} {height}" overflow="hidden"'
    return [f"<svg {place} {box}>", *body, "</svg>"]


def _paths(frame: Frame, kind: str, phi: Array, z: Array, *, closed: bool = False) -> Iterator[str]:
    """A curve, shifted by whole turns so that every part of it is shown once."""
    first = math.floor(float(phi.min()) / FULL_TURN + INVISIBLE)
    last = math.floor(float(phi.max()) / FULL_TURN - INVISIBLE)
    for k in range(first, last + 1):
        points = frame.x(phi - k * FULL_TURN), frame.y(z)
        yield svg.path(kind, svg.steps(*points, 3, closed=closed))


def _grooves(frame: Frame, lines: list[WallCurve]) -> Iterator[str]:
    """Grooves and ribs: the areas between two walls over the same cam angles."""
    for one, other in product(lines, lines):
        alike = one.seat == other.seat or len(one.seat.sides) == 1  # a groove, or a rib
        if one.side > 0 > other.side and alike and np.array_equal(one.theta, other.theta):
            phi = np.concatenate([one.phi, other.phi[::-1]])
            z = np.concatenate([one.z, other.z[::-1]])
            kind = "rest" if one.seat == other.seat else "body"
            yield from _paths(frame, kind, phi, z, closed=True)


def _axes(frame: Frame, u: float) -> list[str]:
    left, right, top, bottom = frame.left, frame.right, frame.top, frame.bottom
    body = []
    for degrees in range(0, 361, EVERY):
        x = frame.x(math.radians(degrees))
        body.append(svg.line("grid", x, top, x, bottom))
        body.append(svg.text("tick", x, bottom + 4.0 * u, f"{degrees}°", "middle"))
    for value in svg.ticks(frame.low, frame.high, 6):
        y = frame.y(value)
        body.append(svg.line("axis" if value == 0.0 else "grid", left, y, right, y))
        body.append(svg.text("tick", left - 1.6 * u, y + 0.9 * u, svg.figure(value), "end"))
    body += [svg.line("axis", left, y, right, y) for y in (top, bottom)]
    body += [svg.line("axis", x, top, x, bottom) for x in (left, right)]
    middle, named = 0.5 * (left + right), "Cam angle at which a point passes the roller"
    body.append(svg.text("label", middle, bottom + 8.6 * u, named, "middle"))
    return [*body, svg.text("label", left - 1.6 * u, top - 1.4 * u, "z, mm", "end")]


def _legend(frame: Frame, unrolled: Development, scale: float, u: float) -> list[str]:
    left, half = frame.left, 0.5 * frame.width
    walls = ", ".join(dict.fromkeys(line.name for line in unrolled.curves if line.side))
    worst = unrolled.error
    rows = (
        ("line outline", f"walls {walls}",
         f"radius {svg.figure(unrolled.radius, 6)} mm, seen from outside, {ratio(scale)}"),
        ("line pitch", "path of the roller's axis",
         "" if worst is None else f"offset drawn in the plane: error {svg.figure(worst, 3)} mm"),
    )  # fmt: skip
    meanings, remarks = [], []
    for k, (kind, meaning, remark) in enumerate(rows):
        y = frame.bottom + (13.0 + 5.0 * k) * u
        name = svg.shorten(meaning, half - 15.0 * u, svg.LABEL * u)
        meanings.append(svg.line(kind, left, y, left + 11.0 * u, y))
        meanings.append(svg.text("label", left + 13.0 * u, y + u, name))
        line = svg.shorten(remark, half - 4.0 * u, svg.LABEL * u)
        remarks.append(svg.text("label", left + half + 4.0 * u, y + u, line))
    return [*meanings, *remarks]


SVG = machine_format("spatial", "developed.svg", _svg, DrawnOptions)
