"""The certificate of a finished cam: every limit, and what every cam must satisfy, line by line."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

from synthesis.catalogue.followers.kinematics import Flank
from synthesis.catalogue.limits.base import Claim, Limit, Machine, all_claims
from synthesis.catalogue.motion import Motion
from synthesis.certify.motion_checks import DERIVATIVES, check_follower, check_motion
from synthesis.certify.piecewise_motion import Jump, PiecewiseMotion
from synthesis.certify.quantities import (
    MeasuredCam,
    Subject,
    infinite_at_corner,
    infinite_by_jump,
    quantity_of,
)
from synthesis.certify.residual_vibration import residual_amplitude
from synthesis.certify.self_intersection import (
    check_self_intersection,
    clear_flanks,
    roller_clearances,
)
from synthesis.design.design import Extreme
from synthesis.numerics.enclosure import Enclosure, Extremum, ExtremumQuery
from synthesis.units import DEGREE

RELATIVE_WIDTH: Final = 1e-10  # of an enclosure that suffices
EXACT_WIDTH: Final = 1e-14  # the same where the claim is about a single value: rounding only
NOT_FINITE: Final = "the motion or the size contains a value that is not a finite number"


def certify(
    motion: Motion,
    machine: Machine,
    size: tuple[float, ...],
    limits: Sequence[Limit],
    continuity: int | None = None,
) -> list[Extreme]:
    """How far every limit is used on the finished cam, proven for every cam angle.

    ``size`` in mm; ``continuity``: order up to which all derivatives of s must be continuous.

    Returns:
        one line per claim of the limits, in their order; then what every cam must satisfy: a
        positive base radius, a follower driven outwards, a profile that does not intersect itself,
        a continuous motion with the required end states and tables, and what its spline laws
        promise.
    """
    cam = MeasuredCam.of(motion, machine, size)
    pieces = cam.motion
    claims = all_claims(limits, motion.segments, machine, cam.size)
    claims = [claim for claim in claims if len(pieces.pieces_of(claim.segments))]
    if not (pieces.is_finite and all(math.isfinite(value) for value in cam.size)):
        unit = machine.derivative_unit(0)
        motionless = Claim("motion", "", (), None, None, unit, float, "program")
        return [_unproven(claim, 0.0, NOT_FINITE) for claim in (motionless, *claims)]
    lines, clear = _check_claims(claims, cam)
    return [
        *lines,
        *check_follower(cam),
        *check_self_intersection(cam, clear),
        *check_motion(pieces, machine, continuity),
    ]


def _check_claims(claims: Sequence[Claim], cam: MeasuredCam) -> tuple[list[Extreme], list[Flank]]:
    """A line per claim, in their order, and the flanks that run round the axis clearly.

    All quantities of the cam angle are enclosed together: they share their boxes.
    """
    # 1. one function for each quantity, path and flank that is claimed about
    numbers, subjects = dict[tuple[str, str, str], int](), list[Subject]()
    lines, questions = dict[int, Extreme](), dict[int, ExtremumQuery]()
    for position, claim in enumerate(claims):
        if claim.vibration:  # about the ends of runs, not about cam angles
            lines[position] = _residual_vibration(claim, cam.motion)
            continue
        number = numbers.setdefault((claim.quantity, claim.path, claim.flank), len(subjects))
        if number == len(subjects):
            subjects.append((quantity_of(claim.quantity, claim.flank, cam), claim.path))
        # 2. claims that a discontinuity makes infinite need no enclosure
        quantity, _ = subjects[number]
        jump = infinite_by_jump(quantity, cam.motion, claim.segments, claim.interval)
        jump = jump or infinite_at_corner(quantity, cam, claim)
        if jump is None:
            questions[position] = _question(cam.motion, claim, number)
        else:
            lines[position] = _infinite(claim, jump, cam.machine)
    # 3. enclose the others, with the clearance of the traced curves' tangents from the axis
    smooth, clearances, clearance_subjects = roller_clearances(cam, len(subjects))
    answers = cam.enclose([*subjects, *clearance_subjects], [*questions.values(), *clearances])
    for position, answer in zip(questions, answers, strict=False):
        lines[position] = _line(claims[position], answer)
    in_order = [lines[position] for position in range(len(claims))]
    return in_order, clear_flanks(smooth, answers[len(questions) :])


def _question(motion: PiecewiseMotion, claim: Claim, function: int) -> ExtremumQuery:
    """The extreme of function number ``function`` that is nearest to the claim's bounds."""
    pieces, spans = (
        (motion.pieces_of(claim.segments), None)
        if claim.interval is None
        else motion.spans_of(claim.segments, claim.interval)
    )
    return ExtremumQuery(
        pieces,
        -math.inf if claim.lower is None else claim.lower,
        math.inf if claim.upper is None else claim.upper,
        spans,
        function,
        EXACT_WIDTH if claim.equality else RELATIVE_WIDTH,
    )


