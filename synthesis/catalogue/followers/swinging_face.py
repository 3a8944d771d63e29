"""Constraints on a flat face that swings, on motion and size together.

Symbols as in ``oscillating_flat_face``: d centre distance, f offset of the face, ψ = ψ0 + φ its
angle at the pivot, w = 1 + σφ' > 0, Rb = d sinψ0 − f, p = d cosψ0. With d given, the profile radius
is at least ρ where

    φ'' ≥ Φ(ψ, w) = k w³ / cosψ − w (2w − 1) tanψ,  k = (f + ρ)/d.

A plane as steep as Φ at the middle of a range of ψ and w lies below it once it is lowered by the
least of what is left; that is enclosed on small cells by affine models.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from synthesis.catalogue.constraints import (
    AffineNorm,
    MotionSizeBox,
    NonconvexConstraint,
    NormBounds,
    PointInequalities,
    Vector,
)
from synthesis.catalogue.followers.arm_pressure_angle import max_of_cosine_minus_line
from synthesis.numerics.affine import Affine
from synthesis.numerics.piecewise import Array

RIGHT_ANGLE = 0.5 * math.pi  # rad
MIN_SQUARE = 1e-6  # added to a normal's squared length, which may vanish at single angles
FAR = 1e6  # rad: stands for an infinite bound of an angle
CELLS = (16, 6)  # of the enclosure, along ψ and along w; its cost grows with their product
STEEPEST = 1.45  # rad: beyond 83° tanψ grows so fast that no plane bounds anything
Ranges = tuple[Array, Array]  # lower and upper ends, (n,) each
Plane = tuple[Array, Array, Array]


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
        one, lowest, highest = np.ones((1, s.shape[1])), self._base(least), self._base(most)
        return PointInequalities(still, -one, -lowest), PointInequalities(still, one, highest)

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
        if self.distance is None or not self.has_relaxation:
            return ()
        if not np.all(np.isfinite(box.v_max - box.v_min)):
            return ()
        ((low, high),) = box.sizes
        start = (low + self.offset) / self.distance, (high + self.offset) / self.distance
        if not 0.0 <= start[0] <= start[1] < 1.0:
            return ()
        swing = box.s_min / self.reference, box.s_max / self.reference
        angle = swing[0] + math.asin(start[0]), swing[1] + math.asin(start[1])
        rate = self.sigma * np.stack([box.v_min, box.v_max]) / self.reference
        below = self._minorant(angle, (1.0 + np.min(rate, axis=0), 1.0 + np.max(rate, axis=0)))
        if below is None:
            return ()
        by_angle, by_speed, height = below
        # bend φ'' + by_angle (φ + ψ0) + by_speed (1 + σ φ') + height ≤ known
        steep, level = _line_below(by_angle, start)
        none = np.zeros_like(height)
        rows = np.stack([by_angle, self.sigma * by_speed, none + self.bend, none]) / self.reference
        upper = -(level + by_speed + height)
        size = (steep / self.distance)[None, :]
        return (PointInequalities(rows, size, upper - steep * self.offset / self.distance),)

    def _minorant(self, angle: Ranges, speed: Ranges) -> Plane | None:
        """A plane below the left side less the right one, over d where there is no bend."""
        assert self.distance is not None
        if self.bend:
            return minorant_plane(-self.cubed / self.distance, angle, speed)
        # along d cosψ is −along d cos(ψ + π) where along > 0
        turn, reach = math.pi if self.along > 0.0 else 0.0, abs(self.along)
        slope = -reach * np.sin(0.5 * (angle[0] + angle[1]) + turn)
        height = max_of_cosine_minus_line(reach, turn, slope, *angle) + self.known / self.distance
        return -slope, np.full_like(slope, -self.first / self.distance), -height


def _line_below(by_angle: Array, start: tuple[float, float]) -> tuple[Array, Array]:
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
    has_relaxation: ClassVar[bool] = False
    least: float
    offset: float

    def excess(self, s: Any, z: Any) -> tuple[Any, ...]:
        p, q = z[0], z[1] + self.offset
        return (1.0 - (p * p + q * q) / self.least**2 + 0.0 * s[0],)

    @property
    def norm_bounds(self) -> tuple[NormBounds, ...]:
        centred = AffineNorm(((1.0, 0.0), (0.0, 1.0)), (0.0, self.offset))
        return (NormBounds(centred, math.inf, self.source, self.least),)

    def half_planes(self, s: Array) -> tuple[PointInequalities, ...]:
        count = s.shape[1]
        size = np.stack([np.zeros(count), -np.ones(count)])
        return (PointInequalities(np.zeros_like(s), size, np.full(count, FAR * self.least)),)


def minorant_plane(k: float, angle: Ranges, speed: Ranges) -> Plane | None:
    """A plane by_angle · ψ + by_speed · w + height below Φ, (n,) each, over ranges of ψ and w."""
    if np.max(np.abs(angle)) > STEEPEST or not np.all(speed[0] > 0.0):
        return None
    # 1. The slopes of Φ in the middle of the ranges.
    psi, w = 0.5 * (angle[0] + angle[1]), 0.5 * (speed[0] + speed[1])
    by_angle = (k * w**3 * np.sin(psi) - w * (2.0 * w - 1.0)) / np.cos(psi) ** 2
    by_speed = 3.0 * k * w**2 / np.cos(psi) - (4.0 * w - 1.0) * np.tan(psi)
    # 2. What stands above a plane of these slopes, enclosed by affine models on small cells.
    low, width = np.stack([angle[0], speed[0]], axis=-1), np.ptp([angle, speed], axis=1).T / CELLS
    nth = np.moveaxis(np.indices(CELLS), 0, -1).reshape(-1, 1, 2)
    at, pace = Affine.variables(low + width * nth, low + width * (nth + 1))
    above = (pace * pace * pace * k - pace * (pace * 2.0 - 1.0) * np.sin(at)) / np.cos(at)
    above = above - at * by_angle - pace * by_speed
    return by_angle, by_speed, np.min(above.lower, axis=0)
