"""What every cam must keep besides its limits: its size, its joints, its states, its tables."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Final

from flint import arb

from synthesis.confirmation.arithmetic import degree, hull, term
from synthesis.confirmation.course import Piece, jump
from synthesis.confirmation.subject import NOTHING, Measured, Subject, within
from synthesis.design import Extreme
from synthesis.units import DEGREE

NAMES: Final = ("displacement", "velocity", "acceleration", "jerk", "snap")
AT_JOINT: Final = 1e-9  # rad: a joint named by an angle in degrees
SIZES: Final = 1e-12  # relative: what a dimension may differ from its range by rounding
JUMPS: Final = 1e-9  # relative: what a jump's two sides may have lost by rounding
PARTS: Final = 2**14  # of a stretch, in which travel backwards is looked for


def base_radius_positive(subject: Subject, extreme: Extreme) -> Measured:
    """The base radius, from the link at displacement 0."""
    base, holds = _base_radius(subject), None
    holds = True if base > 0 else False if base < 0 else None
    near = bool(abs(base - arb(extreme.value or 0.0)) <= SIZES * _reach(subject))
    agrees = near and holds == extreme.holds
    return Measured(base.lower(), base.upper(), holds, agrees, "from the link at rest")


def _reach(subject: Subject) -> arb:
    """A length of the cam's size, which its dimensions are rounded by [mm]."""
    gap = abs(subject.machine.follower.base_gap)
    return abs(_base_radius(subject)) + 2 * arb(gap)


def prime_circle_angle(subject: Subject, extreme: Extreme) -> Measured:
    """The pressure angle at rest where the traced curve is nearest to the axis."""
    path = extreme.limit.removeprefix("prime_circle_angle").removeprefix("_")
    trace = subject.machine.follower.paths[path]
    stroke = subject.design.numbered.stroke()
    there = subject.course.highest if trace.nearest(stroke) > 0.0 else arb(0)
    angle = abs(subject.value("pressure_angle", path, there)) / degree()
    low, high = angle.lower(), angle.upper()
    holds, told = within(low, high, 90.0, 1), extreme.value or 0.0
    near = bool(abs(angle - arb(told)) <= SIZES * 90.0)
    how = "at rest on the prime circle"
    return Measured(low, high, holds, near and holds == extreme.holds, how)


def _base_radius(subject: Subject) -> arb:
    """Of the first flank, or under a face [mm]."""
    link = subject.link
    if link.face is not None:
        (x, y), (nx, ny) = link.face.at, link.face.normal
        return arb(x * nx + y * ny)
    x, y = link.tips[0].at
    first = subject.machine.follower.flanks[0]
    return arb(x * x + y * y).sqrt() - first.side * first.distance


def dimension(subject: Subject, extreme: Extreme) -> Measured:
    """A dimension against its range, from the link where the link has it."""
    measure = _DIMENSIONS.get(extreme.limit)
    if measure is None:
        told = subject.design.dimensions.get(f"{extreme.limit}_{extreme.unit}")
        given = told is not None and told == extreme.value
        how = "a number of the design itself"
        return (
            NOTHING if told is None else Measured(arb(told), arb(told), extreme.holds, given, how)
        )
    value = measure(subject)
    if value is None:
        return NOTHING
    allowed = SIZES * (arb(180) if extreme.unit == "deg" else _reach(subject))
    low, high = value.lower(), value.upper()
    near = extreme.value is not None and abs(value - arb(extreme.value)) <= allowed
    return Measured(low, high, extreme.holds, bool(near), "from the link at rest")


def _pivot_distance(subject: Subject) -> arb | None:
    pivot = subject.link.pivot
    return None if pivot is None else (pivot[0] ** 2 + pivot[1] ** 2) ** 0.5


_DIMENSIONS: dict[str, Callable[[Subject], arb | None]] = {
    "base_radius": _base_radius,
    "centre_distance": _pivot_distance,
}


def join(subject: Subject, extreme: Extreme) -> Measured:
    """The jump at the joint that the certificate found worst, of exact numbers."""
    order = NAMES.index(extreme.limit.rpartition("_")[0])
    here = [abs(jump(*pair, order)) for pair in joints_at(subject, extreme.angle_deg)]
    if not here:
        return NOTHING
    size = here[0] * subject.rate(order)
    low, high = size.lower(), size.upper()
    how = "both sides of the joint"
    if extreme.bound is None:
        told = extreme.value or 0.0
        near = bool(abs(size - arb(told)) <= JUMPS * abs(told))
        return Measured(low, high, extreme.holds, near, how, extreme.angle_deg)
    holds = within(low, high, extreme.bound, 1)
    return Measured(low, high, holds, holds == extreme.holds, how, extreme.angle_deg)


