"""Claims of the limits on the finished cam, measured again.

The amplitude of a residual vibration is |∫ s'(θ) e^(λθ) dθ| over its run, up to a factor, with the
oscillator's complex eigenvalue λ. For a polynomial
∫ p(y) e^(κy) dy = e^(κy) Σ (−1)^j p^(j)/κ^(j+1), and a sinusoid is two exponentials. What cancels
between the ends of a piece costs some of the 200 bits.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from flint import acb, arb

from synthesis.catalogue.constraints import VibrationBound
from synthesis.catalogue.limits.base import Claim
from synthesis.certify.second import Remeasured
from synthesis.certify.second.exact_design import (
    ANGLE_ROUNDING,
    ExactDesign,
    compare,
    remeasured,
    satisfies,
)
from synthesis.certify.second.exact_motion import LawPiece, Maximum, degree, jump
from synthesis.certify.second.invariants import DERIVATIVES, JUMP_ROUNDING, junctions_at
from synthesis.certify.second.quantities import FORCES, ORDERS
from synthesis.design.design import Extreme


@dataclass(frozen=True, eq=False)
class _Side:
    """The extreme next to one of the bounds of a claim, in wire units."""

    low: arb
    high: arb
    bound: float
    holds: bool | None
    found: Maximum
    blur: float


def measure_claim(design: ExactDesign, claim: Claim, extreme: Extreme) -> Remeasured:
    """The extreme of a claim's quantity next to the bound that the certificate names."""
    if claim.quantity in FORCES and design.load.has_friction:
        return remeasured(extreme)  # |sin α| is no power series
    if extreme.value is None and not extreme.holds:
        return _find_infinity(design, claim, extreme)
    each = [
        _side(design, claim, sign, bound)
        for sign, bound in ((1, claim.upper), (-1, claim.lower))
        if bound is not None
    ]
    sides = [side for side in each if side is not None]
    boxes = sum(side.found.boxes for side in sides)
    how = f"branch and bound in ball arithmetic, {boxes} intervals"
    if not sides:  # as of a concave radius on a convex cam: there is no value
        same = extreme.value is None and extreme.holds
        return remeasured(extreme, None, None, True, same, "no such value anywhere on the cam")
    named = next((side for side in sides if side.bound == extreme.bound), sides[0])
    verdicts = [side.holds for side in sides]
    holds = False if False in verdicts else None if None in verdicts else True
    angle = float(named.found.piece.angle_at(named.found.x) / degree())
    return compare(extreme, named.low, named.high, holds, how, angle, named.blur)


def _find_infinity(design: ExactDesign, claim: Claim, extreme: Extreme) -> Remeasured:
    """Whether a derivative below those of the quantity jumps where the certificate says so."""
    orders = range(ORDERS.get(claim.quantity, 2))
    for before, after in junctions_at(design, extreme.angle_deg):
        scale = abs(before.unit) + abs(after.unit)
        for order in orders:
            step = abs(jump(before, after, order))
            if step > JUMP_ROUNDING * scale / before.angle.min(after.angle) ** order:
                size = float(step * design.rate(order))
                how = f"infinite: {DERIVATIVES[order]} jumps there by {size:.6g}"
                return remeasured(extreme, None, None, False, True, how, extreme.angle_deg)
    how = "infinite by the certificate, but no discontinuity was found there"
    return remeasured(extreme, None, None, None, None, how)


def _side(design: ExactDesign, claim: Claim, sign: int, bound: float) -> _Side | None:
    """The extreme next to one bound; None where the wire has no value for it."""
    spans = design.spans(claim)
    found = design.extreme(claim, spans, sign)
    to_wire = _to_wire(design, claim)
    reached, beyond = to_wire(found.lower * sign), to_wire(found.upper * sign)
    wanted = claim.to_wire(bound)
    if wanted is None or reached is None or beyond is None:
        return None
    wanted = float(f"{wanted:.15g}")  # as the spec states it, without rounding of a conversion
    low, high = reached.min(beyond).lower(), reached.max(beyond).upper()
    direction = -sign if _is_decreasing(to_wire) else sign
    # by how much rounding of the cam angle where a piece ends may change the value there
    near = [span for span in spans if span[0].segment == found.piece.segment]
    further = to_wire(found.lower * sign + design.slope(claim, near, found.x) * ANGLE_ROUNDING)
    blur = 0.0 if further is None else float(abs(further - reached))
    return _Side(low, high, wanted, satisfies(low, high, wanted, direction), found, blur)


