"""Amplitude of the free vibration that a run leaves behind, by antiderivatives in ball arithmetic.

The amplitude is |∫ s'(θ) e^(λθ) dθ| over the run, up to a factor, with the oscillator's complex
eigenvalue λ. For a polynomial ∫ p(y) e^(κy) dy = e^(κy) Σ (−1)^j p^(j)/κ^(j+1), and a sinusoid is
two exponentials. What cancels between the ends of a piece costs some of the 200 bits.
"""

from __future__ import annotations

from collections.abc import Sequence

from flint import acb, arb

from synthesis.catalogue.constraints import VibrationBound
from synthesis.catalogue.limits.base import Claim
from synthesis.certify.second.ball_arithmetic import degree
from synthesis.certify.second.exact_design import ExactDesign, Measurement, compare, satisfies
from synthesis.certify.second.exact_motion import LawPiece
from synthesis.design.design import Extreme


def measure_residual_vibration(design: ExactDesign, claim: Claim, extreme: Extreme) -> Measurement:
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
