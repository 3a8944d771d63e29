"""The follower's motion over one turn of the cam, and the stretches it is made of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from synthesis.numerics.peaks import peak
from synthesis.numerics.piecewise import Array, Piecewise, Side, join
from synthesis.units import FULL_TURN

Sense = Literal["rise", "dwell", "return"]
StretchKind = Literal["rise", "dwell", "return", "table"]


@dataclass(frozen=True)
class EndState:
    """What is asked of the motion at one end of a segment; None is left to the neighbour.

    Attributes:
        velocity, acceleration: s' [mm/rad] and s'' [mm/rad²] just inside the segment.
    """

    velocity: float | None = None
    acceleration: float | None = None

    @property
    def known(self) -> tuple[float | None, float | None]:
        """s' and s'' in this order."""
        return self.velocity, self.acceleration

    def normalised(self, angle: float, scale: float) -> tuple[float | None, float | None]:
        """g' and g'' for s = s_start + scale · g((θ − start)/angle)."""
        v, a = self.known
        return (
            None if v is None else v * angle / scale,
            None if a is None else a * angle**2 / scale,
        )

    def or_else(self, other: EndState) -> EndState:
        """What is not asked here is taken from ``other``."""
        v, a = self.velocity, self.acceleration
        if other.velocity is other.acceleration is None or (v is not None and a is not None):
            return self
        return EndState(other.velocity if v is None else v, other.acceleration if a is None else a)


ANY_STATE = EndState()


@dataclass(frozen=True)
class FreeLaw:
    """A law that is part of the answer: a spline of class C^smoothness.

    Attributes:
        smoothness: number of continuous derivatives inside. overshoot: may it move backwards.
        joins: how many derivatives it shares with its neighbours at its start and at its end;
            fewer than the smoothness where a state is asked for that the neighbour has not.
        knots: x in (0, 1) where it must be free to bend: ends of windows, points on the way.
    """

    smoothness: int
    overshoot: bool
    joins: tuple[int, int] = (4, 4)
    knots: tuple[float, ...] = ()

    def promised(self, *, at_start: bool) -> int:
        """Derivatives that do not jump at one of its ends."""
        return min(self.smoothness, self.joins[0 if at_start else 1])


@dataclass(frozen=True, eq=False)
class Readings:
    """A table that a stretch has to follow.

    Attributes:
        x: (m,) where, as fractions of the stretch. s: (m,) displacement there [mm].
        tolerance: how far the motion may pass them [mm]. field: of the segment, that sets it.
    """

    x: Array
    s: Array
    tolerance: float
    field: str = "tolerance_mm"


@dataclass(frozen=True, eq=False)
class Stretch:
    """One segment of the motion program, placed on the cam.

    Attributes:
        index: position in the program, from 0.
        kind: rise, dwell or return; a table that moves both ways is neither.
        start, angle: cam angle where it starts, and its length β [rad].
        s_start, s_end: displacement at its ends [mm], measured from the lowest position.
        law: the normalised law g(x), 0 to 1 over x in [0, 1] (of a table: to lift/unit), so that
            s = s_start + unit · g((θ − start)/β); None while it is free.
        free: what a free law must satisfy; None where the law is given.
        at_start, at_end: states asked for at its two ends.
        readings: the table that it has to follow, None where it follows none.
    """

    index: int
    kind: StretchKind
    start: float
    angle: float
    s_start: float
    s_end: float
    law: Piecewise | None
    free: FreeLaw | None = None
    at_start: EndState = ANY_STATE
    at_end: EndState = ANY_STATE
    readings: Readings | None = None

    @property
    def end(self) -> float:
        """Cam angle where it ends [rad]."""
        return self.start + self.angle

    @property
    def lift(self) -> float:
        """s_end − s_start [mm]: negative on a return."""
        return self.s_end - self.s_start

    @property
    def sought(self) -> bool:
        """Whether its law is to be chosen, neither given nor read from a table."""
        return self.law is None and self.readings is None and self.angle > 0.0

    @property
    def senses(self) -> tuple[Sense, ...]:
        """The ways in which it moves: a table that turns back, both."""
        return ("rise", "return") if self.kind == "table" else (self.kind,)

    @property
    def unit(self) -> float:
        """What g is multiplied by [mm]: the lift, of a table the range it runs through."""
        return self.lift if self.readings is None else float(np.ptp(self.readings.s))

    @property
    def highest(self) -> float:
        """Largest displacement on it [mm]; of a free law that may overshoot, of its ends."""
        ends = max(self.s_start, self.s_end)
        if self.law is None:
            return ends
        return max(ends, self.s_start + self.unit * _extreme(self.law, self.unit > 0.0))

    def with_law(self, law: Piecewise) -> Stretch:
        """The same stretch with its law settled."""
        return replace(self, law=law)

    def placed(self) -> Piecewise:
        """s(θ) on this stretch [mm over rad]; the law must be settled."""
        if self.law is None:
            raise ValueError(f"the law of stretch {self.index} is still free")
        return self._placed

    @cached_property
    def _placed(self) -> Piecewise:
        assert self.law is not None
        return self.law.placed(self.start, self.angle, self.s_start, self.unit)

    def beside(self, highest: int, *, at_start: bool) -> Array:
        """s to s^(highest) just inside one end [mm per rad^k]: (highest + 1,); the law is settled.

        At the end its displacement is ``s_end``, to the last digit.
        """
        assert self.law is not None
        if self.law.still:
            value = np.zeros(highest + 1)
            value[0] = self.s_start + self.unit * self.law.poly[0 if at_start else -1, 0]
            return value
        value = self.unit * _at_ends(self.law)[0 if at_start else 1, : highest + 1]
        value /= self.angle ** np.arange(len(value))
        value[0] += self.s_start
        return np.asarray(value)


@lru_cache(maxsize=1024)
def _at_ends(law: Piecewise) -> Array:
    """g and its derivatives, more than any joint asks for, at both ends: (2, 6)."""
    start, end = law.breaks[:1], law.breaks[-1:]
    return np.stack(
        [law.derivatives(start, 5, "right")[:, 0], law.derivatives(end, 5, "left")[:, 0]]
    )


@lru_cache(maxsize=1024)
def _extreme(law: Piecewise, largest: bool) -> float:
    """Largest or smallest value of a normalised law."""
    sign = 1.0 if largest else -1.0
    return sign * peak(law, (sign, 0.0, 0.0, 0.0))[0]


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