def _to_wire(design: ExactDesign, claim: Claim) -> Callable[[arb], arb | None]:
    """The map from a claim's quantity to the wire's unit, in exact numbers."""
    order = ORDERS.get(claim.quantity)
    if claim.limit == "reach":
        return lambda moved: (_angle_at_rest(design) + moved) / degree()
    if claim.quantity == "travel":
        piece = design.motion.pieces_of(claim.segments)[0]  # travel is gained, or lost
        sense = -1 if design.design.curve.segments[claim.segments[0]].lift < 0.0 else 1
        return lambda moved: (moved - piece.level) * design.to_wire * sense
    if order is not None:
        return lambda rate: rate * design.rate(order)
    if claim.unit == "deg":
        return lambda angle: angle / degree()
    if claim.to_wire is float:  # the core measures in the unit of the wire
        return lambda value: value
    if claim.quantity == "contact_force":
        flanks = design.machine.follower.flanks
        side = next(flank.side for flank in flanks if flank.name == claim.flank)
        return lambda force: force * side
    if claim.quantity == "pressure_square":
        compliance = design.contact_compliance
        return lambda value: (value.max(arb(0)) / compliance).sqrt()
    of_length: Any = claim.to_wire  # sums and quotients, which balls have as well
    return lambda value: of_length(value)


def _is_decreasing(to_wire: Callable[[arb], arb | None]) -> bool:
    """Whether the value on the wire, which is monotone, decreases as the quantity increases."""
    # a radius has values on one side of zero curvature only, a root of positive numbers only
    samples = [to_wire(arb(k)) for k in (-2, -1, 1, 2)]
    values = [value for value in samples if value is not None]
    return bool(values[-1] < values[-2])


def _angle_at_rest(design: ExactDesign) -> arb:
    """Angle at the pivot from the line of centres to the arm or face at displacement 0 [rad]."""
    link = design.link
    assert link.pivot is not None
    px, py = link.pivot
    if link.face is not None:
        x, y = link.face.along
    else:
        x, y = link.tips[0].at[0] - px, link.tips[0].at[1] - py
    return arb.atan2((py * x - px * y) * link.turn, -px * x - py * y)


def measure_residual_vibration(design: ExactDesign, claim: Claim, extreme: Extreme) -> Remeasured:
    """The largest amplitude at the end of one of the claim's runs."""
    found = [_amplitude(design, run) for run in claim.vibration]
    low = max((each.lower() for each in found), key=float)
    high = max((each.upper() for each in found), key=float)
    low, high = low.max(arb(0)) * design.to_wire, high * design.to_wire
    assert extreme.bound is not None
    ends = claim.vibration[found.index(max(found, key=lambda each: float(each.mid())))].run[-1]
    last = design.motion.pieces_of([ends])[-1]
    angle = float(last.angle_at(last.law.high) / degree()) % 360.0
    how = "antiderivatives of the motion times a damped oscillation, in ball arithmetic"
    return compare(extreme, low, high, satisfies(low, high, extreme.bound, 1), how, angle)


def _amplitude(design: ExactDesign, run: VibrationBound) -> arb:
    """The amplitude, mm or rad."""
    zeta = arb(run.damping)
    share = (1 - zeta * zeta).sqrt()
    rate = acb(zeta, -share) * arb(run.frequency)
    # segments from the last to the first; each response decays over the segments after it
    total, after = acb(0), arb(0)
    for index in reversed(run.run):
        pieces = design.motion.pieces_of([index])
        angle, unit = pieces[0].angle, pieces[0].unit
        kappa = rate * angle
        inner = sum((_integral(piece.law, kappa) for piece in pieces), acb(0))
        total += inner * unit * (-rate * after).exp()
        after += angle
    return abs(total) / share


def _integral(law: LawPiece, kappa: acb) -> acb:
    """∫ g'(x) e^(−κ(1 − x)) dx over one piece of a law."""
    low, high = law.low - law.origin, law.high - law.origin
    about = (kappa * (law.origin - 1)).exp()
    slope = [j * c for j, c in enumerate(law.poly)][1:]
    total = acb(0)
    if slope:
        total = _antiderivative(slope, kappa, high) - _antiderivative(slope, kappa, low)
    for amplitude, frequency, phase in law.waves:
        for sign in (1, -1):
            exponent = kappa + acb(0, 1) * frequency * sign
            factor = (acb(0, 1) * phase * sign).exp() * amplitude * frequency / 2
            total += factor * _exponential_integral(exponent, low, high)
    return total * about


def _antiderivative(poly: Sequence[arb], kappa: acb, y: arb) -> acb:
    """An antiderivative of p(y) e^(κy)."""
    total, power = acb(0), 1 / kappa
    row = list(poly)
    while row:
        value = acb(0)
        for coefficient in reversed(row):
            value = value * y + coefficient
        total += value * power
        power = -power / kappa
        row = [j * c for j, c in enumerate(row)][1:]
    return total * (kappa * y).exp()


def _exponential_integral(mu: acb, low: arb, high: arb) -> acb:
    """∫ e^(μy) dy from low to high."""
    # (e^x − 1)/x is Kummer's function 1F1(1; 2; x), which is regular at 0
    width = high - low
    return (mu * low).exp() * width * (mu * width).hypgeom_1f1(acb(1), acb(2))
