"""Velocities and accelerations that segments were asked to begin and end with."""

from __future__ import annotations

from collections.abc import Iterator

from synthesis.certify.course import JOIN_TOLERANCE, Course
from synthesis.certify.joints import NAMES
from synthesis.design import Extreme
from synthesis.limits.base import Machine
from synthesis.motion import Stretch
from synthesis.units import DEGREE


def states(course: Course, machine: Machine) -> list[Extreme]:
    """The state asked for that is missed most, for the velocity and for the acceleration."""
    found = []
    for order in (1, 2):
        misses = list(_misses(course, order))
        if misses:
            worst = max(misses, key=lambda miss: miss[0] / miss[1])
            found.append(_extreme(machine, order, *worst, count=len(misses)))
    return found


def _misses(course: Course, order: int) -> Iterator[tuple[float, float, float, str]]:
    """How far every state is missed, how far it may be, the cam angle, the field of the spec."""
    for stretch in course.motion.stretches:
        asked_of = stretch.at_start.known[order - 1], stretch.at_end.known[order - 1]
        if stretch.angle <= 0.0 or asked_of == (None, None):
            continue
        pieces = course.pieces([stretch.index])
        for end, asked, joint in (
            ("start", stretch.at_start, int(pieces[0]) - 1),
            ("end", stretch.at_end, int(pieces[-1])),
        ):
            wanted = asked.known[order - 1]
            if wanted is None:
                continue
            before, after = course.sides(joint % course.curve.count)
            value = after[order] if end == "start" else before[order]
            angle = stretch.start if end == "start" else stretch.end
            field = f"program/{stretch.index}/{end}"
            yield abs(value - wanted), _allowed(stretch, order, wanted), angle, field


def _allowed(stretch: Stretch, order: int, wanted: float) -> float:
    return JOIN_TOLERANCE * max(abs(stretch.unit) / stretch.angle**order, abs(wanted))


def _extreme(
    machine: Machine,
    order: int,
    miss: float,
    allowed: float,
    angle: float,
    field: str,
    *,
    count: int,
) -> Extreme:
    to_wire = machine.rate(order)
    value, bound = miss * to_wire, allowed * to_wire
    return Extreme(
        limit=f"{NAMES[order]}_asked", value=value, unit=machine.told(order),
        angle_deg=angle / DEGREE, bound=bound, margin=bound - value, width=0.0,
        holds=value <= bound,
        evidence=f"one-sided values at {count} ends of segments; bound: 1e-9 of lift/β^{order}",
        field=field,
    )  # fmt: skip
