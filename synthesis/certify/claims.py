"""Every limit's claims, measured on the finished cam."""

from __future__ import annotations

import math
from collections.abc import Sequence

from synthesis.certify.course import Course, Jump
from synthesis.certify.dimensions import standing, stands
from synthesis.certify.joints import NAMES, joins
from synthesis.certify.loaded import cuts, measurable
from synthesis.certify.overshoot import overshoot
from synthesis.certify.quantities import (
    Measurable,
    Size,
    corner,
    enclose_all,
    infinite,
)
from synthesis.certify.residual import left_ringing
from synthesis.certify.simple import apart, crosses, rounding, rounds_axis
from synthesis.certify.states import states
from synthesis.certify.tables import tables
from synthesis.design import Extreme
from synthesis.followers.flank import Flank
from synthesis.limits.base import Claim, Limit, Machine
from synthesis.motion import Motion
from synthesis.numerics.enclosure import Answer, Enclosed, Question
from synthesis.units import DEGREE

ENOUGH, FINE = 1e-10, 1e-14  # relative widths of enclosures, the second of a single value
NOT_A_NUMBER = "the motion or the size holds something that is not a finite number"


def certify(
    motion: Motion,
    machine: Machine,
    size: tuple[float, ...],
    limits: Sequence[Limit],
    continuity: int | None = None,
) -> list[Extreme]:
    """How far every limit is used on the finished cam, proven for every cam angle.

    Args:
        motion: the settled motion. machine: the machine around it.
        size: the follower's size variables [mm]. limits: what was asked.
        continuity: how many derivatives of s may jump nowhere; None where nothing is asked.

    Returns:
        one extreme per claim of the limits, in their order, then what every cam must satisfy:
        a base radius, a follower that stands beside the cam, a profile that does not cross
        itself, a motion that is continuous, has the states asked of it, follows its tables and
        keeps the promises of its spline laws.
    """
    size = tuple(float(value) for value in size)
    course = Course(motion, cuts(machine))
    asked = [claim for limit in limits for claim in limit.claims(motion.stretches, machine)]
    asked += standing(motion, machine, size)
    claims = [claim for claim in asked if course.has(claim.stretches)]
    if not (course.finite and all(math.isfinite(value) for value in size)):
        return [_not_a_number(machine), *(_unknown(claim, 0.0, NOT_A_NUMBER) for claim in claims)]
    found, clear = _judged(claims, course, machine, size)
    cam = [*stands(course, machine, size), *crosses(course, machine, size, clear)]
    promised = [
        *joins(course, machine, continuity),
        *states(course, machine),
        *tables(course, machine),
    ]
    return [
        *found,
        *cam,
        *promised,
        *overshoot(course, machine),
    ]


def _judged(
    claims: Sequence[Claim], course: Course, machine: Machine, size: Size
) -> tuple[list[Extreme], list[Flank]]:
    """The extremes of all claims, in their order, and flanks that go round the axis well apart.

    All quantities are enclosed at once.
    """
    angled = [claim for claim in claims if not claim.rings]
    subjects = list(dict.fromkeys(map(_subject, angled)))
    measured = [
        (measurable(name, flank, course, machine, size), path) for name, path, flank in subjects
    ]
    which = [subjects.index(_subject(claim)) for claim in angled]
    jumps = [
        _jump(measured[k][0], claim, course, machine, size)
        for k, claim in zip(which, angled, strict=True)
    ]
    questions = [
        _question(course, claim, k)
        for k, claim, jump in zip(which, angled, jumps, strict=True)
        if jump is None
    ]
    rounds = rounding(course, machine)
    asked, distances = rounds_axis(course, rounds, len(measured))
    answers = iter(
        enclose_all([*measured, *distances], course, machine, size, [*questions, *asked])
    )
    each = iter(
        _extreme(claim, next(answers)) if jump is None else _infinite(claim, jump, machine)
        for claim, jump in zip(angled, jumps, strict=True)
    )
    found = [_ringing(claim, course) if claim.rings else next(each) for claim in claims]
    return found, apart(rounds, answers)


