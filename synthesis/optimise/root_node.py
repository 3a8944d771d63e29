"""The root of the branch and bound: the whole domain, relaxed on finer and finer meshes.

A convex problem ends here. Otherwise its relaxation gives the mesh and the start of a local search,
and what the incumbent then costs above the bound is left to nodes over parts of the domain.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from math import inf, sqrt
from typing import Any

from synthesis.numerics.piecewise import Array
from synthesis.numerics.solvers.clarabel import ConeSolution, solve
from synthesis.numerics.solvers.statuses import USABLE
from synthesis.optimise.branching.node import Node, Tree
from synthesis.optimise.branching.pivot_node import PivotNode
from synthesis.optimise.branching.size_search import search_sizes
from synthesis.optimise.branching.traced_node import TracedNode
from synthesis.optimise.conic.program import ConicModel, formulate
from synthesis.optimise.dual_bound.bound import Bound, dual_bound, in_problem_units
from synthesis.optimise.heuristics.local_search import local_search, offer_local_optimum
from synthesis.optimise.problem.derivative_caps import without_highest_caps, without_swift_caps
from synthesis.optimise.problem.grid import Grid, count_intervals, uniform_grid
from synthesis.optimise.recovery.candidate import Candidate, recover_cam
from synthesis.optimise.refinement.mesh import (
    add_midpoints,
    halve_intervals,
    is_same_mesh,
    refine_mesh,
)
from synthesis.optimise.refinement.polish import polish_knots
from synthesis.optimise.relaxation.any_law import size_conflict
from synthesis.optimise.separation.mesh_relaxation import (
    offer_cam,
    rows_cannot_separate,
    solve_and_separate,
)
from synthesis.optimise.separation.outer_approximation import MeshSolution, solve_on_mesh
from synthesis.optimise.state import QUICK, Optimise, SolveState, program_stage
from synthesis.optimise.strategy.dimension_search import search_dimension
from synthesis.optimise.strategy.idle_caps import search_without_idle_caps
from synthesis.optimise.strategy.phase_one import minimise_excess
from synthesis.optimise.strategy.tight_laws import WIDER, fix_tight_laws

MAX_MESHES = 8  # one finer than the other
COARSEST, FINEST = 24, 96  # intervals of the first mesh: the bound's error falls as their square
INTERVALS_AT_UNIT_TOLERANCE = 3.7  # too coarse as a rule: the second has knots where needed
FINEST_CURVED = 16  # intervals of the first mesh at most where curved limits are linearised
FINEST_WITHOUT_ROWS = 150  # of all laws, where curved limits have no rows: a local search follows
CURVATURE_GAP = 0.05  # below which finer meshes do not pay where curvature decides
FINE_ENOUGH = 2.0  # gap in tolerances: good enough for the local search that curvature needs
GROWTH = 1.1  # factor on the number of intervals: fewer say nothing about finer knots
WIDE_GAP = 0.05  # at which caps that do not bind may be what keeps the bound low
NEAREST, NEAR = 1e-5, 1e-4
"""Gaps that halved intervals do not close where knots lie on the law's own switches. Down to the
first one, meshes that begin with equal intervals do; below it are the solver's last digits."""
IDLE = 0.9  # a mesh that leaves more of the gap is idle
PROOF_DISTANCES = (0.5, 2.0, 8.0, 32.0, 128.0, 512.0)
"""Tolerances, in turn: how far below the level reached a proof that no cam is so good is tried."""
MOST_LEVELS = 12  # of a fractional objective on one mesh


