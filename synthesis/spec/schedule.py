"""The program's segments placed side by side on the cam, with the states at their junctions.

A state required on one side of a junction holds on both. Where none is required it is that of the
neighbour whose law has one of its own; a law that matches its neighbours (a boundary polynomial)
rests where the neighbour has none, and between two splines the state is part of the answer.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import accumulate, pairwise
from typing import Any

from pydantic_core import PydanticCustomError

from synthesis.catalogue.laws.base import extremes
from synthesis.catalogue.motion import ANY_STATE, EndState, PlacedSegment
from synthesis.errors.quantities import figure, in_field
from synthesis.numerics.piecewise import Piecewise
from synthesis.spec.program import Segment
from synthesis.units import FULL_TURN, MotionUnits

ANGLE_SUM_TOLERANCE_DEG = 1e-6  # by which angles may miss a turn: they are typed with six decimals
CLOSURE = 1e-9  # of the stroke: rounding of a sum of lifts that closes after one turn
SAME = 1e-9  # of lift/β^k: two values of s^(k) that differ by rounding
BACKWARD = 1e-9  # of g': motion backwards that is rounding
SAME_TURN = 0.01  # relative: what is left of a turn's sum after numbers were rounded to 2 digits
# Sums of angles over a turn in other units, what they are called, and what a turn is in degrees.
OTHER_TURNS = (
    (FULL_TURN, "rad", "radians", "a radian is 57.2958°"),
    (1.0, "turn", "parts of a turn", "a turn has 360°"),
)
MOST_IN_RADIANS = 1.6  # a pressure angle: π/2 rad is more than any, 1.6° less than any in use
AT_REST = EndState(0.0, 0.0)


def check_turn(program: Sequence[Segment], limits: Sequence[Any] = ()) -> None:
    """Refuse a program that does not go round once; limits that share its mistake are named."""
    turn = math.fsum(segment.degrees for segment in program)
    missing = round(360.0 - turn, 9)
    if abs(missing) <= ANGLE_SUM_TOLERANCE_DEG:
        return
    for whole, unit, called, words in OTHER_TURNS:
        if abs(turn - whole) <= SAME_TURN * whole:
            first = program[0].degrees
            raise PydanticCustomError(
                "program_angles",
                "The angles of program sum to {turn}, not 360°: these look like {unit}. Write "
                "{right} instead of {first} at program/0/angle_deg, and so on: {words}{also}.",
                {"value": round(turn, 9), "turn": f"{turn:.9g}", "unit": called,
                 "first": f"{first:.9g}",
                 "words": words, "right": _degrees(first, unit), "also": _also(limits, unit)},
            )  # fmt: skip
    # The longest dwell is the easiest to change, if it stays one.
    dwells = [(each.degrees, i) for i, each in enumerate(program) if each.kind == "dwell"]
    longest, at = max(dwells, default=(0.0, -1))
    where = f": write {longest + missing:.9g} instead of {longest:.9g} at program/{at}/angle_deg"
    added = f', or add {{"kind": "dwell", "angle_deg": {missing:.9g}}}'
    raise PydanticCustomError(
        "program_angles",
        "The angles of program sum to {turn}°, not 360°. {verb} {difference}°{where}{added}.",
        {"value": round(turn, 9), "turn": f"{turn:.9g}", "difference": f"{abs(missing):.9g}",
         "verb": "Add" if missing > 0.0 else "Remove",
         "where": where if at >= 0 and longest + missing > 0.0 else "",
         "added": added if missing > 0.0 else ""},
    )  # fmt: skip


def _degrees(value: float, unit: str) -> str:
    """An angle of another unit, rounded as it was: 90 for 1.57 rad."""
    return figure(in_field(value, unit, "deg"))


def _also(limits: Sequence[Any], unit: str) -> str:
    """The pressure angles that are in radians as the program is, in words."""
    if unit != "rad":
        return ""
    small = {
        f"limits/{i}/{name}": value
        for i, limit in enumerate(limits) if limit.kind == "pressure_angle"
        for name, value in limit.model_dump().items()
        if isinstance(value, float) and value < MOST_IN_RADIANS
    }  # fmt: skip
    return "".join(f"; {_degrees(small[at], unit)} at {at} too" for at in small)


def check_closed(
    rest: float, stroke: float, units: MotionUnits, program: Sequence[Segment] = ()
) -> None:
    """Refuse a program that does not end where it began, or does not move at all.

    ``rest``: the sum of its lifts. ``stroke``: its largest displacement less its least.
    """
    if abs(rest) > CLOSURE * stroke:
        unit, left = units.travel.unit, units.to_wire(rest)
        raise PydanticCustomError(
            "program_lift",
            "The follower ends {rest} {unit} away from where it began. "
            "{closing}: the lifts of rises and returns have to sum to zero.",
            {"value": float(f"{left:.9g}"), "rest": f"{left:.9g}", "unit": unit,
             "closing": _closing(program, left, unit)},
        )  # fmt: skip
    if stroke == 0.0:
        raise PydanticCustomError(
            "program_still",
            "The follower never moves: program holds no rise and no return. Add both.",
        )


def _closing(program: Sequence[Segment], rest: float, unit: str) -> str:
    """The lift that would close a program, or the move that it lacks; ``rest`` on the wire."""
    field, kind = f"lift_{unit}", "return" if rest > 0.0 else "rise"
    # The last move that way goes farther by what is left.
    for i, segment in reversed([*enumerate(program)]):
        lift = segment.free_fields().get(field)
        if segment.kind == kind and isinstance(lift, float):
            return f"Write {lift + abs(rest):.9g} instead of {lift:.9g} at program/{i}/{field}"
    if {segment.kind for segment in program} <= {"dwell", "rise", "return"}:
        return f'Add {{"kind": "{kind}", "angle_deg": …, "{field}": {abs(rest):.9g}}}'
    return f"Change the last move by {abs(rest):.9g} {unit}"


def check_units(program: Sequence[Segment], limits: Sequence[Any], unit: str, moves: str) -> None:
    """Refuse lifts and limits in another unit, mm or deg, than the follower moves in.

    ``moves``: how the follower does, for people, as in "the … follower slides".
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
        for given in limit.units - {unit}:
            raise PydanticCustomError(
                "limit_unit_does_not_suit",
                "limits/{position} ({limit}) is given in {given}, but {moves}. "
                "Give the limit's field with {unit} in its name.",
                {"position": position, "limit": limit.kind, "given": given,
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
    """The segments placed on the cam, their laws run between the states at the junctions.

    They start at angles (n+1,), the last one ending one [rad], and displacements (n,) [mm]. Splines
    are made at least so smooth. Refused is a state that a law or another state contradicts.
    """
    found = [
        segment.place(i, angles[i], angles[i + 1] - angles[i], levels[i], units)
        for i, segment in enumerate(program)
    ]
    turning = [i for i, segment in enumerate(found) if segment.angle > 0.0]
    junctions = [*pairwise(turning), (turning[-1], turning[0])]
    # A state required of one free law is required of its neighbour too.
    for before, after in junctions:
        _share_states(found, before, after, units)
    # Laws that match their neighbours take over the states next to them, in the program's order.
    _match_neighbours(program, found, junctions)
    # Now all given laws are known: they must have the required states, and free laws must be able
    # to. Where accelerations differ, a free law shares the velocity alone with its neighbour.
    for i in turning:
        _check_states(program[i], found[i], units)
    for before, after in junctions:
        _join(program, found, before, after, units)
    return tuple(
        segment
        if segment.free is None or segment.free.smoothness >= least_smoothness
        else replace(segment, free=replace(segment.free, smoothness=least_smoothness))
        for segment in found
    )


def _share_states(found: list[PlacedSegment], before: int, after: int, units: MotionUnits) -> None:
    left, right = found[before], found[after]
    if _differ(left.end_state.velocity, right.start_state.velocity, 1, left, right):
        raise _error(
            units, "states_differ", (left.end_state.velocity, 1), after, "start",
            "{per_s} at the end of program/{other} meets {theirs} {per_s} at the start of "
            "program/{segment}: the velocity would jump. Ask for the same on both sides, or on "
            "one side only",
            other=before, theirs=(right.start_state.velocity, 1),
        )  # fmt: skip
    end_state = left.end_state.filled_from(right.start_state)
    start_state = right.start_state.filled_from(left.end_state)
    if left.free is not None and end_state is not left.end_state:
        found[before] = replace(left, end_state=end_state)
    if right.free is not None and start_state is not right.start_state:
        found[after] = replace(found[after], start_state=start_state)


def _match_neighbours(
    program: Sequence[Segment], found: list[PlacedSegment], junctions: Sequence[tuple[int, int]]
) -> None:
    after, before = dict(junctions), {b: a for a, b in junctions}
    waiting = {i for i in after if _takes_over(program[i])}
    for i in sorted(waiting):
        start, end = found[before[i]].end_state, found[after[i]].start_state
        if before[i] not in waiting:
            start = _own_state(found[before[i]], start, at_start=False)
        if after[i] not in waiting:
            end = _own_state(found[after[i]], end, at_start=True)
        held = found[i].start_state.filled_from(start), found[i].end_state.filled_from(end)
        found[i] = program[i].with_end_states(found[i], *held)
        waiting.remove(i)


def _takes_over(segment: Segment) -> bool:
    """Whether its law takes over derivatives from its neighbours."""
    return segment.own_law is not None and segment.own_law.inherited_derivatives > 0


def _own_state(segment: PlacedSegment, otherwise: EndState, *, at_start: bool) -> EndState:
    """s' and s'' that the law of a segment has at one end; ``otherwise`` where it is free."""
    if segment.law is None:
        return otherwise
    if segment.law.is_constant:
        return AT_REST
    _, v, a = segment.end_derivatives(2, at_start=at_start)
    return EndState(float(v), float(a))


def _differ(
    one: float | None, other: float | None, order: int, left: PlacedSegment, right: PlacedSegment
) -> bool:
    if one is None or other is None:
        return False
    scale = max(abs(s.scale) / s.angle**order for s in (left, right))
    return abs(one - other) > SAME * max(scale, abs(one), abs(other))


def _join(
    program: Sequence[Segment],
    found: list[PlacedSegment],
    before: int,
    after: int,
    units: MotionUnits,
) -> None:
    """Required velocities must be the neighbour's; how smoothly a free law can join follows."""
    left, right = found[before], found[after]
    ours = left.end_state.filled_from(_own_state(left, ANY_STATE, at_start=False))
    theirs = right.start_state.filled_from(_own_state(right, ANY_STATE, at_start=True))
    _check_forward(left, "end", ours.filled_from(theirs), units)
    _check_forward(right, "start", theirs.filled_from(ours), units)
    late = right.start_state.velocity is None
    required = left.end_state.velocity is not None or not late
    if required and _differ(ours.velocity, theirs.velocity, 1, left, right):
        at, end, other = (before, "end", after) if late else (after, "start", before)
        value, its = (ours, theirs) if late else (theirs, ours)
        raise _error(
            units, "state_not_neighbours", (value.velocity, 1), at, end,
            "{per_s} at the {end} of program/{segment} does not meet program/{other} ({law}), "
            "which has {theirs} {per_s} there. Leave the velocity out, or put a rise or return "
            "beside it that meets it: one with the law spline or polynomial_5",
            other=other, theirs=(its.velocity, 1), law=program[other].law_name,
        )  # fmt: skip
    if _differ(ours.acceleration, theirs.acceleration, 2, left, right):
        for i, (at_start, at_end) in ((before, (4, 1)), (after, (1, 4))):
            free = found[i].free
            if free is not None:
                first, last = free.end_continuity
                shared = min(first, at_start), min(last, at_end)
                found[i] = replace(found[i], free=replace(free, end_continuity=shared))


def _check_forward(segment: PlacedSegment, end: str, state: EndState, units: MotionUnits) -> None:
    """A free law that may not move backwards cannot have a state that makes it."""
    if segment.free is None:
        return
    required = segment.end_state if end == "end" else segment.start_state
    if state.velocity is None and required.acceleration is not None:
        raise _error(
            units, "acceleration_alone", (required.acceleration, 2), segment.index, end,
            "{per_s2} at the {end} of program/{segment} is asked for without a velocity, between "
            "two splines. Give a velocity with it, or leave both out",
        )  # fmt: skip
    if segment.free.overshoot:
        return
    forward = 1.0 if segment.lift > 0.0 else -1.0
    scale = abs(segment.lift) / segment.angle
    v, a = state.velocity, required.acceleration
    outward = forward if end == "start" else -forward
    back = v is not None and v * forward < -SAME * scale
    still = v is not None and abs(v) <= SAME * scale
    if back or (still and a is not None and a * outward < 0.0):
        value, words = ((v, 1), "{per_s} ") if back else ((a, 2), "{per_s2} and no velocity ")
        raise _error(
            units, "state_backwards", value, segment.index, end,
            words + "at the {end} of program/{segment} makes the {kind} move backwards. Turn its "
            "sign, or allow overshoot in the segment's law", kind=segment.kind,
        )  # fmt: skip


def _check_states(segment: Segment, placed: PlacedSegment, units: MotionUnits) -> None:
    """A given law must have the states required of it, and not move backwards because of them."""
    required = any(v is not None for v in placed.start_state.known + placed.end_state.known)
    if placed.law is None or not (_takes_over(segment) or required):
        return
    for end, state in (("start", placed.start_state), ("end", placed.end_state)):
        own = _own_state(placed, ANY_STATE, at_start=end == "start")
        for order, unit in ((1, "{per_s}"), (2, "{per_s2}")):
            wanted, has = state.known[order - 1], own.known[order - 1]
            if _differ(wanted, has, order, placed, placed):
                raise _error(
                    units, "state_not_met", (wanted, order), placed.index, end,
                    unit + " is asked for at the {end} of program/{segment}, but its law {law} "
                    "has {own} " + unit + " there. Laws between rests take equal velocities at "
                    "both ends and no acceleration; polynomial_5, polynomial_7 and spline take "
                    "any state",
                    own=(has, order), law=segment.law_name,
                )  # fmt: skip
    slowest = _slowest(placed.law)
    if slowest < -BACKWARD and not (segment.own_law and segment.own_law.may_reverse):
        raise _error(
            units, "law_backwards", (slowest * placed.lift / placed.angle, 1),
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
    units: MotionUnits,
    name: Any,
    value: tuple[float | None, int],
    segment: int,
    end: str,
    words: str,
    **more: Any,
) -> PydanticCustomError:
    """The error with its wrong value first: a derivative per radian, and its order."""
    per_s, per_s2 = (units.travel.derivative_unit(order) for order in (1, 2))
    context = {"value": value, "segment": segment, "end": end, **more}
    for key, each in context.items():
        if isinstance(each, tuple):
            context[key] = float(f"{units.to_wire(*each):.9g}")
    context |= {"per_s": per_s, "per_s2": per_s2}
    return PydanticCustomError(name, f"{{value}} {words}.", context)
