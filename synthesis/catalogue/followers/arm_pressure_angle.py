"""Pressure angle of a roller on an arm, as limits on motion and size together.

Symbols: l arm; d centre distance; φ swing from the lowest position, s = l φ; ψ = ψ0 + φ angle at
the pivot between arm and line of centres; σ = +1 where the lifting arm turns against the cam,
−1 where with it; t = tan α_max. From the roller centre's velocity as seen from the cam,

    tan α = [l (1 + σ φ') − d cos ψ] / (d sin ψ),

so that |α| ≤ α_max reads  l + σ s' ≤ d cos ψ + t d sin ψ  and  d cos ψ − t d sin ψ ≤ l + σ s'.

Two charts of the size. Pivot free: z = (p, q) = d (cos ψ0, sin ψ0); both rows are then linear in z
at every cam angle, and with φ in a range and z in a box planes say what they imply. Pivot fixed:
z = (w,), w = l ψ0; with d √(1+t²) = D both rows are

    l + σ s' ≤ D cos(ψ − α_max)  and  −(l + σ s') ≤ D cos(π − α_max − ψ),

of one cosine that is concave up to 90° and convex beyond.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from math import atan, atan2, hypot, pi
from typing import Any, ClassVar

import numpy as np

from synthesis.catalogue.constraints import (
    MotionSizeBox,
    NonconvexConstraint,
    PointInequalities,
    Vector,
)
from synthesis.numerics.piecewise import Array

TANGENTS = 7  # tangents to a cosine over its range: the largest gap between hull and rows is 3 %
TANGENT_SHARES = tuple(k / (TANGENTS - 1.0) for k in range(TANGENTS))
BEFORE, NEWTON_STEPS = 0.51, 4
"""Of how far a range of a cosine ends behind π/2, the start of Newton's steps before it, which
leave less than the last bits of an angle."""
TINY = 1e-30  # a slope without which there is no range
TOUCH_SHARES = (0.0, 0.5, 1.0)  # shares of a range of swings at which its planes touch the cosine
WIDE = 20.0  # arm lengths: over a larger box of pivots no plane cuts anything off


@dataclass(frozen=True)
class FreePivotPressureAngle(NonconvexConstraint):
    """|tan α| ≤ slope in the chart z = (p, q); arm l [mm], sense σ, slope t."""

    order: ClassVar[int] = 1
    arm: float
    sense: float
    slope: float

    def excess(self, s: Any, z: Any) -> tuple[Any, ...]:
        p, q = z
        phi = s[0] / self.arm
        cosine, sine = np.cos(phi), np.sin(phi)
        across, beside = p * cosine - q * sine, self.slope * (p * sine + q * cosine)
        lever = self.arm + self.sense * s[1]
        return (lever - across - beside) / self.arm, (across - beside - lever) / self.arm

    @property
    def speed_curvatures(self) -> tuple[float, float]:
        # F = D cos(ψ − α) − l bends down where it is positive; of F = l − D cos(ψ + α), with
        # D = d √(1 + t²), l² F'' = D cos(ψ + α) = l − F. Both are linear in z.
        return 0.0, 1.0 / self.arm

    def half_planes(self, s: Array) -> tuple[PointInequalities, ...]:
        phi, lever, still = s[0] / self.arm, self.arm + self.sense * s[1], np.zeros_like(s)
        cosine, sine, t = np.cos(phi), np.sin(phi), self.slope
        above = np.stack([-cosine - t * sine, sine - t * cosine])
        below = np.stack([cosine - t * sine, -sine - t * cosine])
        return PointInequalities(still, above, -lever), PointInequalities(still, below, lever)

    def linear_relaxation(
        self, box: MotionSizeBox, about: tuple[Array, Vector] | None
    ) -> tuple[PointInequalities, ...]:
        low, high = box.s_min / self.arm, box.s_max / self.arm
        widest = max(b - a for a, b in box.sizes)
        if not np.all(np.isfinite(high - low)) or widest > WIDE * self.arm:
            return ()
        if about is None:
            size = tuple(0.5 * (a + b) for a, b in box.sizes)
            swings = [low + share * (high - low) for share in TOUCH_SHARES]
        else:
            size = tuple(min(max(v, a), b) for v, (a, b) in zip(about[1], box.sizes, strict=True))
            swings = [np.clip(about[0][0] / self.arm, low, high)]
        # Each side of |tan α| ≤ t bounds l + σ s' by d √(1 + t²) cos(ψ + turn). Replacing the
        # cosine by a plane above it over the whole box leaves a linear, implied inequality.
        corners = tuple(product(*box.sizes))
        reach, alpha = hypot(1.0, self.slope), atan(self.slope)
        none, one, found = np.zeros_like(low), np.ones_like(low), list[PointInequalities]()
        for sign, turn in ((1.0, -alpha), (-1.0, alpha - pi)):
            for phi in swings:
                along, by_size, height = majorant_plane(turn, corners, (low, high), (phi, size))
                # sign (l + σ s') ≤ D' d cos(ψ + turn)
                steep = -reach * along / self.arm
                rows = np.stack([steep, sign * self.sense * one, none, none])
                upper = reach * height - sign * self.arm
                found.append(PointInequalities(rows, -reach * by_size, upper))
        return tuple(found)


@dataclass(frozen=True)
class FixedPivotPressureAngle(NonconvexConstraint):
    """|tan α| ≤ slope in the chart z = (w,), the centre distance d [mm] being given."""

    order: ClassVar[int] = 1
    arm: float
    distance: float
    sense: float
    slope: float

    @property
    def _angle(self) -> float:
        """α_max [rad]."""
        return atan(self.slope)

    @property
    def _reach(self) -> float:
        """D = d √(1 + t²) [mm]."""
        return self.distance * hypot(1.0, self.slope)

    def excess(self, s: Any, z: Any) -> tuple[Any, ...]:
        (w,) = z
        psi = (s[0] + w) / self.arm
        lever, unit = self.arm + self.sense * s[1], max(self.arm, self._reach)
        above = lever - self._reach * np.cos(psi - self._angle)
        below = self._reach * np.cos(psi + self._angle) - lever
        return above / unit, below / unit

    @property
    def speed_curvatures(self) -> tuple[float, float]:
        return 0.0, 1.0 / self.arm  # the same of s + w, in which F rises, then falls

    def half_planes(self, s: Array) -> tuple[PointInequalities, ...]:
        # With cos A = (l + σ s')/D the two rows read cos(ψ − α) ≥ cos A and cos(ψ + α) ≤ cos A, so
        # |A − α| ≤ ψ ≤ min(A + α, 2π − A − α): four half-planes of the one size variable.
        share, alpha, still = (self.arm + self.sense * s[1]) / self._reach, self._angle, 0.0 * s
        a = np.arccos(np.clip(share, -1.0, 1.0))
        # no angle at all where |share| > 1 leaves none: ends that exclude each other
        a = np.where(share > 1.0, -2.0 * pi, a)
        least = (alpha - a, np.where(share < -1.0, a, a - alpha))
        most = (alpha + a, 2.0 * pi - a - alpha)
        if np.any(share < -1.0):
            most = (most[0], np.where(share < -1.0, -pi, most[1]))
        one = np.ones((1, s.shape[1]))
        return (
            *(PointInequalities(still, -one, s[0] - self.arm * low) for low in least),
            *(PointInequalities(still, one, self.arm * high - s[0]) for high in most),
        )

    def linear_relaxation(
        self, box: MotionSizeBox, about: tuple[Array, Vector] | None
    ) -> tuple[PointInequalities, ...]:
        ((w_low, w_high),), found = box.sizes, list[PointInequalities]()
        low = np.clip((box.s_min + w_low) / self.arm, 0.0, pi)
        high = np.clip((box.s_max + w_high) / self.arm, 0.0, pi)
        for sign, turn in ((1.0, -self._angle), (-1.0, pi - self._angle)):
            # v = sign ψ + turn, and −α_max ≤ v ≤ π − α_max
            ends = np.sort(np.stack([sign * low + turn, sign * high + turn]), axis=0)
            at = ends[0]
            if about is not None:
                at = sign * np.clip((about[0][0] + about[1][0]) / self.arm, low, high) + turn
            # Only angles at which the constraint can be active matter; over them the cosine is
            # replaced by its concave hull, and the hull by tangents.
            ends = self._active_range(sign, box, ends, at)
            hull = ConcaveHull.over(ends[0], ends[1])
            where = [at]
            if about is None:
                where = [ends[0] + share * (hull.touch - ends[0]) for share in TANGENT_SHARES]
                where.append(ends[1])
            for v in where:
                value, slope = hull.line(v)
                # sign (l + σ s') ≤ D [value + slope (sign (w + s)/l + turn)]
                steep = -self._reach * slope * sign / self.arm
                one, none = np.ones_like(v), np.zeros_like(v)
                coefficients = np.stack([steep, sign * self.sense * one, none, none])
                upper = self._reach * (value + slope * turn) - sign * self.arm
                found.append(PointInequalities(coefficients, steep[None, :], upper))
        return tuple(found)

    def _active_range(self, sign: float, box: MotionSizeBox, ends: Array, at: Array) -> Array:
        """The part of a range of v over which a row has to hold, s' being bounded.

        The row reads cos v ≥ sign (l + σ s')/D. With inner and outer the arccosines of the largest
        and the smallest right side, it always holds where |v| ≤ inner, and never where |v| > outer.
        So it is active on one side of 0 or on both. Where it is active below 0, the part below is
        left out if the place ``at`` of the tangents, (n,), is above: lines that touch the cosine
        above ``inner`` fall, and hold below it as well.
        """
        speeds = np.stack([box.v_min, box.v_max])
        with np.errstate(invalid="ignore"):
            share = np.sort(sign * (self.arm + self.sense * speeds) / self._reach, axis=0)
        inner, outer = np.arccos(np.clip(share[::-1], -1.0, 1.0))
        below = (ends[0] < -inner) & (at < 0.0)
        low = np.maximum(ends[0], np.where(below, -outer, inner))
        nearer = np.stack([low, np.minimum(ends[1], outer)])
        return np.asarray(np.where(nearer[0] < nearer[1], nearer, ends))


@dataclass(frozen=True, eq=False)
class ConcaveHull:
    """The least concave function above the cosine on [low, high] within (−π/2, π], (n,) each.

    It is the cosine up to ``touch``, and from there the line to the end at ``high``.
    """

    low: Array
    high: Array
    touch: Array

    @classmethod
    def over(cls, low: Array, high: Array) -> ConcaveHull:
        """The tangent from the end touches where f(c) = cos c − sin c (high − c) − cos high is 0.

        f falls and is convex up to π/2: Newton's steps from a place before its zero stay before it,
        where tangents pass above the end. The zero lies nearly half as far before π/2 as the end
        lies behind it.
        """
        beyond, most = np.maximum(high - 0.5 * pi, 0.0), np.maximum(np.minimum(high, 0.5 * pi), low)
        touch = np.maximum(0.5 * pi - BEFORE * beyond, low)
        for _ in range(NEWTON_STEPS):
            excess = np.cos(touch) - np.sin(touch) * (high - touch) - np.cos(high)
            slope = np.maximum(np.cos(touch) * (high - touch), TINY)
            touch = np.minimum(touch + np.maximum(excess, 0.0) / slope, most)
        return cls(low, high, np.where(high <= 0.5 * pi, high, touch))

    def line(self, v: Array) -> tuple[Array, Array]:
        """Value at 0 and slope of the line that touches the hull at v."""
        v = np.maximum(v, self.low)
        at = np.minimum(v, self.touch)
        width = np.maximum(self.high - self.touch, 1e-300)
        chord = (np.cos(self.high) - np.cos(self.touch)) / width
        convex = (v >= self.touch) & (self.high - self.touch > 1e-9)
        slope = np.where(convex, chord, -np.sin(at))
        return np.cos(at) - slope * at, slope


ROUNDING = 1e-13  # relative: a plane is raised by it, far above the rounding of its terms
Point = Sequence[float]


def majorant_plane(
    turn: float, corners: Sequence[Point], swing: tuple[Array, Array], at: tuple[Array, Point]
) -> tuple[Array, Array, Array]:
    """The lowest plane above d cos(ψ + turn) that is as steep as this is at a place.

    Args:
        corners: (p, q) of a polygon in which the pivot lies [mm].
        swing: lower and upper end of φ, (n,) each [rad].
        at: φ (n,) and (p, q) of the place.

    Returns:
        (n,), (2, n) and (n,) of the plane along · φ + size · (p, q) + height [mm].
    """
    # The tangent plane's slopes at the place.
    phi, (p, q) = at[0] + turn, at[1]
    size = np.stack([np.cos(phi), -np.sin(phi)])
    along = -p * np.sin(phi) - q * np.cos(phi)
    # What stands above a plane of these slopes is linear in (p, q), hence largest at a corner.
    left = [
        max_of_cosine_minus_line(hypot(*corner), atan2(corner[1], corner[0]) + turn, along, *swing)
        - (size[0] * corner[0] + size[1] * corner[1])
        for corner in corners
    ]
    terms = max(hypot(*corner) for corner in corners) + np.abs(along) * np.abs(swing[1])
    return along, size, np.max(left, axis=0) + ROUNDING * terms


def max_of_cosine_minus_line(
    reach: float, start: float, slope: Array, low: Array, high: Array
) -> Array:
    """The largest of reach · cos(φ + start) − slope · φ for φ between low and high."""

    def difference(phi: Array) -> Array:
        return np.asarray(reach * np.cos(phi + start) - slope * phi)

    # A stationary point has −reach · sin(φ + start) = slope; it is a maximum where the cosine is
    # positive. Of its periods the one nearest to the range is clipped to it: the function has one
    # maximum a period, so its largest value over the range is there or at an end.
    top = np.arcsin(np.clip(-slope / max(reach, 1e-300), -1.0, 1.0)) - start
    top = top + 2.0 * pi * np.round((0.5 * (low + high) - top) / (2.0 * pi))
    inner = difference(np.clip(top, low, high))
    return np.asarray(np.maximum(np.maximum(difference(low), difference(high)), inner))
