"""Numbers of the motion program that are left free: angles and lifts of its segments."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from synthesis.numerics.piecewise import Array
from synthesis.numerics.polytope import Polytope
from synthesis.program import Segment
from synthesis.ranges import ends
from synthesis.units import Pace

TURN = 360.0
CLOSED = 1e-9  # relative: what sums may miss by rounding


@dataclass(frozen=True)
class Opening:
    """One number that is left free: field ``name`` of a segment, between two ends."""

    segment: int
    name: str
    low: float
    high: float

    @property
    def field(self) -> str:
        """Its path in the spec."""
        return f"program/{self.segment}/{self.name}"


@dataclass(frozen=True, eq=False)
class Openings:
    """All numbers of a program that are left free, and what ties them together.

    The angles sum to a turn and the displacements gained to nothing; both are linear.
    """

    program: tuple[Segment, ...]
    pace: Pace
    free: tuple[Opening, ...]

    @classmethod
    def of(cls, program: Sequence[Segment], pace: Pace) -> Openings:
        """Those of a program; ``pace`` turns the wire's numbers into the core's."""
        free = tuple(
            Opening(i, name, *ends(value))
            for i, segment in enumerate(program)
            for name, value in segment.left_open().items()
            if ends(value)[0] != ends(value)[1]
        )
        return cls(tuple(program), pace, free)

    def filled(self, values: Sequence[float]) -> list[Segment]:
        """The program with these numbers in place."""
        program = list(self.program)
        for opening, value in zip(self.free, values, strict=True):
            i = opening.segment
            program[i] = program[i].model_copy(update={opening.name: float(value)})
        return program

    def numbers(self, u: Array) -> list[float]:
        """The numbers at a point of the unit box."""
        return [o.low + (o.high - o.low) * float(x) for o, x in zip(self.free, u, strict=True)]

    def at(self, u: Array) -> list[Segment]:
        """The program at a point of the unit box."""
        return self.filled(self.numbers(u))

    def tied_otherwise(self, name: str) -> bool:
        """Whether the sum of one field's numbers holds another field's number too."""
        row = 0 if name == "angle_deg" else 1
        others = [opening.name != name for opening in self.free]
        return bool(np.any(np.abs(self._table[0][row, others]) > CLOSED))

    @cached_property
    def polytope(self) -> Polytope:
        """Where the numbers may lie, each from 0 at its lower end to 1 at its upper end."""
        matrix, start = self._table
        tied = np.any(np.abs(matrix) > CLOSED, axis=1) | (np.abs(start) > CLOSED)
        return Polytope(matrix[tied], -start[tied])

    @cached_property
    def _table(self) -> tuple[Array, Array]:
        """What both sums miss at a point u is matrix · u + start: (2, n) and (2,)."""
        count = len(self.free)
        start = self._rest(np.zeros(count))
        return np.stack([self._rest(unit) - start for unit in np.eye(count)], axis=1), start

    def _rest(self, u: Array) -> Array:
        """By how much the angles miss a turn, and the displacements gained their sum, relative."""
        program = self.filled(self.numbers(u))
        angle = math.fsum(segment.degrees for segment in program)
        gain = math.fsum(segment.gain(self.pace) for segment in program)
        return np.array([angle / TURN - 1.0, gain / self._longest])

    @cached_property
    def _longest(self) -> float:
        """The longest way that a segment may go [mm]."""
        program = self.filled([opening.high for opening in self.free])
        return max(abs(segment.gain(self.pace)) for segment in program) or 1.0
