"""Drawing of the cam as SVG, in mm: the cam, its circles, and the follower.

The shapes stand in a group with y upwards, so their numbers are those of the cam's frame; a place
on a shaft, ``turn_deg`` and ``z_mm``, is not drawn.
"""

from __future__ import annotations

import math

import numpy as np

from synthesis.design.design import Design
from synthesis.exporters.drawing import canvas as svg
from synthesis.exporters.drawing.heading import TURNS, heading
from synthesis.exporters.exporter import Exporter
from synthesis.exporters.figures.cam_figure import BELOW, Scene, shapes
from synthesis.exporters.figures.labels import labels
from synthesis.exporters.options import CamDrawingOptions
from synthesis.exporters.samples.cam import Cam

HEADER, MARGIN, ROW = 22.0, 14.0, 5.2  # in units of the sheet
NARROW, WIDE, SHOWN = 110.0, 420.0, 300.0  # of a sheet [mm]: see ``shown_at``
OPPOSITE = {"ccw": "cw", "cw": "ccw"}


def _profile(design: Design, options: CamDrawingOptions) -> bytes:
    Cam.of(design, options)  # a curve that the cam has not is refused; all are drawn
    scene = Scene.of(design, Cam.of(design), options)
    u, (left, bottom, right, top) = scene.u, scene.extent
    width = right - left + 2.0 * MARGIN * u
    x, y = MARGIN * u - left, HEADER * u + top
    legend = y - bottom + (BELOW + 3.0) * u
    rows = _legend(design, scene)
    height = legend + (max(5, len(rows)) + 1.0) * ROW * u
    widest = max(svg.width_of(text, svg.LABEL * u) for _, text in rows)
    second = max(0.5 * width + 8.0 * u, (MARGIN + 13.0) * u + widest + 3.0 * u)
    scale = shown_at(width)
    body = [
        f'<g transform="translate({svg.num(x)} {svg.num(y)}) scale(1 -1)">',
        *shapes(scene),
        "</g>",
        *labels(design, scene, x, y),
        *heading(design, MARGIN * u, width - MARGIN * u, u),
        *_legend_lines(rows, MARGIN * u, legend, u),
        *_remarks(design, scene, second, legend, u),
        *_scale_bar(second, legend + 4.0 * ROW * u, u, ratio(scale)),
    ]
    title = f"Cam {design.name or design.id}"
    text = (
        f"The cam's profile and pitch curve, drawn {ratio(scale)}, with the follower at cam "
        "angle 0. One unit of the coordinates is 1 mm of the cam."
    )
    return svg.document(width, height, u, title, text, body, scale, options.theme)


def shown_at(width: float) -> float:
    """How many times its true size a sheet [mm] is shown: 1 where that can be read.

    Otherwise the largest round number at which it is no wider than ``SHOWN``.
    """
    if NARROW <= width <= WIDE:
        return 1.0
    power = 10.0 ** math.floor(math.log10(SHOWN / width))
    return max(k * power for k in (1.0, 2.0, 5.0) if k * power * width <= SHOWN * (1.0 + 1e-9))


def ratio(scale: float) -> str:
    """A scale as on a technical drawing (ISO 5455)."""
    enlarged, reduced = svg.figure(max(scale, 1.0)), svg.figure(max(1.0 / scale, 1.0))
    return f"{enlarged} : {reduced}"


def _legend(design: Design, scene: Scene) -> list[tuple[str, str]]:
    """Kinds of lines and what they stand for."""
    size = {name: svg.figure(value, 6) for name, value in design.dimensions.items()}
    first = scene.flanks[0][0]
    rows = []
    for flank, curve in scene.flanks:
        radius = np.hypot(curve.x, curve.y)
        least, largest = svg.figure(float(radius.min()), 5), svg.figure(float(radius.max()), 5)
        text = f"{flank.name} profile, radius {least} to {largest} mm".strip()
        rows.append(("line outline" if flank.path == first.path else "line curve", text))
    rows.append(("line circle", f"base circle, radius {size['base_radius_mm']} mm"))
    if scene.roller > 0.0:
        rows.insert(len(scene.flanks), ("line pitch", "pitch curve, path of the roller's centre"))
        rows.append(("line prime", f"prime circle, radius {size['prime_radius_mm']} mm"))
    if "offset_mm" in size:
        rows.append(("line centre", f"line of the follower, offset {size['offset_mm']} mm"))
    if scene.pivot is not None:
        arm = f"arm {size['arm_mm']} mm, " if "arm_mm" in size else ""
        rows.append(("line centre", f"{arm}pivot at {size['centre_distance_mm']} mm"))
    return rows


def _legend_lines(rows: list[tuple[str, str]], x: float, top: float, u: float) -> list[str]:
    body = []
    for k, (kind, text) in enumerate(rows):
        y = top + (k + 0.5) * ROW * u
        body.append(svg.line(kind, x, y, x + 11.0 * u, y))
        body.append(svg.text("label", x + 13.0 * u, y + 1.0 * u, text))
    return body


def _remarks(design: Design, scene: Scene, x: float, top: float, u: float) -> list[str]:
    levels = [end for segment in design.motion for end in segment.levels]
    stroke = svg.with_unit(max(levels) - min(levels), design.spec.follower.travel.unit)
    tip = "knife edge"
    if any(scene.face):
        tip = f"flat face, contact over {svg.figure(sum(scene.face), 6)} mm"
    elif scene.roller > 0.0:
        tip = f"roller radius {svg.figure(scene.roller, 6)} mm"
    text = [
        tip,
        f"{'stroke' if scene.pivot is None else 'swing'} {stroke}",
        "follower shown at cam angle 0°",
        f"cam angles run {TURNS[OPPOSITE[design.rotation]]}",
    ]
    return [
        svg.text("label", x, top + ((k + 0.5) * ROW + 1.0) * u, line) for k, line in enumerate(text)
    ]


def _scale_bar(x: float, y: float, u: float, drawn: str) -> list[str]:
    """A bar of round length, at most 32 units long, and the sheet's scale."""
    power = 10.0 ** math.floor(math.log10(32.0 * u))
    length = max(k * power for k in (1.0, 2.0, 5.0) if k * power <= 32.0 * u * (1.0 + 1e-9))
    mid, end = x + 0.5 * length, x + length
    body = [svg.line("line outline", x, y + 2.0 * u, end, y + 2.0 * u)]
    body += [svg.line("line outline", a, y + 1.2 * u, a, y + 2.8 * u) for a in (x, mid, end)]
    text = f"{svg.figure(length)} mm, scale {drawn}"
    body.append(svg.text("tick", end + 1.6 * u, y + 2.9 * u, text))
    return body


PROFILE = Exporter(
    "svg", "Drawing of the cam", "image/svg+xml", ".svg", _profile, CamDrawingOptions,
    placeable=False,
)  # fmt: skip
