"""Timing diagram of a set as SVG: a lane a cam, its follower's displacement over shaft angle (mm).

Under the lanes a strip counts how many followers move at the same time.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from synthesis.design.cam_set import CamSet, MountedCam, TimingArc
from synthesis.design.design import SegmentMotion
from synthesis.exporters.diagrams.plot import Frame
from synthesis.exporters.diagrams.sheet import angle_axis, moving_segments
from synthesis.exporters.drawing import canvas as svg
from synthesis.exporters.drawing.canvas import TURNS, two_lines
from synthesis.exporters.samples.cam import Cam
from synthesis.exporters.samples.sampling import in_degrees
from synthesis.numerics.piecewise import Array
from synthesis.spec.cam_set import UPWARDS_DEG, wrap_turn
from synthesis.units import DEGREE

WIDTH, LEFT, RIGHT = 190.0, 43.0, 8.0
HEADER, NAMES, HEIGHT, LANE, FOOTER = 22.0, 5.2, 15.0, 27.5, 13.0
COUNT = 5.0  # height of the strip that counts who moves
PAD = 1.2  # room above and below a curve
FULL = 360.0
SHAFT = Frame(LEFT, 0.0, WIDTH - LEFT - RIGHT, 0.0)
DRAWN = np.arange(0.0, FULL + 0.25, 0.5)  # [deg]; a joint of the motion is added to these


def timing_diagram(cams: CamSet) -> bytes:
    """The set's timing diagram."""
    bottom = HEADER + LANE * len(cams.cams)
    body = _heading(cams)
    for lane, cam in enumerate(cams.cams):
        top = HEADER + lane * LANE
        body += _captions(cam, top)
        body += _lane(cam, top) if cam.has_cam else _nothing(top)
    if len(cams.cams) > 1:
        bottom += 1.5
        body += _counted(cams.timing.arcs, bottom)
        bottom += COUNT
    body += angle_axis(replace(SHAFT, top=bottom), name="Shaft angle")
    title = f"Timing of {cams.name or cams.id}"
    text = "Displacement of every follower over one turn of the shaft, one lane a cam."
    return svg.document(WIDTH, bottom + FOOTER, 1.0, title, text, body)


def _x(degrees: float) -> float:
    return float(SHAFT.x(np.array(degrees)))


def _frame(y: float, height: float) -> list[str]:
    """The edges of a strip over the turn."""
    body = [svg.line("axis", LEFT, y + h, _x(FULL), y + h) for h in (0.0, height)]
    return body + [svg.line("axis", _x(a), y, _x(a), y + height) for a in (0.0, FULL)]


def _spans(start: float, angle: float) -> list[tuple[float, float]]:
    """Shaft angles from a start on; two spans where they run over the turn's end."""
    end = start + angle
    if end <= FULL + 1e-9:
        return [(start, min(end, FULL))]
    return [(start, FULL), (0.0, end - FULL)]


def _heading(cams: CamSet) -> list[str]:
    count, name = len(cams.cams), cams.name.strip() or "Cam set"
    text = (
        f"{count} cam{'s' if count > 1 else ''} on one shaft · turns {TURNS[cams.rotation]} at "
        f"{svg.figure(cams.speed_rpm, 6)} rpm · {cams.status} · {cams.id[:8]}"
    )
    return two_lines(name, text, RIGHT, WIDTH - RIGHT, 1.0)


def _captions(cam: MountedCam, top: float) -> list[str]:
    """What stands to the left of a lane."""
    room, x = LEFT - RIGHT - 3.0, RIGHT
    lines = [
        ("label", cam.name),
        ("tick", f"phase {svg.figure(cam.phase_deg, 6)}°"),
        ("tick", f"z {svg.figure(cam.axial_mm, 6)} mm"),
    ]
    if cam.has_cam:
        levels = [end for segment in cam.design.motion for end in segment.levels]
        unit = cam.design.spec.follower.travel.unit
        stroke = svg.with_unit(max(levels) - min(levels), unit)
        lines.insert(1, ("tick", f"stroke {stroke}"))
    if cam.follower_direction_deg != UPWARDS_DEG:
        lines.append(("tick", f"follower at {svg.figure(cam.follower_direction_deg, 6)}°"))
    sizes = {"label": svg.LABEL, "tick": svg.TICK}
    return [
        svg.text(kind, x, top + NAMES + 2.4 + 4.1 * k, svg.shorten(text, room, sizes[kind]))
        for k, (kind, text) in enumerate(lines)
    ]


