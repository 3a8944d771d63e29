"""The vocabulary between limits and formulations: linear rows and cones.

s, s', s'', s'''  displacement and its derivatives per radian [mm, mm/rad, …]
z                 the follower's size variables: (e, s0) of a roller, (Rb) of a face [mm]
P                 the objective's own variable: the level that it pushes down
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from operator import mul
from typing import Any, ClassVar

import numpy as np

from synthesis.numerics.piecewise import Array

Vector = tuple[float, ...]


@dataclass(frozen=True)
class Row:
    """coefficients · (s, s', s'', s''') + size · z + level · P ≤ upper, at every cam angle.

    Of one stretch, that is: of all of it, or of a part.

    Attributes:
        coefficients: four numbers, for s to s'''.
        size: one number per size variable; empty stands for zeros.
        upper: right-hand side.
        level: coefficient of P (only objectives use it).
        source: the objective, or the claim of a limit, that asks for it.
        part: first and last x, in [0, 1], of the stretch where it holds, equal for a point;
            None where it holds all along.
        exact: = upper in place of ≤ upper.
        room: how far below ``upper`` another row allows to go.
    """

    coefficients: tuple[float, float, float, float]
    size: Vector
    upper: float
    level: float = 0.0
    source: str = ""
    part: tuple[float, float] | None = None
    exact: bool = False
    room: float = math.inf

    @cached_property
    def orders(self) -> tuple[int, ...]:
        """Which derivatives it speaks of, from s up."""
        return tuple(k for k, a in enumerate(self.coefficients) if a != 0.0)

    @property
    def constant(self) -> bool:
        """Whether neither the motion nor the size has a say in it: it holds, or nothing helps."""
        return not (any(self.coefficients) or any(self.size) or self.level)


def derivative(order: int, factor: float) -> tuple[float, float, float, float]:
    """Coefficients of a row that holds ``factor`` times the ``order``-th derivative alone."""
    s, v, a, j = (factor if k == order else 0.0 for k in range(4))
    return s, v, a, j


@dataclass(frozen=True)
class Norm:
    """‖matrix · z + shift‖, Euclidean: how a radius depends on the size variables [mm]."""

    matrix: tuple[Vector, ...]
    shift: Vector

    def image(self, z: Vector) -> list[float]:
        """Of what it is the length: matrix · z + shift [mm]."""
        rows = zip(self.matrix, self.shift, strict=True)
        return [sum(map(mul, row, z)) + m for row, m in rows]

    def value(self, z: Vector) -> float:
        """The norm at given size variables [mm]."""
        return math.hypot(*self.image(z))

    def floor(self, bounds: Sequence[tuple[float, float]]) -> float:
        """A lower bound of the norm where every size variable lies between two ends [mm]."""
        least = []
        for row, m in zip(self.matrix, self.shift, strict=True):
            ends = [sorted((a * low, a * high)) for a, (low, high) in zip(row, bounds, strict=True)]
            low, high = (m + sum(end[k] for end in ends) for k in (0, 1))
            least.append(max(low, -high, 0.0))
        return math.hypot(*least)


@dataclass(frozen=True)
class Cone:
    """least ≤ norm ≤ radius [mm]; ``least`` is not convex, and no cone program knows of it."""

    norm: Norm
    radius: float
    source: str
    least: float = 0.0

    def step(self, z: Vector) -> float:
        """How far the last size variable can grow from z [mm]; 0 from outside."""
        return self._growth(z, self.radius)

    def short(self, z: Vector) -> float:
        """How far the last size variable has to grow from z until the norm is ``least`` [mm]."""
        return self._growth(z, self.least) if self.norm.value(z) < self.least else 0.0

    def _growth(self, z: Vector, radius: float) -> float:
        """How far the last size variable grows until the norm is ``radius``; 0 from outside."""
        here, step = self.norm.image(z), [row[-1] for row in self.norm.matrix]
        square = sum(a * a for a in step)
        half = sum(a * b for a, b in zip(here, step, strict=True))
        left = half * half + square * (radius**2 - sum(a * a for a in here))
        return (math.sqrt(left) - half) / square if left >= 0.0 else 0.0


@dataclass(frozen=True)
class Ringing:
    """What a run of stretches leaves an oscillator ringing with, at rest before it: ≤ ``largest``.

    The follower carries the oscillator, x is by how much that lags behind: with θ for the time,
    x'' + 2ζν x' + ν² x = −s''. Where the run ends the follower dwells, and x swings on within an
    envelope A e^(−ζνθ); A at the end of the run is meant.

    Attributes:
        run: indices of the stretches, in order; s' is 0 before the first and after the last.
        frequency: ν = ω_n/ω, undamped, per radian of the cam. damping: ζ in [0, 1).
        largest: of A [mm]. source: the claim of a limit that asks for it.
    """

    run: tuple[int, ...]
    frequency: float
    damping: float
    largest: float
    source: str


@dataclass(frozen=True, eq=False)
class Cuts:
    """Rows that hold at n points: coefficients · (s, s', s'', s''') + size · z ≤ upper.

    Attributes:
        coefficients: (4, n). size: (n_size, n). upper: (n,).
    """

    coefficients: Array
    size: Array
    upper: Array


@dataclass(frozen=True, eq=False)
class Within:
    """What is known beforehand of n points: low ≤ s ≤ high, slow ≤ s' ≤ fast, (n,) each, and of z.

    ``sizes``: lower and upper bound of every size variable [mm].
    """

    low: Array
    high: Array
    slow: Array
    fast: Array
    sizes: tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class Implied(ABC):
    """A limit on motion and size together from which rows follow where both lie in a range.

    ``source``: as of a row. ``turns``: whether ``cuts`` says anything.
    """

    source: str
    turns: ClassVar[bool] = True

    @abstractmethod
    def cuts(self, within: Within, about: tuple[Array, Vector] | None) -> tuple[Cuts, ...]:
        """Rows implied wherever motion and size are ``within``, tight about a point.

        Args:
            within: what is known of s and z at n points.
            about: s to s'' (3, n) and z where the rows shall be tight; None: rows all over the
                range.

        Returns:
            () where no such rows are known.
        """


@dataclass(frozen=True)
class Curved(Implied):
    """A limit on motion and size together that no fixed row says.

    For a settled motion it is linear in the size, exactly; where it is nearly convex, rows follow
    from it point by point. ``order``: highest derivative in it.
    """

    order: ClassVar[int] = 3

    @property
    def implies(self) -> bool:
        """Whether rows follow from it where motion and size lie in narrow ranges."""
        return True

    @abstractmethod
    def excess(self, s: Any, z: Any) -> tuple[Any, ...]:
        """Left less right sides over a natural length: ≤ 0 where the limit holds.

        Args:
            s: s to s''' as arrays or CasADi columns of one length [mm, per rad].
            z: the size variables, scalars [mm].
        """

    @abstractmethod
    def half_planes(self, s: Array) -> tuple[Cuts, ...]:
        """The sizes that a settled motion allows, exactly: all of these together.

        Args:
            s: (4, n) s to s''' at n cam angles [mm, per rad].

        Returns:
            rows without motion; where no size is allowed, rows that exclude each other; () where
            only a finished size can be asked.
        """


@dataclass(frozen=True)
class Seen:
    """A traced point as its curve sees it: X = x + σ s + …, u = … + σ s', e = …, each with its z.

    Attributes:
        sign: σ, whether the point rises with the follower or sinks.
        constants: of X, u and e [mm].
        by: (3) rows of one factor per size variable, of X, u and e.
    """

    sign: int
    constants: Vector
    by: tuple[Vector, Vector, Vector]

    def of(self, s: Any, z: Sequence[Any]) -> tuple[Any, Any, Any]:
        """X, u and e of motions s, s', … at a size."""
        shares = (sum(a * v for a, v in zip(row, z, strict=True)) for row in self.by)
        motion = (self.sign * s[0], self.sign * s[1], 0.0 * s[0])
        x, u, e = (m + c + a for m, c, a in zip(motion, self.constants, shares, strict=True))
        return x, u, e

    def offsets(self, sizes: Sequence[tuple[float, float]]) -> tuple[float, float]:
        """Least and largest e for sizes in a box [mm]."""
        return self._still(2, sizes)

    def _still(self, which: int, sizes: Sequence[tuple[float, float]]) -> tuple[float, float]:
        """Least and largest part of X, u or e that no motion is in, for sizes in a box [mm]."""
        ends = [
            sorted((a * low, a * high))
            for a, (low, high) in zip(self.by[which], sizes, strict=True)
        ]
        least, most = (self.constants[which] + sum(end[k] for end in ends) for k in (0, 1))
        return least, most

    def moved(
        self, low: Array, high: Array, sizes: Sequence[tuple[float, float]]
    ) -> tuple[Array, Array]:
        """Bounds of s and s' that follow from those of X, u and e, (3, n), and of sizes: (2, n)."""
        still = [self._still(which, sizes) for which in (0, 1)]
        ends = np.stack(
            [
                np.stack([low[k] - most, high[k] - least]) * self.sign
                for k, (least, most) in enumerate(still)
            ],
            axis=1,
        )
        return ends.min(axis=0), ends.max(axis=0)


