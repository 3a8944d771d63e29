"""Constraints that limits and objectives state and the optimiser reads.

Symbols, used throughout the catalogue:

    s, s', s'', s'''  displacement and its derivatives per radian of cam angle
    z                 the follower's size variables: (e, s0) of a roller on a slide, (Rb) of a face
    P                 epigraph variable of the objective: the value that is minimised

Lengths are in the unit of length of the problem at hand: mm where a spec is read, the stroke where
the optimiser has made the problem dimensionless. No formula here depends on which of the two it is.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from operator import mul
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from synthesis.numerics.piecewise import Array

Vector = tuple[float, ...]
Ends = tuple[float, float]
"""Lower and upper end of a range, infinite where it is open."""


@dataclass(frozen=True)
class LinearInequality:
    """coefficients · (s, s', s'', s''') + size · z + level · P ≤ upper at every cam angle.

    It holds all along one segment, or on a part of it: one semi-infinite row of the problem.

    Attributes:
        coefficients: four. size: one number per size variable; empty stands for zeros.
        level: only objectives use it.
        source: the objective, or the claim of a limit, that states it.
        interval: first and last x, in [0, 1], of the part of the segment where it holds, equal for
            a point; None: the whole segment.
        equality: = upper in place of ≤ upper.
        range_width: from ``upper`` to the bound of the opposite inequality, if there is one.
    """

    coefficients: Vector
    size: Vector
    upper: float
    level: float = 0.0
    source: str = ""
    interval: Ends | None = None
    equality: bool = False
    range_width: float = math.inf

    @cached_property
    def orders(self) -> tuple[int, ...]:
        """Orders of the derivatives with a nonzero coefficient, ascending."""
        return tuple(k for k, a in enumerate(self.coefficients) if a != 0.0)

    @property
    def is_constant(self) -> bool:
        """Whether it contains no variable: it is true or false whatever the cam."""
        return not (any(self.coefficients) or any(self.size) or self.level)


def derivative(order: int, factor: float) -> Vector:
    """Coefficients of ``factor`` times the ``order``-th derivative alone."""
    return tuple(factor if k == order else 0.0 for k in range(4))


@dataclass(frozen=True, eq=False)
class PointInequalities:
    """Linear inequalities at n points: coefficients · (s, s', s'', s''') + size · z ≤ upper.

    Unlike in a ``LinearInequality`` they differ from point to point: (4, n), (n_size, n) and (n,).
    """

    coefficients: Array
    size: Array
    upper: Array

    def select(self, which: NDArray[Any]) -> PointInequalities:
        """Those at some of the points."""
        return PointInequalities(
            self.coefficients[:, which], self.size[:, which], self.upper[which]
        )


@dataclass(frozen=True, eq=False)
class ExtremalMove:
    """A move by its acceleration s'' [length/rad²] at x, from 0 to 1 over its angle: (m,) each.

    ``breaks``: (n,) places of x between which it is nearly straight.
    """

    breaks: Array
    x: Array
    acceleration: Array


@dataclass(frozen=True)
class AffineNorm:
    """‖matrix · z + shift‖, Euclidean: how a radius of the cam depends on the size variables."""

    matrix: tuple[Vector, ...]
    shift: Vector

    def image(self, z: Vector) -> list[float]:
        """The vector matrix · z + shift whose length is taken."""
        rows = zip(self.matrix, self.shift, strict=True)
        return [sum(map(mul, row, z)) + m for row, m in rows]

    def value(self, z: Vector) -> float:
        """The norm at given size variables."""
        return math.hypot(*self.image(z))

    def growth(self, z: Vector, radius: float) -> float:
        """How far the last variable has to grow from z until the norm is ``radius``; 0 if never.

        The larger root of |a|² t² + 2 (image · a) t + |image|² − radius² = 0, a the last column.
        """
        here, step = self.image(z), [row[-1] for row in self.matrix]
        square = sum(a * a for a in step)
        half = sum(map(mul, here, step))
        left = half * half + square * (radius**2 - sum(a * a for a in here))
        return (math.sqrt(left) - half) / square if left >= 0.0 else 0.0

    def lower_bound(self, bounds: Sequence[Ends]) -> float:
        """A lower bound of the norm over a box of size variables, by interval arithmetic."""
        rows = zip(self.matrix, self.shift, strict=True)
        ranges = (affine_range(row, m, bounds) for row, m in rows)
        return math.hypot(*(max(low, -high, 0.0) for low, high in ranges))


def affine_range(row: Vector, constant: float, bounds: Sequence[Ends]) -> Ends:
    """Smallest and largest row · z + constant over a box of z."""
    ends = [sorted((a * low, a * high)) for a, (low, high) in zip(row, bounds, strict=True)]
    least, most = (constant + sum(end[k] for end in ends) for k in (0, 1))
    return least, most


@dataclass(frozen=True)
class NormBounds:
    """lower ≤ norm ≤ upper.

    The upper bound is a second-order cone. The lower bound is reverse convex: a cone program omits
    it, and branch and bound adds cuts for it.
    """

    norm: AffineNorm
    upper: float
    source: str
    lower: float = 0.0

    def growth_to_lower(self, z: Vector) -> float:
        """How far the last size variable has to grow from z until the norm is ``lower``."""
        return self.norm.growth(z, self.lower) if self.norm.value(z) < self.lower else 0.0


@dataclass(frozen=True)
class SizeDomain:
    """Domain of the size variables: finite bounds of each, and second-order cones.

    ``min_norm``: smallest value of ``radius_norm``: reverse convex, so that bounds and cones
    contain points that break it.
    """

    bounds: tuple[Ends, ...]
    norm_bounds: tuple[NormBounds, ...]
    min_norm: float


def enlarged(z: Vector, amount: float) -> Vector:
    """z with its last variable larger by ``amount``, which eases every geometric limit."""
    return (*z[:-1], z[-1] + amount)


def enlarged_to(z: Vector, norm: AffineNorm, least: float) -> Vector:
    """z with its last variable enlarged until a norm is at least so much."""
    return (*z[:-1], max(z[-1], norm.growth((*z[:-1], 0.0), least)))


def max_enlargement(z: Vector, bounds: Sequence[Ends], norms: Sequence[NormBounds]) -> float:
    """The largest amount by which ``enlarged`` keeps z within bounds and norms; 0 if none."""
    steps = [bounds[-1][1] - z[-1], *(each.norm.growth(z, each.upper) for each in norms)]
    return max(min(steps), 0.0)


@dataclass(frozen=True)
class VibrationBound:
    """Residual amplitude of an oscillator on the follower after a run of segments ≤ max_amplitude.

    x is the lag of the oscillator behind the follower: with θ for the time,
    x'' + 2ζν x' + ν² x = −s'', at rest before the run. Where the run ends the follower dwells and x
    decays within an envelope A e^(−ζνθ); A at the end of the run is the amplitude.

    Attributes:
        run: indices of the segments, in order; s' is 0 before the first and after the last.
        frequency: ν = ω_n/ω, undamped, per radian of the cam. damping: ζ in [0, 1).
        max_amplitude: bound on A. source: the claim of the limit that states it.
    """

    run: tuple[int, ...]
    frequency: float
    damping: float
    max_amplitude: float
    source: str


@dataclass(frozen=True, eq=False)
class MotionSizeBox:
    """Bounds of s and of s' at n points, (n,) each, and of the size: the domain of a relaxation.

    ``sizes``: (lower, upper) of every size variable.
    """

    s_min: Array
    s_max: Array
    v_min: Array
    v_max: Array
    sizes: tuple[Ends, ...]


@dataclass(frozen=True)
class NonconvexConstraint(ABC):
    """A constraint on motion and size together that is not linear in both.

    For a fixed motion it is linear in the size, exactly (``half_planes``). Over a box of motion and
    size it has a linear relaxation, if ``has_relaxation`` (``linear_relaxation``).

    Attributes:
        source: as of a ``LinearInequality``.
        order: highest derivative of s in it.
        linearises: whether the cone program approximates it from outside, by iteration; where
            not, only local solvers and branch and bound see it.
    """

    source: str
    order: ClassVar[int] = 3
    linearises: ClassVar[bool] = True

    @property
    def has_relaxation(self) -> bool:
        """Whether ``linear_relaxation`` returns inequalities over small boxes."""
        return True

    @property
    def speed_curvatures(self) -> tuple[float, ...]:
        """Of each value of ``excess`` that is affine in s' and knows no higher derivative.

        It leaves |s'| ≤ F(s, z), where F is linear in z, or one function of s + z that rises, then
        falls. An upper bound of ∂²F/∂s² where F ≥ 0. () where it says nothing of the kind.
        """
        return ()

    @property
    def norm_bounds(self) -> tuple[NormBounds, ...]:
        """What the constraint says of the size alone, exactly, that no half-plane does."""
        return ()

    @abstractmethod
    def excess(self, s: Any, z: Any) -> tuple[Any, ...]:
        """Left less right sides, divided by a length of the cam: ≤ 0 where the constraint holds.

        s to s''' are arrays or CasADi columns of one length, the size variables scalars.
        """

    @abstractmethod
    def half_planes(self, s: Array) -> tuple[PointInequalities, ...]:
        """The sizes that a fixed motion, s to s''' at n cam angles (4, n), allows.

        Inequalities without motion; where no size is allowed, some that contradict each other; ()
        where nothing is known before the size is fixed.
        """

    def half_planes_over_move(
        self, angle: float, start: Array, end: Array
    ) -> tuple[PointInequalities, ...]:
        """The sizes that some law over an angle [rad] may allow, from one state to another.

        start, end: s and s', NaN where s' is not known. () where nothing is known of all laws.
        """
        return ()

    def extremal_move(
        self, angle: float, start: float, end: float, size: Vector, ramp: float
    ) -> ExtremalMove | None:
        """A move from rest to rest that such a half-plane leaves next to no room.

        From s = start to end over an angle [rad], at a size. ``ramp``: what it takes to reach its
        speed, of the angle. None where none is known, or where it breaks the constraint.
        """
        return None

    def linear_relaxation(
        self, box: MotionSizeBox, about: tuple[Array, Vector] | None
    ) -> tuple[PointInequalities, ...]:
        """Linear inequalities that the constraint implies everywhere in a box; () if none is known.

        ``about``: s to s'' (3, n) and z where they shall be tight; None: several, spread over the
        box.
        """
        return ()


NonconvexConstraints = tuple[NonconvexConstraint, ...]


@dataclass(frozen=True)
class SlideCoordinates:
    """Coordinates of a trace point on a slide, affine in motion and size.

    X = σ s + … is its height above the cam's axis along the slide, u = σ s' + …, and e = … its
    offset; the dots are affine in z. tan α = u/X.

    Attributes:
        sign: σ, +1 where the point rises with the follower, −1 where it falls.
        constants: of X, u and e.
        size_factors: (3) rows of one factor per size variable, of X, u and e.
    """

    sign: int
    constants: Vector
    size_factors: tuple[Vector, Vector, Vector]

    @classmethod
    def of_motion(cls, sizes: int) -> SlideCoordinates:
        """X = s, u = s' and e = 0, whatever so many size variables are."""
        nothing = (0.0,) * sizes
        return cls(1, (0.0, 0.0, 0.0), (nothing, nothing, nothing))

    def evaluate(self, s: Any, z: Sequence[Any]) -> tuple[Any, Any, Any]:
        """X, u and e at s, s', … and z."""
        shares = (sum(a * v for a, v in zip(row, z, strict=True)) for row in self.size_factors)
        motion = (self.sign * s[0], self.sign * s[1], 0.0 * s[0])
        x, u, e = (m + c + a for m, c, a in zip(motion, self.constants, shares, strict=True))
        return x, u, e

    def through(self, form: Callable[[Vector], tuple[Vector, float]]) -> SlideCoordinates:
        """The same coordinates of a point that moves by −s; the size an affine map of another.

        ``form`` maps a linear form of this size to one of the other, and a constant.
        """
        forms = [form(row) for row in self.size_factors]
        constants = zip(self.constants, forms, strict=True)
        x, u, e = (row for row, _ in forms)
        shifted = tuple(constant + more for constant, (_, more) in constants)
        return SlideCoordinates(-self.sign, shifted, (x, u, e))

    def offset_range(self, sizes: Sequence[Ends]) -> Ends:
        """Smallest and largest e over a box of sizes."""
        return affine_range(self.size_factors[2], self.constants[2], sizes)

    def motion_bounds(self, low: Array, high: Array, sizes: Sequence[Ends]) -> tuple[Array, Array]:
        """Bounds of s and s', (2, n) each, implied by a box (3, n) of X, u, e and one of sizes."""
        # What of X and u does not come from the motion lies in a range; the motion is the rest.
        static = [affine_range(self.size_factors[k], self.constants[k], sizes) for k in (0, 1)]
        least, most = np.array(static).T[..., None]
        ends = np.stack([low[:2] - most, high[:2] - least]) * self.sign
        return ends.min(axis=0), ends.max(axis=0)


