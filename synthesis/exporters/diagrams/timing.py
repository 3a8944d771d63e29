"""Timing diagram of a set as SVG: a lane a cam, its follower's displacement over shaft angle (mm).

Under the lanes a strip counts how many followers move at the same time.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from synthesis.design.cam_set import CamSet, MountedCam, TimingArc
from synthesis.design.design import SegmentMotion
from synthesis.exporters.drawing import canvas as svg
from synthesis.exporters.drawing.heading import BOLD, TURNS
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
    body += _angle_axis(bottom)
    title = f"Timing of {cams.name or cams.id}"
    told = "Displacement of every follower over one turn of the shaft, one lane a cam."
    return svg.document(WIDTH, bottom + FOOTER, 1.0, title, told, body)


def _x(degrees: float) -> float:
    return LEFT + (WIDTH - LEFT - RIGHT) * degrees / FULL


def _heading(cams: CamSet) -> list[str]:
    """Two lines, cut where they do not fit."""
    width, count = WIDTH - 2.0 * RIGHT, len(cams.cams)
    told = (
        f"{count} cam{'s' if count > 1 else ''} on one shaft · turns {TURNS[cams.rotation]} at "
        f"{svg.figure(cams.speed_rpm, 6)} rpm · {cams.status} · {cams.id[:8]}"
    )
    name = cams.name.strip() or "Cam set"
    return [
        svg.text("title", RIGHT, 8.0, svg.shortened(name, width, BOLD * svg.TITLE)),
        svg.text("quiet", RIGHT, 13.0, svg.shortened(told, width, svg.LABEL)),
    ]


def _captions(cam: MountedCam, top: float) -> list[str]:
    """What stands to the left of a lane."""
    room, x = LEFT - RIGHT - 3.0, RIGHT
    lines = [
        ("label", cam.name),
        ("tick", f"phase {svg.figure(cam.phase_deg, 6)}°"),
        ("tick", f"z {svg.figure(cam.axial_mm, 6)} mm"),
    ]
    if cam.has_cam:
        lines.insert(1, ("tick", f"stroke {_stroke(cam)}"))
    if cam.follower_direction_deg != UPWARDS_DEG:
        lines.append(("tick", f"follower at {svg.figure(cam.follower_direction_deg, 6)}°"))
    sizes = {"label": svg.LABEL, "tick": svg.TICK}
    return [
        svg.text(kind, x, top + NAMES + 2.4 + 4.1 * k, svg.shortened(told, room, sizes[kind]))
        for k, (kind, told) in enumerate(lines)
    ]


def _stroke(cam: MountedCam) -> str:
    levels = [end for segment in cam.design.motion for end in segment.levels]
    return svg.measured(max(levels) - min(levels), cam.design.spec.follower.travel.unit)


def _nothing(top: float) -> list[str]:
    y = top + NAMES
    return [
        svg.box("rest", LEFT, y, _x(FULL) - LEFT, HEIGHT),
        svg.text("alarm", _x(180.0), y + 0.5 * HEIGHT + 1.0, "nothing fits: no cam", "middle"),
    ]


def _lane(cam: MountedCam, top: float) -> list[str]:
    """Ground, names of segments, the curve, and where the program starts."""
    y = top + NAMES
    segments = [segment for segment in cam.design.motion if segment.angle_deg > 0.0]
    body = [
        svg.box("rest", _x(start), y, _x(end) - _x(start), HEIGHT)
        for segment in segments
        if segment.kind == "dwell"
        for start, end in _spans(cam, segment)
    ]
    body += [svg.line("grid", _x(a), y, _x(a), y + HEIGHT) for a in range(30, 360, 30)]
    body += [
        svg.line("border", _x(at), y - 3.6, _x(at), y + HEIGHT + 1.2)
        for at in (wrap_turn(s.start_deg + cam.phase_deg) for s in segments)
    ]
    body += [svg.line("axis", LEFT, y + h, _x(FULL), y + h) for h in (0.0, HEIGHT)]
    body += [svg.line("axis", _x(a), y, _x(a), y + HEIGHT) for a in (0.0, FULL)]
    body += _names(cam, segments, y - 1.4)
    body += _borders(cam, segments, y + HEIGHT + 4.2)
    return [*body, *_curve(cam, y), *_start(cam, y)]


def _spans(cam: MountedCam, segment: SegmentMotion) -> list[tuple[float, float]]:
    """Shaft angles that a segment extends over; two spans where it runs over the turn's end."""
    start = wrap_turn(segment.start_deg + cam.phase_deg)
    end = start + segment.angle_deg
    if end <= FULL + 1e-9:
        return [(start, min(end, FULL))]
    return [(start, FULL), (0.0, end - FULL)]


