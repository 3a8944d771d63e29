"""Pressure angle and wall radius as constraints on the motion and the machine's size together.

Every constraint here is z ≥ least size(s, s'), with z the minimised dimension, not linear in the
motion. Outer rows, about no motion, hold for every motion that keeps it (a relaxation, for dual
bounds). Inner rows, about a given motion, exclude every motion that breaks it (a restriction, for
cams); where it is not concave in the motion they are its linear approximation.

Turret: C centre distance; ρ place on a roller, from the turret's axis; ψ a roller's angle from the
common perpendicular, ψ' its derivative by the cam angle; t = tan α_max. The normal of a cylindrical
roller and its direction of motion make the angle tan α = ρ|ψ'|/(C − ρ cos ψ), see
``numerics.geometry.swept_roller``. So α ≤ α_max reads

    C ≥ ρ (cos ψ + |ψ'|/t)

for every roller in mesh and every ρ. The right side grows with ρ, so that the roller's outer end
decides, and with cos ψ, so that the roller nearest to the common perpendicular does. On a crowned
roller the contact at ρ has its foot at ρ + r r' and its normal leans by r' more: 1 + tan² α = (1 +
r'²)(1 + tan² α_foot), which leaves a smaller t at every ρ; no single end decides. The displacement
is the arc s = Lψ of the outer end. cos ψ is concave in ψ, so that its tangents give inner rows, and
its chords over the range of ψ give outer rows.

Arm across a cylindrical cam: R radius of the cylinder; ρ distance from its axis along a roller; ψ
angle of a roller's arm from the perpendicular to the cam's axis; s = lψ arc of the roller at the
arm's length l; χ = +1 where the cam turns about its axis z, −1 about −z, the arm swinging about −x.
The cam's surface passes the roller with the velocity χρ across z, and the roller moves at ψ from z.
So tan α = |s' − χρ sin ψ|/(ρ cos ψ), and α ≤ α_max reads

    s' ≤ ρ (t cos ψ + χ sin ψ)   and   −s' ≤ ρ (t cos ψ − χ sin ψ)

at every ρ; a cylindrical roller's inner end decides. Rows are tangents about a motion; no outer
rows are known.

Wall radius of a turret: B = C − ρ cos ψ. Seen from the turning cam, a roller's axis sweeps a ruled
surface with the first and second fundamental forms (derivatives by the cam angle)

    W² = (ρψ')² + B²,   K = −(Cψ')²/W⁴,   2H = ± [(ρψ'' − B sin ψ) B − 2 (ρψ')² sin ψ]/W³.

The walls are its offset surfaces at ±Rr. K ≤ 0, so that one principal curvature is positive, and on
one of the two walls that one is convex. A wall's convex radius is at least m, and with m = 0 the
wall is not undercut, where an offset by r = Rr + m is regular:

    1 − 2|H| r + K r² ≥ 0.

The left side grows with C except where the roller's axis is nearer to the cam's than r, which the
cam's core excludes. Derived here; ruled surfaces of indexing cams as in Gonzalez-Palacios and
Angeles, Cam Synthesis, 1993.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from math import ceil, pi
from typing import Any, ClassVar

import numpy as np

from synthesis.catalogue.constraints import (
    MotionSizeBox,
    NonconvexConstraint,
    PointInequalities,
    Vector,
)
from synthesis.numerics.geometry.swept_roller import Roller
from synthesis.numerics.piecewise import Array

RIGHT_ANGLE = 0.5 * pi  # rad
PLACES = 17  # samples along a crowned roller; its profile is smooth; ``measuring`` decides
UNREACHABLE = 1e9  # arm lengths: least radius where no cylinder keeps the limit even at rest
LEAST_LEVER = 1e-9  # of t cos ψ ± χ sin ψ: below it the limit cannot be kept at any radius
ARM_STEP = 1e-6  # of the arm's length: forward differences, error and cancellation both near 1e-6
FARTHEST = 1e2  # lengths L: upper end of the interval that is searched for the least C
HALVINGS, NEWTON = 17, 3  # of that interval into Newton's region, and steps to rounding
HARDEST = 2  # of all rollers and places, those that get rows; others follow as the motion changes
RADIUS_STEP = 1e-5  # relative: forward differences of wall radii


@dataclass(frozen=True)
class SizeConstraint(NonconvexConstraint):
    """z ≥ least size(s, s', …), with z the machine's minimised dimension [mm].

    ``linear_relaxation`` returns outer rows where it is given no motion, inner rows about a motion.

    Attributes:
        length: a natural length, of the order of the size [mm]; s is the arc of this radius.
    """

    order: ClassVar[int] = 1
    length: float

    @abstractmethod
    def least_size(self, s: Array) -> Array:
        """The least size at s, s', … (orders, n) [mm]: (n,)."""

    @abstractmethod
    def max_speed(self, s: Array, size: float, sense: float) -> Array:
        """The largest |s'| allowed at displacements s (n,) and a size [mm]: (n,) [mm/rad].

        ``sense`` is +1 for motion towards growing s, −1 for the other direction.
        """

    def excess(self, s: Any, z: Any) -> tuple[Any, ...]:
        return ((self.least_size(s) - z[0]) / self.length,)

    def half_planes(self, s: Array) -> tuple[PointInequalities, ...]:
        # −z ≤ −least size: with the motion given, the constraint is a bound on the size alone.
        return (
            PointInequalities(np.zeros_like(s), -np.ones((1, s.shape[1])), -self.least_size(s)),
        )


@dataclass(frozen=True)
class TurretPressureAngle(SizeConstraint):
    """C ≥ ρ cos ψ + |s'| b for all (ρ, b); z = (C,).

    Attributes:
        first: ψ of any roller at s = 0 [rad]. spacing: angle from roller to roller [rad].
        places: (ρ, b) with b = ρ/(L t) [mm, 1].
    """

    first: float
    spacing: float
    places: tuple[tuple[float, float], ...]

    def _nearest(self, s: Array) -> Array:
        """ψ of the roller nearest to the common perpendicular at displacements s [mm]."""
        return _nearest(self.first + s / self.length, self.spacing)

    def max_speed(self, s: Array, size: float, sense: float) -> Array:
        cosine = np.cos(self._nearest(s))
        return np.asarray(np.min([(size - rho * cosine) / b for rho, b in self.places], axis=0))

    def least_size(self, s: Array) -> Array:
        cosine, speed = np.cos(self._nearest(s[0])), np.abs(s[1])
        return np.asarray(np.max([rho * cosine + b * speed for rho, b in self.places], axis=0))

    def linear_relaxation(
        self, box: MotionSizeBox, about: tuple[Array, Vector] | None
    ) -> tuple[PointInequalities, ...]:
        if about is not None:
            # A row with the largest ρ and the largest b implies the rows of all places.
            lines = self._tangents(about[0][0])
            place = max(rho for rho, _ in self.places), max(b for _, b in self.places)
        else:
            lines, place = [self._chord(box)], max(self.places, key=lambda each: each[1])
        rows, (rho, b) = [], place
        for value, slope in lines:
            none = np.zeros_like(value)
            # |s'| ≤ … is one row for either sign of s' that the motion can have.
            for sign, possible in ((1.0, box.v_max > 0.0), (-1.0, box.v_min < 0.0)):
                if np.any(possible):  # ρ (value + slope s/L) + sign b s' ≤ C
                    factors = np.stack([rho / self.length * slope, none + sign * b, none, none])
                    rows.append(PointInequalities(factors, none[None, :] - 1.0, -rho * value))
        return tuple(rows)

    def _tangents(self, s: Array) -> list[tuple[Array, Array]]:
        """Tangents above the cosines of the two nearest rollers at s (n,): value at s = 0, slope.

        Two, as another roller becomes the nearest one where the motion may move to.
        """
        near = self._nearest(s)
        next_one = near - self.spacing * np.where(near > 0.0, 1.0, -1.0)
        return [(np.cos(psi) + np.sin(psi) * s / self.length, -np.sin(psi))
                for psi in (near, next_one)]  # fmt: skip

    def _chord(self, box: MotionSizeBox) -> tuple[Array, Array]:
        """The best line below the nearest roller's cosine over a box."""
        finite = np.isfinite(box.s_max) & np.isfinite(box.s_min)
        low, high = np.where(finite, box.s_min, 0.0), np.where(finite, box.s_max, 0.0)
        middle = 0.5 * (low + high)
        psi, half = self._nearest(middle), 0.5 * (high - low) / self.length
        # The cosine is concave, and its chord a lower bound, between −90° and 90° alone.
        known = finite & (np.abs(psi) + half <= RIGHT_ANGLE)
        # Chord through ψ ± δ, by cos(ψ ± δ) = cos ψ cos δ ∓ sin ψ sin δ.
        half = np.where(known, half, 0.0)
        slope, height = -np.sin(psi) * np.sinc(half / pi), np.cos(psi) * np.cos(half)
        # The nearest roller is never farther than half a spacing: a constant lower bound.
        lowest = np.full_like(height, np.cos(0.5 * self.spacing))
        higher = known & (height > lowest)
        at_zero = height - slope * middle / self.length
        return np.where(higher, at_zero, lowest), np.where(higher, slope, 0.0)


def critical_places(roller: Roller, slope: float, end: float) -> tuple[tuple[float, float], ...]:
    """Places that decide the pressure angle: (foot on the axis [mm], tan α that is left there).

    ``slope`` is tan α_max; where a crowned roller's |r'| exceeds it, 0 is left. On a cylindrical
    roller one ``end`` decides.
    """
    if roller.crown == 0.0:
        return ((end, slope),)
    rho = np.linspace(roller.inner, roller.outer, PLACES)
    radius, lean, _ = roller.profile(rho)
    left = np.sqrt(np.maximum((1.0 + slope**2) / (1.0 + lean**2) - 1.0, 0.0))
    return tuple(zip((rho + radius * lean).tolist(), left.tolist(), strict=True))


@dataclass(frozen=True)
class ArmPressureAngle(SizeConstraint):
    """R ≥ depth + |s'|/(t cos ψ ± χ sin ψ); z = (R,).

    Attributes:
        length: l, of the arm [mm]. starts: ψ of the rollers at s = 0 [rad]. hand: χ.
        depth: of the rollers' inner ends below the cylinder [mm]. slope: t.
    """

    starts: tuple[float, ...]
    hand: int
    depth: float
    slope: float

    def _levers(self, s: Array, sense: float) -> Array:
        """t cos ψ ± χ sin ψ of every roller at displacements s (n,): (rollers, n)."""
        psi = np.array(self.starts)[:, None] + s / self.length
        return np.asarray(self.slope * np.cos(psi) + sense * self.hand * np.sin(psi))

    def max_speed(self, s: Array, size: float, sense: float) -> Array:
        return np.asarray(np.min((size - self.depth) * self._levers(s, sense), axis=0))

    def least_size(self, s: Array) -> Array:
        least = np.zeros(s.shape[1])
        for sense in (1.0, -1.0):
            levers = self._levers(s[0], sense)
            needed = sense * s[1] / np.maximum(levers, LEAST_LEVER)
            needed = np.where(levers > LEAST_LEVER, needed, UNREACHABLE * self.length)
            least = np.maximum(least, np.max(needed, axis=0))
        return np.asarray(self.depth + least)

    def linear_relaxation(
        self, box: MotionSizeBox, about: tuple[Array, Vector] | None
    ) -> tuple[PointInequalities, ...]:
        if about is None:
            return ()
        return (_linear_approximation(self.least_size, about[0], [ARM_STEP * self.length] * 2),)


@dataclass(frozen=True)
class TurretWallRadius(SizeConstraint):
    """1 − 2|H| r + K r² ≥ 0 for every roller in mesh; z = (C,).

    Attributes:
        first: ψ of any roller at s = 0 [rad]. spacing: angle from roller to roller [rad].
        radius: r [mm]. places: ρ that are checked [mm].
        mesh: largest angle from the common perpendicular at which a roller meshes [rad].
    """

    order: ClassVar[int] = 2
    first: float
    spacing: float
    radius: float
    places: tuple[float, ...]
    mesh: float

    def max_speed(self, s: Array, size: float, sense: float) -> Array:
        return np.full(len(s), np.inf)  # it bounds the acceleration, at any speed

    def excess(self, s: Any, z: Any) -> tuple[Any, ...]:
        return (np.asarray(np.max(-self._regularity(self._states(s), np.asarray(z[0])), axis=0)),)

    def least_size(self, s: Array) -> Array:
        return np.asarray(np.max(self._least(self._states(s)), axis=0))

    def linear_relaxation(
        self, box: MotionSizeBox, about: tuple[Array, Vector] | None
    ) -> tuple[PointInequalities, ...]:
        if about is None or len(about[0]) < 3:
            return ()
        # Of all rollers and places those with the largest least C; their numbers stay as s moves.
        s = about[0]
        hardest = np.argpartition(-self._least(self._states(s)), HARDEST, axis=0)[:HARDEST]

        def least_of(number: Array, s: Array) -> Array:
            return self._least(self._states(s)[:, number, np.arange(s.shape[1])])

        steps = [RADIUS_STEP * max(float(np.max(np.abs(s[k]))), self.length) for k in range(3)]
        return tuple(_linear_approximation(partial(least_of, k), s, steps) for k in hardest)

    def _states(self, s: Array) -> Array:
        """ρ, ψ, ψ' and ψ'' of all rollers and places: (4, rollers × places, n).

        A roller outside its mesh is taken at the end of it.
        """
        q, q1, q2 = s[0] / self.length, s[1] / self.length, s[2] / self.length
        count = max(ceil(self.mesh / self.spacing - 0.5), 0)
        others = np.arange(-count, count + 1)[:, None] * self.spacing
        psi = np.clip(others + _nearest(self.first + q, self.spacing), -self.mesh, self.mesh)
        rho = np.repeat(self.places, len(others))[:, None]
        return np.array(np.broadcast_arrays(rho, np.tile(psi, (len(self.places), 1)), q1, q2))

    def _regularity(self, states: Array, size: Array) -> Array:
        """1 − 2|H| r + K r²."""
        rho, psi, q1, q2 = states
        off = size - rho * np.cos(psi)
        speed = np.hypot(rho * q1, off)
        bend = (rho * q2 - off * np.sin(psi)) * off - 2.0 * (rho * q1) ** 2 * np.sin(psi)
        twist = self.radius * size * q1 / speed**2
        return np.asarray(1.0 - self.radius * np.abs(bend) / speed**3 - twist**2)

    def _least(self, states: Array) -> Array:
        """The C from which on the offset is regular, of every roller and place."""
        # Bisection on log C brackets the root, from where the roller's axis is r from the cam's.
        low = np.maximum(states[0] * np.cos(states[1]), 0.0) + self.radius
        high = np.full_like(low, FARTHEST * self.length)
        for _ in range(HALVINGS):
            middle = np.sqrt(low * high)
            enough = self._regularity(states, middle) >= 0.0
            low, high = np.where(enough, low, middle), np.where(enough, middle, high)
        # Newton's method within the bracket refines it.
        for _ in range(NEWTON):
            wide = RADIUS_STEP * high
            left = self._regularity(states, high)
            slope = (self._regularity(states, high + wide) - left) / wide
            high = np.clip(high - left / np.where(slope > 0.0, slope, np.inf), low, high + wide)
        return np.asarray(high)


def _nearest(psi: Array, spacing: float) -> Array:
    """ψ of the roller nearest to the common perpendicular, of one roller's ψ [rad]."""
    return np.asarray(psi - spacing * np.round(psi / spacing))


def _linear_approximation(
    least: Callable[[Array], Array], s: Array, steps: Sequence[float]
) -> PointInequalities:
    """z ≥ least size to first order about s (orders, n), as inner rows.

    ``steps`` of forward differences: in s, s', …, as far as the least size depends on them.
    """
    value, slopes = least(s), np.zeros((4, s.shape[1]))
    for order, step in enumerate(steps):
        moved = np.array(s)
        moved[order] += step
        slopes[order] = (least(moved) - value) / step
    upper = np.sum(slopes[: len(s)] * s, axis=0) - value
    return PointInequalities(slopes, np.full((1, len(value)), -1.0), upper)