def _residual_vibration(claim: Claim, motion: PiecewiseMotion) -> Extreme:
    """The largest amplitude at the end of one of the claim's runs."""
    amplitudes = [residual_amplitude(motion, run) for run in claim.vibration]
    worst = max(amplitudes, key=lambda each: each.upper)
    evidence = "equation of motion of the follower train by Taylor series, remainder bounded"
    if len(amplitudes) > 1:
        each_run = (
            f"{claim.to_wire(each.value):.6g} at {each.angle / DEGREE:.6g}°" for each in amplitudes
        )
        evidence = f"{evidence}; {', '.join(each_run)}"
    return _bounded(claim, worst, above=True, evidence=evidence)


def _line(claim: Claim, answer: Extremum) -> Extreme:
    """The line of an enclosed claim, in wire units."""
    above = answer.side > 0
    bound = claim.upper if above else claim.lower
    if bound is None or not math.isfinite(answer.enclosure.width):
        why = f"no enclosure was found in {answer.boxes} boxes"
        return _unproven(claim, answer.enclosure.angle, why)
    evidence = f"branch and bound with Taylor models, {answer.boxes} boxes"
    return _bounded(claim, answer.enclosure, above=above, evidence=evidence)


def _bounded(claim: Claim, found: Enclosure, *, above: bool, evidence: str) -> Extreme:
    """An enclosure beside its bound, in wire units.

    A line holds only if the enclosure is on the allowed side both before and after conversion,
    where the margin must not be below the width.
    """
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
        limit=claim.limit, value=value, unit=claim.unit, angle_deg=found.angle / DEGREE,
        bound=_rounded(limit), margin=margin, width=width, holds=holds,
        evidence=evidence, field=claim.field,
    )  # fmt: skip


def _infinite(claim: Claim, jump: Jump, machine: Machine) -> Extreme:
    """The line of a claim whose quantity is infinite at a discontinuity."""
    what, unit = DERIVATIVES[jump.order], machine.derivative_unit(jump.order)
    size = abs(jump.size) * machine.wire_factor(jump.order)
    evidence = f"{what} jumps by {size:.6g} {unit} at {jump.angle / DEGREE:.6g}°"
    return _unproven(claim, jump.angle, evidence)


def _unproven(claim: Claim, angle: float, evidence: str) -> Extreme:
    """The line of a claim without a finite value."""
    bound = claim.upper if claim.upper is not None else claim.lower
    return Extreme(
        limit=claim.limit, value=None, unit=claim.unit, angle_deg=angle / DEGREE,
        bound=_rounded(None if bound is None else claim.to_wire(bound)), margin=None, width=0.0,
        holds=False, evidence=evidence, field=claim.field,
    )  # fmt: skip


def _rounded(bound: float | None) -> float | None:
    """A bound as the spec states it: 15 digits drop the rounding of a conversion and back."""
    return None if bound is None else float(f"{bound:.15g}")
