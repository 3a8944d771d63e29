"""A spatial cam as a problem of the optimiser: one size variable, and the motion as a length."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf
from typing import ClassVar, cast

from synthesis.catalogue.constraints import AffineNorm, LinearInequality
from synthesis.catalogue.followers.base import Follower
from synthesis.catalogue.followers.closures import SINGLE_FLANK, Closure
from synthesis.catalogue.followers.sizing import SizeDomain
from synthesis.catalogue.limits import Limit, Machine
from synthesis.catalogue.motion import EndState, PlacedSegment
from synthesis.machines.spatial.limits import objective_of
from synthesis.machines.spatial.machine import SpatialMachine
from synthesis.machines.spatial.pressure_angle_constraints import SizeConstraint
from synthesis.machines.spatial.spec import SpatialCamSpec
from synthesis.optimise.problem.problem import Problem
from synthesis.units import Travel

FARTHEST = 1e4  # largest strokes and roller paths: stands for an open upper end of the size


@dataclass(frozen=True)
class SpatialFollower:
    """A spatial machine as the optimiser's follower: all dimensions given but the size z.

    It has the members of ``catalogue.followers.Follower`` that the optimiser and limits on the
    motion use for a problem without curved profiles, and no others.

    Attributes:
        machine: the machine. sizes: its other dimensions [mm].
        scale: length that stands for one unit of q [mm]. largest: upper end of the size [mm].
        rotation: +1 where the cam turns ccw, −1 where it turns cw.
        inner: rows of constraints that are not linear are inner rows, see ``SizeConstraint``.
    """

    machine: SpatialMachine
    sizes: Mapping[str, float]
    scale: float
    largest: float
    rotation: int = 1
    inner: bool = False

    active_closure: ClassVar[Closure] = SINGLE_FLANK

    @property
    def size_names(self) -> tuple[str, ...]:
        """Name of the minimised dimension."""
        return (self.machine.size_field,)

    @property
    def travel(self) -> Travel:
        """Units of displacement: lengths inside the optimiser, the machine's on the wire."""
        travel = self.machine.travel
        return Travel(travel.unit, travel.per_unit * self.scale)

    def fixable_dimension(self) -> None:
        """No dimension is searched outside of the convex program."""
        return None

    def size_domain(self, radii: tuple[float, float]) -> SizeDomain:
        """Domain of the size [mm]."""
        return SizeDomain(((0.0, self.largest),), (), 0.0)

    def radius_norm(self) -> AffineNorm:
        """The objective: the size itself."""
        return AffineNorm(((1.0,),), (0.0,))

    def enlarged_to(self, z: tuple[float, ...], radius: float) -> tuple[float, ...]:
        """The size raised to at least ``radius`` [mm]."""
        return (max(z[0], radius),)

    def pressure_angle_rows(self, slope: float) -> tuple[LinearInequality, ...]:
        """|tan α| ≤ slope where it is linear in motion and size."""
        return self.machine.pressure_angle_rows(self.sizes, slope)

    def pressure_angle_constraints(self, slope: float) -> tuple[SizeConstraint, ...]:
        """|tan α| ≤ slope where it is not linear."""
        return self._as_inner(self.machine.pressure_angle_curves(self.sizes, slope, self.rotation))

    def profile_radius_constraints(self, least: float) -> tuple[SizeConstraint, ...]:
        """Radius of convex wall parts ≥ least [mm]."""
        return self._as_inner(self.machine.wall_radius_curves(self.sizes, least))

    def _as_inner(self, curves: tuple[SizeConstraint, ...]) -> tuple[SizeConstraint, ...]:
        return tuple(curve.inner_approximation() for curve in curves) if self.inner else curves


def formulate_problem(
    spec: SpatialCamSpec,
    segments: Sequence[PlacedSegment],
    limits: Sequence[Limit],
    sizes: Mapping[str, float],
) -> Problem:
    """The optimisation problem with every dimension given but the minimised one.

    Args:
        spec: machine, speed and rotation. segments: the program placed on the cam [rad or mm].
        limits: limits on motion and size. sizes: the other dimensions, by field [mm].
    """
    machine = spec.machine
    scale = machine.length_scale(sizes)
    placed = tuple(_as_length(segment, scale) for segment in segments if segment.angle > 0.0)
    stroke = max(abs(segment.lift) for segment in placed)
    largest = FARTHEST * max(stroke, scale)
    follower = SpatialFollower(machine, sizes, scale, largest, spec.rotation_sign)
    return Problem(
        placed, Machine(cast(Follower, follower), spec.omega), tuple(limits),
        follower.size_domain((0.0, inf)), objective_of(machine.size_field), stroke,
    )  # fmt: skip


def inner_approximation(problem: Problem) -> Problem:
    """The same problem with inner rows: every point of its programs keeps the limits."""
    follower = replace(cast(SpatialFollower, problem.machine.follower), inner=True)
    return replace(problem, machine=replace(problem.machine, follower=cast(Follower, follower)))


def _as_length(segment: PlacedSegment, scale: float) -> PlacedSegment:
    """A segment with its displacement multiplied by ``scale``."""
    if scale == 1.0:
        return segment
    table = segment.table
    if table is not None:
        table = replace(table, s=table.s * scale, tolerance=table.tolerance * scale)
    return replace(
        segment,
        s_start=segment.s_start * scale,
        s_end=segment.s_end * scale,
        start_state=_scaled(segment.start_state, scale),
        end_state=_scaled(segment.end_state, scale),
        table=table,
    )


def _scaled(state: EndState, scale: float) -> EndState:
    v, a = state.known
    return EndState(None if v is None else v * scale, None if a is None else a * scale)
