"""Timing diagram of a set as SVG: a lane a cam, its follower's displacement over shaft angle (mm).

Under the lanes a strip counts how many followers move at the same time.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from synthesis.design.cam_set import CamSet, MountedCam, TimingArc
from synthesis.design.warnings import labelled_status
from synthesis.exporters.diagrams.plot import FULL, Frame
from synthesis.exporters.diagrams.sheet import angle_axis, moving_segments
from synthesis.exporters.drawing import canvas as svg
from synthesis.exporters.drawing.canvas import TURNS, two_lines
from synthesis.exporters.samples.cam import Cam
from synthesis.exporters.samples.sampling import in_degrees
from synthesis.numerics.piecewise import Array
from synthesis.spec.cam_set import UPWARDS_DEG, wrap_turn
from synthesis.units import DEGREE

WIDTH, LEFT, RIGHT = 190.0, 43.0, 8.0  # mm
HEADER, NAMES, HEIGHT, LANE, FOOTER = 22.0, 5.2, 15.0, 27.5, 13.0  # mm
COUNT = 5.0  # height of the strip that counts who moves
PAD = 1.2  # room above and below a curve
SHAFT = Frame(LEFT, 0.0, WIDTH - LEFT - RIGHT, HEIGHT)
DRAWN = np.arange(0.0, FULL + 0.25, 0.5)  # [deg]; a joint of the motion is added to these


def timing_diagram(cams: CamSet) -> bytes:
    """The set's timing diagram."""
    bottom = HEADER + LANE * len(cams.cams)
    body = _heading(cams)
    for lane, cam in enumerate(cams.cams):
        top = HEADER + lane * LANE
        body += _captions(cam, top)
        body += _lane(cam, replace(SHAFT, top=top + NAMES))
    if len(cams.cams) > 1:
        bottom += 1.5
        body += _counted(cams.timing.arcs, replace(SHAFT, top=bottom, height=COUNT))
        bottom += COUNT
    body += angle_axis(replace(SHAFT, top=bottom, height=0.0), name="Shaft angle")
    title = f"Timing of {cams.name or cams.id}"
    text = "Displacement of every follower over one turn of the shaft, one lane a cam."
    return svg.document(WIDTH, bottom + FOOTER, 1.0, title, text, body)


def _edges(strip: Frame) -> list[str]:
    """Those of a strip over the turn."""
    left, right, top, low = strip.left, strip.right, strip.top, strip.bottom
    body = [svg.line("axis", left, y, right, y) for y in (top, low)]
    return body + [svg.line("axis", x, top, x, low) for x in (left, right)]


def _spans(start: float, angle: float) -> list[tuple[float, float]]:
    """Abscissae of an angle from a start on; two pairs where it runs over the turn's end."""
    end = start + angle
    spans = [(start, min(end, FULL))] if end <= FULL + 1e-9 else [(start, FULL), (0.0, end - FULL)]
    return [(SHAFT.x(a), SHAFT.x(b)) for a, b in spans]


def _heading(cams: CamSet) -> list[str]:
    count, name = len(cams.cams), cams.name.strip() or "Cam set"
    status = labelled_status(cams.status, cams.severity)
    text = (
        f"{count} cam{'s' if count > 1 else ''} on one shaft · turns {TURNS[cams.rotation]} at "
        f"{svg.figure(cams.speed_rpm, 6)} rpm · {status} · {cams.id[:8]}"
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
        lines.insert(1, ("tick", f"stroke {svg.stroke(cam.design)}"))
    if cam.follower_direction_deg != UPWARDS_DEG:
        lines.append(("tick", f"follower at {svg.figure(cam.follower_direction_deg, 6)}°"))
    return [
        svg.text(kind, x, top + NAMES + 2.4 + 4.1 * k, svg.shorten(text, room, svg.SIZES[kind]))
        for k, (kind, text) in enumerate(lines)
    ]


def _lane(cam: MountedCam, lane: Frame) -> list[str]:
    """Ground, names of segments, the curve, and where the program starts."""
    top, foot = lane.top, lane.bottom
    if not cam.has_cam:
        middle, y = lane.x(180.0), top + 0.5 * HEIGHT + 1.0
        return [svg.box("rest", LEFT, top, lane.width, HEIGHT),
                svg.text("alarm", middle, y, "nothing fits: no cam", "middle")]  # fmt: skip
    segments = moving_segments(cam.design.motion)
    starts = [wrap_turn(segment.start_deg + cam.phase_deg) for segment in segments]
    body, names = list[str](), list[str]()
    for start, segment in zip(starts, segments, strict=True):
        spans = _spans(start, segment.angle_deg)
        if segment.kind == "dwell":
            body += [svg.box("rest", a, top, b - a, HEIGHT) for a, b in spans]
        # what it does, where there is room: in the longer part where it is split
        a, b = max(spans, key=lambda span: span[1] - span[0])
        angle = f"{svg.figure(segment.angle_deg, 6)}°"
        texts = [f"{segment.kind} {angle}", segment.kind, segment.kind[:1].upper()]
        name = svg.first_fitting(texts, b - a - 0.8, svg.TICK)
        names += [svg.text("tick", 0.5 * (a + b), top - 1.4, name, "middle")] if name else []
    body += [svg.line("grid", lane.x(a), top, lane.x(a), foot) for a in range(30, 360, 30)]
    body += [svg.line("border", lane.x(a), top - 3.6, lane.x(a), foot + 1.2) for a in starts]
    angles = [f"{svg.figure(at, 6)}°" for at in sorted(starts)]
    borders = [lane.x(at) for at in sorted(starts)]
    body += [*_edges(lane), *names, *svg.spaced_texts(borders, angles, foot + 4.2, 0.4)]
    # the displacement, in a scale of its own
    shaft, s = displacement(cam)
    low, high = float(s.min()), float(s.max())
    levels = foot - PAD - (HEIGHT - 2.0 * PAD) / (high - low) * (s - low)
    body.append(svg.path("line curve", svg.steps(lane.x(shaft), levels, 3)))
    at = lane.x(wrap_turn(cam.phase_deg))
    return [
        *body,
        svg.line("phase", at, top - 3.6, at, foot + 1.2),
        svg.arrow_head("start", at, foot, 0.5 * math.pi, 2.6),
    ]


def displacement(cam: MountedCam) -> tuple[Array, Array]:
    """Shaft angles (n,) from 0 to 360 [deg], joints among them, and displacements there (n,)."""
    motion = Cam.of(cam.design)
    joints = (in_degrees(motion.joints.theta) + cam.phase_deg) % FULL
    shaft = np.union1d(DRAWN, joints)
    theta = (shaft - cam.phase_deg) * DEGREE
    return shaft, motion.derivatives(theta, np.zeros(len(theta), dtype=bool))[0]


def _counted(arcs: Sequence[TimingArc], strip: Frame) -> list[str]:
    """How many followers move at the same time."""
    y = strip.top + 3.4
    body = [svg.text("tick", RIGHT, y, "followers moving")]
    for arc in arcs:
        count = len(arc.moving)
        kind = "several" if count > 1 else "rest" if count else "ground"
        for a, b in _spans(arc.start_deg, arc.angle_deg):
            body.append(svg.box(kind, a, strip.top, b - a, strip.height))
            if svg.width_of(str(count), svg.TICK) + 0.6 < b - a:
                body.append(svg.text("tick", 0.5 * (a + b), y, str(count), "middle"))
    return body + _edges(strip)
