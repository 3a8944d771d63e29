"""Positions along the turn to a smooth motion, and what a tolerance hides of its derivatives."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from synthesis.measured.contact import Ride
from synthesis.motion import Motion
from synthesis.numerics.peaks import peak
from synthesis.numerics.periodic import DEGREE, PeriodicSpline, fitted
from synthesis.numerics.piecewise import Array, Piecewise
from synthesis.units import FULL_TURN

KNOTS: Final = (24, 36, 54, 80, 120, 180, 270, 400, 600, 900)
DATA_PER_KNOT: Final = 4.0
CROWDED: Final = 0.3  # of a knot interval: a kink so near to a knot takes its place
FAVARD: Final = (1.0, math.pi / 2.0, math.pi**2 / 8.0, math.pi**3 / 24.0, 5.0 * math.pi**4 / 384.0)
SHORTEST_DWELL: Final = 4.0 * FULL_TURN / 360.0


@dataclass(frozen=True, eq=False)
class Read:
    """The motion as read.

    Attributes:
        motion: s(θ), 0 at its lowest. spline: the same as it was fitted [mm over rad].
        lowest: position there [mm]. off: largest distance from the positions [mm].
        smooth: whether the velocity is continuous, no hollow being spanned.
    """

    motion: Motion
    spline: PeriodicSpline
    lowest: float
    off: float
    smooth: bool


def read(ride: Ride, tolerance: float) -> Read:
    """The spline of fewest even knots that passes within a tolerance of all positions.

    Where the follower rests on both sides of a hollow its velocity jumps: the spline may have a
    kink there.
    """
    kinks = np.unique(np.round([bridge.angle for bridge in ride.bridges], 6))
    kinks = kinks[kinks < FULL_TURN]
    values = ride.position[:, None]
    for count in KNOTS:
        knots = _knots(count, kinks)
        spline, residual = fitted(knots, FULL_TURN, ride.theta, values)
        off = float(np.max(np.abs(residual)))
        if off <= tolerance or len(ride.theta) < DATA_PER_KNOT * count:
            break
    return _settled(spline, off, len(kinks) == 0)


def _settled(spline: PeriodicSpline, off: float, smooth: bool) -> Read:
    curve = spline.piecewise()
    lowest = -peak(curve, (-1.0,))[0]
    poly = curve.poly.copy()
    poly[:, 0] -= lowest
    motion = Motion((), replace(curve, poly=poly))
    level = replace(spline, coefficients=spline.coefficients - lowest)  # the basis sums to 1
    return Read(motion, level, lowest, off, smooth)


def _knots(count: int, kinks: Array) -> Array:
    """Even knots, the first at 0, and each kink as often as leaves only the value continuous."""
    even = FULL_TURN * np.arange(count) / count
    if len(kinks) == 0:
        return even
    apart = np.abs(even[:, None] - kinks)
    apart = np.minimum(apart, FULL_TURN - apart).min(axis=1)
    kept = (apart > CROWDED * FULL_TURN / count) | (even == 0.0)
    return np.sort(np.concatenate([even[kept], np.repeat(kinks, DEGREE)]))


def hidden(curve: Piecewise, error: float) -> tuple[float, ...]:
    """What an error of s can hide of s', s'', s''' [per radian].

    Landau–Kolmogorov for functions on the line: ‖f⁽ᵏ⁾‖ ≤ K ‖f‖^{1−k/n} ‖f⁽ⁿ⁾‖^{k/n} with
    K = a_{n−k}/a_n^{1−k/n}, a_j the Favard constants (Kolmogorov 1939); here n = 4, f the
    difference of two motions whose fourth derivatives are no larger than the curve's.
    """
    fourth = [peak(curve, (0.0, 0.0, 0.0, 0.0, sign))[0] for sign in (1.0, -1.0)]
    most, n = 2.0 * max(fourth), 4
    return tuple(
        FAVARD[n - k] / FAVARD[n] ** (1.0 - k / n) * error ** (1.0 - k / n) * most ** (k / n)
        for k in range(1, n)
    )


def dwells(motion: Motion, tolerance: float) -> list[tuple[float, float, float]]:
    """Longest arcs, none shorter than 4°, along which s keeps within twice a tolerance.

    Returns:
        start [rad], length [rad], mean of s [mm] of each, in the order of the cam angle.
    """
    count = 3600
    step = FULL_TURN / count
    s = motion.derivatives(step * np.arange(count), 0)[0]
    twice = np.concatenate([s, s])
    if float(np.ptp(s)) <= 2.0 * tolerance:
        return [(0.0, FULL_TURN, float(np.mean(s)))]
    reach = _reaches(twice, 2.0 * tolerance)[:count]
    found: list[tuple[float, float, float]] = []
    taken = np.zeros(count, dtype=bool)
    for i in np.argsort(-reach, kind="stable"):
        if reach[i] * step < SHORTEST_DWELL:
            break
        arc = (i + np.arange(reach[i] + 1)) % count
        if not taken[arc].any():
            taken[arc] = True
            found.append((i * step, float(reach[i] * step), float(np.mean(s[arc]))))
    return sorted(found)


def _reaches(s: Array, width: float) -> NDArray[np.intp]:
    """(n,) how many steps on from each sample all values keep within a width."""
    n, end = len(s), 0
    low, high = [0], [0]  # indices of falling minima and rising maxima, two queues
    reach = np.zeros(n, dtype=np.intp)
    for start in range(n):
        if end < start:
            end, low, high = start, [start], [start]
        while end + 1 < n:
            new = s[end + 1]
            if max(s[high[0]], new) - min(s[low[0]], new) > width:
                break
            end += 1
            while low and s[low[-1]] >= new:
                low.pop()
            while high and s[high[-1]] <= new:
                high.pop()
            low.append(end)
            high.append(end)
        reach[start] = end - start
        if low and low[0] == start:
            low.pop(0)
        if high and high[0] == start:
            high.pop(0)
    return reach
