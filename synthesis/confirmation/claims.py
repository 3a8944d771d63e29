"""Limits on the finished cam: the claims that the certificate judges, measured again."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from flint import arb

from synthesis.confirmation.arithmetic import degree
from synthesis.confirmation.course import jump
from synthesis.confirmation.forces import FORCES
from synthesis.confirmation.promises import JUMPS, NAMES, joints_at
from synthesis.confirmation.search import Found
from synthesis.confirmation.subject import NOTHING, Measured, Subject, compared, within
from synthesis.design import Extreme
from synthesis.limits.base import Claim

ORDERS = {"travel": 0, "displacement": 0, "velocity": 1, "acceleration": 2, "jerk": 3}
PLAIN = ("face_radius", "camshaft_torque")  # told as they are measured
NEARBY = 1e-6  # rad


@dataclass(frozen=True, eq=False)
class _Side:
    """One of the two bounds of a claim: the extreme next to it, on the wire."""

    low: arb
    high: arb
    bound: float
    holds: bool | None
    found: Found
    slope: float


def measured(subject: Subject, claim: Claim, extreme: Extreme) -> Measured:
    """What a claim's quantity comes to next to the bound that the certificate names."""
    if claim.quantity in FORCES and subject.burden.rubs:
        return NOTHING  # |sin α| is no power series
    if extreme.value is None and not extreme.holds:
        return _infinite(subject, claim, extreme)
    sides = [
        _side(subject, claim, sign, bound)
        for sign, bound in ((1, claim.upper), (-1, claim.lower))
        if bound is not None
    ]
    told = [side for side in sides if side is not None]
    boxes = sum(side.found.boxes for side in told)
    how = f"branch and bound in balls, {boxes} boxes"
    if not told:  # no hollow, or nothing convex: no value on the wire
        same = extreme.value is None and extreme.holds
        return Measured(None, None, True, same, "no such value anywhere on the cam")
    named = next((side for side in told if side.bound == extreme.bound), told[0])
    verdicts = [side.holds for side in told]
    holds = False if False in verdicts else None if None in verdicts else True
    angle = float(named.found.piece.angle_at(named.found.x) / degree())
    return compared(extreme, named.low, named.high, holds, how, angle, named.slope)


def _infinite(subject: Subject, claim: Claim, extreme: Extreme) -> Measured:
    """Whether a derivative below those of the quantity jumps where the certificate says so."""
    orders = range(ORDERS.get(claim.quantity, 2))
    for before, after in joints_at(subject, extreme.angle_deg):
        scale = abs(before.unit) + abs(after.unit)
        for order in orders:
            step = abs(jump(before, after, order))
            if step > JUMPS * scale / before.angle.min(after.angle) ** order:
                size = float(step * subject.rate(order))
                how = f"infinite: {NAMES[order]} jumps there by {size:.6g}"
                return Measured(None, None, False, True, how, extreme.angle_deg)
    return Measured(None, None, None, None, "said to be infinite, but no jump was found there")


def _side(subject: Subject, claim: Claim, sign: int, bound: float) -> _Side | None:
    """The extreme next to one bound; None where the wire has no value for it."""
    spans = subject.spans(claim)
    found = subject.extreme(claim, spans, sign)
    to_wire = _to_wire(subject, claim)
    met, beyond = to_wire(found.lower * sign), to_wire(found.upper * sign)
    asked = claim.to_wire(bound)
    if asked is None or met is None or beyond is None:
        return None
    asked = float(f"{asked:.15g}")  # as it was asked: without the trace of the way to rad and back
    low, high = met.min(beyond).lower(), met.max(beyond).upper()
    direction = -sign if _falls(subject, claim) else sign
    # what the value does within 1e-6 rad of the angle where it was found, at the end of a piece
    mine = [span for span in spans if span[0].stretch == found.piece.stretch]
    slope = subject.slope(claim, mine, found.x)
    further = to_wire(found.lower * sign + slope * NEARBY)
    steep = 0.0 if further is None else float(abs(further - met)) / NEARBY
    return _Side(low, high, asked, within(low, high, asked, direction), found, steep)


def _falls(subject: Subject, claim: Claim) -> bool:
    """Whether the value on the wire falls as the quantity grows."""
    if claim.quantity == "travel":
        return _sense(subject, claim) < 0
    if claim.quantity == "contact_force":
        return _pressing(subject, claim) < 0
    if claim.quantity != "pitch_curvature":
        return False
    values = [claim.to_wire(k) for k in (-2.0, -1.0, 1.0, 2.0)]  # on one side there are none
    told = [value for value in values if value is not None]
    return told[1] < told[0]


def _sense(subject: Subject, claim: Claim) -> int:
    """+1 where travel is displacement gained, −1 where it is lost."""
    return -1 if subject.design.curve.stretches[claim.stretches[0]].lift < 0.0 else 1


def _to_wire(subject: Subject, claim: Claim) -> Callable[[arb], arb | None]:
    """The map to the wire's unit, in exact numbers."""
    order = ORDERS.get(claim.quantity)
    if claim.limit == "reach":
        return lambda moved: (_at_rest(subject) + moved) / degree()
    if claim.quantity == "travel":
        piece, sense = subject.course.of(claim.stretches)[0], _sense(subject, claim)
        return lambda moved: (moved - piece.level) * subject.to_wire * sense
    if order is not None:
        return lambda rate: rate * subject.rate(order)
    if claim.unit == "deg":
        return lambda angle: angle / degree()
    if claim.quantity in PLAIN:
        return lambda value: value
    if claim.quantity == "contact_force":
        return lambda force: force * _pressing(subject, claim)
    if claim.quantity == "pressure_square":
        stiffness = subject.stiffness
        return lambda value: (value.max(arb(0)) / stiffness).sqrt()
    told: Any = claim.to_wire  # of a length: sums and quotients, which balls have too
    return lambda value: told(value)


def _pressing(subject: Subject, claim: Claim) -> int:
    """Which sense of the contact force presses the flank of a claim."""
    flanks = subject.machine.follower.flanks
    return next(flank.side for flank in flanks if flank.name == claim.flank)


def _at_rest(subject: Subject) -> arb:
    """Angle at the pivot from the line to the axis to the arm or face, at displacement 0 [rad]."""
    link = subject.link
    assert link.pivot is not None
    px, py = link.pivot
    if link.face is not None:
        x, y = link.face.along
    else:
        x, y = link.tips[0].at[0] - px, link.tips[0].at[1] - py
    return arb.atan2((py * x - px * y) * link.turn, -px * x - py * y)
