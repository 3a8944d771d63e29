"""The fastest that any law of a cam of a given size can be, and the smallest cam that is in time.

A limit on the pressure angle leaves a largest speed V(p) to every position p, the smaller the
smaller the cam. Caps on jerk J and acceleration A leave a largest speed since an end of the law,
where its state is known. A law whose acceleration is a at speed v still gains a²/(2J), the jerk
being capped, so that a ≤ √(2J (P(p) − v)), where P is the largest speed left to it from there on.
Every law is slower than what keeps to all that from both ends. It needs a least angle; a cam so
small that this is more than there is has no law at all. What this leaves out is how a law's
acceleration follows V, so that it is exact where only accelerations or velocities are capped.

Every step overestimates speeds, so that angles are least ones but for ``ROUNDING``.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, isfinite, sqrt

import numpy as np
from scipy.optimize import brentq

from synthesis.formulations.question.problem import Problem
from synthesis.motion import Stretch
from synthesis.numerics.piecewise import Array
from synthesis.spatial.formulations.scene import leverages

NODES = 801  # positions between the ends of a stretch
STEPS = 160  # of an angle, until a law from rest has its largest speed
MOST = 40  # times as many, after which a ramp is left as it is
ROUNDING = 1e-6  # relative, of a size: far more than quadrature between the nodes is out by
FAN = 60  # doublings of a size that is tried


@dataclass(frozen=True)
class Caps:
    """Bounds of |s'|, |s''| and |s'''| all along a stretch [mm/rad^k]; infinite where none."""

    velocity: float
    acceleration: float
    jerk: float

    @classmethod
    def of(cls, problem: Problem, stretch: Stretch) -> Caps:
        """What limits on single derivatives say, the looser side of each."""
        sides = {(k, sign): inf for k in (1, 2, 3) for sign in (1, -1)}
        for row in problem.limit_rows(stretch):
            orders = [k for k, factor in enumerate(row.coefficients) if factor]
            if len(orders) == 1 and orders[0] > 0 and row.part is None and not any(row.size):
                factor = row.coefficients[orders[0]]
                side = orders[0], 1 if factor > 0.0 else -1
                sides[side] = min(sides[side], row.upper / abs(factor))
        velocity, acceleration, jerk = (max(sides[k, 1], sides[k, -1]) for k in (1, 2, 3))
        return cls(velocity, acceleration, jerk)


@dataclass(frozen=True, eq=False)
class Run:
    """Speeds that no law exceeds, by position, and the least angles they leave.

    Attributes:
        p: (n,) positions from the start, in the sense of the stretch [mm]. speed: (n,) [mm/rad].
        ahead: (n,) least angle from the start to p [rad]. behind: (n,) likewise to the end.
    """

    p: Array
    speed: Array
    ahead: Array
    behind: Array

    @property
    def angle(self) -> float:
        """The least angle from end to end [rad]."""
        return float(np.max(self.ahead + self.behind))


@dataclass(frozen=True, eq=False)
class Track:
    """A free stretch as it is run.

    Attributes:
        states: s' and s'' at its start and at its end, as far as they are known, in its sense.
    """

    problem: Problem
    stretch: Stretch
    caps: Caps
    states: tuple[Sequence[float], Sequence[float]]

    @classmethod
    def of(cls, problem: Problem, stretch: Stretch, known: Sequence[Array]) -> Track:
        """``known``: g, g', … of its law at its start and at its end."""
        units = abs(stretch.lift) / stretch.angle ** np.arange(3)
        start, end = (
            [float(v * u) for v, u in zip(g[1:3], units[1:], strict=False)] for g in known
        )
        return cls(problem, stretch, Caps.of(problem, stretch), (start, end))

    def allowed(self, p: Array, size: float) -> Array:
        """V at positions p (n,) [mm/rad]; not above 0 where the cam is too small."""
        sense = 1.0 if self.stretch.lift > 0.0 else -1.0
        s = self.stretch.s_start + sense * p
        found = np.full(len(p), self.caps.velocity)
        for curve in leverages(self.problem, self.stretch):
            found = np.minimum(found, curve.fastest(s, size, sense))
        return found

    def run(self, size: float) -> Run | None:
        """The fastest run on a cam of this size [mm]; None where the cam is too small for any."""
        lift = abs(self.stretch.lift)
        p = np.linspace(0.0, lift, NODES)
        allowed = self.allowed(p, size)
        if np.min(allowed) <= 0.0:
            return None
        ramps = [np.full(NODES, inf), np.full(NODES, inf)]
        gone = [np.zeros(NODES), np.zeros(NODES)]
        for _ in range(2):  # the second time each end knows of the other's
            speeds = (np.minimum(allowed, ramps[1]), np.minimum(allowed, ramps[0])[::-1])
            found = [self._ramp(end, p, speed) for end, speed in enumerate(speeds)]
            ramps, gone = [found[0][0], found[1][0][::-1]], [found[0][1], found[1][1][::-1]]
        return _run(p, np.minimum(allowed, np.minimum(*ramps)), gone)

    def _ramp(self, end: int, p: Array, speed: Array) -> tuple[Array, Array]:
        """From an end on: the largest speed at every p, infinite beyond the ramp, and the angle
        that is needed to get there, as far as the ramp goes.
        """
        peak = np.maximum.accumulate(speed[::-1])[::-1]
        state = self.states[end]
        turned = [v if k == 0 or end == 0 else -v for k, v in enumerate(state)]
        found, angle = np.full(len(p), inf), np.full(len(p), np.nan)
        top = float(peak[0])
        if not turned or not isfinite(top):
            return found, angle
        at, fast, x = _followed(turned, self.caps, p.tolist(), speed.tolist(), peak.tolist())
        inside = p <= at[-1]
        # the speed of the next step's end is none too low for any place before it
        ahead = np.minimum(np.searchsorted(at, p[inside], "left"), len(at) - 1)
        found[inside] = fast[ahead]
        angle[inside] = np.interp(p[inside], at, x)
        return found, angle


