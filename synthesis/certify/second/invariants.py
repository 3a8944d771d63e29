"""What every cam must satisfy besides its limits, measured again: size and motion."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import reduce
from typing import Any, Final

from flint import arb

from synthesis.catalogue.fields import ends
from synthesis.catalogue.followers.base import base_gap, paths
from synthesis.certify.second import Remeasured
from synthesis.certify.second.exact_design import ExactDesign, remeasured, satisfies
from synthesis.certify.second.exact_motion import (
    MotionPiece,
    coefficient,
    degree,
    hull,
    jump,
    middle_of,
)
from synthesis.design.design import Extreme
from synthesis.units import DEGREE

DERIVATIVES: Final = ("displacement", "velocity", "acceleration", "jerk", "snap")
AT_JUNCTION: Final = 1e-9  # of a junction that is named by its angle in degrees [rad]
AT_REST: Final = "from the output link at rest"  # how a dimension is measured
SIZE_ROUNDING: Final = 1e-12  # relative, of a dimension computed from the size
JUMP_ROUNDING: Final = 1e-9  # relative, of both sides of a junction, and of a table's rows
FINEST_PART: Final = 2.0**-14  # of a segment: the search for backward travel bisects no further


def measure_invariant(design: ExactDesign, extreme: Extreme) -> Remeasured:
    """The second measurement of a line that is no claim of a limit."""
    name = extreme.limit
    if name.startswith("prime_circle_angle"):
        return _prime_circle_angle(design, extreme)
    if name.endswith(("_join", "_jump")):
        return _junction(design, extreme)
    if name.endswith("_required"):
        return _end_state(design, extreme)
    if name == "base_radius_positive":
        base, allowed = _base_radius(design), SIZE_ROUNDING * _cam_size(design)
        return _beside(extreme, base, AT_REST, allowed, holds=bool(base > 0))
    along = {"table_deviation": _table_deviation, "overshoot": _overshoot}
    return along.get(name, _dimension)(design, extreme)


def _beside(
    extreme: Extreme,
    value: arb,
    how: str,
    allowed: arb | None = None,
    *,
    holds: bool | None = None,
    angle: float | None = None,
) -> Remeasured:
    """A value beside the certificate's.

    They agree if both verdicts are the same and, where ``allowed`` is given, the values differ by
    no more than that. The verdict is ``holds``, or else that the value is at most the line's bound.
    """
    low, high = value.lower(), value.upper()
    if holds is None and extreme.bound is not None:
        holds = satisfies(low, high, extreme.bound, 1)
    agrees = None if holds is None else holds == extreme.holds
    if allowed is not None:
        near = extreme.value is not None and abs(value - arb(extreme.value)) <= allowed
        agrees = agrees and bool(near)
    return remeasured(extreme, low, high, holds, agrees, how, angle)


def _base_radius(design: ExactDesign) -> arb:
    """Base radius of the first flank, or under a face [mm]."""
    link = design.link
    if link.face is not None:
        (x, y), (nx, ny) = link.face.at, link.face.normal
        return arb(x * nx + y * ny)
    x, y = link.tips[0].at
    first = design.machine.follower.flanks[0]
    return arb(x * x + y * y).sqrt() - first.side * first.distance


def _cam_size(design: ExactDesign) -> arb:
    """A length of the order of the cam's size, to which rounding of dimensions is relative [mm]."""
    gap = abs(base_gap(design.machine.follower))
    return abs(_base_radius(design)) + 2 * arb(gap)


def _prime_circle_angle(design: ExactDesign, extreme: Extreme) -> Remeasured:
    """The pressure angle at rest where the traced curve is nearest to the axis."""
    path = extreme.limit.removeprefix("prime_circle_angle").removeprefix("_")
    trace = paths(design.machine.follower)[path]
    stroke = design.design.resolved_spec.stroke()
    there = design.motion.highest if trace.nearest_displacement(stroke) > 0.0 else arb(0)
    angle = abs(design.value_at_rest("pressure_angle", path, there)) / degree()
    return _beside(extreme, angle, "at rest on the prime circle", arb(SIZE_ROUNDING * 90.0))


def _dimension(design: ExactDesign, extreme: Extreme) -> Remeasured:
    """A dimension against the range that was asked for: from the output link if that has it."""
    stated = design.design.dimensions.get(f"{extreme.limit}_{extreme.unit}")
    pivot, cam_size = design.link.pivot, _cam_size(design)
    allowed = SIZE_ROUNDING * cam_size
    spec: Any = design.design.resolved_spec
    low, high = ends(reduce(getattr, extreme.field.split("/"), spec))
    if extreme.limit == "base_radius":
        value, how = _base_radius(design), AT_REST
    elif extreme.limit.startswith("room_for_"):
        # across the base circle; of a shaft's hub 7/4 of the shaft and a quarter of an inch
        value, how, high = 2 * _base_radius(design), AT_REST, math.inf
        if extreme.limit == "room_for_shaft":
            value = (value - arb("6.35")) * 4 / 7
    elif extreme.limit == "centre_distance" and pivot is not None:
        value = (pivot[0] ** 2 + pivot[1] ** 2) ** 0.5
        how = AT_REST
    elif stated is not None:
        value, how, allowed = arb(stated), "stated by the design itself", arb(0)
    else:
        return remeasured(extreme)
    # both judges round: the value itself, and what it may miss its range by
    scale = arb(180) if extreme.unit == "deg" else abs(value).max(cam_size)
    missed = (low - value).max(value - high)
    holds = bool(missed <= 2 * SIZE_ROUNDING * scale)
    return _beside(extreme, value, how, allowed, holds=holds)