@dataclass(frozen=True, eq=False)
class Moving:
    """What is known of the motion at n points.

    Attributes:
        theta: (n,) cam angles [rad].
        low, high: (3, n) bounds of s, s' and s''. about: (3, n) where rows shall be tight; None:
            in the middles.
    """

    theta: Array
    low: Array
    high: Array
    about: Array | None = None


class Thrust(ABC):
    """What presses a roller against its cam, as a number Λ that (k − σκ) φ cos α may not be below.

    κ is the curvature of the roller's centre's curve, k [1/mm] the most that σκ may be on a cam
    without undercut, α the pressure angle; φ cos α is what friction leaves of its cosine.
    """

    @abstractmethod
    def drive(self, theta: Array) -> tuple[Array, Array]:
        """Λ at cam angles (n,) as a linear form in s, s' and s'': (3,), constants (n,) [1/mm]."""

    @abstractmethod
    def grip(self, low: Array, high: Array, moving: Moving) -> tuple[Array, Array]:
        """a and b, (n,) each, with φ ≤ a + b tan α and 0 < a + b tan α all over boxes.

        Args:
            low, high: (3, n) bounds of the point's X, u and e [mm]; tan α = u/X.
            moving: bounds of the motion.
        """


@dataclass(frozen=True)
class Traced(ABC):
    """A limit from which rows follow where a traced point's X, u and e lie in a range.

    ``source``: as of a row. ``seen``: the point.
    """

    source: str
    seen: Seen

    @property
    def weighed(self) -> bool:
        """Whether its rows need to know how the motion is bounded, s'' too."""
        return False

    @abstractmethod
    def cuts(
        self, low: Array, high: Array, about: Array | None, moving: Moving | None = None
    ) -> Cuts | None:
        """Rows implied wherever (X, u, e) is in a box, n points at once, tight about a place.

        Args:
            low, high: (3, n) the boxes.
            about: (3, n) where the rows shall be tight; None: in the middles.
            moving: what is known of the motion there; None: nothing.

        Returns:
            None where no such rows are known.
        """