@dataclass(frozen=True, eq=False)
class RootNode(Node):
    """The whole domain.

    Attributes:
        optimise: solves a problem of the same kind, with a dimension fixed.
        presolved: whether the closed form has given the answer.
        mesh_number: of the mesh, from 1. previous_interval_count: of the mesh before.
        last_solvable_mesh: the last mesh on which the relaxation had a point.
        dimension_searched: whether a dimension was searched, each value a problem of its own.
        near: whether the first mesh has the knots of a neighbouring problem's best laws.
    """

    optimise: Optimise
    presolved: bool
    mesh_number: int = 1
    last_solvable_mesh: tuple[Grid, ...] = ()
    previous_interval_count: int = 0
    dimension_searched: bool = False
    near: bool = False
    is_first: bool = field(default=True, kw_only=True)

    def process(self, state: SolveState) -> tuple[SolveState, Node]:
        """One mesh: relax, bound, recover a cam, and refine the mesh where that pays."""
        problem = state.problem
        if self.presolved:
            return self._finish(state)
        dimension = problem.machine.follower.fixable_dimension()
        if problem.has_curved_limits and dimension is not None:
            node = replace(self, processed=True, dimension_searched=True)
            return search_dimension(state, self.optimise), node
        if self.mesh_number == 1:
            state = _first_mesh(state)
        # 1. Relax and solve; the dual bound holds over all laws where their jerk is capped.
        started = time.perf_counter()
        gap_before, bound_before = state.relaxation_gap, state.lower
        solve_mesh = _solve_fractional if problem.objective.quasiconvex else solve_on_mesh
        state, model, solution, bound = solve_mesh(state, 0.0)
        # 2. Recover a cam, and the points at which it violates rows.
        state, cam, violations = offer_cam(state, model, solution, bound)
        seconds = time.perf_counter() - started
        name = f"convex {self.mesh_number}"
        state = state.with_stage(program_stage(name, model, solution, seconds))
        # 3. No spline of this mesh satisfies the rows, or next to none: other knots may have one.
        if solution.stopped not in USABLE:
            other_knots = self._seek_knots(state, violations)
            if other_knots is not None:
                return other_knots
        state = _with_first_cam(state, self.mesh_number)
        # 4. Knots of a neighbour, where the law is next to the best, move onto its own switches.
        if self.near and self.mesh_number == 1 and bound is not None:
            near = self._from_neighbour(state)
            if near is not None:
                return near
        # 5. Stop, or refine the mesh where the law costs more than the ideal one.
        failed = bound is None and self.mesh_number > 1
        if failed or _needs_no_finer_mesh(state, model, solution, bound):
            mesh = _mesh_for_local_search(state, cam, bound, violations)
            return self._finish(replace(state, grids=mesh))
        idle = IDLE * _over_bound(gap_before) < _over_bound(state.relaxation_gap) < inf
        fine = state.relaxation_gap <= FINE_ENOUGH * state.tolerance  # for the local search
        intervals = count_intervals(state.grids)
        many_added = intervals >= GROWTH * self.previous_interval_count
        gained = state.lower - bound_before
        if (
            (rows_cannot_separate(state) and gained <= state.tolerance * abs(state.lower))
            or (idle and (many_added or state.nonconvex_limits_cost))
            or (self.mesh_number > 1 and state.nonconvex_limits_cost and fine)
        ):
            return self._finish(state)
        solvable = state.grids if bound is not None else ()
        refined = _refined(state, cam, bound, violations, every=idle)
        if is_same_mesh(refined, state.grids):
            return self._finish(state)
        state = replace(state, grids=refined)
        if state.nonconvex_limits_cost and state.relaxation_gap < CURVATURE_GAP:
            # The local search finds its cam on this mesh, and far above this bound.
            return self._finish(state)
        return self._next(state, last_solvable_mesh=solvable, previous_interval_count=intervals)

    def _from_neighbour(self, state: SolveState) -> tuple[SolveState, Node] | None:
        """The end where the knots of a neighbour are next to the best; None where they are not.

        Where they leave more than the tolerance, but so little that halved intervals gain nothing,
        meshes begin again with equal ones.
        """
        polished = polish_knots(state, solve_and_separate)
        if polished.is_close(polished.relaxed) or polished.relaxation_gap <= NEAREST:
            return polished, replace(self, processed=True)
        if polished.relaxation_gap > NEAR:
            return None
        return self._next(_first_mesh(replace(polished, grids=(), relaxed=None)))

    def _seek_knots(
        self, state: SolveState, violations: list[Array]
    ) -> tuple[SolveState, Node] | None:
        """Where no spline of the mesh fits: other knots, or the end; None where neither is known.

        Phase 1 finds the gentlest law, whose knots are tried next; or proves that no law fits.
        """
        problem = state.problem
        if self.last_solvable_mesh:
            state = replace(state, grids=self.last_solvable_mesh, margin=0.0)
            grids = halve_intervals(problem, state.grids, violations)
            return self._next(replace(state, grids=grids), last_solvable_mesh=())
        proof = size_conflict(problem) if self.mesh_number == 1 else ""  # whatever the mesh
        if proof or self.mesh_number > 1 or not state.grids:
            nothing = replace(state, infeasible=bool(proof) or state.relaxed is None)
            return self._finish(replace(nothing, infeasibility_proof=proof))
        curved, args = problem.has_curved_limits, (state.grids, state.tighten, state.deadline)
        result = None if curved else minimise_excess(problem, *args)
        if result is None:
            return None
        if result.just_meets and state.tighten > 0.0:
            met = fix_tight_laws(state, result, self.optimise)
            return self._finish(self._bound_of_wider_limits(met, result.grids))
        state = replace(
            state, grids=result.grids, infeasibility_proof=result.impossible,
            undecided=result.undecided, infeasible=not result.fits,
            least_excess=None if result.fits else result.share - 1.0, strained=result.names,
        )  # fmt: skip
        return self._next(state) if result.fits else self._finish(state)

    def _bound_of_wider_limits(self, state: SolveState, grids: tuple[Grid, ...]) -> SolveState:
        """The bound of limits a little wider, which leave slack: it holds for these too."""
        wider = replace(state, grids=grids, tighten=-WIDER)
        node: Node = replace(self, mesh_number=2)
        while not node.processed:
            wider, node = node.process(wider)
        if not wider.covers_all_laws:
            return state
        return replace(state, stages=wider.stages).raise_bound(wider.lower, wider.valid_for)

    def _next(self, state: SolveState, **changed: Any) -> tuple[SolveState, Node]:
        """The same domain on the state's mesh."""
        node = replace(self, mesh_number=self.mesh_number + 1, **changed)
        return node._finish(state) if node.mesh_number > MAX_MESHES else (state, node)

    def _finish(self, state: SolveState) -> tuple[SolveState, Node]:
        """End the root: polish the last digits of convex problems; search least dimensions."""
        problem, node = state.problem, replace(self, processed=True)
        if not (self.presolved or state.suffices):
            state = polish_knots(state, solve_and_separate)
            state = _bound_without_vibration(state)
            state = self._bound_without_highest_caps(state)
        # A least value is not convex, nor are all ranges stated: a dimension is fixed at values.
        pinning = problem.machine.follower.fixable_dimension()
        undecided = not (state.is_good_enough or state.infeasibility_proof)
        if pinning and (pinning.needed or pinning.low > 0.0) and undecided:
            return search_dimension(state, self.optimise), replace(node, dimension_searched=True)
        return state, node

    def _bound_without_highest_caps(self, state: SolveState) -> SolveState:
        """A bound, knots and a cam without caps so far out of reach that they bind nowhere.

        The wider the highest derivative's cap, the more knots the bound takes; without it fewer,
        which serve here too. Where the acceleration swings at once, the whole proof is without it.
        """
        swift = None if state.is_good_enough else without_swift_caps(state.problem)
        wide = state.relaxation_gap > WIDE_GAP and state.time_left > 0.0 and state.grids
        problem = swift or (without_highest_caps(state.problem) if wide else None)
        if problem is None:
            return state
        proof = state.proof_budget if swift or state.cam_only else QUICK
        wider = self.optimise(problem, state.tolerance, state.deadline, state.tighten, proof=proof)
        if wider.covers_all_laws:
            state = state.raise_bound(wider.lower, wider.valid_for)
        if swift and wider.incumbent is not None:
            state = replace(state, modelled_kinds=wider.modelled_kinds)
            state, _ = offer_local_optimum(state, wider.incumbent.laws, wider.incumbent.size)
        if not wider.grids or state.time_left <= 0.0 or state.is_good_enough:
            return state
        finer, _ = solve_and_separate(replace(state, grids=wider.grids), self.mesh_number + 1)
        better = finer.relaxation_gap < state.relaxation_gap
        return finer if better else replace(finer, grids=state.grids)

    def branch(self, state: SolveState) -> tuple[SolveState, Sequence[Node]]:
        """A local search, then the whole domain again, with the incumbent's value to bound it."""
        state, problem = state.with_proof_begun(), state.problem
        if not self.dimension_searched:
            if not state.needs_local_search:
                return state, ()
            state = search_without_idle_caps(state, self.optimise)
            problem = state.problem
        pinning = problem.machine.follower.fixable_dimension()
        over = state.is_good_enough or state.time_left <= 0.0
        if over or (pinning is not None and pinning.needed):
            return state, ()  # boxes of sizes do not know what only a fixed value states
        if not problem.free:
            return search_sizes(state), ()
        if state.cam_only:
            return state, ()
        if not self.dimension_searched and without_swift_caps(problem) is not None:
            return state, ()  # all that the proof could do was done without these
        by_pivots = self.dimension_searched or problem.omits_curved_rows
        pivots = PivotNode if by_pivots and problem.has_curved_limits else None
        child: Node | None = TracedNode.root(state) or (pivots and pivots.root(state))
        return state, [child] if child is not None else []

    def is_pruned(self, state: SolveState) -> bool:
        return self.processed and state.is_good_enough

    def node_limit(self, state: SolveState) -> float:
        return inf

    def conclude(self, state: SolveState, tree: Tree) -> SolveState:
        return state


