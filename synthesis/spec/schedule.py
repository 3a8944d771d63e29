"""The program's segments placed side by side on the cam: what each takes from its neighbours.

At a joint, what one side asks for holds for both. What neither asks for is the one-sided value of
the neighbour whose law has its own; a law that takes over (a boundary polynomial) rests where the
neighbour has none to give, and two splines share what is left, as part of the answer.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import accumulate, pairwise
from typing import Any

from pydantic_core import PydanticCustomError

from synthesis.catalogue.laws.characteristics import extremes
from synthesis.catalogue.motion import ANY_STATE, EndState, PlacedSegment
from synthesis.numerics.piecewise import Piecewise
from synthesis.spec.program import Segment
from synthesis.units import FULL_TURN, MotionUnits

ANGLE_SUM_TOLERANCE_DEG = 1e-6
SAME = 1e-9  # of lift/β^k: two values of s^(k) that agree
BACKWARD = 1e-9  # of g': motion backwards that is rounding
AT_REST = EndState(0.0, 0.0)


def check_turn(program: Sequence[Segment]) -> None:
    """Refuse a program that does not go round once.

    Raises:
        PydanticCustomError: with the sum of its angles, and what to add or remove.
    """
    turn = math.fsum(segment.degrees for segment in program)
    if abs(turn - 360.0) > ANGLE_SUM_TOLERANCE_DEG:
        raise PydanticCustomError(
            "program_angles",
            "The angles of program sum to {turn}°, not 360°. "
            "{verb} {difference}°, or add a dwell.",
            {"turn": round(turn, 9), "verb": "Add" if turn < 360.0 else "Remove",
             "difference": round(abs(360.0 - turn), 9)},
        )  # fmt: skip


def check_units(program: Sequence[Segment], limits: Sequence[Any], unit: str, moves: str) -> None:
    """Refuse lifts and limits in another unit than the follower moves in.

    Args:
        unit: mm or deg. moves: how the follower does, for people, as in "the … follower slides".

    Raises:
        PydanticCustomError: with the first of them, and the unit to give it in.
    """
    for position, segment in enumerate(program):
        for given in sorted(segment.units - {unit}):
            raise PydanticCustomError(
                "lift_does_not_suit",
                "program/{position} gives its lift in {given}, but {moves}. "
                "Give lift_{unit} instead of lift_{given}.",
                {"position": position, "given": given, "moves": moves, "unit": unit},
            )
    for position, limit in enumerate(limits):
        if limit.travel_unit not in (None, unit):
            raise PydanticCustomError(
                "limit_unit_does_not_suit",
                "limits/{position} ({limit}) is given in {given}, but {moves}. "
                "Give the limit's field with {unit} in its name.",
                {"position": position, "limit": limit.kind, "given": limit.travel_unit,
                 "moves": moves, "unit": unit},
            )  # fmt: skip


def angles_of(program: Sequence[Segment]) -> list[float]:
    """(n+1,) cam angles where the segments start and where the last one ends [rad]."""
    degrees = [segment.degrees for segment in program]
    turn = math.fsum(degrees)
    found = [FULL_TURN * at / turn for at in accumulate(degrees, initial=0.0)]
    found[-1] = FULL_TURN
    return found


def placed(
    program: Sequence[Segment],
    angles: Sequence[float],
    levels: Sequence[float],
    units: MotionUnits,
    least_smoothness: int = 0,
) -> tuple[PlacedSegment, ...]:
    """The segments as segments, laws run between the states that the joints settle.

    Args:
        program: the segments.
        angles: (n+1,) where they start and where the last one ends [rad].
        levels: (n,) displacement at their starts [mm].
        units: turns the wire's displacements and rates into the core's.
        least_smoothness: splines are made at least so smooth.

    Raises:
        PydanticCustomError: a state that a law cannot meet, or two states that contradict.
    """
    found = [
        segment.place(i, angles[i], angles[i + 1] - angles[i], levels[i], units)
        for i, segment in enumerate(program)
    ]
    turning = [i for i, placed_segment in enumerate(found) if placed_segment.angle > 0.0]
    joints = [*pairwise(turning), (turning[-1], turning[0])]
    for before, after in joints:
        _share(found, before, after, units)
    _take_over(program, found, joints)
    for i in turning:
        _check(program, found[i], units)
    for before, after in joints:
        _meet(program, found, before, after, units)
    return tuple(_smoothed(placed_segment, least_smoothness) for placed_segment in found)


def _smoothed(segment: PlacedSegment, least: int) -> PlacedSegment:
    if segment.free is None or segment.free.smoothness >= least:
        return segment
    return replace(segment, free=replace(segment.free, smoothness=least))


def _share(found: list[PlacedSegment], before: int, after: int, units: MotionUnits) -> None:
    """What one free side of a joint asks for is asked of the other too."""
    left, right = found[before], found[after]
    if _differ(left.end_state.velocity, right.start_state.velocity, 1, left, right):
        assert left.end_state.velocity is not None
        assert right.start_state.velocity is not None
        raise _error(
            units, "states_differ", units.to_wire(left.end_state.velocity, 1), after, "start",
            "{per_s} at the end of program/{other} meets {theirs} {per_s} at the start of "
            "program/{segment}: the velocity would jump. Ask for the same on both sides, or on "
            "one side only",
            other=before, theirs=units.to_wire(right.start_state.velocity, 1),
        )  # fmt: skip
    at_end, at_start = (
        left.end_state.filled_from(right.start_state),
        right.start_state.filled_from(left.end_state),
    )
    if left.free is not None and at_end is not left.end_state:
        found[before] = replace(left, end_state=at_end)
    if right.free is not None and at_start is not right.start_state:
        found[after] = replace(found[after], start_state=at_start)


def _take_over(
    program: Sequence[Segment], found: list[PlacedSegment], joints: Sequence[tuple[int, int]]
) -> None:
    """Laws that take their neighbours' values do so, in the order of the program."""
    after, before = dict(joints), {b: a for a, b in joints}
    waiting = {i for i in after if program[i].matched_derivatives}
    for i in sorted(waiting):
        waiting_still = {k for k in waiting if k >= i}
        start = _given(found[before[i]], found[before[i]].end_state, at_end=True,
                       heard=before[i] not in waiting_still)  # fmt: skip
        end = _given(found[after[i]], found[after[i]].start_state, at_end=False,
                     heard=after[i] not in waiting_still)  # fmt: skip
        placed = found[i]
        found[i] = program[i].with_end_states(
            placed, placed.start_state.filled_from(start), placed.end_state.filled_from(end)
        )


