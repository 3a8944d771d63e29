"""Bounds over all motion laws from the phase plane (position, speed) of a free segment.

A limit on the pressure angle leaves a maximum speed V(p, size) to every position p, the smaller the
smaller the cam. Caps on jerk J and acceleration A bound the speed near the ends of the law, where
its state is known: a law with acceleration a at speed v still gains a²/(2J) of speed while its
acceleration falls to zero, so that a ≤ √(2J (P(p) − v)), with P the largest V from p on. The
maximum-speed profile is the lower envelope of V and of the profiles integrated from both ends.
Every law is slower than it at every position, which yields

* the least cam angle in which a segment can be passed: a size for which that is more than the
  segment has is infeasible for every law (``least_size``);
* a tube that holds every law of a cam no larger than a given size: none is ahead of the fastest run
  from the start, nor behind the one that arrives in time at the end (``trajectory_tubes``).

How a law's acceleration follows the slope of V is left out, so that the bound is exact where only
accelerations or velocities are capped. Every step overestimates speeds, so that angles are lower
bounds up to ``QUADRATURE``. The method is that of time-optimal motion along a path (Bobrow,
Dubowsky and Gibson, 1985).
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, isfinite, sqrt
from typing import cast

import numpy as np
from scipy.optimize import brentq

from synthesis.catalogue.motion import PlacedSegment
from synthesis.machines.spatial.size_constraints import SizeConstraint
from synthesis.numerics.piecewise import Array
from synthesis.optimise.conic.law_bounds import LawBounds
from synthesis.optimise.conic.program import ConicModel
from synthesis.optimise.problem.problem import Problem

POSITIONS = 801  # nodes in position between the ends of a segment
STEPS = 160  # integration steps in which a law from rest reaches its largest speed
MAX_STEPS = 40 * STEPS  # a profile that has not met V by then stays as it is
QUADRATURE = 1e-6  # relative, of a size: far above the error of the quadrature between nodes
NEGLIGIBLE = 1e-18  # of the first size: where no size above this is too small, none is
TUBE_NODES = 128  # cam angles of a tube
TUBE_MARGIN = 1e-4  # of the lift: far above the error of linear interpolation in a profile


@dataclass(frozen=True, eq=False)
class SpeedProfile:
    """Speeds that no law exceeds, by position, and the least cam angles that follow, (n,) each.

    Attributes:
        p: distance from the start, in the direction of the segment [mm].
        speed: maximum speed [mm/rad].
        from_start: least cam angle from the start to p [rad]. to_end: from p to the end.
    """

    p: Array
    speed: Array
    from_start: Array
    to_end: Array

    @property
    def angle(self) -> float:
        """The least cam angle from end to end [rad]."""
        return float(np.max(self.from_start + self.to_end))


@dataclass(frozen=True, eq=False)
class PhasePlane:
    """A free segment and what bounds the speed of its laws.

    Attributes:
        problem, segment: which.
        caps: upper bounds of |s'|, |s''| and |s'''| on the segment [mm/rad^k]; infinite: none.
        states: s' and s'' at its start and at its end as far as known, in its direction.
    """

    problem: Problem
    segment: PlacedSegment
    caps: tuple[float, ...]
    states: tuple[Sequence[float], Sequence[float]]

    @classmethod
    def of(cls, problem: Problem, segment: PlacedSegment, known: Sequence[Array]) -> PhasePlane:
        """``known``: the normalised law's g, g', … at its start and at its end, as far as known."""
        units = abs(segment.lift) / segment.angle ** np.arange(3)
        start, end = (
            [float(v * u) for v, u in zip(g[1:3], units[1:], strict=False)] for g in known
        )
        # Caps are the limits on single derivatives; of their two signs the looser one.
        sides = np.full((4, 2), inf)
        for row in problem.limit_rows(segment):
            orders = np.flatnonzero(row.coefficients)
            if len(orders) == 1 and orders[0] > 0 and row.interval is None and not any(row.size):
                factor = row.coefficients[orders[0]]
                side = orders[0], int(factor > 0.0)
                sides[side] = min(sides[side], row.upper / abs(factor))
        return cls(problem, segment, tuple(sides.max(axis=1)[1:].tolist()), (start, end))

    def speed_limit(self, p: Array, size: float) -> Array:
        """V at positions p (n,) [mm/rad]; not above 0 where the cam is too small."""
        sense = 1.0 if self.segment.lift > 0.0 else -1.0
        s = self.segment.s_start + sense * p
        limit = np.full(len(p), self.caps[0])
        for curve in self.problem.curved_limits_on(self.segment):
            limit = np.minimum(limit, cast(SizeConstraint, curve).max_speed(s, size, sense))
        return limit

    def profile(self, size: float) -> SpeedProfile | None:
        """The maximum-speed profile on a cam of this size [mm].

        None where some position allows no speed at all: no law is feasible then.
        """
        p = np.linspace(0.0, abs(self.segment.lift), POSITIONS)
        limit = self.speed_limit(p, size)
        if np.min(limit) <= 0.0:
            return None
        ramps = [np.full(POSITIONS, inf), np.full(POSITIONS, inf)]
        # The second pass integrates from each end under the profile of the other end.
        for _ in range(2):
            limits = (np.minimum(limit, ramps[1]), np.minimum(limit, ramps[0])[::-1])
            (first, first_angles), (last, last_angles) = (
                self._ramp(end, p, each) for end, each in enumerate(limits)
            )
            ramps = [first, last[::-1]]
        speed = np.minimum(limit, np.minimum(*ramps))
        # Cam angles: along a ramp those of its integration, beyond it ∫ dp/speed.
        slowness = np.divide(1.0, speed, out=np.zeros(len(p)), where=speed > 0.0)
        cells = 0.5 * (p[1] - p[0]) * (slowness[1:] + slowness[:-1])
        from_start = _angles(first_angles, cells)
        return SpeedProfile(p, speed, from_start, _angles(last_angles, cells[::-1])[::-1])

    def _ramp(self, end: int, p: Array, limit: Array) -> tuple[Array, Array]:
        """The profile integrated from one end (0 or 1), at p = 0, until it meets the speed limit.

        Returns:
            (n,) maximum speed at every p, infinite beyond the ramp, and (n,) the cam angle needed
            to get there, NaN beyond the ramp.
        """
        peak = np.maximum.accumulate(limit[::-1])[::-1]
        # Seen from the end, time runs backwards: even derivatives keep their sign.
        state = [v if k == 0 or end == 0 else -v for k, v in enumerate(self.states[end])]
        speed, angle = np.full(len(p), inf), np.full(len(p), np.nan)
        if not state or not isfinite(float(peak[0])):
            return speed, angle
        at, fast, x = _integrate(state, self.caps, p.tolist(), limit.tolist(), peak.tolist())
        inside = p <= at[-1]
        # Speeds rise along the ramp: that at the end of a step bounds all positions within it.
        speed[inside] = fast[np.searchsorted(at, p[inside], "left")]
        angle[inside] = np.interp(p[inside], at, x)
        return speed, angle


def _integrate(
    state: Sequence[float],
    caps: Sequence[float],
    p: list[float],
    limit: list[float],
    peak: list[float],
) -> tuple[Array, Array, Array]:
    """The fastest start from a known state until it meets the limit, by steps in the cam angle.

    Args:
        state: s' and, if known, s'' at p = 0. caps: as in ``PhasePlane``.
        p: positions. limit: V there. peak: the largest V from there on.

    Returns:
        positions, speeds and cam angles after each step; positions and speeds are overestimated.
    """
    v0, a0 = state[0], state[1] if len(state) > 1 else inf
    (_, A, J), lift = caps, p[-1]
    jerk_capped = inf > J
    # The step is a share of the angle in which a law from rest reaches its largest speed.
    h = (2.0 * sqrt(peak[0] / J) + peak[0] / A) / STEPS
    if h == 0.0:
        return np.zeros(1), np.full(1, inf), np.zeros(1)
    q, v, x = 0.0, max(v0, 0.0), 0.0
    steps = [(q, v, x)]
    while q < lift and len(steps) < MAX_STEPS:
        node = min(bisect_right(p, q) - 1, len(p) - 2)
        most = peak[node]
        gain = A * h
        if jerk_capped:
            # At most the initial acceleration plus J x, and at most what lets the acceleration fall
            # to zero by the time the speed reaches the peak.
            left = sqrt(2.0 * max(most - v, 0.0) / J)
            eased = most - 0.5 * J * max(left - h, 0.0) ** 2 - v
            gain = min(gain, a0 * h + J * (x + 0.5 * h) * h, eased)
        gain = max(gain, 0.0)
        # Trapezoidal rule; as |s'''| ≤ J its error is at most J h³/12.
        q += h * (v + 0.5 * gain) + (J * h**3 / 12.0 if jerk_capped else 0.0)
        v, x = v + gain, x + h
        steps.append((q, v, x))
        if v >= max(limit[node], limit[node + 1]):
            break
    at, fast, angles = np.array(steps).T
    return at, fast, angles


def _angles(ramp: Array, cells: Array) -> Array:
    """Angles to all nodes, from those along a ramp (NaN beyond it) and those of the cells."""
    known, total = np.isfinite(ramp), np.concatenate([[0.0], np.cumsum(cells)])
    if not known.any():
        return total
    last = int(np.count_nonzero(known)) - 1
    return np.where(known, ramp, ramp[last] + total - total[last])


def least_size(plane: PhasePlane, start: float, largest: float) -> float:
    """The size below which no law passes the segment in its cam angle [mm]; 0: none is too small.

    ``start`` is a size to try first, ``largest`` the largest of interest [mm].
    """

    def excess(size: float) -> float:
        profile = plane.profile(size)
        return inf if profile is None else profile.angle - plane.segment.angle

    # The excess of the least angle falls as the size grows: bracket its root, then find it.
    high = min(start, largest)
    while excess(high) > 0.0:
        if high >= largest:
            return largest
        high = min(2.0 * high, largest)
    low = 0.5 * high
    while excess(low) <= 0.0:
        low, high = 0.5 * low, low
        if low < NEGLIGIBLE * start:
            return 0.0
    root = brentq(lambda size: min(excess(size), 1e3), low, high, xtol=1e-9 * high, rtol=1e-9)
    return float(root) * (1.0 - QUADRATURE)


def trajectory_tubes(plan: ConicModel, size: float) -> tuple[LawBounds, ...]:
    """Tubes that hold every free law of a cam no larger than ``size`` [mm]; a derivative is capped.

    Returns:
        () where no law is feasible on a cam of that size.
    """
    tubes = []
    nodes = np.linspace(0.0, 1.0, TUBE_NODES + 1)
    for segment, ends in zip(plan.problem.free, plan.boundary_states, strict=True):
        plane = PhasePlane.of(plan.problem, segment, (ends.start, ends.end))
        profile, lift, angle = plane.profile(size), abs(segment.lift), segment.angle
        if profile is None:
            return ()
        # No law is ahead of the fastest run from the start, nor behind that which is in time.
        margin = TUBE_MARGIN * lift
        high = np.interp(nodes * angle, profile.from_start, profile.p) + margin
        low = np.interp(nodes * angle, angle - profile.to_end, profile.p) - margin
        assert segment.free is not None
        if not segment.free.overshoot:
            low, high = np.clip(low, 0.0, lift), np.clip(high, 0.0, lift)
        low[0] = high[0] = 0.0
        low[-1] = high[-1] = lift
        fast = np.full(len(nodes), min(float(np.max(profile.speed)) * angle / lift, 1e6))
        slow = -fast if segment.free.overshoot else 0.0 * fast
        order = 3 if plane.caps[2] < inf else 2
        cap = plane.caps[order - 1] * angle**order / lift
        tubes.append(LawBounds(nodes, low / lift, high / lift, slow, fast, order, cap))
    return tuple(tubes)
