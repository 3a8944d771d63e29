"""A spatial cam's question as the formulations see it: one size, the motion as a length."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf
from typing import ClassVar, cast

from synthesis.followers.base import Follower
from synthesis.followers.sizing import Sizing
from synthesis.formulations.question.problem import Problem
from synthesis.limits import Limit, Machine
from synthesis.motion import EndState, Stretch
from synthesis.spatial.leverage import Leverage
from synthesis.spatial.machine import SpatialMachine
from synthesis.spatial.objectives.base import SpatialObjective
from synthesis.terms import Cone, Norm, Row
from synthesis.units import Travel

FARTHEST = 1e4  # strokes and reaches: an open end of the dimension that is made small


@dataclass(frozen=True)
class SizedMachine:
    """A machine with all dimensions given but the one that is made small, which is its size z.

    It promises what formulations and limits on the motion ask of a planar follower.

    Attributes:
        machine: the machine. sizes: its other dimensions [mm].
        reach: length of the core for one unit of q [mm]. largest: end of the size [mm].
        turns: +1 where the cam turns ccw, −1 where it turns cw.
        safe: limits that are not linear give rows that exclude whatever breaks them.
    """

    machine: SpatialMachine
    sizes: Mapping[str, float]
    reach: float
    largest: float
    turns: int = 1
    safe: bool = False

    companions: ClassVar[tuple[str, ...]] = ()

    @property
    def size_names(self) -> tuple[str, ...]:
        """The dimension that is made small."""
        return (self.machine.sought,)

    @property
    def travel(self) -> Travel:
        """How displacements are told: the core's are lengths."""
        travel = self.machine.travel
        return Travel(travel.unit, travel.per_unit * self.reach)

    def pinning(self) -> None:
        """No dimension is pinned."""
        return None

    def sizing(self, radii: tuple[float, float]) -> Sizing:
        """Where the size may lie [mm]."""
        return Sizing(((0.0, self.largest),), (), 0.0)

    def prime_radius(self) -> Norm:
        """What is made small."""
        return Norm(((1.0,),), (0.0,))

    def raised(self, z: tuple[float, ...], amount: float) -> tuple[float, ...]:
        """The size larger by ``amount`` [mm]."""
        return (z[0] + amount,)

    def reaching(self, z: tuple[float, ...], radius: float) -> tuple[float, ...]:
        """The size raised to at least ``radius`` [mm]."""
        return (max(z[0], radius),)

    def room(
        self, z: tuple[float, ...], bounds: Sequence[tuple[float, float]], cones: Sequence[Cone]
    ) -> float:
        """How far it can be raised [mm]."""
        return max(bounds[-1][1] - z[-1], 0.0)

    @property
    def paths(self) -> Mapping[str, SizedMachine]:
        """What pressure angles are of: of all rollers at once."""
        return {"": self}

    def pressure_angle_rows(self, slope: float) -> tuple[Row, ...]:
        """|tan α| ≤ slope where it is linear in motion and size."""
        return self.machine.pressure_angle_rows(self.sizes, slope)

    def pressure_angle_curves(self, slope: float) -> tuple[Leverage, ...]:
        """|tan α| ≤ slope where it is not."""
        return self._turned(self.machine.pressure_angle_curves(self.sizes, slope, self.turns))

    def profile_radius_curves(self, least: float) -> tuple[Leverage, ...]:
        """Convex radius of the walls ≥ least [mm]."""
        return self._turned(self.machine.wall_curves(self.sizes, least))

    def _turned(self, curves: tuple[Leverage, ...]) -> tuple[Leverage, ...]:
        return tuple(curve.made_safe() for curve in curves) if self.safe else curves


def posed(
    machine: SpatialMachine,
    stretches: Sequence[Stretch],
    omega: float,
    limits: Sequence[Limit],
    objective: SpatialObjective,
    sizes: Mapping[str, float],
    turns: int,
) -> Problem:
    """The question with every dimension given but the one that is made small.

    Args:
        machine: around the cam. stretches: the program on the cam [rad or mm].
        omega: cam speed ω [rad/s]. limits: what may not be exceeded.
        objective: names that dimension. sizes: the others [mm].
        turns: +1 where the cam turns ccw, −1 where it turns cw.
    """
    reach = machine.reach(sizes)
    placed = tuple(_in_mm(stretch, reach) for stretch in stretches if stretch.angle > 0.0)
    stroke = max(abs(stretch.lift) for stretch in placed)
    sized = SizedMachine(machine, sizes, reach, FARTHEST * max(stroke, reach), turns)
    # formulations ask of a follower what SizedMachine promises, and no more
    around = Machine(cast(Follower, sized), omega)
    return Problem(placed, around, tuple(limits), sized.sizing((0.0, inf)), objective, stroke)


def made_safe(problem: Problem) -> Problem:
    """The same question, its rows about a law excluding whatever breaks a limit."""
    sized = replace(cast(SizedMachine, problem.machine.follower), safe=True)
    return replace(problem, machine=replace(problem.machine, follower=cast(Follower, sized)))


def leverages(problem: Problem, stretch: Stretch) -> tuple[Leverage, ...]:
    """The limits on a stretch that are not linear."""
    return cast(tuple[Leverage, ...], tuple(problem.curves_on(stretch)))


def _in_mm(stretch: Stretch, reach: float) -> Stretch:
    """A stretch with its displacement as a length of the core."""
    if reach == 1.0:
        return stretch
    return replace(
        stretch,
        s_start=stretch.s_start * reach,
        s_end=stretch.s_end * reach,
        at_start=_state(stretch.at_start, reach),
        at_end=_state(stretch.at_end, reach),
        readings=None
        if stretch.readings is None
        else replace(
            stretch.readings,
            s=stretch.readings.s * reach,
            tolerance=stretch.readings.tolerance * reach,
        ),
    )


def _state(state: EndState, reach: float) -> EndState:
    v, a = state.known
    return EndState(None if v is None else v * reach, None if a is None else a * reach)
