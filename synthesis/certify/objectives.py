"""The value of an objective on the finished cam, enclosed."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from synthesis.certify.course import Course
from synthesis.certify.energy import rms
from synthesis.certify.loaded import cuts, measurable
from synthesis.certify.quantities import QUANTITIES, Size, enclose_all, infinite
from synthesis.limits.base import Machine
from synthesis.motion import Motion
from synthesis.numerics.enclosure import Enclosed, Question


def measure(quantity: str, motion: Motion, machine: Machine, size: Size) -> Enclosed:
    """The value of an objective on the finished cam, in core units.

    Args:
        quantity: ``prime_radius``; the peaks ``acceleration`` and ``jerk`` over the turn;
            ``rms_acceleration`` and ``rms_jerk``; ``pressure_slope``, the peak of |tan α| over
            rises and returns; ``drive_force``, the peak of the force along the motion.
        motion, machine, size: the finished cam.
    """
    size = tuple(float(value) for value in size)
    return MEASURES[quantity](motion, machine, size)


def _prime_radius(motion: Motion, machine: Machine, size: Size) -> Enclosed:
    # in the unit of the norm that stands for it, as bounds are: the objective maps it back
    value = machine.follower.value_of(machine.follower.radius(size))
    return Enclosed(value, value * (1.0 - 1e-15), value * (1.0 + 1e-15), 0.0)


def _peak(name: str) -> Callable[[Motion, Machine, Size], Enclosed]:
    def peak(motion: Motion, machine: Machine, size: Size) -> Enclosed:
        course = Course(motion)
        everywhere = [s.index for s in course.motion.stretches if s.angle > 0.0]
        jump = infinite(QUANTITIES[name], course, everywhere)
        if jump is not None:
            return Enclosed(math.inf, math.inf, math.inf, jump.angle)
        return _largest(name, course, machine, size, everywhere)

    return peak


def _largest(
    name: str,
    course: Course,
    machine: Machine,
    size: Size,
    stretches: Sequence[int],
    path: str = "",
) -> Enclosed:
    """Largest |quantity| on these stretches."""
    question = Question(course.pieces(stretches), 0.0, 0.0)
    (answer,) = enclose_all([(QUANTITIES[name], path)], course, machine, size, [question])
    found = answer.extreme
    if answer.side > 0:
        return found
    return Enclosed(-found.value, -found.upper, -found.lower, found.angle)


def _pressure_slope(motion: Motion, machine: Machine, size: Size) -> Enclosed:
    course = Course(motion)
    moving = [s.index for s in course.motion.stretches if s.angle > 0.0 and s.kind != "dwell"]
    if not moving:
        return Enclosed(0.0, 0.0, 0.0, 0.0)
    each = [
        _largest("pressure_angle", course, machine, size, moving, path)
        for path in machine.follower.paths
    ]
    found = max(each, key=lambda one: one.upper)
    ends = (found.value, found.lower, found.upper)
    value, lower, upper = (
        math.tan(end) if abs(end) < 0.5 * math.pi else math.copysign(math.inf, end) for end in ends
    )
    return Enclosed(value, lower, upper, found.angle)


def _rms(name: str) -> Callable[[Motion, Machine, Size], Enclosed]:
    def measured(motion: Motion, machine: Machine, size: Size) -> Enclosed:
        course = Course(motion)
        everywhere = [s.index for s in course.motion.stretches if s.angle > 0.0]
        jump = infinite(QUANTITIES[name], course, everywhere)
        if jump is not None:
            return Enclosed(math.inf, math.inf, math.inf, jump.angle)
        return rms(course.jets, QUANTITIES[name].order)

    return measured


def _drive_force(motion: Motion, machine: Machine, size: Size) -> Enclosed:
    """The largest drive in the sense in which it presses; pushed both ways, the largest |G| [N]."""
    load = machine.load
    if load is None:
        return Enclosed(math.inf, math.inf, math.inf, 0.0)  # nobody has told what it is
    course = Course(motion, cuts(machine))
    quantity = measurable("drive_force", "", course, machine, size)
    everywhere = [s.index for s in course.motion.stretches if s.angle > 0.0]
    jump = infinite(quantity, course, everywhere)
    if jump is not None:
        return Enclosed(math.inf, math.inf, math.inf, jump.angle)
    lower, upper = (-math.inf, 0.0) if load.side > 0 else (0.0, math.inf)
    ends = (0.0, 0.0) if load.both_ways else (lower, upper)
    question = Question(course.pieces(everywhere), *ends)
    (answer,) = enclose_all([(quantity, "")], course, machine, size, [question])
    found = answer.extreme
    if answer.side > 0:
        return found
    return Enclosed(-found.value, -found.upper, -found.lower, found.angle)


MEASURES: dict[str, Callable[[Motion, Machine, Size], Enclosed]] = {
    "prime_radius": _prime_radius,
    "velocity": _peak("velocity"),
    "acceleration": _peak("acceleration"),
    "jerk": _peak("jerk"),
    "rms_acceleration": _rms("acceleration"),
    "rms_jerk": _rms("jerk"),
    "pressure_slope": _pressure_slope,
    "drive_force": _drive_force,
}