def joints_at(subject: Subject, angle_deg: float) -> Iterator[tuple[Piece, Piece]]:
    """The pieces that meet at a cam angle."""
    for before, after in subject.course.joints():
        angle = before.angle_at(before.law.high)
        if abs(float(angle) - angle_deg * DEGREE) <= AT_JOINT:
            yield before, after


def asked(subject: Subject, extreme: Extreme) -> Measured:
    """How far the state that the certificate found missed most is missed."""
    order = NAMES.index(extreme.limit.removesuffix("_asked"))
    _, index, end = extreme.field.split("/")
    stretch = subject.design.curve.stretches[int(index)]
    pieces = subject.course.of([int(index)])
    at_start = end == "start"
    wanted = (stretch.at_start if at_start else stretch.at_end).known[order - 1]
    if wanted is None or extreme.bound is None:
        return NOTHING
    piece = pieces[0] if at_start else pieces[-1]
    x = piece.law.low if at_start else piece.law.high
    value = term(piece.displacement(x), order) * math.factorial(order)
    miss = abs(value - arb(wanted) * subject.from_core) * subject.rate(order)
    low, high = miss.lower(), miss.upper()
    holds = within(low, high, extreme.bound, 1)
    agrees = None if holds is None else holds == extreme.holds
    return Measured(low, high, holds, agrees, f"at the {end} of the segment", extreme.angle_deg)


def table(subject: Subject, extreme: Extreme) -> Measured:
    """The largest distance of the motion from a table's rows."""
    index = int(extreme.field.split("/")[1])
    readings = subject.design.curve.stretches[index].readings
    if readings is None or extreme.bound is None:
        return NOTHING
    worst = arb(0)
    for x, s in zip(readings.x.tolist(), readings.s.tolist(), strict=True):
        piece = next(p for p in subject.course.of([index]) if p.law.low <= x <= p.law.high)
        miss = term(piece.displacement(arb(x)), 0) - arb(s) * subject.from_core
        worst = worst.max(abs(miss))
    worst = worst * subject.to_wire
    low, high = worst.lower(), worst.upper()
    holds = within(low, high, extreme.bound, 1)
    near = extreme.value is not None and bool(
        abs(worst - arb(extreme.value)) <= JUMPS * arb(extreme.bound)
    )
    return Measured(low, high, holds, near and holds == extreme.holds, "at every row of the table")


def overshoot(subject: Subject, extreme: Extreme) -> Measured:
    """Travel backwards along the stretch that the certificate names, between two ends."""
    index = int(extreme.field.split("/")[1])
    forward = 1 if subject.design.curve.stretches[index].lift > 0.0 else -1
    least = most = arb(0)
    for piece in subject.course.of([index]):
        low, high = _backwards(piece, forward)
        least, most = least + low, most + high
    least, most = least * subject.to_wire, most * subject.to_wire
    holds = within(least.lower(), most.upper(), extreme.bound or 0.0, 1)
    agrees = None if holds is None else holds == extreme.holds
    how = "velocity enclosed in balls; both ends of what it can be"
    return Measured(least.lower(), most.upper(), holds, agrees, how)


def _backwards(piece: Piece, forward: int) -> tuple[arb, arb]:
    """Travel backwards along one piece: proven ends."""
    least, most = arb(0), arb(0)
    open_parts = [(piece.law.low, piece.law.high)]
    fine = (piece.law.high - piece.law.low) / PARTS
    while open_parts:
        low, high = open_parts.pop()
        speed = _speed(piece, low, high) * forward
        if speed.lower() >= 0:
            continue
        width = (high - low) * piece.angle
        if high - low <= fine or speed.upper() <= 0:
            net = term(piece.displacement(high), 0) - term(piece.displacement(low), 0)
            fall = (-net * forward).max(arb(0))
            least += fall.lower()
            most += fall.upper() if speed.upper() <= 0 else (-speed.lower() * width).upper()
            continue
        middle = ((low + high) / 2).mid()
        open_parts += [(low, middle), (middle, high)]
    return least, most


def _speed(piece: Piece, low: arb, high: arb) -> arb:
    """Velocity per radian over a part of a piece, from its Taylor series about the middle."""
    middle = ((low + high) / 2).mid()
    here, over = piece.displacement(middle), piece.displacement(hull(low, high))
    reach = arb(0, ((high - low) * piece.angle / 2).upper())
    return term(here, 1) + reach * (2 * term(here, 2) + 3 * reach * term(over, 3))


def promise(extreme: Extreme) -> Callable[[Subject, Extreme], Measured]:
    """What measures a line of the certificate that is no claim of a limit."""
    name = extreme.limit
    if name.startswith("prime_circle_angle"):
        return prime_circle_angle
    if name.endswith(("_join", "_jump")):
        return join
    if name.endswith("_asked"):
        return asked
    return {
        "base_radius_positive": base_radius_positive,
        "table_deviation": table,
        "overshoot": overshoot,
    }.get(name, dimension)