@dataclass(frozen=True, eq=False)
class MotionBox:
    """Bounds (3, n) of s, s' and s'' at n cam angles, and of the size: the domain of a relaxation.

    Attributes:
        sizes: (lower, upper) of every size variable; at every point if these are (n,).
        about: (3, n) and z where inequalities shall be tight; None: the middle of the box.
    """

    theta: Array
    low: Array
    high: Array
    sizes: tuple[tuple[Any, Any], ...] = ()
    about: tuple[Array, Vector] | None = None


class PressureTerm(ABC):
    """A lower bound Λ of (k − σκ) φ cos α, from a limit on the contact pressure of a roller.

    κ is the curvature of the pitch curve, k the largest σκ of a cam without undercut, α the
    pressure angle, and φ cos α what friction leaves of its cosine. Λ and k are 1/length.
    """

    @abstractmethod
    def linear_form(self, theta: Array) -> tuple[Array, Array]:
        """Λ at (n,) cam angles, linear in s, s', s'': coefficients (3,) and constants (n,)."""

    @abstractmethod
    def friction_bound(self, low: Array, high: Array, motion: MotionBox) -> tuple[Array, Array]:
        """a and b, (n,) each, with φ ≤ a + b tan α and a + b tan α > 0 everywhere in a box.

        ``low``, ``high``: (3, n) bounds of the trace point's X, u and e; tan α = u/X.
        """