def _followed(
    state: Sequence[float], caps: Caps, p: list[float], speed: list[float], peak: list[float]
) -> tuple[Array, Array, Array]:
    """Places, speeds and angles of the fastest start from a known state, until V stops it."""
    v0, a0 = state[0], state[1] if len(state) > 1 else inf
    J, A, lift, steered = caps.jerk, caps.acceleration, p[-1], caps.jerk < inf
    # a time in which a law from rest is fast: far from it where neither is capped
    scale = 2.0 * sqrt(peak[0] / J) + peak[0] / A
    h = scale / STEPS
    if h == 0.0:
        return np.zeros(1), np.full(1, inf), np.zeros(1)
    q, v, x = 0.0, max(v0, 0.0), 0.0
    at, fast, angles = [q], [v], [x]
    while q < lift and len(at) < MOST * STEPS:
        node = min(bisect_right(p, q) - 1, len(p) - 2)
        most = peak[node]
        gain = A * h
        if steered:
            left = sqrt(2.0 * max(most - v, 0.0) / J)
            eased = most - 0.5 * J * max(left - h, 0.0) ** 2 - v
            gain = min(gain, a0 * h + J * (x + 0.5 * h) * h, eased)
        gain = max(gain, 0.0)
        # |s'''| ≤ J: the trapezium is out by no more
        q += h * (v + 0.5 * gain) + (J * h**3 / 12.0 if steered else 0.0)
        v, x = v + gain, x + h
        at.append(q)
        fast.append(v)
        angles.append(x)
        if v >= max(speed[node], speed[node + 1]):
            break
    return np.array(at), np.array(fast), np.array(angles)


def _run(p: Array, speed: Array, gone: Sequence[Array]) -> Run:
    """Least angles from both ends: along the ramps those that they need, then dp over speed."""
    slow = np.divide(1.0, speed, out=np.zeros(len(p)), where=speed > 0.0)  # 0: as a ramp begins
    cells = 0.5 * (p[1] - p[0]) * (slow[1:] + slow[:-1])
    ahead = _gone(gone[0], cells)
    return Run(p, speed, ahead, _gone(gone[1][::-1], cells[::-1])[::-1])


def _gone(ramp: Array, cells: Array) -> Array:
    """Angles to all nodes, from those along a ramp (not a number beyond) and between nodes."""
    known = np.isfinite(ramp)
    last = int(np.count_nonzero(known)) - 1
    total = np.concatenate([[0.0], np.cumsum(cells)])
    if last < 0:
        return total
    return np.where(known, ramp, ramp[last] + total - total[last])


def least_size(track: Track, start: float, largest: float) -> float:
    """The size below which no law is in time [mm], 0 where none is too small.

    Args:
        start: a size to try first [mm]. largest: the largest of interest [mm].
    """

    def late(size: float) -> float:
        found = track.run(size)
        return inf if found is None else found.angle - track.stretch.angle

    low, high = 0.0, start
    while late(high) > 0.0:
        low, high = high, 2.0 * high
        if high > largest:
            return largest
    if low == 0.0:
        low = 0.5 * high
        for _ in range(FAN):
            if late(low) > 0.0:
                break
            low, high = 0.5 * low, low
        else:
            return 0.0
    found = brentq(lambda size: min(late(size), 1e3), low, high, xtol=1e-9 * high, rtol=1e-9)
    return float(found) * (1.0 - ROUNDING)
