"""What a motion promises at its joints and on the way."""

from __future__ import annotations

import math

import numpy as np

from synthesis.certify.course import HIGHEST_JOIN, Course, Jump
from synthesis.design import Extreme
from synthesis.limits.base import Machine
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE

NAMES = ("displacement", "velocity", "acceleration", "jerk", "snap")
REPORTED = 2  # jumps up to s'' are reported where they are allowed
BACKWARD = 1e-9  # of the lift: travel against the sense of a stretch that counts as none


def joins(course: Course, machine: Machine, continuity: int | None = None) -> list[Extreme]:
    """Continuity: of s everywhere, of the derivatives where it is asked for or promised by splines.

    Args:
        course: the motion. machine: gives the speed.
        continuity: how many derivatives may jump nowhere; None where nothing is asked.
    """
    smooth = np.maximum(_smoothness(course), continuity or 0)
    found = []
    for order in range(min(max(REPORTED, int(smooth.max())), HIGHEST_JOIN) + 1):
        promised = (smooth >= order).nonzero()[0]
        if len(promised):
            asked = continuity is not None and order <= continuity
            found.append(_join(machine, course.worst(order, promised), len(promised), asked=asked))
        if order <= REPORTED and len(promised) < len(smooth):
            others = course.breaches(order, (smooth < order).nonzero()[0])
            if len(others):
                found.append(_jump(machine, course.worst(order, others)))
    return found


def _smoothness(course: Course) -> Array:
    """(n,) how many derivatives promise not to jump at each joint.

    A spline law joins its neighbours as smoothly as it is itself, but for what was asked of it
    there; two of them, as the rougher.
    """
    free = [stretch.free for stretch in course.motion.stretches]
    inner = np.array([math.inf if law is None else law.smoothness for law in free])
    start, end = (
        np.array([math.inf if law is None else law.promised(at_start=first) for law in free])
        for first in (True, False)
    )
    here, there = course.stretch, course.stretch[course.after]
    inside = (here == there) & (course.after > 0)  # a stretch of a whole turn meets itself
    found = np.where(inside, inner[here], np.minimum(end[here], start[there]))
    return np.where(np.isinf(found), 0.0, found)


def _join(machine: Machine, jump: Jump, count: int, *, asked: bool) -> Extreme:
    """The worst of the joints where continuity is promised or asked for."""
    to_wire = machine.rate(jump.order)
    value, bound = abs(jump.size) * to_wire, jump.allowed * to_wire
    finite = math.isfinite(value)
    return Extreme(
        limit=f"{NAMES[jump.order]}_join", value=value if finite else None,
        unit=machine.told(jump.order), angle_deg=jump.angle / DEGREE, bound=bound,
        margin=bound - value if finite else None, width=0.0, holds=value <= bound,
        evidence=f"both sides of {count} joints; bound: 1e-9 of lift/β^{jump.order} and roundings",
        field="continuity" if asked else "program",
    )  # fmt: skip


def _jump(machine: Machine, jump: Jump) -> Extreme:
    """A jump that the chosen law brings with it: reported, not judged."""
    return Extreme(
        limit=f"{NAMES[jump.order]}_jump", value=abs(jump.size) * machine.rate(jump.order),
        unit=machine.told(jump.order), angle_deg=jump.angle / DEGREE, bound=None, margin=None,
        width=0.0, holds=True, evidence="both sides of the joint; no law promises to join here",
        field="program",
    )  # fmt: skip
