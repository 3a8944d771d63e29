"""Diagrams over the cam angle, stacked on a sheet under the strip of segments (mm)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from synthesis.design.design import Design, SegmentMotion
from synthesis.exporters.diagrams.diagram import Frame, diagram
from synthesis.exporters.diagrams.plot import Plot
from synthesis.exporters.drawing import canvas as svg
from synthesis.exporters.drawing.heading import heading
from synthesis.exporters.drawing.theme import Theme

WIDTH, LEFT, RIGHT = 190.0, 21.0, 8.0
HEADER, BAND, HEIGHT, GAP, FOOTER = 20.0, 9.4, 42.0, 11.0, 12.0
SHORT = 7  # what is left of a cut name must have more letters than this
STRIP = Frame(LEFT, HEADER, WIDTH - LEFT - RIGHT, BAND)
DRAWN_PER_DEGREE = 2.0  # a sheet is not drawn more coarsely than this


def sheet(design: Design, plots: Sequence[Plot], title: str, told: str, theme: Theme) -> bytes:
    """The sheet of a design; ``title`` and ``told`` are for those who do not see it."""
    above = heading(design, LEFT, WIDTH - RIGHT, 1.0)
    moved = Moved(design.motion, design.spec.follower.travel.unit)
    return stacked(moved, above, plots, (title, told), theme)


@dataclass(frozen=True)
class Moved:
    """A motion as a sheet needs it: its segments, and the unit of their levels."""

    motion: Sequence[SegmentMotion]
    unit: str


def stacked(
    moved: Moved, above: Sequence[str], plots: Sequence[Plot], told: tuple[str, str], theme: Theme
) -> bytes:
    """The same under a heading of ``above``; ``told``: title, and what it shows."""
    motion = moved.motion
    tops = [HEADER + BAND + GAP - 2.0 + k * (HEIGHT + GAP) for k in range(len(plots))]
    bottom = tops[-1] + HEIGHT
    body = [
        *above,
        *grounds(motion, STRIP),
        *_band(moved),
    ]
    for top, plot in zip(tops, plots, strict=True):
        frame = replace(STRIP, top=top, height=HEIGHT)
        body += [*grounds(motion, frame), *diagram(plot, frame)]
    body += angle_axis(replace(STRIP, top=tops[-1], height=HEIGHT))
    return svg.document(WIDTH, bottom + FOOTER, 1.0, *told, body, theme=theme)


def _x(degrees: float) -> float:
    return LEFT + (WIDTH - LEFT - RIGHT) * degrees / 360.0


def _segments(motion: Sequence[SegmentMotion]) -> list[SegmentMotion]:
    return [segment for segment in motion if segment.angle_deg > 0.0]


def grounds(motion: Sequence[SegmentMotion], frame: Frame) -> list[str]:
    """A ground for what is drawn over the cam angle: dwells shaded, borders of segments drawn."""
    segments, low = _segments(motion), frame.top + frame.height
    starts = frame.x(np.array([segment.start_deg for segment in segments] + [360.0])).tolist()
    body = [
        svg.box("rest", a, frame.top, b - a, frame.height)
        for segment, a, b in zip(segments, starts, starts[1:], strict=False)
        if segment.kind == "dwell"
    ]
    return body + [svg.line("border", x, frame.top, x, low) for x in starts]


def _band(moved: Moved) -> list[str]:
    """The strip of segments: what each does and how, as far as there is room."""
    body = [svg.line("border", LEFT, y, WIDTH - RIGHT, y) for y in (HEADER, HEADER + BAND)]
    segments, unit = _segments(moved.motion), moved.unit
    for segment in segments:
        width = _x(segment.angle_deg) - LEFT
        middle = _x(segment.start_deg) + 0.5 * width
        told = svg.fitting(_names(segment, unit), width - 1.0, svg.LABEL)
        if told:
            body.append(svg.text("label", middle, HEADER + 4.0, told, "middle"))
        manner = _manner(segment, unit)
        told = svg.shortened(manner, width - 1.0, svg.TICK)
        if len(told) > SHORT or told == manner:
            body.append(svg.text("tick", middle, HEADER + 7.8, told, "middle"))
    return body + _border_angles([s.start_deg for s in segments] + [360.0])


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


def angle_axis(frame: Frame, every: int = 30, name: str = "Cam angle") -> list[str]:
    """Numbers and name of the abscissa under a diagram."""
    body, bottom = [], frame.top + frame.height
    for degrees in range(0, 361, every):
        x = float(frame.x(np.array(degrees)))
        body.append(svg.line("axis", x, bottom, x, bottom + 1.2))
        body.append(svg.text("tick", x, bottom + 4.4, f"{degrees}", "middle"))
    middle = frame.left + 0.5 * frame.width
    return [*body, svg.text("label", middle, bottom + 9.2, f"{name}, degrees", "middle")]
