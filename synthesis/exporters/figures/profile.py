"""Drawing of the cam as SVG, in mm: the cam, its circles, and the follower.

The shapes stand in a group with y upwards, so their numbers are those of the cam's frame; a place
on a shaft, ``turn_deg`` and ``z_mm``, is not drawn.
"""

from __future__ import annotations

import math

import numpy as np

from synthesis.design.design import Design
from synthesis.exporters.drawing import canvas as svg
from synthesis.exporters.drawing.canvas import TURNS, heading
from synthesis.exporters.exporter import Exporter
from synthesis.exporters.figures.cam_figure import BELOW, TICK, Scene, shapes
from synthesis.exporters.figures.parts import STEM, Box
from synthesis.exporters.options import CamDrawingOptions
from synthesis.exporters.samples.cam import Cam
from synthesis.exporters.samples.sampling import in_degrees

HEADER, MARGIN, ROW = 22.0, 14.0, 5.2  # in units of the sheet
NARROW, WIDE, SHOWN = 110.0, 420.0, 300.0  # of a sheet [mm]: see ``shown_at``
Text = tuple[str, float, float, str]  # kind, x, y, what it says
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


def labels(design: Design, scene: Scene, x: float, y: float) -> list[str]:
    """Texts on the sheet, the cam's centre at (x, y); those that would overlap are left out."""
    taken = _occupied(scene)
    body = []
    for kind, px, py, text in [*_border_texts(scene), *_segment_texts(design, scene)]:
        half = 0.5 * svg.width_of(text, svg.LABEL * scene.u)
        place = (px - half, py - 1.6 * scene.u, px + half, py + 1.6 * scene.u)
        left, bottom, right, top = place
        if not any(left < b[2] and b[0] < right and bottom < b[3] and b[1] < top for b in taken):
            taken.append(place)
            body.append(svg.text(kind, x + px, y - py + 1.0 * scene.u, text, "middle"))
    return body + _offset_text(scene, x, y)


def _occupied(scene: Scene) -> list[Box]:
    """Boxes that texts must not touch: the roller, the stem and the rotation arrow."""
    u, (x, y), (gx, gy) = scene.u, scene.centre, scene.drive
    radius, first, last = scene.arc
    points = [(radius * math.cos(t), radius * math.sin(t)) for t in np.linspace(first, last, 12)]
    points += [
        (x + k * u * gx, y + k * u * gy) for k in np.arange(0.0, scene.roller / u + STEM, 2.0)
    ]
    boxes = [(px - 2.5 * u, py - 2.5 * u, px + 2.5 * u, py + 2.5 * u) for px, py in points]
    side = 0.9 * scene.roller + 0.5 * u
    return [*boxes, (x - side, y - side, x + side, y + side)]


def _clear(scene: Scene, text: str, nx: float, ny: float) -> float:
    """How far along a normal the middle of a text must stand to keep clear of its foot."""
    half = 0.5 * svg.width_of(text, svg.LABEL * scene.u)
    return half * abs(nx) + 1.5 * scene.u * abs(ny) + 0.8 * scene.u


def _border_texts(scene: Scene) -> list[Text]:
    at = scene.borders
    texts: list[Text] = []
    for k, angle in enumerate(in_degrees(at.theta).tolist()):
        text = f"{svg.figure(angle, 6)}°"
        nx, ny = float(at.normal_x[k]), float(at.normal_y[k])
        over = TICK * scene.u + _clear(scene, text, nx, ny)
        place = float(at.pitch_x[k]) + over * nx, float(at.pitch_y[k]) + over * ny
        texts.append(("label halo", *place, text))
    return texts


def _segment_texts(design: Design, scene: Scene) -> list[Text]:
    """What the segments do, inside of the profile, where each is long enough."""
    at, u = scene.middles, scene.u
    texts: list[Text] = []
    segments = [segment for segment in design.motion if segment.angle_deg > 0.0]
    for k, segment in enumerate(segments):
        nx, ny = float(at.normal_x[k]), float(at.normal_y[k])
        under = _clear(scene, segment.kind, nx, ny) + 1.0 * u
        px, py = float(at.x[k]) - under * nx, float(at.y[k]) - under * ny
        room = math.radians(segment.angle_deg) * math.hypot(px, py)
        if room > svg.width_of(segment.kind, svg.LABEL * u) + 2.0 * u:
            texts.append(("quiet inner", px, py, segment.kind))
    return texts


def _offset_text(scene: Scene, x: float, y: float) -> list[str]:
    if abs(scene.offset) < 0.2 * scene.u or scene.drive[0] != 0.0:
        return []
    u, text = scene.u, svg.figure(abs(scene.offset), 6)
    level = y - scene.extent[1] + (BELOW - 2.0) * u
    if svg.width_of(text, svg.LABEL * u) + 5.0 * u < abs(scene.offset):
        middle = x + 0.5 * scene.centre[0]
        return [svg.text("label", middle, level - 1.0 * u, text, "middle")]
    return [svg.text("label", x + max(scene.centre[0], 0.0) + 5.0 * u, level + 1.0 * u, text)]


PROFILE = Exporter(
    "svg", "Drawing of the cam", "image/svg+xml", ".svg", _profile, CamDrawingOptions,
    placeable=False,
)  # fmt: skip
