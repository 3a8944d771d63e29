"""Outer approximation: rows of curved limits, linearised again and again at the last solution.

A curved limit enters a cone program by rows that hold for every motion and size of a region; each
such program is a relaxation, and its dual bound is valid. Where the limit is convex, rows tangent
to it at the last solution make the next program exact to second order, as in Newton's method. Rows
of a few solutions before are kept, without which the iteration may alternate between two points.
Where the limit is not convex, the rows are as tight as the region is narrow: bound tightening
(``propagation``) narrows it to what a cam better than the incumbent can be.
"""

from __future__ import annotations

from dataclasses import replace
from math import inf, isfinite

import numpy as np

from synthesis.numerics.solvers.clarabel import ConeSolution, solve
from synthesis.numerics.solvers.statuses import USABLE
from synthesis.optimise.conic.control import capped_controls
from synthesis.optimise.conic.program import NO_TIGHTENING, ConicModel, formulate
from synthesis.optimise.conic.tangent_cuts import Region, TangentPoint
from synthesis.optimise.dual_bound.bound import Bound, dual_bound, in_problem_units
from synthesis.optimise.heuristics.local_search import improve_from, smooth_start
from synthesis.optimise.propagation import law_tightening
from synthesis.optimise.recovery.candidate import recover_cam
from synthesis.optimise.refinement.row_violations import ALLOWED, row_violations
from synthesis.optimise.state import SolveState

MAX_ITERATIONS = 24  # cone programs on one mesh
STALLED = 0.05  # of the tolerance, or of the open gap: an iteration that gains less has stalled
TIGHTENING_GAIN = 0.1  # of the open gap: what bound tightening has to gain before it is done again
ROW_SHARE = 0.3  # of the gap: the part left by the rows from which on the region is narrowed
KEPT_POINTS = 4  # solutions at which rows are kept tangent
TANGENT = 1e-9  # excess of a curved limit up to which rows at the solution cannot cut it off
SIZE_GAIN = 0.1  # of the tolerance: what rows may leave to gain once a cam of that value is known
SPARE = 1e-9  # relative slack of values that a better cam satisfies, against rounding

MeshSolution = tuple[SolveState, ConicModel, ConeSolution, Bound | None]


def solve_on_mesh(state: SolveState, level: float) -> MeshSolution:
    """Solve the relaxation on the present mesh: one cone program, and its dual bound.

    Where limits are curved, programs are solved until their rows touch these limits: the last one
    is returned, with its solution and bound; no bound where the solver gave no usable point.
    """
    value, value_when_tightened = -inf, -inf
    curved = state.problem.has_curved_limits
    if curved and state.relaxed is None and state.region is None:
        state, _ = smooth_start(state)  # any cam at all bounds the sizes of better ones
    for _ in range(MAX_ITERATIONS):
        # 1. Solve the relaxation with the rows at hand; its bound is valid whatever these are.
        model = formulate(state.problem, state.grids, level, state.tightening, state.region)
        solution = solve(model.program, state.time_left)
        lower = dual_bound(model, solution) if solution.stopped in USABLE else None
        if lower is None or not curved:
            break
        # 2. Linearise at its solution; laws on which the limit is still exceeded are "loose".
        state, loose = _linearise(state.with_bound(lower), model, solution)
        state = replace(state, tangent=not loose)
        if state.tangent or state.is_close(state.relaxed) or state.time_left <= 0.0:
            break
        if state.problem.omits_curved_rows:
            break
        # 3. Go on while new tangents raise the optimum.
        before, value = value, in_problem_units(model, model.program.value(solution.x))
        best = state.smallest_value
        missing = best - value if isfinite(best) else 0.0
        if value - before > STALLED * max(state.tolerance * abs(value), missing):
            continue
        # 4. New tangents gain nothing more: what is left is due to the region's width, or to knots.
        if best - value <= ROW_SHARE * (best - state.lower) < inf:
            break
        state = _look_for_cam(state)
        if value - value_when_tightened <= TIGHTENING_GAIN * (state.smallest_value - value) < inf:
            break
        tightened = _tighten_region(state, model, lower, loose)
        if tightened is None:
            break
        state, value_when_tightened = tightened, value
    return state, model, solution, lower