def _ringing(claim: Claim, course: Course) -> Extreme:
    """The largest amplitude where one of the runs ends."""
    found = [left_ringing(course, ring) for ring in claim.rings]
    worst = max(found, key=lambda each: each.upper)
    how = "the train's equation by Taylor series with a bound of what they miss"
    if len(found) > 1:
        told = (f"{_wire(claim, each.value):.6g} at {_degrees(each.angle):.6g}°" for each in found)
        how = f"{how}; {', '.join(told)}"
    return _bounded(claim, worst, above=True, evidence=how)


def _wire(claim: Claim, value: float) -> float:
    told = claim.to_wire(value)
    return math.nan if told is None else told


def _subject(claim: Claim) -> tuple[str, str, str]:
    """What a claim is about: quantity, path, flank."""
    return claim.quantity, claim.path, claim.flank


def _jump(
    quantity: Measurable, claim: Claim, course: Course, machine: Machine, size: Size
) -> Jump | None:
    """What makes the quantity of a claim infinite."""
    jump = infinite(quantity, course, claim.stretches, claim.part)
    return jump or corner(quantity, course, machine, size, claim)


def _question(course: Course, claim: Claim, function: int) -> Question:
    """What a claim asks of its part of the turn."""
    pieces, spans = (
        (course.pieces(claim.stretches), None)
        if claim.part is None
        else course.spans(claim.stretches, claim.part)
    )
    return Question(
        pieces,
        -math.inf if claim.lower is None else claim.lower,
        math.inf if claim.upper is None else claim.upper,
        spans,
        function,
        FINE if claim.exact else ENOUGH,
    )


def _extreme(claim: Claim, answer: Answer) -> Extreme:
    """One claim, in the wire's units."""
    above = answer.side > 0
    bound = claim.upper if above else claim.lower
    if bound is None or not math.isfinite(answer.extreme.width):
        why = f"no enclosure was found in {answer.boxes} boxes"
        return _unknown(claim, answer.extreme.angle, why)
    evidence = f"branch and bound with Taylor models, {answer.boxes} boxes"
    return _bounded(claim, answer.extreme, above=above, evidence=evidence)


def _bounded(claim: Claim, found: Enclosed, *, above: bool, evidence: str) -> Extreme:
    """What was enclosed beside its bound, in the wire's units."""
    bound = claim.upper if above else claim.lower
    assert bound is not None
    value, limit, *ends = map(claim.to_wire, (found.value, bound, found.lower, found.upper))
    holds = found.upper <= bound if above else found.lower >= bound
    width, margin = 0.0, None
    if value is not None and limit is not None:
        within = found.value <= bound if above else found.value >= bound
        margin = math.copysign(abs(limit - value), 1.0 if within else -1.0)
        known = [value, *(end for end in ends if end is not None)]
        width = max(known) - min(known)
        holds = holds and margin >= width
    return Extreme(
        limit=claim.limit, value=value, unit=claim.unit, angle_deg=_degrees(found.angle),
        bound=_tidy(limit), margin=margin, width=width, holds=holds,
        evidence=evidence, field=claim.field,
    )  # fmt: skip


def _infinite(claim: Claim, jump: Jump, machine: Machine) -> Extreme:
    """A claim that a jump breaks."""
    what, unit = NAMES[jump.order], machine.told(jump.order)
    size = abs(jump.size) * machine.rate(jump.order)
    evidence = f"{what} jumps by {size:.6g} {unit} at {_degrees(jump.angle):.6g}°"
    return _unknown(claim, jump.angle, evidence)


def _unknown(claim: Claim, angle: float, evidence: str) -> Extreme:
    """A claim that has no finite value."""
    bound = claim.upper if claim.upper is not None else claim.lower
    return Extreme(
        limit=claim.limit, value=None, unit=claim.unit, angle_deg=_degrees(angle),
        bound=_tidy(None if bound is None else claim.to_wire(bound)), margin=None, width=0.0,
        holds=False, evidence=evidence, field=claim.field,
    )  # fmt: skip


def _not_a_number(machine: Machine) -> Extreme:
    return Extreme(
        limit="motion", value=None, unit=machine.told(0), angle_deg=0.0, bound=None,
        margin=None, width=0.0, holds=False, evidence=NOT_A_NUMBER, field="program",
    )  # fmt: skip


def _tidy(bound: float | None) -> float | None:
    """A bound as it was asked for: without the last digit's trace of the way to rad and back."""
    return None if bound is None else float(f"{bound:.15g}")


def _degrees(angle: float) -> float:
    return angle / DEGREE
