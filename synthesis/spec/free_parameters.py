"""Numbers that are left free and searched: angles and lifts of segments, lengths of the machine."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from pydantic_core import PydanticCustomError

from synthesis.catalogue.fields import Range, ends
from synthesis.catalogue.followers import AnyFollower
from synthesis.numerics.piecewise import Array
from synthesis.numerics.polytope import Polytope
from synthesis.spec.program import Segment
from synthesis.units import MotionUnits

TURN = 360.0  # degrees
LENGTH_TRIALS = 33  # lengths of a machine that are looked at for one that serves
ROUNDING = 1e-9  # relative: what sums may miss by rounding
ProgramAndFollower = tuple[list[Segment], AnyFollower]


@dataclass(frozen=True)
class FreeParameter:
    """One number that is left free: field ``name`` of a segment or, with None, of the follower.

    ``requested``: as it stands in the spec; ``low``, ``high``: ends of what of it is searched.
    """

    segment: int | None
    name: str
    requested: float | Range
    low: float
    high: float

    @property
    def field(self) -> str:
        """Its path in the spec."""
        return f"{'follower' if self.segment is None else f'program/{self.segment}'}/{self.name}"


@dataclass(frozen=True, eq=False)
class FreeParameters:
    """All numbers of a spec that are left free, and what ties them together.

    The angles sum to a turn and the displacements gained to nothing; both are linear. Lengths of
    the machine are not tied to anything.
    """

    program: tuple[Segment, ...]
    follower: AnyFollower
    omega: float
    parameters: tuple[FreeParameter, ...]

    @classmethod
    def of(
        cls,
        program: Sequence[Segment],
        follower: AnyFollower,
        omega: float,
        base_radius: tuple[float, float],
    ) -> FreeParameters:
        """Those of a program and its machine; ends of the base radius [mm], open ones infinite."""
        own = (
            FreeParameter(i, name, value, *ends(value))
            for i, segment in enumerate(program)
            for name, value in segment.free_fields().items()
        )
        machines = follower.searched_dimensions(base_radius).items()
        lengths = (FreeParameter(None, name, given, *found) for name, (given, found) in machines)
        free = tuple(each for each in (*own, *lengths) if len({*ends(each.requested)}) > 1)
        return cls(tuple(program), follower, omega, free)

    @property
    def machine_indices(self) -> tuple[int, ...]:
        """Positions of those that are the follower's."""
        return tuple(k for k, parameter in enumerate(self.parameters) if parameter.segment is None)

    def substitute(self, values: Sequence[float]) -> ProgramAndFollower:
        """Program and follower with these numbers in place."""
        program, machine = list(self.program), dict[str, float]()
        for parameter, value in zip(self.parameters, values, strict=True):
            i = parameter.segment
            if i is None:
                machine[parameter.name] = float(value)
            else:
                program[i] = program[i].model_copy(update={parameter.name: float(value)})
        return program, self.follower.model_copy(update=machine) if machine else self.follower

    def values_in(self, program: Sequence[Segment], follower: AnyFollower) -> list[float]:
        """The numbers that stand in such a program and such a follower."""
        owners = (follower if o.segment is None else program[o.segment] for o in self.parameters)
        return [getattr(owner, o.name) for owner, o in zip(owners, self.parameters, strict=True)]

    def values_at(self, u: Array) -> list[float]:
        """The numbers at a point of the unit box."""
        return [
            o.low + (o.high - o.low) * float(x) for o, x in zip(self.parameters, u, strict=True)
        ]

    def at_point(self, u: Array) -> ProgramAndFollower:
        """Program and follower at a point of the unit box."""
        return self.substitute(self.values_at(u))

    def points_along(self, middle: Array, position: int, count: int) -> list[Array]:
        """Points along one number's range, evenly in its logarithm, ends included."""
        values = np.geomspace(self.parameters[position].low, self.parameters[position].high, count)
        return [self.with_value(middle, position, float(value)) for value in values]

    def with_value(self, u: Array, position: int, value: float) -> Array:
        """The point with one number at a value, or at the nearest end of its range."""
        low, high = self.parameters[position].low, self.parameters[position].high
        found = u.copy()
        found[position] = (min(max(value, low), high) - low) / (high - low)
        return found

    def check_reach(self, serves: Callable[[ProgramAndFollower], None]) -> None:
        """Refuse a machine that cannot serve whatever its free numbers are, of some that are tried.

        ``serves`` raises a PydanticCustomError where a program and a follower do not.
        """
        middle = self.polytope.centre() if self.machine_indices else None
        if middle is None:
            serves((list(self.program), self.follower))
            return
        (position,), why = self.machine_indices, list[str]()
        for u in self.points_along(middle, position, LENGTH_TRIALS):
            try:
                serves(self.at_point(u))
            except PydanticCustomError as refusal:
                why.append(refusal.message().partition(". ")[0])
            else:
                return
        low, high = ends(self.parameters[position].requested)
        both = f"with the shortest, {why[0]}; with the longest, {why[-1]}"
        raise PydanticCustomError(
            "no_length_serves",
            "{name} from {low} to {high} leaves no length that serves: {why}. Widen its range, or "
            "change what it has to reach.",
            {"name": self.parameters[position].name, "low": low, "high": high,
             "why": why[-1] if why[0] == why[-1] else both},
        )  # fmt: skip

    def tied_otherwise(self, name: str) -> bool:
        """Whether the sum of one field's numbers holds another field's number too."""
        row = 0 if name == "angle_deg" else 1
        others = [parameter.name != name for parameter in self.parameters]
        return bool(np.any(np.abs(self._sum_matrix[0][row, others]) > ROUNDING))

    @cached_property
    def polytope(self) -> Polytope:
        """Where the numbers may lie, each from 0 at its lower end to 1 at its upper end."""
        matrix, start = self._sum_matrix
        tied = np.any(np.abs(matrix) > ROUNDING, axis=1) | (np.abs(start) > ROUNDING)
        return Polytope(matrix[tied], -start[tied])

    @cached_property
    def _sum_matrix(self) -> tuple[Array, Array]:
        """What both sums miss at a point u is matrix · u + start: (2, n) and (2,)."""
        count = len(self.parameters)
        start = self._sum_errors(np.zeros(count))
        return np.stack([self._sum_errors(unit) - start for unit in np.eye(count)], axis=1), start

    def _sum_errors(self, u: Array) -> Array:
        """By how much the angles miss a turn, and the displacements gained their sum, relative."""
        program, _ = self.at_point(u)
        angle = math.fsum(segment.degrees for segment in program)
        gain = math.fsum(self._gains(program))
        return np.array([angle / TURN - 1.0, gain / self._longest])

    def _gains(self, program: Sequence[Segment]) -> Iterator[float]:
        """Displacement gained over every segment, the machine's lengths as they stand [mm]."""
        units = MotionUnits(self.follower.travel, self.omega)
        return (segment.gain(units) for segment in program)

    @cached_property
    def _longest(self) -> float:
        """The longest way that a segment may go [mm]."""
        program, _ = self.substitute([parameter.high for parameter in self.parameters])
        return max(map(abs, self._gains(program))) or 1.0
