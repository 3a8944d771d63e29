"""Constraints on a flat face that swings, on motion and size together.

Symbols as in ``oscillating_flat_face``: d centre distance, f offset of the face, ψ = ψ0 + φ its
angle at the pivot, w = 1 + σφ' > 0, Rb = d sinψ0 − f, p = d cosψ0. The profile radius is at least ρ
where

    φ'' ≥ [(f + ρ) w³ − w (2w − 1) d sinψ] / (d cosψ),

and the other limits read the same without φ''. Over a box of motion and size a plane as steep as
the right side at a place of it lies below, once it is lowered by the least of what is left.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from synthesis.catalogue.constraints import (
    AffineNorm,
    ExtremalMove,
    MotionSizeBox,
    NonconvexConstraint,
    NormBounds,
    PointInequalities,
    Vector,
)
from synthesis.numerics.affine import minorant_plane, positive
from synthesis.numerics.piecewise import Array

RIGHT_ANGLE = 0.5 * math.pi  # rad
MIN_SQUARE = 1e-6  # added to a normal's squared length, which may vanish at single angles
LEAST_SQUARE = 1e-14  # added to the square of a distance over its least: smooth at 0 too
FAR = 1e6  # rad: stands for an infinite bound of an angle
WIDE = 20.0  # rad, rad per rad: over a wider box of motion no plane bounds anything
ROUNDING = 1e-12  # of the lengths in a half-plane: a thousand times what its terms are rounded by
SLOWEST_TURN = 1e-3  # of the normal's: how fast the cam turns at least on a law that is proposed
RAMP_PARTS = 4  # intervals of a ramp
ARC_PARTS_AT_UNIT_RAMP = 1.1  # of an arc, over the root of a ramp's share: each costs as much
GROWTH = 2.0  # from one interval beside a ramp to the next
SAMPLES = 8  # in each: h is integrated between them as if h'' were straight
CELLS = (4, 4, 1, 1)  # of the enclosure along φ, φ' and the size; its cost grows with their product

Planes = tuple[PointInequalities, ...]


@dataclass(frozen=True)
class SwingingFaceConstraint(NonconvexConstraint):
    """A d cosψ + B d sinψ ≤ C, one limit on a face that swings.

    A = along + bend φ'', B = lean + bend (1 + 2σφ') w, C = known + first w + cubed w³.

    Attributes:
        reference: mm of displacement per radian. sigma: σ. offset: f [mm].
        distance: d [mm] where it is a number: then z = (Rb,), else z = (p, Rb).
    """

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
    def order(self) -> int:  # type: ignore[override]
        return 2 if self.bend else 1

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

    def half_planes(self, s: Array) -> Planes:
        return self._half_planes(s[0] / self.reference, *self._terms(s))

    def half_planes_over_move(self, angle: float, start: Array, end: Array) -> Planes:
        """Of the profile radius: what a move leaves of the size, whatever its law.

        Seen from the cam the face's normal turns by w = 1 + σφ' > 0 per radian: over a move by
        B = β + σ Δφ, whatever the law. In that angle χ the radius is h + h'' ≥ ρ, h = d sinψ − f,
        as under a face on a slide. With the weight sin χ ≥ 0, B ≤ π, two integrations by parts
        leave the ends alone, of which the far one has a known h' = d cosψ φ'/w:

            d sinψ_near − cos B d sinψ_far + sin B h'_far ≥ (ρ + f) (1 − cos B),

        linear in d cosψ0 and d sinψ0. Mirrored, h' changes its sign and the ends their places.
        """
        turn = angle + self.sigma * float(end[0] - start[0]) / self.reference
        if not self.bend or turn > math.pi:
            return ()
        planes, cosine, sine = list[PointInequalities](), math.cos(turn), math.sin(turn)
        for far, near, sense in ((end, start, 1.0), (start, end, -1.0)):
            rate = far[1] / self.reference
            w = 1.0 + self.sigma * rate
            if not w > 0.0:
                continue  # s' is not known there
            # −h_near is a half-plane of ψ_near; the far end turned by what lies between them
            between = (far[0] - near[0]) / self.reference
            beside, ahead = cosine, -sense * sine * rate / w
            a = ahead * math.cos(between) + beside * math.sin(between)
            b = beside * math.cos(between) - ahead * math.sin(between) - 1.0
            c = self.cubed * (1.0 - cosine)
            c += ROUNDING * (abs(c) + self.reference)
            terms = (np.full(1, each) for each in (near[0] / self.reference, a, b, c))
            planes += self._half_planes(*terms)
        return tuple(planes)

    def extremal_move(
        self, angle: float, start: float, end: float, size: Vector, ramp: float
    ) -> ExtremalMove | None:
        """The law that runs along one radius R, but for ramps: what its half-plane asks for.

        In the normal's angle χ from the lower end h = R + (h_high − R) cos(B − χ), the solution of
        h + h'' = R that comes to rest at the higher end. It begins at a speed, which a ramp of h''
        reaches, straight up and straight down; its rest at the other end begins with another.
        """
        q, turn = size[-1] + self.offset, angle + self.sigma * (end - start) / self.reference
        distance = self.distance or math.hypot(size[0], q)
        base = math.asin(min(q / distance, 1.0))
        sense = self.sigma if end > start else -self.sigma
        low, high = (base + each / self.reference for each in sorted((start, end)))
        if not self.bend or not high < RIGHT_ANGLE or not 0.0 < turn <= math.pi:
            return None
        # 1. The radius that leaves the ends as they are, ramps and all.
        rise, step = distance * (math.sin(high) - math.sin(low)), ramp * turn
        top = turn - 0.5 * step  # of the arc, as if there were no ramp at the higher end
        reach = rise / (1.0 - math.cos(top - step))
        radius = distance * math.sin(high) - reach
        if radius < -self.cubed:
            return None
        # 2. h'', straight between places on the ramps, and h by integration.
        breaks = _breaks_along(turn, step)
        chi = _between(breaks)
        bend = -reach * np.cos(top - chi)
        slope, fall = reach * math.sin(top - 2.0 * step), -reach * math.cos(top - 2.0 * step)
        peak = slope / step - 0.5 * fall
        bend = np.where(chi < 2.0 * step, peak + (fall - peak) * (chi / step - 1.0), bend)
        bend = np.where(chi < step, peak * chi / step, bend)
        last = (turn - chi) / step
        bend = np.where(last < 1.0, -reach * math.cos(0.5 * step) * last, bend)
        width = np.diff(chi)
        rate = np.append(0.0, np.cumsum(0.5 * width * (bend[1:] + bend[:-1])))
        gain = width * rate[:-1] + width**2 * (2.0 * bend[:-1] + bend[1:]) / 6.0
        height = distance * math.sin(low) + np.append(0.0, np.cumsum(gain))
        # 3. The face's angle ψ, the cam's angle θ = χ − σ (ψ − ψ_low) and ψ'' along it.
        psi = np.arcsin(np.clip(height / distance, -1.0, 1.0))
        ahead = distance * np.cos(psi)
        by_chi = rate / ahead
        slowed = 1.0 - sense * by_chi  # dθ/dχ
        if not slowed.min() > SLOWEST_TURN:
            return None
        second = (bend + height * by_chi**2) / ahead / slowed**3
        theta = chi - sense * (psi - psi[0])
        x, places = theta / theta[-1], np.interp(breaks, chi, theta) / theta[-1]
        if end < start:
            x, second, places = 1.0 - x[::-1], second[::-1], 1.0 - places[::-1]
        return ExtremalMove(places, x, self.reference * second)

    def _half_planes(self, swing: Array, a: Array, b: Array, c: Array) -> Planes:
        """a d cosψ + b d sinψ ≤ c at swings φ = ψ − ψ0, (n,) each, as half-planes of the size."""
        still, cos, sin = np.zeros((4, len(swing))), np.cos(swing), np.sin(swing)
        # ψ = ψ0 + φ turned back by φ: the limit reads a d cosψ0 + b d sinψ0 ≤ c, linear in z.
        a, b = a * cos + b * sin, b * cos - a * sin
        if self.distance is None:
            return (PointInequalities(still, np.stack([a, b]), c - b * self.offset),)
        least, most = self._interval(np.hypot(a, b) * self.distance, np.arctan2(b, a), c)
        one, lowest, highest = np.ones((1, len(swing))), self._base(least), self._base(most)
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

    def linear_relaxation(self, box: MotionSizeBox, about: tuple[Array, Vector] | None) -> Planes:
        """A plane below the limit's left side less its right one, divided by d cosψ if it bends."""
        unit, one = self.reference, np.ones_like(box.s_min)
        sizes = np.array(box.sizes).T[:, :, None] * one
        low = np.concatenate([np.stack([box.s_min, box.v_min]), sizes[0]]) / unit
        high = np.concatenate([np.stack([box.s_max, box.v_max]), sizes[1]]) / unit
        if not np.all(high - low <= WIDE):
            return ()
        at = 0.5 * (low + high)
        if about is not None:
            at = np.concatenate([about[0][:2], np.outer(about[1], one)]) / unit
        below = minorant_plane(self._left, low, high, np.clip(at, low, high), CELLS[: len(low)])
        if below is None:
            return ()
        slopes, height = below
        none = np.zeros_like(height)
        rows = np.stack([slopes[0], slopes[1], none + self.bend, none]) / unit
        return (PointInequalities(rows, slopes[2:] / unit, -height),)

    def _left(self, swing: Any, rate: Any, *size: Any) -> Any:
        """What must not exceed 0, of a limit with a bend −bend φ''; lengths over the reference."""
        unit, w = self.reference, rate * self.sigma + 1.0
        q = size[-1] + self.offset / unit
        if self.distance is None:
            p = size[0]
        else:
            p = np.sqrt(q * q * -1.0 + (self.distance / unit) ** 2)
        cos, sin = np.cos(swing), np.sin(swing)
        ahead, beside = p * cos - q * sin, p * sin + q * cos
        lean = (w * 2.0 - 1.0) * w * self.bend + self.lean
        most = w * w * w * (self.cubed / unit) + w * (self.first / unit) + self.known / unit
        left = beside * lean - most
        return left / positive(ahead) if self.bend else left + ahead * self.along


def _breaks_along(turn: float, ramp: float) -> Array:
    """Places on an arc between which it is nearly straight: on its ramps, ever wider beside them.

    A ramp up and one down at the beginning, one at the end.
    """
    ramps = np.linspace(0.0, ramp, RAMP_PARTS + 1)
    widths = GROWTH ** np.arange(1, math.floor(math.log(turn / ramp, GROWTH)) + 1) * ramps[1]
    parts = math.ceil(ARC_PARTS_AT_UNIT_RAMP / math.sqrt(ramp / turn))
    beside = np.cumsum(widths[widths < turn / parts])
    first, last = 2.0 * ramp, turn - ramp
    inner = np.linspace(first + beside[-1], last - beside[-1], parts + 1)
    ends = first + beside[:-1], last - beside[-2::-1]
    return np.concatenate([ramps, ramp + ramps[1:], ends[0], inner, ends[1], last + ramps])


def _between(breaks: Array) -> Array:
    """Places, and more of them in every interval between."""
    inner = breaks[:-1, None] + np.diff(breaks)[:, None] * np.arange(SAMPLES) / SAMPLES
    return np.append(inner.ravel(), breaks[-1])


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
        # the distance itself: its square has no slope where the pivot is next to the cam's axis
        p, q = z[0] / self.least, (z[1] + self.offset) / self.least
        return (1.0 - (p * p + q * q + LEAST_SQUARE) ** 0.5 + 0.0 * s[0],)

    @property
    def norm_bounds(self) -> tuple[NormBounds, ...]:
        centred = AffineNorm(((1.0, 0.0), (0.0, 1.0)), (0.0, self.offset))
        return (NormBounds(centred, math.inf, self.source, self.least),)

    def half_planes(self, s: Array) -> Planes:
        count = s.shape[1]
        size = np.stack([np.zeros(count), -np.ones(count)])
        return (PointInequalities(np.zeros_like(s), size, np.full(count, FAR * self.least)),)
