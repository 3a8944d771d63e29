"""The follower's motion over one turn of the cam, and the stretches it is made of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from synthesis.numerics.piecewise import Array, Piecewise, Side, join
from synthesis.units import FULL_TURN

StretchKind = Literal["rise", "dwell", "return"]


@dataclass(frozen=True)
class FreeLaw:
    """A law that is part of the answer: a spline of class C^smoothness.

    ``knots`` are x in (0, 1) where it must be free to bend: ends of windows, points on the way.
    """

    smoothness: int
    overshoot: bool
    knots: tuple[float, ...] = ()


@dataclass(frozen=True, eq=False)
class Stretch:
    """One segment of the motion program, placed on the cam.

    Attributes:
        index: position in the program, from 0.
        kind: rise, dwell or return.
        start, angle: cam angle where it starts, and its length β [rad].
        s_start, s_end: displacement at its ends [mm], measured from the lowest position.
        law: the normalised law g(x), 0 to 1 over x in [0, 1], so that
            s = s_start + (s_end − s_start) g((θ − start)/β); None while it is free.
        free: what a free law must satisfy; None where the law is given.
    """

    index: int
    kind: StretchKind
    start: float
    angle: float
    s_start: float
    s_end: float
    law: Piecewise | None
    free: FreeLaw | None = None

    @property
    def end(self) -> float:
        """Cam angle where it ends [rad]."""
        return self.start + self.angle

    @property
    def lift(self) -> float:
        """s_end − s_start [mm]: negative on a return."""
        return self.s_end - self.s_start

    def with_law(self, law: Piecewise) -> Stretch:
        """The same stretch with its law settled."""
        return replace(self, law=law)

    def placed(self) -> Piecewise:
        """s(θ) on this stretch [mm over rad]; the law must be settled."""
        if self.law is None:
            raise ValueError(f"the law of stretch {self.index} is still free")
        return self.law.placed(self.start, self.angle, self.s_start, self.lift)


@dataclass(frozen=True, eq=False)
class Motion:
    """Displacement s(θ) for θ in [0, 2π], every law settled."""

    stretches: tuple[Stretch, ...]
    curve: Piecewise

    @classmethod
    def of(cls, stretches: Sequence[Stretch]) -> Motion:
        """Join settled stretches; those of zero angle contribute no piece."""
        return cls(tuple(stretches), join([s.placed() for s in stretches if s.angle > 0.0]))

    def derivatives(self, theta: ArrayLike, highest: int = 3, side: Side = "right") -> Array:
        """s, s', …, s^(highest) at θ, derivatives per radian.

        Args:
            theta: (n,) cam angles [rad], any turn.
            highest: highest derivative wanted.
            side: which one-sided value to give where a derivative jumps.

        Returns:
            (highest + 1, n) [mm, mm/rad, …].
        """
        angle = np.asarray(theta, dtype=float).ravel()
        wrapped = angle - FULL_TURN * np.floor(angle / FULL_TURN)
        if side == "left":
            wrapped = np.where((wrapped == 0.0), FULL_TURN, wrapped)
        return self.curve.derivatives(wrapped, highest, side)