def _look_for_cam(state: SolveState) -> SolveState:
    """A local search, once, where no size fits the laws of the cone programs."""
    last = None if state.local_search_done else state.last
    if last is None or row_violations(state, last)[1] <= ALLOWED:
        return state
    start = state.incumbent or state.relaxed or last
    return improve_from(replace(state, local_search_done=True), start)


def _tighten_region(
    state: SolveState, model: ConicModel, lower: Bound, loose: set[int]
) -> SolveState | None:
    """The state with the region of every better cam; None where nothing bounds the laws."""
    region, problem, best = state.region, state.problem, state.smallest_value
    if region is None or not lower.switching or not isfinite(best):
        return None
    # Every better cam satisfies the rows, and the objective's cap where sizes do not imply it.
    inside = replace(problem.sizing, bounds=region.sizes, min_norm=0.0)
    better = law_tightening.with_value_cap(replace(problem, sizing=inside), best * (1.0 + SPARE))
    if problem.objective.norm(problem.machine) is not None:
        better = replace(better, objective_caps=problem.objective_caps)
    grids = tuple(grid.knots_only for grid in model.grids)
    first = replace(region, tangent_points=region.tangent_points[:1])
    relaxed = formulate(better, grids, 0.0, NO_TIGHTENING, first)
    capped = capped_controls(relaxed)
    if capped is None:
        return None
    known = region.law_bounds or {
        k: law_tightening.initial_law_bounds(relaxed, k, control)
        for k, control in enumerate(capped)
    }
    bounds = {
        k: law_tightening.tighten_law(relaxed, capped, region.sizes, k, one, state.deadline)
        if k in loose
        else one
        for k, one in known.items()
    }
    return replace(state, region=replace(region, law_bounds=bounds))


def _linearise(
    state: SolveState, model: ConicModel, solution: ConeSolution
) -> tuple[SolveState, set[int]]:
    """Take the solution as the next point of tangency, and make a cam of it.

    The cam's smallest size follows from its law alone, and no better cam is larger than the best.
    Also the positions of the laws on which a curved limit is still exceeded.
    """
    problem = state.problem
    laws, size = model.recover(solution.x)
    cam = recover_cam(problem, laws, size)
    state = replace(state, last=cam)
    curves = tuple(law.curve() for law in laws)
    if row_violations(state, cam)[1] <= ALLOWED:
        state = state.with_relaxed(cam)
    region = state.region or Region()
    points = (TangentPoint(curves, cam.size), TangentPoint(curves, size), *region.tangent_points)
    region = replace(region, sizes=_sizes(state), tangent_points=points[:KEPT_POINTS])
    state = replace(state, region=region)
    value = in_problem_units(model, model.program.value(solution.x))
    if state.smallest_value - value <= SIZE_GAIN * state.tolerance * abs(value):
        return state, set()
    loose = set[int]()
    for position, (free, grid, curve) in enumerate(
        zip(problem.free, state.grids, curves, strict=True)
    ):
        segment = free.with_law(curve)
        s = segment.placed().derivatives(segment.start + segment.angle * grid.points)
        limits = problem.curved_limits_on(segment)
        if any(np.max(excess) > TANGENT for limit in limits for excess in limit.excess(s, size)):
            loose.add(position)
    return state, loose


def _sizes(state: SolveState) -> tuple[tuple[float, float], ...]:
    """Bounds of the size that every better cam satisfies, where one size alone is minimised."""
    bounds = state.problem.sizing.bounds
    norm = state.problem.objective.norm(state.problem.machine)
    if norm is None or len(bounds) > 1:
        return bounds
    ((factor,),), (shift,) = norm.matrix, norm.shift
    ((low, high),) = bounds
    high = min(high, (state.smallest_value * (1.0 + SPARE) - shift) / factor)
    if isfinite(state.lower):
        low = max(low, (state.lower * (1.0 - SPARE) - shift) / factor)
    return ((min(low, high), high),)
