"""Diagrams of the motion as SVG: s, v, a and j over the cam angle, stacked on one sheet (mm)."""

from __future__ import annotations

import math

import numpy as np

from synthesis.design import Design, SegmentMotion
from synthesis.exporters import svg_canvas as svg
from synthesis.exporters.cam import Cam
from synthesis.exporters.exporter import Exporter, untold
from synthesis.exporters.options import MotionOptions
from synthesis.exporters.readings import QUANTITIES
from synthesis.exporters.svg_diagram import Frame, diagram
from synthesis.exporters.svg_heading import heading

WIDTH, LEFT, RIGHT = 190.0, 21.0, 8.0
HEADER, BAND, HEIGHT, GAP, FOOTER = 20.0, 9.4, 42.0, 11.0, 12.0
SHORT = 7  # what is left of a cut name must have more letters than this
DRAWN_PER_DEGREE = 2.0  # a sheet is not drawn more coarsely than this


def _motion(design: Design, options: MotionOptions) -> bytes:
    cam = Cam.of(design)
    tops = [HEADER + BAND + GAP - 2.0 + k * (HEIGHT + GAP) for k in range(len(QUANTITIES))]
    bottom = tops[-1] + HEIGHT
    per_degree = MotionOptions(max(options.points_per_degree, DRAWN_PER_DEGREE))
    body = [
        *heading(design, LEFT, WIDTH - RIGHT, 1.0),
        *_grounds(design, HEADER, BAND),
        *_band(design),
    ]
    for top, quantity in zip(tops, QUANTITIES, strict=True):
        frame = Frame(LEFT, top, WIDTH - LEFT - RIGHT, HEIGHT)
        body += _grounds(design, top, HEIGHT)
        body += diagram(design, cam, quantity, frame, per_degree)
    body += _angle_axis(bottom)
    title = f"Motion of {design.name or design.id}"
    told = "Displacement, velocity, acceleration and jerk of the follower over the cam angle."
    return svg.document(WIDTH, bottom + FOOTER, 1.0, title, told, body)


def _x(degrees: float) -> float:
    return LEFT + (WIDTH - LEFT - RIGHT) * degrees / 360.0


def _segments(design: Design) -> list[SegmentMotion]:
    return [segment for segment in design.motion if segment.angle_deg > 0.0]


def _grounds(design: Design, top: float, height: float) -> list[str]:
    """A ground for what is drawn over the cam angle: dwells shaded, borders of segments drawn."""
    segments = _segments(design)
    still = [segment for segment in segments if segment.kind == "dwell"]
    borders = [segment.start_deg for segment in segments] + [360.0]
    body = [svg.box("rest", _x(s.start_deg), top, _x(s.angle_deg) - LEFT, height) for s in still]
    return body + [svg.line("border", _x(b), top, _x(b), top + height) for b in borders]


def _band(design: Design) -> list[str]:
    """The strip of segments: what each does and how, as far as there is room."""
    body = [svg.line("border", LEFT, y, WIDTH - RIGHT, y) for y in (HEADER, HEADER + BAND)]
    unit = design.spec.follower.travel.unit
    for segment in _segments(design):
        width = _x(segment.angle_deg) - LEFT
        middle = _x(segment.start_deg) + 0.5 * width
        told = svg.fitting(_names(segment, unit), width - 1.0, svg.LABEL)
        if told:
            body.append(svg.text("label", middle, HEADER + 4.0, told, "middle"))
        manner = _manner(segment, unit)
        told = svg.shortened(manner, width - 1.0, svg.TICK)
        if len(told) > SHORT or told == manner:
            body.append(svg.text("tick", middle, HEADER + 7.8, told, "middle"))
    return body + _border_angles([s.start_deg for s in _segments(design)] + [360.0])


def _border_angles(borders: list[float]) -> list[str]:
    """Cam angles of the borders above the strip, those left out that would overlap."""
    body, free = [], -math.inf
    texts = [f"{svg.figure(border, 6)}°" for border in borders]
    last = _x(360.0) - 0.5 * svg.width_of(texts[-1], svg.TICK)
    for border, text in zip(borders, texts, strict=True):
        half = 0.5 * svg.width_of(text, svg.TICK)
        ends = border == borders[-1]
        if ends or (_x(border) - half >= free and _x(border) + half + 1.0 <= last):
            body.append(svg.text("tick", _x(border), HEADER - 1.3, text, "middle"))
            free = _x(border) + half + 1.0
    return body


def _names(segment: SegmentMotion, unit: str) -> list[str]:
    """What a segment does, the longest text first."""
    angle = f"{svg.figure(segment.angle_deg, 6)}°"
    if segment.kind == "dwell":
        return [f"dwell {angle}", "dwell"]
    start, end = segment.levels
    lift = svg.measured(abs(end - start), unit)
    return [f"{segment.kind} {lift} in {angle}", f"{segment.kind} {lift}", segment.kind]


def _manner(segment: SegmentMotion, unit: str) -> str:
    """How it does it."""
    if segment.kind == "dwell":
        return f"at {svg.measured(round(segment.levels[0], 9), unit)}"  # lifts leave residues
    return segment.law.replace("_", " ")


def _angle_axis(bottom: float) -> list[str]:
    body = []
    for degrees in np.arange(0.0, 361.0, 30.0).tolist():
        body.append(svg.line("axis", _x(degrees), bottom, _x(degrees), bottom + 1.2))
        body.append(svg.text("tick", _x(degrees), bottom + 4.4, f"{degrees:.0f}", "middle"))
    middle = 0.5 * (LEFT + WIDTH - RIGHT)
    return [*body, svg.text("label", middle, bottom + 9.2, "Cam angle, degrees", "middle")]


MOTION = Exporter(
    "svg", "Diagrams of the motion", "image/svg+xml", ".svg", untold(_motion), MotionOptions
)
