"""Constraints on a flat face that swings, on motion and size together.

Symbols as in ``oscillating_flat_face``: d centre distance, f offset of the face, ψ = ψ0 + φ its
angle at the pivot, w = 1 + σφ' > 0, Rb = d sinψ0 − f, p = d cosψ0. With d given, the profile radius
is at least ρ where

    φ'' ≥ Φ(ψ, w) = k w³ / cosψ − w (2w − 1) tanψ,  k = (f + ρ)/d.

A plane as steep as Φ at the middle of a range of ψ and w lies below it once it is lowered by the
least of what is left; that is enclosed on small cells, from the middle of each and the range of the
slopes on it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from synthesis.catalogue.constraints import (
    MotionSizeBox,
    NonconvexConstraint,
    PointInequalities,
    Vector,
)
from synthesis.catalogue.followers.arm_pressure_angle import max_of_cosine_minus_line
from synthesis.numerics.piecewise import Array

RIGHT_ANGLE = 0.5 * math.pi
MIN_SQUARE = 1e-6  # added to a normal's squared length, which may vanish at single angles
FAR = 1e6  # rad: stands for an infinite bound of an angle
CELLS = (16, 6)  # of the enclosure, along ψ and along w; its cost grows with their product
STEEPEST = 1.45  # rad: beyond 83° tanψ grows so fast that no plane bounds anything
ROUNDING = 1e-12  # relative: a plane is lowered by it, far above the rounding of its terms


@dataclass(frozen=True)
class SwingingFaceConstraint(NonconvexConstraint):
    """A d cosψ + B d sinψ ≤ C, one limit on a face that swings.

    A = along + bend φ'', B = lean + bend (1 + 2σφ') w, C = known + first w + cubed w³.

    Attributes:
        reference: mm of displacement per radian. sigma: σ. offset: f [mm].
        distance: d [mm] where it is a number: then z = (Rb,), else z = (p, Rb).
    """

    order: ClassVar[int] = 2
    linearises: ClassVar[bool] = False
    reference: float
    sigma: float
    offset: float
    distance: float | None
    bend: float = 0.0
    along: float = 0.0
    lean: float = 0.0
    known: float = 0.0
    first: float = 0.0
    cubed: float = 0.0

    @property
    def has_relaxation(self) -> bool:
        return self.distance is not None and not self.lean

    def _terms(self, s: Any) -> tuple[Any, Any, Any]:
        """A, B and C."""
        v, a = s[1] / self.reference, s[2] / self.reference
        w = 1.0 + self.sigma * v
        fast = (1.0 + 2.0 * self.sigma * v) * w
        return (
            self.along + self.bend * a,
            self.lean + self.bend * fast,
            self.known + self.first * w + self.cubed * w * w * w,
        )

    def excess(self, s: Any, z: Any) -> tuple[Any, ...]:
        a, b, c = self._terms(s)
        q, swing = z[-1] + self.offset, s[0] / self.reference
        p = z[0] if self.distance is None else (self.distance**2 - q * q) ** 0.5
        cos, sin = np.cos(swing), np.sin(swing)
        # over d times the length of the half-plane's normal
        unit = ((p * p + q * q) * (a * a + b * b + MIN_SQUARE)) ** 0.5
        return ((a * (p * cos - q * sin) + b * (p * sin + q * cos) - c) / unit,)

    def half_planes(self, s: Array) -> tuple[PointInequalities, ...]:
        a, b, c = self._terms(s)
        swing, still = s[0] / self.reference, np.zeros_like(s)
        cos, sin = np.cos(swing), np.sin(swing)
        # ψ = ψ0 + φ turned back by φ: the limit reads a d cosψ0 + b d sinψ0 ≤ C, linear in z.
        a, b = a * cos + b * sin, b * cos - a * sin
        if self.distance is None:
            return (PointInequalities(still, np.stack([a, b]), c - b * self.offset),)
        least, most = self._interval(np.hypot(a, b) * self.distance, np.arctan2(b, a), c)
        one = np.ones((1, s.shape[1]))
        return PointInequalities(still, -one, -self._base(least)), PointInequalities(
            still, one, self._base(most)
        )

    def _interval(self, reach: Array, turn: Array, c: Array) -> tuple[Array, Array]:
        """Least and largest ψ0 with reach · cos(ψ0 − turn) ≤ C, ψ0 within a right angle of 0.

        Where angles on both sides of a forbidden arc remain, nothing is said.
        """
        # The arc turn ± gap is forbidden; what remains of the angles on one side of it is a range.
        share = c / reach
        gap = np.arccos(np.clip(share, -1.0, 1.0))
        lowest = math.asin(max(min(self.offset / float(self.distance or 1.0), 0.0), -1.0))
        below, above = turn - gap > lowest, turn + gap < RIGHT_ANGLE
        least = np.where(above & ~below, turn + gap, -FAR)
        most = np.where(below & ~above, turn - gap, FAR)
        # A forbidden arc of more than half a turn leaves one arc about the opposite angle.
        other = turn - math.pi * np.where(turn > 0.0, 1.0, -1.0)
        wide = share <= 0.0
        least = np.where(wide, other - (math.pi - gap), least)
        most = np.where(wide, other + (math.pi - gap), most)
        # The whole circle is forbidden, or what is allowed lies outside of the right angles.
        never = (share < -1.0) | ((share > 0.0) & (share < 1.0) & ~below & ~above)
        least, most = np.where(never, FAR, least), np.where(never, -FAR, most)
        free = share >= 1.0
        return np.where(free, -FAR, least), np.where(free, FAR, most)

    def _base(self, angle: Array) -> Array:
        """Rb at ψ0, continued beyond the right angles by a line [mm]."""
        inside = np.clip(angle, -RIGHT_ANGLE, RIGHT_ANGLE)
        distance = float(self.distance or 0.0)
        return np.asarray(distance * (np.sin(inside) + angle - inside) - self.offset)

    def relax(
        self, box: MotionSizeBox, about: tuple[Array, Vector] | None
    ) -> tuple[PointInequalities, ...]:
        """Where the pivot is given: planes over what the face's angle and speed can be."""
        if (
            self.distance is None
            or not self.has_relaxation
            or not np.all(np.isfinite(box.v_max - box.v_min))
        ):
            return ()
        ((low, high),) = box.sizes
        start = (low + self.offset) / self.distance, (high + self.offset) / self.distance
        if not 0.0 <= start[0] <= start[1] < 1.0:
            return ()
        swing = box.s_min / self.reference, box.s_max / self.reference
        angle = Interval(swing[0] + math.asin(start[0]), swing[1] + math.asin(start[1]))
        rate = self.sigma * np.stack([box.v_min, box.v_max]) / self.reference
        below = self._minorant(
            angle, Interval(1.0 + np.min(rate, axis=0), 1.0 + np.max(rate, axis=0))
        )
        if below is None:
            return ()
        # bend φ'' + by_angle (φ + ψ0) + by_speed (1 + σ φ') + height ≤ known
        steep, level = _line_below(below.by_angle, start, angle)
        none, one = np.zeros_like(angle.low), np.ones_like(angle.low)
        rows = np.stack(
            [below.by_angle, self.sigma * below.by_speed, self.bend * one, none]
        ) / self.reference  # fmt: skip
        upper = -(level + below.by_speed + below.height)
        size = (steep / self.distance)[None, :]
        return (PointInequalities(rows, size, upper - steep * self.offset / self.distance),)

    def _minorant(self, angle: Interval, speed: Interval) -> MinorantPlane | None:
        """A plane below the left side less the right one, over d where there is no bend."""
        assert self.distance is not None
        if self.bend:
            return minorant_plane(-self.cubed / self.distance, angle, speed)
        middle = 0.5 * (angle.low + angle.high)
        # along d cosψ is −along d cos(ψ + π) where along > 0
        turn = math.pi if self.along > 0.0 else 0.0
        reach = abs(self.along)
        slope = -reach * np.sin(middle + turn)
        height = max_of_cosine_minus_line(reach, turn, slope, angle.low, angle.high)
        first = np.full_like(middle, -self.first / self.distance)
        return MinorantPlane(-slope, first, -height - self.known / self.distance)


def _line_below(
    by_angle: Array, start: tuple[float, float], angle: Interval
) -> tuple[Array, Array]:
    """Slope and height of a line in sinψ0 below by_angle · ψ0, which is convex in it or concave."""
    low, high = (math.asin(end) for end in start)
    middle = 0.5 * (low + high)
    tangent = 1.0 / math.cos(middle)
    chord = (high - low) / (start[1] - start[0]) if start[1] > start[0] else tangent
    touching = middle - tangent * math.sin(middle), low - chord * start[0]
    convex = by_angle >= 0.0
    return (
        by_angle * np.where(convex, tangent, chord),
        by_angle * np.where(convex, touching[0], touching[1]),
    )


@dataclass(frozen=True)
class LeastPivotDistance(NonconvexConstraint):
    """The pivot no nearer than ``least`` [mm], where z = (p, Rb); ``offset``: f [mm].

    Not convex: no half-plane says it, and the one that stands for it excludes nothing. As the lower
    end of a norm of the size, as of an arm, the local search ends at larger cams.
    """

    order: ClassVar[int] = 0
    linearises: ClassVar[bool] = False
    least: float
    offset: float

    @property
    def has_relaxation(self) -> bool:
        return False

    def excess(self, s: Any, z: Any) -> tuple[Any, ...]:
        p, q = z[0], z[1] + self.offset
        return (1.0 - (p * p + q * q) / self.least**2 + 0.0 * s[0],)

    def half_planes(self, s: Array) -> tuple[PointInequalities, ...]:
        count = s.shape[1]
        size = np.stack([np.zeros(count), -np.ones(count)])
        return (PointInequalities(np.zeros_like(s), size, np.full(count, FAR * self.least)),)


# -- planes below Φ over a range of the face's angle and its speed --------------------------------


class Interval(NamedTuple):
    """An interval, elementwise."""

    low: Array
    high: Array

    def times(self, other: Interval) -> Interval:
        """All products."""
        each = np.stack([a * b for a in self for b in other])
        return Interval(np.min(each, axis=0), np.max(each, axis=0))

    def less(self, other: Interval) -> Interval:
        """All differences."""
        return Interval(self.low - other.high, self.high - other.low)

    def reach(self) -> Array:
        """The largest absolute value."""
        return np.maximum(np.abs(self.low), np.abs(self.high))


class MinorantPlane(NamedTuple):
    """by_angle · ψ + by_speed · w + height at n points, (n,) each."""

    by_angle: Array
    by_speed: Array
    height: Array


def minorant_plane(k: float, angle: Interval, speed: Interval) -> MinorantPlane | None:
    """A plane below Φ for angles [rad] and speeds in ranges (n,); None where there is none."""
    if np.max(angle.reach()) > STEEPEST or not np.all(speed.low > 0.0):
        return None
    psi, w = 0.5 * (angle.low + angle.high), 0.5 * (speed.low + speed.high)
    # The slopes of Φ in the middle of the range.
    slopes = _slopes(k, Interval(psi, psi), Interval(w, w))
    by_angle, by_speed = slopes[0].low, slopes[1].low
    # What stands above a plane of these slopes, at the middle of every cell, less the most that it
    # can fall from there: the range of its slopes times half the cell's width (mean value theorem).
    parts, widths = [], []
    for ends, count in zip((angle, speed), CELLS, strict=True):
        shares = np.linspace(0.0, 1.0, count + 1)[:, None]
        edges = ends.low + (ends.high - ends.low) * shares
        parts.append(Interval(edges[:-1], edges[1:]))
        widths.append((ends.high - ends.low) / (2.0 * count))
    cell = Interval(*(np.repeat(edge, CELLS[1], axis=0) for edge in parts[0]))
    pace = Interval(*(np.tile(edge, (CELLS[0], 1)) for edge in parts[1]))
    middle, fast = 0.5 * (cell.low + cell.high), 0.5 * (pace.low + pace.high)
    left = _bend(k, middle, fast) - by_angle * middle - by_speed * fast
    along, across = _slopes(k, cell, pace)
    slack = along.less(Interval(by_angle, by_angle)).reach() * widths[0]
    slack = slack + across.less(Interval(by_speed, by_speed)).reach() * widths[1]
    height = np.min(left - slack, axis=0)
    height -= ROUNDING * (1.0 + np.abs(height) + np.abs(by_angle) + np.abs(by_speed))
    return MinorantPlane(by_angle, by_speed, height)


def _bend(k: float, psi: Array, w: Array) -> Array:
    """Φ."""
    return np.asarray(k * w**3 / np.cos(psi) - w * (2.0 * w - 1.0) * np.tan(psi))


def _slopes(k: float, psi: Interval, w: Interval) -> tuple[Interval, Interval]:
    """The ranges of ∂Φ/∂ψ and ∂Φ/∂w over cells, |ψ| < 90° and w > 0."""
    far = psi.reach()
    near = np.where(psi.low * psi.high < 0.0, 0.0, np.minimum(np.abs(psi.low), np.abs(psi.high)))
    secant = Interval(1.0 / np.cos(near), 1.0 / np.cos(far))
    sine, tangent = (
        Interval(np.sin(psi.low), np.sin(psi.high)),
        Interval(np.tan(psi.low), np.tan(psi.high)),
    )
    factor = Interval(np.full_like(w.low, k), np.full_like(w.low, k))
    cube, square = Interval(w.low**3, w.high**3), Interval(3.0 * w.low**2, 3.0 * w.high**2)
    other = w.times(Interval(2.0 * w.low - 1.0, 2.0 * w.high - 1.0))
    along = factor.times(cube).times(sine).less(other).times(secant.times(secant))
    across = factor.times(square).times(secant)
    return along, across.less(Interval(4.0 * w.low - 1.0, 4.0 * w.high - 1.0).times(tangent))
