"""Diagrams over the cam angle, stacked on a sheet under the strip of segments (mm)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from synthesis.design.design import Design, SegmentMotion
from synthesis.exporters.diagrams.diagram import Frame, diagram
from synthesis.exporters.diagrams.plot import Plot
from synthesis.exporters.drawing import canvas as svg
from synthesis.exporters.drawing.heading import heading
from synthesis.exporters.options import Theme

WIDTH, LEFT, RIGHT = 190.0, 21.0, 8.0
HEADER, BAND, HEIGHT, GAP, FOOTER = 20.0, 9.4, 42.0, 11.0, 12.0
SHORT = 7  # what is left of a cut name must have more letters than this
STRIP = Frame(LEFT, HEADER, WIDTH - LEFT - RIGHT, BAND)
DRAWN_PER_DEGREE = 2.0  # a sheet is not drawn more coarsely than this


def sheet(design: Design, plots: Sequence[Plot], title: str, text: str, theme: Theme) -> bytes:
    """The sheet of a design; ``title`` and ``text`` are for those who do not see it."""
    above, unit = heading(design, LEFT, WIDTH - RIGHT, 1.0), design.spec.follower.travel.unit
    return stack(design.motion, unit, above, plots, (title, text), theme)


def stack(
    motion: Sequence[SegmentMotion],
    unit: str,
    above: Sequence[str],
    plots: Sequence[Plot],
    title_and_text: tuple[str, str],
    theme: Theme,
) -> bytes:
    """The same under a heading of ``above``; ``unit``: of the segments' levels."""
    body = [*above, *grounds(motion, STRIP), *_band(motion, unit)]
    frame = STRIP
    for k, plot in enumerate(plots):
        top = HEADER + BAND + GAP - 2.0 + k * (HEIGHT + GAP)
        frame = replace(STRIP, top=top, height=HEIGHT)
        body += [*grounds(motion, frame), *diagram(plot, frame)]
    body += angle_axis(frame)
    height = frame.top + frame.height + FOOTER
    return svg.document(WIDTH, height, 1.0, *title_and_text, body, theme=theme)


def _x(degrees: float) -> float:
    return float(STRIP.x(np.array(degrees)))


def moving_segments(motion: Sequence[SegmentMotion]) -> list[SegmentMotion]:
    """Those that extend over some angle."""
    return [segment for segment in motion if segment.angle_deg > 0.0]


def grounds(motion: Sequence[SegmentMotion], frame: Frame) -> list[str]:
    """A ground for what is drawn over the cam angle: dwells shaded, borders of segments drawn."""
    segments, low = moving_segments(motion), frame.top + frame.height
    starts = frame.x(np.array([segment.start_deg for segment in segments] + [360.0])).tolist()
    body = [
        svg.box("rest", a, frame.top, b - a, frame.height)
        for segment, a, b in zip(segments, starts, starts[1:], strict=False)
        if segment.kind == "dwell"
    ]
    return body + [svg.line("border", x, frame.top, x, low) for x in starts]


def _band(motion: Sequence[SegmentMotion], unit: str) -> list[str]:
    """The strip of segments: what each does and how, as far as there is room."""
    body = [svg.line("border", LEFT, y, WIDTH - RIGHT, y) for y in (HEADER, HEADER + BAND)]
    segments = moving_segments(motion)
    for segment in segments:
        width = _x(segment.angle_deg) - LEFT
        middle = _x(segment.start_deg) + 0.5 * width
        name = svg.first_fitting(_names(segment, unit), width - 1.0, svg.LABEL)
        if name:
            body.append(svg.text("label", middle, HEADER + 4.0, name, "middle"))
        law = segment.law.replace("_", " ")
        if segment.kind == "dwell":  # lifts leave residues
            law = f"at {svg.with_unit(round(segment.levels[0], 9), unit)}"
        text = svg.shorten(law, width - 1.0, svg.TICK)
        if len(text) > SHORT or text == law:
            body.append(svg.text("tick", middle, HEADER + 7.8, text, "middle"))
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
    lift = svg.with_unit(abs(end - start), unit)
    return [f"{segment.kind} {lift} in {angle}", f"{segment.kind} {lift}", segment.kind]


def angle_axis(frame: Frame, every: int = 30, name: str = "Cam angle") -> list[str]:
    """Numbers and name of the abscissa under a diagram."""
    body, bottom = [], frame.top + frame.height
    for degrees in range(0, 361, every):
        x = float(frame.x(np.array(degrees)))
        body.append(svg.line("axis", x, bottom, x, bottom + 1.2))
        body.append(svg.text("tick", x, bottom + 4.4, f"{degrees}", "middle"))
    middle = frame.left + 0.5 * frame.width
    return [*body, svg.text("label", middle, bottom + 9.2, f"{name}, degrees", "middle")]
