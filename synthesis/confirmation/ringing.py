"""What a run leaves an oscillator ringing with, by antiderivatives in balls.

∫ p(y) e^(κy) dy of a polynomial is e^(κy) Σ (−1)^j p^(j)/κ^(j+1), and a sinusoid is two
exponentials; what cancels between the ends of a piece costs some of the 200 bits.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from flint import acb, arb

from synthesis.confirmation.arithmetic import degree
from synthesis.confirmation.course import Law
from synthesis.confirmation.subject import Measured, Subject, compared, within
from synthesis.design import Extreme
from synthesis.limits.base import Claim
from synthesis.terms import Ringing

SLOW: Final = 2.0**-40  # an exponent over a piece below which its integral is summed as a series


def ringing(subject: Subject, claim: Claim, extreme: Extreme) -> Measured:
    """The largest amplitude where one of the runs ends."""
    found = [_amplitude(subject, ring) for ring in claim.rings]
    low = max((each.lower() for each in found), key=float)
    high = max((each.upper() for each in found), key=float)
    low, high = low.max(arb(0)) * subject.to_wire, high * subject.to_wire
    assert extreme.bound is not None
    ends = claim.rings[found.index(max(found, key=lambda each: float(each.mid())))].run[-1]
    last = subject.course.of([ends])[-1]
    angle = float(last.angle_at(last.law.high) / degree()) % 360.0
    how = "antiderivatives of the motion against a damped wave, in balls"
    return compared(extreme, low, high, within(low, high, extreme.bound, 1), how, angle)


def _amplitude(subject: Subject, ring: Ringing) -> arb:
    """A in mm or rad."""
    zeta = arb(ring.damping)
    share = (1 - zeta * zeta).sqrt()
    rate = acb(zeta, -share) * arb(ring.frequency)
    total, after = acb(0), arb(0)
    for index in reversed(ring.run):
        pieces = subject.course.of([index])
        angle, unit = pieces[0].angle, pieces[0].unit
        kappa = rate * angle
        inner = sum((_integral(piece.law, kappa) for piece in pieces), acb(0))
        total += inner * unit * (-rate * after).exp()
        after += angle
    return abs(total) / share


def _integral(law: Law, kappa: acb) -> acb:
    """∫ g'(x) e^(−κ(1 − x)) dx over one piece of a law."""
    low, high = law.low - law.origin, law.high - law.origin
    about = (kappa * (law.origin - 1)).exp()
    slope = [j * c for j, c in enumerate(law.poly)][1:]
    total = _primitive(slope, kappa, high) - _primitive(slope, kappa, low) if slope else acb(0)
    for amplitude, frequency, phase in law.waves:
        for sign in (1, -1):
            exponent = kappa + acb(0, 1) * frequency * sign
            factor = (acb(0, 1) * phase * sign).exp() * amplitude * frequency / 2
            total += factor * _exponential(exponent, low, high)
    return total * about


def _primitive(poly: Sequence[arb], kappa: acb, y: arb) -> acb:
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


def _exponential(mu: acb, low: arb, high: arb) -> acb:
    """∫ e^(μy) dy."""
    width = high - low
    turn = mu * width
    if abs(turn) > SLOW:
        return (mu * low).exp() * (turn.exp() - 1) / mu
    series = 1 + turn / 2 + turn**2 / 6 + turn**3 / 24 + turn**4 / 120
    return (mu * low).exp() * width * series