def _junction(design: ExactDesign, extreme: Extreme) -> Remeasured:
    """The jump at the junction that the certificate names as the worst."""
    order = DERIVATIVES.index(extreme.limit.rpartition("_")[0])
    here = [abs(jump(*pair, order)) for pair in junctions_at(design, extreme.angle_deg)]
    if not here:
        return remeasured(extreme)
    size, angle = here[0] * design.rate(order), extreme.angle_deg
    how = "one-sided values at the junction"
    if extreme.bound is not None:
        return _beside(extreme, size, how, angle=angle)
    allowed = arb(JUMP_ROUNDING * abs(extreme.value or 0.0))
    return _beside(extreme, size, how, allowed, holds=extreme.holds, angle=angle)


def junctions_at(
    design: ExactDesign, angle_deg: float
) -> Iterator[tuple[MotionPiece, MotionPiece]]:
    """The pieces that meet at a cam angle."""
    for before, after in design.motion.junctions():
        angle = before.angle_at(before.law.high)
        if abs(float(angle) - angle_deg * DEGREE) <= AT_JUNCTION:
            yield before, after


def _end_state(design: ExactDesign, extreme: Extreme) -> Remeasured:
    """Deviation from the required velocity or acceleration that the certificate names."""
    order = DERIVATIVES.index(extreme.limit.removesuffix("_required"))
    _, index, end = extreme.field.split("/")
    segment = design.design.curve.segments[int(index)]
    pieces = design.motion.pieces_of([int(index)])
    at_start = end == "start"
    wanted = (segment.start_state if at_start else segment.end_state).known[order - 1]
    if wanted is None:
        return remeasured(extreme)
    piece = pieces[0] if at_start else pieces[-1]
    x = piece.law.low if at_start else piece.law.high
    value = coefficient(piece.displacement(x), order) * math.factorial(order)
    miss = abs(value - arb(wanted) * design.from_core) * design.rate(order)
    return _beside(extreme, miss, f"at the {end} of the segment", angle=extreme.angle_deg)


def _table_deviation(design: ExactDesign, extreme: Extreme) -> Remeasured:
    """The largest deviation of the motion from a table's rows."""
    index = int(extreme.field.split("/")[1])
    table = design.design.curve.segments[index].table
    if table is None or extreme.bound is None:
        return remeasured(extreme)
    worst, pieces = arb(0), design.motion.pieces_of([index])
    for x, s in zip(table.x.tolist(), table.s.tolist(), strict=True):
        piece = next(p for p in pieces if p.law.low <= x <= p.law.high)
        value = coefficient(piece.displacement(arb(x)), 0)
        worst = worst.max(abs(value - arb(s) * design.from_core))
    allowed = arb(JUMP_ROUNDING * extreme.bound)
    return _beside(extreme, worst * design.to_wire, "all rows of the table", allowed)


def _overshoot(design: ExactDesign, extreme: Extreme) -> Remeasured:
    """Backward travel along the segment that the certificate names."""
    index = int(extreme.field.split("/")[1])
    forward = 1 if design.design.curve.segments[index].lift > 0.0 else -1
    each = [_backward_travel(piece, forward) for piece in design.motion.pieces_of([index])]
    least, most = (sum(ends, arb(0)) for ends in zip(*each, strict=True))
    travel = hull(least.lower(), most.upper()) * design.to_wire
    return _beside(extreme, travel, "velocity enclosed in ball arithmetic")


def _backward_travel(piece: MotionPiece, forward: int) -> tuple[arb, arb]:
    """∫ max(−v, 0) over one piece, v in the sense of the segment: lower and upper end.

    Parts on which v has one sign contribute their net displacement. The others are bisected; the
    finest contribute at least their net loss, at most the largest backward velocity times width.
    """
    least, most = arb(0), arb(0)
    open_parts = [(piece.law.low, piece.law.high)]
    finest = (piece.law.high - piece.law.low) * FINEST_PART
    while open_parts:
        low, high = open_parts.pop()
        velocity = _velocity(piece, low, high) * forward
        if velocity.lower() >= 0:
            continue
        width = (high - low) * piece.angle
        if high - low <= finest or velocity.upper() <= 0:
            net = coefficient(piece.displacement(high), 0) - coefficient(piece.displacement(low), 0)
            loss = (-net * forward).max(arb(0))
            least += loss.lower()
            most += loss.upper() if velocity.upper() <= 0 else (-velocity.lower() * width).upper()
            continue
        middle = middle_of(low, high)
        open_parts += [(low, middle), (middle, high)]
    return least, most


def _velocity(piece: MotionPiece, low: arb, high: arb) -> arb:
    """Velocity per radian over a part of a piece, from its Taylor series about the middle."""
    middle = middle_of(low, high)
    here, over = piece.displacement(middle), piece.displacement(hull(low, high))
    reach = arb(0, ((high - low) * piece.angle / 2).upper())
    bend = 2 * coefficient(here, 2) + 3 * reach * coefficient(over, 3)
    return coefficient(here, 1) + reach * bend