def _nothing(top: float) -> list[str]:
    y = top + NAMES
    return [
        svg.box("rest", LEFT, y, _x(FULL) - LEFT, HEIGHT),
        svg.text("alarm", _x(180.0), y + 0.5 * HEIGHT + 1.0, "nothing fits: no cam", "middle"),
    ]


def _lane(cam: MountedCam, top: float) -> list[str]:
    """Ground, names of segments, the curve, and where the program starts."""
    y = top + NAMES
    segments = moving_segments(cam.design.motion)
    starts = [wrap_turn(segment.start_deg + cam.phase_deg) for segment in segments]
    spans = [_spans(at, segment.angle_deg) for at, segment in zip(starts, segments, strict=True)]
    body = [
        svg.box("rest", _x(start), y, _x(end) - _x(start), HEIGHT)
        for segment, parts in zip(segments, spans, strict=True)
        if segment.kind == "dwell"
        for start, end in parts
    ]
    body += [svg.line("grid", _x(a), y, _x(a), y + HEIGHT) for a in range(30, 360, 30)]
    body += [svg.line("border", _x(at), y - 3.6, _x(at), y + HEIGHT + 1.2) for at in starts]
    body += [
        *_frame(y, HEIGHT),
        *_names(segments, spans, y - 1.4),
        *_borders(starts, y + HEIGHT + 4.2),
    ]
    # the displacement, in a scale of its own
    shaft, s = displacement(cam)
    low, high = float(s.min()), float(s.max())
    scale = (HEIGHT - 2.0 * PAD) / (high - low)
    levels = y + HEIGHT - PAD - scale * (s - low)
    body.append(svg.path("line curve", svg.steps(SHAFT.x(shaft), levels, 3)))
    at, foot = _x(wrap_turn(cam.phase_deg)), y + HEIGHT
    return [
        *body,
        svg.line("phase", at, y - 3.6, at, foot + 1.2),
        svg.arrow_head("start", at, foot, 0.5 * math.pi, 2.6),
    ]


def _names(
    segments: Sequence[SegmentMotion], spans: Sequence[Sequence[tuple[float, float]]], y: float
) -> list[str]:
    """What the segments do, where there is room; split ones are named in the longer part."""
    body = []
    for segment, parts in zip(segments, spans, strict=True):
        start, end = max(parts, key=lambda span: span[1] - span[0])
        angle = f"{svg.figure(segment.angle_deg, 6)}°"
        texts = [f"{segment.kind} {angle}", segment.kind, segment.kind[:1].upper()]
        name = svg.first_fitting(texts, _x(end) - _x(start) - 0.8, svg.TICK)
        if name:
            body.append(svg.text("tick", 0.5 * (_x(start) + _x(end)), y, name, "middle"))
    return body


def _borders(starts: Sequence[float], y: float) -> list[str]:
    """Shaft angles of the borders, those left out that would overlap."""
    body, free = [], -math.inf
    for at in sorted(starts):
        text = f"{svg.figure(at, 6)}°"
        half = 0.5 * svg.width_of(text, svg.TICK)
        if _x(at) - half >= free:
            body.append(svg.text("tick", _x(at), y, text, "middle"))
            free = _x(at) + half + 0.4
    return body


def displacement(cam: MountedCam) -> tuple[Array, Array]:
    """Shaft angles (n,) from 0 to 360 [deg], joints among them, and displacements there (n,)."""
    motion = Cam.of(cam.design)
    joints = (in_degrees(motion.joints.theta) + cam.phase_deg) % FULL
    shaft = np.union1d(DRAWN, joints)
    theta = (shaft - cam.phase_deg) * DEGREE
    return shaft, motion.derivatives(theta, np.zeros(len(theta), dtype=bool))[0]


def _counted(arcs: Sequence[TimingArc], y: float) -> list[str]:
    """How many followers move at the same time."""
    body = [svg.text("tick", RIGHT, y + 3.4, "followers moving")]
    for arc in arcs:
        for start, end in _spans(arc.start_deg, arc.angle_deg):
            a, b, count = _x(start), _x(end), len(arc.moving)
            kind = "several" if count > 1 else "rest" if count else "ground"
            body.append(svg.box(kind, a, y, b - a, COUNT))
            if svg.width_of(str(count), svg.TICK) + 0.6 < b - a:
                body.append(svg.text("tick", 0.5 * (a + b), y + 3.4, str(count), "middle"))
    return body + _frame(y, COUNT)
