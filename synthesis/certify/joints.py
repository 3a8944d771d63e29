"""What a motion promises at its joints and on the way."""

from __future__ import annotations

import math

import numpy as np

from synthesis.certify.course import HIGHEST_JOIN, Course, Indices, Jump
from synthesis.design import Extreme
from synthesis.limits.base import Machine
from synthesis.motion import Stretch
from synthesis.units import DEGREE

NAMES = ("displacement", "velocity", "acceleration", "jerk", "snap")
UNITS = ("mm", "mm/s", "mm/s²", "mm/s³", "mm/s⁴")
REPORTED = 2  # jumps up to s'' are reported where they are allowed
BACKWARD = 1e-9  # of the lift: travel against the sense of a stretch that counts as none
BOXES = 8


def joins(course: Course, machine: Machine) -> list[Extreme]:
    """Continuity: of s everywhere, of the derivatives where a spline law promises it."""
    found = []
    for order in range(HIGHEST_JOIN + 1):
        promised = _promised(course, order)
        found += [_join(course, machine, jump) for jump in course.jumps(order, promised)[:1]]
        others = np.setdiff1d(np.arange(course.curve.count), promised)
        if order <= REPORTED:
            found += [_jump(machine, jump) for jump in course.breaches(order, others)[:1]]
    return found


def _promised(course: Course, order: int) -> Indices:
    """Joints at which a derivative may not jump.

    A spline law joins its neighbours as smoothly as it is itself; two of them, as the rougher.
    """
    if order == 0:
        return np.arange(course.curve.count)
    smoothness = {s.index: s.free.smoothness for s in course.motion.stretches if s.free is not None}
    sides = np.array([smoothness.get(int(index), math.inf) for index in course.stretch])
    rougher = np.minimum(sides, np.roll(sides, -1))
    return np.flatnonzero((rougher >= order) & np.isfinite(rougher))


def _join(course: Course, machine: Machine, jump: Jump) -> Extreme:
    """The worst of the promised joints."""
    to_wire = machine.omega**jump.order
    value, bound = abs(jump.size) * to_wire, jump.allowed * to_wire
    finite = bool(np.isfinite(value))
    return Extreme(
        limit=f"{NAMES[jump.order]}_join", value=value if finite else None,
        unit=UNITS[jump.order], angle_deg=jump.angle / DEGREE, bound=bound,
        margin=bound - value if finite else None, width=0.0, holds=value <= bound,
        evidence=f"both sides of {course.curve.count} joints; bound: 1e-9 of lift/β^{jump.order}",
        field="program",
    )  # fmt: skip


def _jump(machine: Machine, jump: Jump) -> Extreme:
    """A jump that the chosen law brings with it: reported, not judged."""
    return Extreme(
        limit=f"{NAMES[jump.order]}_jump", value=abs(jump.size) * machine.omega**jump.order,
        unit=UNITS[jump.order], angle_deg=jump.angle / DEGREE, bound=None, margin=None,
        width=0.0, holds=True, evidence="both sides of the joint; no law promises to join here",
        field="program",
    )  # fmt: skip


def overshoot(course: Course) -> list[Extreme]:
    """Travel backwards on spline stretches that must not overshoot; the worst of them."""
    found = [
        _backward(course, stretch)
        for stretch in course.motion.stretches
        if stretch.free is not None and not stretch.free.overshoot and stretch.angle > 0.0
    ]
    return sorted(found, key=lambda extreme: extreme.margin or 0.0)[:1]


def _backward(course: Course, stretch: Stretch) -> Extreme:
    """∫ of the backward velocity over one stretch, from boxes."""
    pieces = course.pieces([stretch.index])
    breaks = course.curve.breaks
    piece = np.repeat(pieces, BOXES)
    nth = np.tile(np.arange(BOXES), len(pieces)) / BOXES
    step = (breaks[piece + 1] - breaks[piece]) / BOXES
    lo = breaks[piece] + nth * (BOXES * step)
    s, v = course.jets.models(piece, lo, lo + step, 1)
    high, low, *_ = v.extremes()
    back = -low if stretch.lift > 0.0 else high
    travel = 2.0 * np.abs(0.5 * step) * np.maximum(back + v.rem, 0.0)
    net = np.maximum(-np.sign(stretch.lift) * 2.0 * s.c1 - 2.0 * s.rem, 0.0)
    upper, value = float(np.sum(travel)), float(np.sum(net))
    bound = BACKWARD * abs(stretch.lift)
    return Extreme(
        limit="overshoot", value=value, unit="mm",
        angle_deg=float(lo[np.argmax(travel)]) / DEGREE, bound=bound, margin=bound - value,
        width=upper - value, holds=upper <= bound,
        evidence=f"velocity enclosed on {len(lo)} boxes of stretch {stretch.index}; "
        "bound: 1e-9 of the lift", field=f"program/{stretch.index}/law/overshoot",
    )  # fmt: skip