def _given(neighbour: PlacedSegment, asked: EndState, *, at_end: bool, heard: bool) -> EndState:
    """s' and s'' that a neighbour brings to the joint: its law's own, else what is asked of it."""
    if neighbour.law is None or not heard:
        return asked
    return _own(neighbour, at_end=at_end)


def _own(segment: PlacedSegment, *, at_end: bool) -> EndState:
    """s' and s'' just inside one end of a settled segment."""
    if segment.law is not None and segment.law.is_constant:
        return AT_REST
    _, v, a = segment.end_derivatives(2, at_start=not at_end)
    return EndState(float(v), float(a))


def _differ(
    one: float | None, other: float | None, order: int, left: PlacedSegment, right: PlacedSegment
) -> bool:
    if one is None or other is None:
        return False
    scale = max(abs(s.scale) / s.angle**order for s in (left, right))
    return abs(one - other) > SAME * max(scale, abs(one), abs(other))


def _meet(
    program: Sequence[Segment],
    found: list[PlacedSegment],
    before: int,
    after: int,
    units: MotionUnits,
) -> None:
    """Velocities asked for must be the neighbour's; how smoothly a free law can join follows."""
    left, right = found[before], found[after]
    ours = left.end_state.filled_from(ANY_STATE if left.law is None else _own(left, at_end=True))
    theirs = right.start_state.filled_from(
        ANY_STATE if right.law is None else _own(right, at_end=False)
    )
    for i, end in ((before, "end"), (after, "start")):
        both = ours.filled_from(theirs) if end == "end" else theirs.filled_from(ours)
        _forwards(found[i], end, both, units)
    asked = left.end_state.velocity is not None or right.start_state.velocity is not None
    if asked and _differ(ours.velocity, theirs.velocity, 1, left, right):
        late = right.start_state.velocity is None
        at, end, other = (before, "end", after) if late else (after, "start", before)
        value, its = (ours, theirs) if late else (theirs, ours)
        assert value.velocity is not None
        assert its.velocity is not None
        raise _error(
            units, "state_not_neighbours", units.to_wire(value.velocity, 1), at, end,
            "{per_s} at the {end} of program/{segment} does not meet program/{other} ({law}), "
            "which has {theirs} {per_s} there. Leave the velocity out, or put a rise or return "
            "beside it that meets it: one with the law spline or polynomial_5",
            other=other, theirs=units.to_wire(its.velocity, 1), law=program[other].law_name,
        )  # fmt: skip
    if _differ(ours.acceleration, theirs.acceleration, 2, left, right):
        found[before], found[after] = _rougher(left, 1), _rougher(right, 0)