def _first_mesh(state: SolveState) -> SolveState:
    """The state with equal intervals, their number by the tolerance, unless it has a mesh."""
    if state.grids:
        return state
    finest = FINEST_CURVED if state.problem.has_curved_limits else FINEST
    wanted = INTERVALS_AT_UNIT_TOLERANCE / sqrt(state.tolerance)
    count = int(min(max(wanted, COARSEST), finest))
    grids = tuple(uniform_grid(segment, count) for segment in state.problem.free)
    return replace(state, grids=grids)


def _refined(
    state: SolveState,
    cam: Candidate | None,
    bound: Bound | None,
    violations: list[Array],
    *,
    every: bool,
) -> tuple[Grid, ...]:
    """The next mesh; ``every``: all intervals halved, as knots at single places gained little."""
    if every:
        return halve_intervals(state.problem, state.grids, violations)
    if state.relaxed is not None and bound is not None and not bound.switching:
        return add_midpoints(state.grids)
    return refine_mesh(state.problem, state.grids, cam, bound, violations)


def _with_first_cam(state: SolveState, mesh_number: int) -> SolveState:
    """A cam at once where the meshes give the bound alone."""
    known = state.incumbent is not None or mesh_number > 1
    return state if known or not state.problem.omits_curved_rows else local_search(state)


