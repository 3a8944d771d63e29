"""The follower's motion over one turn of the cam, and the segments it is made of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from synthesis.numerics.maxima import maximise
from synthesis.numerics.piecewise import Array, Piecewise, Side, concatenate
from synthesis.units import FULL_TURN

Sense = Literal["rise", "dwell", "return"]
SegmentKind = Literal["rise", "dwell", "return", "table"]


@dataclass(frozen=True)
class EndState:
    """Required s' and s'' just inside one end of a segment; None: the neighbour determines it."""

    velocity: float | None = None
    acceleration: float | None = None

    @property
    def known(self) -> tuple[float | None, float | None]:
        """s' and s'' in this order."""
        return self.velocity, self.acceleration

    def normalised(self, angle: float, scale: float) -> tuple[float | None, float | None]:
        """g' and g'' for s = s_start + scale · g((θ − start)/angle)."""
        v, a = self.known
        first = None if v is None else v * angle / scale
        return first, None if a is None else a * angle**2 / scale

    def filled_from(self, other: EndState) -> EndState:
        """The state with values that are None taken from ``other``."""
        v, a = self.known
        if other == ANY_STATE or (v is not None and a is not None):
            return self
        return EndState(other.velocity if v is None else v, other.acceleration if a is None else a)


ANY_STATE = EndState()


@dataclass(frozen=True)
class FreeLaw:
    """A free law: a spline of class C^smoothness that the optimiser chooses.

    Attributes:
        smoothness: inside. overshoot: may it move backwards.
        end_continuity: how many derivatives it shares with its neighbours at start and end; fewer
            than the smoothness where the required state is not the neighbour's.
        knots: x in (0, 1) where it must be free to bend: ends of windows, points on the way.
    """

    smoothness: int
    overshoot: bool
    end_continuity: tuple[int, int] = (4, 4)
    knots: tuple[float, ...] = ()

    def continuity_at(self, *, at_start: bool) -> int:
        """Derivatives that do not jump at one of its ends."""
        return min(self.smoothness, self.end_continuity[0 if at_start else 1])


@dataclass(frozen=True, eq=False)
class TablePoints:
    """A table that a segment has to follow: s [mm] at x, fractions of the segment, (m,) each.

    ``tolerance``: how far the motion may pass it [mm]. ``field``: of the segment, that sets that.
    """

    x: Array
    s: Array
    tolerance: float
    field: str = "tolerance_mm"


@dataclass(frozen=True, eq=False)
class PlacedSegment:
    """One segment of the motion program, placed on the cam.

    Attributes:
        index: position in the program, from 0.
        kind: rise, dwell or return; a table that moves both ways is neither.
        start, angle: cam angle where it starts, and its length β [rad].
        s_start, s_end: displacement at its ends [mm], measured from the lowest position.
        law: the normalised law g(x), 0 to 1 over x in [0, 1] (of a table: to lift/unit), so that
            s = s_start + unit · g((θ − start)/β); None while it is free.
        free: what a free law must satisfy; None where the law is given.
        start_state, end_state: required at its ends. table: that it has to follow.
    """

    index: int
    kind: SegmentKind
    start: float
    angle: float
    s_start: float
    s_end: float
    law: Piecewise | None
    free: FreeLaw | None = None
    start_state: EndState = ANY_STATE
    end_state: EndState = ANY_STATE
    table: TablePoints | None = None

    @property
    def end(self) -> float:
        """Cam angle where it ends [rad]."""
        return self.start + self.angle

    @property
    def lift(self) -> float:
        """s_end − s_start [mm]: negative on a return."""
        return self.s_end - self.s_start

    @property
    def law_is_free(self) -> bool:
        """Whether the optimiser chooses its law: neither given nor fitted to a table."""
        return self.law is None and self.table is None and self.angle > 0.0

    @property
    def may_overshoot(self) -> bool:
        """Whether its law is one of the answer's that may go beyond its ends."""
        return self.free is not None and self.free.overshoot

    @property
    def senses(self) -> tuple[Sense, ...]:
        """The ways in which it moves: a table that turns back, both."""
        return ("rise", "return") if self.kind == "table" else (self.kind,)

    @property
    def scale(self) -> float:
        """What g is multiplied by [mm]: the lift, of a table the range it runs through."""
        return self.lift if self.table is None else float(np.ptp(self.table.s))

    @property
    def max_displacement(self) -> float:
        """Largest displacement on it [mm]; of a free law that may overshoot, of its ends."""
        ends = max(self.s_start, self.s_end)
        if self.law is None:
            return ends
        return max(ends, self.s_start + self.scale * _extreme(self.law, self.scale > 0.0))

    def with_law(self, law: Piecewise) -> PlacedSegment:
        """The segment with a law in place of a free one."""
        return replace(self, law=law)

    def placed(self) -> Piecewise:
        """s(θ) on this segment [mm over rad]; the law must be given."""
        if self.law is None:
            raise ValueError(f"the law of segment {self.index} is still free")
        return self._placed

    @cached_property
    def _placed(self) -> Piecewise:
        assert self.law is not None
        return self.law.rescale(self.start, self.angle, self.s_start, self.scale)

    def end_derivatives(self, highest: int, *, at_start: bool) -> Array:
        """s to s^(highest) just inside one end [mm per rad^k]: (highest + 1,); its law is known."""
        assert self.law is not None
        if self.law.is_constant:
            value = np.zeros(highest + 1)
            value[0] = self.s_start + self.scale * self.law.poly[0 if at_start else -1, 0]
            return value
        value = self.scale * _at_ends(self.law)[0 if at_start else 1, : highest + 1]
        value /= self.angle ** np.arange(len(value))
        value[0] += self.s_start
        return np.asarray(value)


Segments = Sequence[PlacedSegment]
"""The segments of one turn, in order."""


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
    return sign * maximise(law, (sign, 0.0, 0.0, 0.0))[0]


@dataclass(frozen=True, eq=False)
class Motion:
    """Displacement s(θ) for θ in [0, 2π], every law known."""

    segments: tuple[PlacedSegment, ...]
    curve: Piecewise

    @classmethod
    def of(cls, segments: Segments) -> Motion:
        """Join segments whose laws are known; those of zero angle contribute no piece."""
        return cls(tuple(segments), concatenate([s.placed() for s in segments if s.angle > 0.0]))

    def derivatives(self, theta: ArrayLike, highest: int = 3, side: Side = "right") -> Array:
        """s, s', …, s^(highest) at cam angles (n,) of any turn: (highest + 1, n) [mm, mm/rad, …].

        ``side``: which one-sided value to give where a derivative jumps.
        """
        angle = np.asarray(theta, dtype=float).ravel()
        return self.curve.derivatives(within_turn(angle, side), highest, side)


def within_turn(theta: Array, side: Side) -> Array:
    """The same cam angles in [0, 2π); looked at from the left, in (0, 2π]."""
    wrapped = theta - FULL_TURN * np.floor(theta / FULL_TURN)
    return np.where(wrapped == 0.0, FULL_TURN, wrapped) if side == "left" else wrapped