def _rougher(segment: PlacedSegment, end: int) -> PlacedSegment:
    """A free law that shares the velocity and no more at one end."""
    if segment.free is None:
        return segment
    joins = (1, segment.free.end_continuity[1]) if end == 0 else (segment.free.end_continuity[0], 1)
    return replace(segment, free=replace(segment.free, end_continuity=joins))


def _forwards(segment: PlacedSegment, end: str, state: EndState, units: MotionUnits) -> None:
    """A free law that may not move backwards cannot have a state that makes it."""
    asked = segment.end_state if end == "end" else segment.start_state
    if segment.free is None:
        return
    if state.velocity is None and asked.acceleration is not None:
        raise _error(
            units, "acceleration_alone", units.to_wire(asked.acceleration, 2), segment.index, end,
            "{per_s2} at the {end} of program/{segment} is asked for without a velocity, between "
            "two splines. Give a velocity with it, or leave both out",
        )  # fmt: skip
    if segment.free.overshoot:
        return
    forward = 1.0 if segment.lift > 0.0 else -1.0
    scale = abs(segment.lift) / segment.angle
    v, a = state.velocity, asked.acceleration
    outward = forward if end == "start" else -forward
    words = "at the {end} of program/{segment} makes the {kind} move backwards"
    remedy = ". Turn its sign, or allow overshoot in the segment's law"
    if v is not None and v * forward < -SAME * scale:
        raise _error(
            units, "state_backwards", units.to_wire(v, 1), segment.index, end,
            "{per_s} " + words + remedy,
            kind=segment.kind,
        )  # fmt: skip
    if v is not None and a is not None and abs(v) <= SAME * scale and a * outward < 0.0:
        raise _error(
            units, "state_backwards", units.to_wire(a, 2), segment.index, end,
            "{per_s2} and no velocity " + words + remedy, kind=segment.kind,
        )  # fmt: skip


def _check(program: Sequence[Segment], placed: PlacedSegment, units: MotionUnits) -> None:
    """A given law must have the states asked of it, and not move backwards because of them."""
    segment = program[placed.index]
    asked_of = placed.start_state.known + placed.end_state.known
    if placed.law is None or not (
        segment.matched_derivatives or any(v is not None for v in asked_of)
    ):
        return
    for end, asked in (("start", placed.start_state), ("end", placed.end_state)):
        own = _own(placed, at_end=end == "end")
        for order, unit in ((1, "{per_s}"), (2, "{per_s2}")):
            wanted, has = asked.known[order - 1], own.known[order - 1]
            if _differ(wanted, has, order, placed, placed):
                assert wanted is not None
                assert has is not None
                raise _error(
                    units, "state_not_met", units.to_wire(wanted, order), placed.index, end,
                    unit + " is asked for at the {end} of program/{segment}, but its law {law} "
                    "has {own} " + unit + " there. Laws between rests take equal velocities at "
                    "both ends and no acceleration; polynomial_5, polynomial_7 and spline take "
                    "any state",
                    own=units.to_wire(has, order), law=segment.law_name,
                )  # fmt: skip
    least = _slowest(placed.law)
    if least < -BACKWARD and not segment.may_reverse:
        raise _error(
            units, "law_backwards", units.to_wire(least * placed.lift / placed.angle, 1),
            placed.index, "law",
            "{per_s} is reached on program/{segment}: between these states its law {law} moves the "
            "{kind} backwards. Ask for other velocities, another angle or lift, or take "
            "polynomial_5 or spline with overshoot allowed",
            law=segment.law_name, kind=placed.kind,
        )  # fmt: skip


@lru_cache(maxsize=1024)
def _slowest(law: Piecewise) -> float:
    return extremes(law, 1)[1]


def _error(
    units: MotionUnits, name: Any, value: float, segment: int, end: str, words: str, **more: Any
) -> PydanticCustomError:
    """The error with its wrong value first; ``segment`` and ``end`` say where it stands."""
    rounded: dict[str, Any] = {
        k: _digits(v) if isinstance(v, float) else v for k, v in more.items()
    }
    names = {"per_s": units.travel.derivative_unit(1), "per_s2": units.travel.derivative_unit(2)}
    context = {"value": _digits(value), "segment": segment, "end": end, **rounded, **names}
    return PydanticCustomError(name, f"{{value}} {words}.", context)


def _digits(value: float) -> float:
    return float(f"{value:.9g}")
