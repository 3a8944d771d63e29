"""A smooth motion through positions, its dwells, and the uncertainty of its derivatives."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from synthesis.catalogue.motion import Motion
from synthesis.numerics.maxima import maximise
from synthesis.numerics.periodic_spline import DEGREE, PeriodicSpline, fit_least_squares
from synthesis.numerics.piecewise import Array, Piecewise
from synthesis.studies.measured.contact import FollowerPath
from synthesis.units import FULL_TURN

KNOT_COUNTS: Final = (24, 36, 54, 80, 120, 180, 270, 400, 600, 900)
DATA_PER_KNOT: Final = 4.0  # fewer positions do not determine a spline
KINK_CLEARANCE: Final = 0.3  # of a knot interval: a kink this near to a knot replaces it
FAVARD: Final = (1.0, math.pi / 2.0, math.pi**2 / 8.0, math.pi**3 / 24.0, 5.0 * math.pi**4 / 384.0)
DWELL_ANGLES: Final = 3600  # at which ends of dwells are looked for: a tenth of a degree
SHORTEST_DWELL: Final = 4.0 * FULL_TURN / 360.0  # 4°: shorter arcs may be turning points


@dataclass(frozen=True, eq=False)
class FittedMotion:
    """The motion of the follower.

    Attributes:
        motion: s(θ), 0 at its lowest. spline: the fitted spline [mm over rad].
        lowest: position there [mm]. off: largest distance of the spline from the positions [mm].
        smooth: whether the velocity is continuous, as no hollow is spanned.
    """

    motion: Motion
    spline: PeriodicSpline
    lowest: float
    off: float
    smooth: bool


def fit_motion(path: FollowerPath, tolerance: float) -> FittedMotion:
    """The spline with the fewest even knots within a tolerance of all positions [mm].

    Where the follower touches both sides of a hollow its velocity jumps, and the spline may have a
    kink.
    """
    angles = np.array([math.radians(hollow.angle_deg) for hollow in path.hollows])
    kinks = np.unique(np.round(angles, 6))
    kinks = kinks[kinks < FULL_TURN]
    for count in KNOT_COUNTS:
        # Even knots, the first at 0; a kink is a knot of multiplicity p (C0) in place of near ones.
        even = FULL_TURN * np.arange(count) / count
        distance = np.abs(even[:, None] - kinks)
        nearest = np.minimum(distance, FULL_TURN - distance).min(axis=1, initial=FULL_TURN)
        smooth = (nearest > KINK_CLEARANCE * FULL_TURN / count) | (even == 0.0)
        knots = np.sort(np.concatenate([even[smooth], np.repeat(kinks, DEGREE)]))
        spline, residual = fit_least_squares(knots, FULL_TURN, path.theta, path.position[:, None])
        off = float(np.max(np.abs(residual)))
        if off <= tolerance or len(path.theta) < DATA_PER_KNOT * count:
            break
    curve = spline.piecewise()
    lowest = -maximise(curve, (-1.0,))[0]
    poly = curve.poly.copy()
    poly[:, 0] -= lowest
    # The basis functions sum to 1, so that coefficients shift the spline.
    level = replace(spline, coefficients=spline.coefficients - lowest)
    motion = Motion((), replace(curve, poly=poly))
    return FittedMotion(motion, level, lowest, off, len(kinks) == 0)


def derivative_uncertainty(curve: Piecewise, error: float) -> tuple[float, ...]:
    """Largest errors of s', s'', s''' that an error of s allows [per radian].

    Landau–Kolmogorov inequality on the line: ‖f⁽ᵏ⁾‖ ≤ K ‖f‖^{1−k/n} ‖f⁽ⁿ⁾‖^{k/n} with
    K = a_{n−k}/a_n^{1−k/n}, a_j the Favard constants (Kolmogorov 1939); here n = 4, f the
    difference of two motions whose fourth derivatives are no larger than the curve's.
    """
    fourth = [maximise(curve, (0.0, 0.0, 0.0, 0.0, sign))[0] for sign in (1.0, -1.0)]
    most, n = 2.0 * max(fourth), 4
    return tuple(
        FAVARD[n - k] / FAVARD[n] ** (1.0 - k / n) * error ** (1.0 - k / n) * most ** (k / n)
        for k in range(1, n)
    )


def find_dwells(motion: Motion, tolerance: float) -> list[tuple[float, float, float]]:
    """Longest arcs of at least 4° along which s varies by at most twice a tolerance.

    Returns:
        start [rad], length [rad], mean of s [mm] of each, in the order of the cam angle.
    """
    count, step = DWELL_ANGLES, FULL_TURN / DWELL_ANGLES
    s = motion.derivatives(step * np.arange(count), 0)[0]
    twice = np.concatenate([s, s])
    if float(np.ptp(s)) <= 2.0 * tolerance:
        return [(0.0, FULL_TURN, float(np.mean(s)))]
    reach = _longest_runs(twice, 2.0 * tolerance)[:count]
    found: list[tuple[float, float, float]] = []
    used = np.zeros(count, dtype=bool)
    for i in np.argsort(-reach, kind="stable"):
        if reach[i] * step < SHORTEST_DWELL:
            break
        arc = (i + np.arange(reach[i] + 1)) % count
        if not used[arc].any():
            used[arc] = True
            found.append((i * step, float(reach[i] * step), float(np.mean(s[arc]))))
    return sorted(found)


def _longest_runs(s: Array, width: float) -> NDArray[np.intp]:
    """(n,) number of following samples that stay within a width, by doubling."""
    # Extremes of 2^k samples from each one on.
    lows, highs = [s], [s]
    while 2 ** len(lows) <= len(s):
        half = 2 ** (len(lows) - 1)
        lows.append(np.minimum(lows[-1][:-half], lows[-1][half:]))
        highs.append(np.maximum(highs[-1][:-half], highs[-1][half:]))
    # Runs grow by the largest powers of two that keep them within the width.
    low, high, end = s, s, np.arange(len(s)) + 1
    for k in reversed(range(len(lows))):
        at = np.where(end + 2**k <= len(s), end, 0)
        lower, upper = np.minimum(low, lows[k][at]), np.maximum(high, highs[k][at])
        grows = (at > 0) & (upper - lower <= width)
        low, high = np.where(grows, lower, low), np.where(grows, upper, high)
        end = end + 2**k * grows
    return end - 1 - np.arange(len(s))
