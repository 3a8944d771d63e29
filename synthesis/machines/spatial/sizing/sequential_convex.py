"""Minimise the size under pressure-angle limits that are concave in the motion, with a lower bound.

Primal: sequential convex programming with inner approximations. Tangents of the concave limit about
the last laws are inner rows (``SizeConstraint``): every point of the convex program keeps the
limit, and the last laws are such a point, so that each cam is as good as the last one or better.
Knots are added where the program's multipliers ask for them.

Dual: the phase plane bounds the size over all laws. Where it leaves a gap above the tolerance and
finer knots gain little, outer rows are written as chords over the tubes of laws that could be
better than the best cam; the multipliers of that convex program give another bound by weak duality.

The loop of ``optimise.driver`` reads bounds and cams off one relaxation of limits that are nearly
convex. A turret's limit is concave in the motion: its valid rows (chords) are so weak without tubes
that such a program yields neither. Grids, programs, dual bounds and recovery are those of
``optimise``, to which a spatial cam is a problem with one size variable; its motion is a length.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf
from typing import ClassVar, cast

from synthesis.catalogue.constraints import AffineNorm, LinearInequality, SizeDomain
from synthesis.catalogue.followers.base import Follower
from synthesis.catalogue.followers.closures import SINGLE_FLANK, Closure
from synthesis.catalogue.limits import Limit, Machine
from synthesis.catalogue.motion import EndState, PlacedSegment
from synthesis.machines.spatial.machine import LARGEST, SpatialMachine
from synthesis.machines.spatial.size_constraints import SizeConstraint
from synthesis.machines.spatial.sizing.phase_plane import PhasePlane, least_size, trajectory_tubes
from synthesis.machines.spatial.spec import SpatialCamSpec, objective_of
from synthesis.numerics.piecewise import Array
from synthesis.numerics.solvers.clarabel import solve
from synthesis.numerics.solvers.statuses import USABLE
from synthesis.optimise.conic.control import law_controls
from synthesis.optimise.conic.linear_rows import Tightening
from synthesis.optimise.conic.program import formulate
from synthesis.optimise.conic.tangent_cuts import Region, TangentPoint
from synthesis.optimise.dual_bound.bound import Bound, dual_bound
from synthesis.optimise.heuristics.local_search import smooth_start
from synthesis.optimise.problem.boundary import boundary_states
from synthesis.optimise.problem.grid import uniform_grid
from synthesis.optimise.problem.problem import Problem
from synthesis.optimise.recovery.candidate import Candidate, recover_cam
from synthesis.optimise.recovery.closed_form import closed_form_size
from synthesis.optimise.refinement.mesh import refine_mesh
from synthesis.optimise.refinement.row_violations import ALLOWED, row_violations
from synthesis.optimise.state import SolveState, Stage, program_stage
from synthesis.optimise.strategy.phase_one import minimise_excess
from synthesis.units import Travel

FIRST_INTERVALS = 24  # spline intervals of the first grid
MAX_MESHES = 7  # of knot refinement
MAX_MESHES_CURVATURE = 3  # where accelerations are limited: no bound says what finer knots gain
MAX_LINEARISATIONS = 12  # on a mesh
NO_GAIN = 0.05  # of the tolerance: a linearisation that gains less ends the work on a mesh
LITTLE_GAIN = 0.1  # of the tolerance: a mesh that gains less asks for the bound by chords
ALL_LAWS = "all motion laws"


@dataclass(frozen=True)
class SpatialFollower:
    """A spatial machine as the optimiser's follower: all dimensions given but the size z.

    It has those members of ``catalogue.followers.Follower`` that are used for a problem without
    curved profiles.

    Attributes:
        machine: the machine. sizes: its other dimensions [mm].
        scale: length that stands for one unit of q [mm].
        rotation: +1 where the cam turns ccw, −1 where it turns cw.
    """

    machine: SpatialMachine
    sizes: Mapping[str, float]
    scale: float
    rotation: int

    closure: ClassVar[Closure] = SINGLE_FLANK

    @property
    def size_names(self) -> tuple[str, ...]:
        """Name of the minimised dimension."""
        return (self.machine.size_field,)

    def allows(self, z: tuple[float, ...]) -> bool:
        """Every size of the domain; see ``Follower``."""
        return True

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
        return SizeDomain(((0.0, LARGEST),), (), 0.0)

    def radius_norm(self) -> AffineNorm:
        """The objective: the size itself."""
        return AffineNorm(((1.0,),), (0.0,))

    def pressure_angle_rows(self, slope: float) -> tuple[LinearInequality, ...]:
        """|tan α| ≤ slope where it is linear in motion and size."""
        return self.machine.pressure_angle_rows(self.sizes, slope)

    def pressure_angle_constraints(self, slope: float) -> tuple[SizeConstraint, ...]:
        """|tan α| ≤ slope where it is not linear."""
        return self.machine.pressure_angle_curves(self.sizes, slope, self.rotation)

    def profile_radius_constraints(self, least: float) -> tuple[SizeConstraint, ...]:
        """Radius of convex wall parts ≥ least [mm]."""
        return self.machine.wall_radius_curves(self.sizes, least)


def formulate_problem(
    spec: SpatialCamSpec,
    segments: Sequence[PlacedSegment],
    limits: Sequence[Limit],
    sizes: Mapping[str, float],
) -> Problem:
    """The optimisation problem with every dimension given but the minimised one.

    Args:
        spec: machine, speed and rotation. segments: the program placed on the cam [rad or mm].
        limits: on motion and size. sizes: the other dimensions, by field [mm].
    """
    machine = spec.machine
    scale = machine.length_scale(sizes)
    placed = tuple(_as_length(segment, scale) for segment in segments if segment.angle > 0.0)
    stroke = max(abs(segment.lift) for segment in placed)
    follower = SpatialFollower(machine, sizes, scale, spec.rotation_sign)
    return Problem(
        placed, Machine(cast(Follower, follower), spec.omega), tuple(limits),
        follower.size_domain((0.0, inf)), objective_of(machine.size_field), stroke,
    )  # fmt: skip


def _as_length(segment: PlacedSegment, scale: float) -> PlacedSegment:
    """A segment with its displacement multiplied by ``scale``."""

    def scaled(state: EndState) -> EndState:
        return EndState(*(None if value is None else value * scale for value in state.known))

    table = segment.table
    if table is not None:
        table = replace(table, s=table.s * scale, tolerance=table.tolerance * scale)
    return replace(
        segment, s_start=segment.s_start * scale, s_end=segment.s_end * scale, table=table,
        start_state=scaled(segment.start_state), end_state=scaled(segment.end_state),
    )  # fmt: skip


def minimise_size(
    problem: Problem, tolerance: float, deadline: float, tighten: float
) -> SolveState:
    """The smallest cam, of a problem with free laws, to a relative gap or as near as meshes come.

    Args:
        deadline: ``clock.now()`` at which to stop.
        tighten: relative amount by which rows are tightened against the solver's tolerance.
    """
    grids = tuple(uniform_grid(segment, FIRST_INTERVALS) for segment in problem.free)
    state = SolveState(problem, tolerance, deadline, tighten, grids=grids)
    # Bound over all laws, before any cam is known.
    state, last = _bound_in_phase_plane(state), None
    # Where accelerations are limited the fastest laws are a bad start, and a smooth one is good.
    curves = (curve for segment in problem.free for curve in problem.curved_limits_on(segment))
    curvature = any(curve.order > 1 for curve in curves)
    if curvature:
        state, last = smooth_start(state)
    before, little = inf, False
    for number in range(1, (MAX_MESHES_CURVATURE if curvature else MAX_MESHES) + 1):
        # Primal: relinearise about the last laws until they no longer improve.
        state, last, lower, missed = _relinearise(state, last, number)
        if lower is None:
            # No point of the program: try knots on which the limits on the motion can be kept.
            if number > 1:
                break
            phase_one = minimise_excess(problem, state.grids, tighten, deadline)
            if phase_one is None:
                break
            state = replace(
                state, grids=phase_one.grids, infeasibility_proof=phase_one.impossible,
                undecided=phase_one.undecided, infeasible=bool(phase_one.impossible),
            )  # fmt: skip
            if not phase_one.fits:
                break
            continue
        if state.is_good_enough or state.time_left <= 0.0:
            break
        # Dual: chords over tubes, once finer knots gain little.
        best = state.incumbent
        value = inf if best is None else best.value
        little |= before - value <= LITTLE_GAIN * tolerance * value
        before = value
        if little and best is not None:
            state, better = bound_by_chords(state, best.size[0], number)
            lower = better or lower
            if state.is_good_enough or not lower.switching:
                break
        # Refine the knots where the multipliers say that laws would gain.
        state = replace(state, grids=refine_mesh(problem, state.grids, last, lower, missed))
    return state


def _bound_in_phase_plane(state: SolveState) -> SolveState:
    """Bound the size by what the fastest law and the given laws need."""
    began, problem = time.perf_counter(), state.problem
    ends, _ = boundary_states(problem.segments, state.grids)
    least = [
        least_size(PhasePlane.of(problem, segment, (own.start, own.end)), problem.length, LARGEST)
        for segment, own in zip(problem.free, ends, strict=True)
    ]
    given = tuple(segment for segment in problem.segments if segment.law is not None)
    size = closed_form_size(replace(problem, segments=given)) if given else None
    return state.raise_bound(max([*least, *(size or ())]), ALL_LAWS).with_stage(
        Stage("fastest run", "phase plane", "none", len(least), 0, 0, time.perf_counter() - began,
              "solved")
    )  # fmt: skip


def _relinearise(
    state: SolveState, last: Candidate | None, number: int
) -> tuple[SolveState, Candidate | None, Bound | None, list[Array]]:
    """Convex programs with inner rows about one law after the other, until they gain no more.

    Returns:
        the state; the last cam; the bound from the last program's multipliers, which holds for
        its own rows alone and serves to place knots, or None where the program has no point; and
        where rows were violated between their points.
    """
    began, iterations = time.perf_counter(), 0
    missed, lower = list[Array](), None
    for _ in range(MAX_LINEARISATIONS):
        # The convex program with tangents about the last laws; with chords while there are none.
        region = Region(state.problem.sizing.bounds)
        if last is not None:
            about = TangentPoint(tuple(law.curve() for law in last.laws), last.size)
            region = replace(region, tangent_points=(about,))
        plan = formulate(state.problem, state.grids, 0.0, state.tightening, region)
        solution = solve(plan.program, state.time_left)
        iterations += solution.iterations
        if solution.stopped not in USABLE:
            break
        lower = dual_bound(plan, solution)
        before = inf if last is None else last.value
        last = recover_cam(state.problem, *plan.recover(solution.x))
        missed, excess = row_violations(state, last)
        if excess > ALLOWED:
            # Rows hold at sample points: tighten them by more than what they miss in between.
            state = replace(state, margin=1.1 * (state.margin + excess))
        elif state.incumbent is None or last.value < state.incumbent.value:
            state = replace(state, incumbent=last)
        no_gain = before - last.value <= NO_GAIN * state.tolerance * last.value
        if (no_gain and excess <= ALLOWED) or state.time_left <= 0.0:
            break
    stage = program_stage(f"tangents {number}", plan, solution, time.perf_counter() - began)
    return state.with_stage(replace(stage, iterations=iterations)), last, lower, missed


def bound_by_chords(state: SolveState, size: float, number: int) -> tuple[SolveState, Bound | None]:
    """The state with a bound over all laws whose cam is no larger than ``size`` [mm], and that.

    The chord of a concave function over an interval is below it, so that chord rows over tubes
    hold for every such law; larger cams are above the bound anyway. Weak duality takes any
    nonnegative multipliers. None where no derivative of the laws is bounded: none bound all laws.
    """
    began, problem = time.perf_counter(), state.problem
    bare = formulate(problem, state.grids, 0.0, Tightening(), Region())
    if not law_controls(bare):
        return state, None
    region = Region(problem.sizing.bounds, (), dict(enumerate(trajectory_tubes(bare, size))))
    plan = formulate(problem, state.grids, 0.0, Tightening(state.tighten), region)
    solution = solve(plan.program, state.time_left)
    lower = dual_bound(plan, solution) if solution.stopped in USABLE else None
    if lower is not None:
        state = state.raise_bound(lower.value, lower.valid_for)
    stage = program_stage(f"chords {number}", plan, solution, time.perf_counter() - began)
    return state.with_stage(stage), lower