def _names(cam: MountedCam, segments: Sequence[SegmentMotion], y: float) -> list[str]:
    """What the segments do, where there is room; split ones are named in the longer part."""
    body = []
    for segment in segments:
        start, end = max(_spans(cam, segment), key=lambda span: span[1] - span[0])
        angle = f"{svg.figure(segment.angle_deg, 6)}°"
        texts = [f"{segment.kind} {angle}", segment.kind, segment.kind[:1].upper()]
        told = svg.fitting(texts, _x(end) - _x(start) - 0.8, svg.TICK)
        if told:
            body.append(svg.text("tick", 0.5 * (_x(start) + _x(end)), y, told, "middle"))
    return body


def _borders(cam: MountedCam, segments: Sequence[SegmentMotion], y: float) -> list[str]:
    """Shaft angles of the borders, those left out that would overlap."""
    body, free = [], -math.inf
    for at in sorted(wrap_turn(segment.start_deg + cam.phase_deg) for segment in segments):
        text = f"{svg.figure(at, 6)}°"
        half = 0.5 * svg.width_of(text, svg.TICK)
        if _x(at) - half >= free:
            body.append(svg.text("tick", _x(at), y, text, "middle"))
            free = _x(at) + half + 0.4
    return body


def _curve(cam: MountedCam, y: float) -> list[str]:
    """The displacement, in a scale of its own."""
    shaft, s = displacement(cam)
    low, high = float(s.min()), float(s.max())
    scale = (HEIGHT - 2.0 * PAD) / (high - low)
    across = LEFT + (WIDTH - LEFT - RIGHT) * shaft / FULL
    return [svg.path("line curve", svg.steps(across, y + HEIGHT - PAD - scale * (s - low), 3))]


def displacement(cam: MountedCam) -> tuple[Array, Array]:
    """Shaft angles (n,) from 0 to 360 [deg], joints among them, and displacements there (n,)."""
    motion = Cam.of(cam.design)
    joints = (in_degrees(motion.joints.theta) + cam.phase_deg) % FULL
    shaft = np.union1d(DRAWN, joints)
    theta = (shaft - cam.phase_deg) * DEGREE
    return shaft, motion.derivatives(theta, np.zeros(len(theta), dtype=bool))[0]


def _start(cam: MountedCam, y: float) -> list[str]:
    """A mark where the program starts."""
    at = _x(wrap_turn(cam.phase_deg))
    foot = y + HEIGHT
    return [
        svg.line("phase", at, y - 3.6, at, foot + 1.2),
        svg.arrow_head("start", at, foot, 0.5 * math.pi, 2.6),
    ]


def _counted(arcs: Sequence[TimingArc], top: float) -> list[str]:
    """How many followers move at the same time."""
    y = top
    body = [svg.text("tick", RIGHT, y + 3.4, "followers moving")]
    for arc in arcs:
        end = arc.start_deg + arc.angle_deg
        spans = [(arc.start_deg, min(end, FULL)), (0.0, end - FULL)]
        for a, b in spans:
            if b <= a:
                continue
            kind = "several" if len(arc.moving) > 1 else "rest" if arc.moving else "ground"
            body.append(svg.box(kind, _x(a), y, _x(b) - _x(a), COUNT))
            told, middle = str(len(arc.moving)), 0.5 * (_x(a) + _x(b))
            if svg.width_of(told, svg.TICK) + 0.6 < _x(b) - _x(a):
                body.append(svg.text("tick", middle, y + 3.4, told, "middle"))
    body += [svg.line("axis", LEFT, y + h, _x(FULL), y + h) for h in (0.0, COUNT)]
    return body + [svg.line("axis", _x(a), y, _x(a), y + COUNT) for a in (0.0, FULL)]


def _angle_axis(bottom: float) -> list[str]:
    body = []
    for degrees in range(0, 361, 30):
        body.append(svg.line("axis", _x(degrees), bottom, _x(degrees), bottom + 1.2))
        body.append(svg.text("tick", _x(degrees), bottom + 4.4, f"{degrees}", "middle"))
    middle = 0.5 * (LEFT + WIDTH - RIGHT)
    return [*body, svg.text("label", middle, bottom + 9.2, "Shaft angle, degrees", "middle")]