def _mesh_for_local_search(
    state: SolveState, cam: Candidate | None, bound: Bound | None, violations: Sequence[Array]
) -> tuple[Grid, ...]:
    """The present mesh, or a finer one where a least size rather than knots closed the gap."""
    if state.relaxed is None or bound is None or not bound.switching:
        return state.grids
    if not state.nonconvex_limits_cost or state.is_close(state.relaxed, bound.value):
        return state.grids
    return refine_mesh(state.problem, state.grids, cam, bound, violations)


def _needs_no_finer_mesh(
    state: SolveState, model: ConicModel, solution: ConeSolution, bound: Bound | None
) -> bool:
    """Whether the relaxation is solved to the tolerance, or there is no time for more.

    Where curved limits have no rows, no cam of the meshes tells: the relaxation's own optimum is
    compared with its bound. Too many knots would make the local search slow there.
    """
    done = state.suffices or state.is_close(state.relaxed)
    if done or state.time_left <= 0.0 or not state.grids:
        return True
    if not state.problem.omits_curved_rows or bound is None:
        return False
    value = in_problem_units(model, model.program.value(solution.x))
    close = value - bound.value <= 0.5 * state.tolerance * abs(value)
    return close or count_intervals(state.grids) > FINEST_WITHOUT_ROWS


def _solve_fractional(state: SolveState, _: float) -> MeshSolution:
    """A fractional objective on the present mesh, by Dinkelbach's method.

    The level is lowered to the value of the last solution until it stays; a program just below it
    has a positive optimum: no cam reaches that level. Where the mesh is too coarse, lower ones are.
    """
    level = 1.0 if state.relaxed is None else state.relaxed.value
    for _ in range(MOST_LEVELS):
        state, model, solution, bound = solve_on_mesh(state, level)
        if solution.stopped not in USABLE:
            return state, model, solution, None
        reached = recover_cam(model.problem, *model.recover(solution.x)).value
        stays = abs(reached - level) <= 1e-2 * state.tolerance * level
        level = reached
        if stays:
            break
    for distance in PROOF_DISTANCES:
        below = level * (1.0 - distance * state.tolerance)
        if below <= 0.0:
            break
        state, _plan, _solution, excess = solve_on_mesh(state, below)
        if excess is None:
            return state, model, solution, bound
        if excess.value > 0.0:
            return state, model, solution, replace(excess, value=below)
    return state, model, solution, None if bound is None else replace(bound, value=0.0)


def _bound_without_vibration(state: SolveState) -> SolveState:
    """A bound without limits on residual vibration, which laws of few knots pay too much for."""
    problem = state.problem
    unfit = problem.has_curved_limits or problem.objective.quasiconvex or not state.grids
    if not problem.vibration_limits or unfit or state.is_good_enough or state.time_left <= 0.0:
        return state
    model = formulate(problem.without_vibration, state.grids, 0.0, state.tightening)
    solution = solve(model.program, state.time_left)
    return state.with_bound(dual_bound(model, solution)) if solution.stopped in USABLE else state


def _over_bound(gap: float) -> float:
    """(value − bound)/bound of a gap (value − bound)/value: near 1 the gap shows no progress."""
    return gap / (1.0 - gap) if gap < 1.0 else inf
