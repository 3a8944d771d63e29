"""Texts around and inside the cam's figure; those that would overlap are left out."""

from __future__ import annotations

import math

import numpy as np

from synthesis.design.design import Design
from synthesis.exporters.drawing import canvas as svg
from synthesis.exporters.figures.cam_figure import BELOW, TICK, Scene
from synthesis.exporters.figures.parts import STEM, Box
from synthesis.exporters.samples.sampling import in_degrees

Text = tuple[str, float, float, str]  # kind, x, y, what it says


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
