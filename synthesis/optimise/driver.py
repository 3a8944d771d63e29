"""The driver: a spatial branch and bound over sizes and, of traced limits, over the objective's
value. Laws are relaxed, never branched on.

The relaxation of a node is a cone program over splines, and its dual bound holds over all motion
laws, not only over these splines. A convex problem is one whose root is solved to the tolerance;
nothing else distinguishes it.

    presolve    closed forms for given laws, and of extremal laws; a base circle that is too small
    select      the leaf with the least lower bound
    process     propagate, relax, separate, solve and bound (``root_node``: on one mesh, then again
                on a finer one; ``branching``: on a part of the domain); heuristics
    branch      a local search at the root; then parts of the domain; of given laws boxes of sizes

Who asks: ``pipeline`` for designs and conflicts, ``parameters`` for free angles and lengths, and
``strategy`` for problems with one dimension or one limit fixed.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from math import inf

from synthesis.numerics import clock
from synthesis.numerics.piecewise import Array
from synthesis.numerics.solvers.clarabel import solve
from synthesis.numerics.solvers.statuses import USABLE
from synthesis.optimise.branching.node import Node, Tree
from synthesis.optimise.conic.linear_rows import Tightening
from synthesis.optimise.conic.program import formulate
from synthesis.optimise.dual_bound.bound import Bound, in_problem_units
from synthesis.optimise.heuristics.extremal_laws import try_extremal_laws
from synthesis.optimise.problem.derivative_caps import highest_caps
from synthesis.optimise.problem.grid import Grid, grid_through
from synthesis.optimise.problem.problem import Problem
from synthesis.optimise.recovery.candidate import (
    Candidate,
    cam_at_size,
    enlarge_until_feasible,
    recover_cam,
    smallest_size,
    weighs_size,
)
from synthesis.optimise.recovery.closed_form import closed_form_size
from synthesis.optimise.relaxation.any_law import EVERY_LAW, ROUNDING, least_size, size_conflict
from synthesis.optimise.root_node import RootNode
from synthesis.optimise.state import (
    DEFAULT_TIGHTENING,
    QUICK,
    ProofBudget,
    SolveState,
    Stage,
    WarmStart,
)
from synthesis.optimise.strategy.coarser_tolerance import retry_at_coarser_tolerance
from synthesis.optimise.strategy.idle_caps import for_problem
from synthesis.optimise.strategy.pressure_angle_bisection import bisect_pressure_angle
from synthesis.optimise.strategy.unmodelled_limits import unmodelled_limits

LEVELS = 20
"""Trial levels of a fractional objective on one mesh."""
LEVEL_STAYS = 1e-7
"""Relative change of the level at which an estimate stops: searches over parameters take slopes
of it over steps a thousand times larger."""
ESTIMATE_TOLERANCE = 1e-2  # relative; an estimate refines no mesh

# Exits that the report names otherwise than the table below, which says when the loop ends.
TOLERANCE, SUFFICIENT = "tolerance", "sufficient"  # the incumbent is good enough, whatever ended it
BUDGET = "budget of the proof"  # a longer proof would process more nodes
NODE_LIMIT = "node limit"
UNDIVIDED = "the lowest node is not divided"

Test = Callable[[SolveState, Tree, Node], bool]

EXITS: tuple[tuple[str, Test], ...] = (
    (
        "the relaxation has no point",
        lambda state, tree, node: (
            state.infeasible and (node.processed or bool(state.infeasibility_proof))
        ),
    ),
    ("no open node has a better cam", lambda state, tree, node: node.is_pruned(state)),
    ("time", lambda state, tree, node: node.processed and state.time_left <= 0.0),
    (
        NODE_LIMIT,
        lambda state, tree, node: (
            (node.processed or node.upper_half) and tree.count >= tree.node_limit(state)
        ),
    ),
)
"""When the loop ends, besides a lowest node that cannot be divided (``UNDIVIDED``)."""


def optimise(
    problem: Problem,
    tolerance: float,
    deadline: float = inf,
    tighten: float = DEFAULT_TIGHTENING,
    *,
    proof: ProofBudget = QUICK,
    warm_start: WarmStart | None = None,
    earlier: Candidate | None = None,
    sufficient: float = -inf,
    sufficient_bound: float = inf,
    mesh: Sequence[Array] = (),
) -> SolveState:
    """Minimise one objective under all limits, to a relative gap.

    Args:
        problem: the problem.
        tolerance: relative gap at which to stop.
        deadline: ``time.monotonic()`` at which to stop with the best so far.
        tighten: relative tightening of the rows against the solver's tolerance.
        proof: what may be spent where nonconvex limits leave a gap.
        warm_start: where the local search of a neighbouring problem ended.
        earlier: a cam that another objective under the same limits has led to: the first
            incumbent, and its knots are those of the first mesh.
        sufficient: a value of the objective at which to stop, whatever the gap, in the problem's
            spec's units.
        sufficient_bound: a lower bound of the objective at which to stop, whatever the gap, in the
            same units.
        mesh: knots of every free law to begin with, those of a neighbouring problem; none, or
            those of other laws: equal intervals.

    Returns:
        the final state; without an incumbent where no cam was found.
    """
    now = clock.now()
    state = SolveState(
        problem, tolerance, deadline, tighten, warm_start=warm_start, sufficient=sufficient,
        sufficient_bound=sufficient_bound, cam_only=proof.cam_only,
        programs=proof.programs, proof_deadline=now + proof.share * (deadline - now),
    ).with_proof_begun()  # fmt: skip
    if problem.objective.equivalent_limits(1.0, problem.machine):
        # The objective is itself a nonconvex limit: its least value is bisected, each trial a
        # problem for this driver.
        return _with_valid_for(bisect_pressure_angle(state, optimise))
    state, presolved = _presolve(state)
    if earlier is not None and not presolved:
        state = _begin_from(state, earlier)
    near = earlier is None and 0 < len(mesh) == len(problem.free)
    if near:
        state = replace(state, grids=_grids_through(problem, mesh))
    tree = Tree((RootNode(optimise, presolved, near=near),))
    while not any(holds(state, tree, tree.next_node) for _, holds in EXITS):
        node = tree.next_node
        if not node.processed:
            state, processed = node.process(state)
            tree = tree.with_processed(node, processed)
            continue
        state, children = node.branch(state)
        if not children:
            break
        tree = tree.with_children(node, children)
    state = for_problem(tree.next_node.conclude(state, tree), problem)
    state = _with_valid_for(retry_at_coarser_tolerance(state, proof, optimise))
    return state.with_exit(_exit(state, tree))


def _begin_from(state: SolveState, best: Candidate) -> SolveState:
    """The state with the cam and the knots that an earlier objective has led to.

    On its knots that cam is a point of the relaxation and a start of the local search, however
    little room the earlier objective's value leaves.
    """
    state = state.with_incumbent(recover_cam(state.problem, best.laws, best.size, keep_size=True))
    knots = [law.space.breaks for law in best.laws]
    return replace(state, grids=_grids_through(state.problem, knots))


def _grids_through(problem: Problem, knots: Sequence[Array]) -> tuple[Grid, ...]:
    return tuple(grid_through(s, breaks) for s, breaks in zip(problem.free, knots, strict=True))


def _exit(state: SolveState, tree: Tree) -> str:
    """Why the loop has ended, for the report."""
    tests = ((name, holds(state, tree, tree.next_node)) for name, holds in EXITS)
    if state.is_good_enough:
        is_open = state.gap_between(state.incumbent, state.lower) > state.tolerance
        return SUFFICIENT if state.suffices or is_open else TOLERANCE
    name = next((name for name, holds in tests if holds), UNDIVIDED)
    # What only a longer proof would raise: more nodes, or any at all where curvature decides.
    short = name == NODE_LIMIT or (name == UNDIVIDED and state.needs_local_search)
    return BUDGET if short and not state.thorough else name


def _presolve(state: SolveState) -> tuple[SolveState, bool]:
    """Answer without a solver where that is possible.

    Returns:
        the state, and whether the closed form has given the answer.
    """
    problem = state.problem
    # where no cone program knows the limits, a local search would end before this is asked
    omitted = problem.omits_curved_rows
    if proof := problem.base_circle_conflict or (size_conflict(problem) if omitted else ""):
        return replace(state, infeasible=True, infeasibility_proof=proof), True
    state, presolved = _closed_form(_with_base_circle(state))
    state = state if presolved else try_extremal_laws(state)
    return state, presolved or state.is_good_enough


def _with_base_circle(state: SolveState) -> SolveState:
    """The state with a bound that is no less than a circle that is a part of every cam."""
    problem = state.problem
    if not problem.least_base_circle or problem.objective.norm(problem.machine) is None:
        return state
    circle = problem.objective.from_wire(problem.least_base_circle, problem.machine)
    return state.raise_bound(circle, "every motion law: a dwell below is a part of the base circle")


def _with_size_of_any_law(state: SolveState) -> SolveState:
    """The state with a bound over all laws where its own covers none, or a family of splines alone.

    The least size on the half-planes that every law keeps, whatever its derivatives.
    """
    problem, norm = state.problem, state.problem.objective.norm(state.problem.machine)
    if norm is None or not problem.free or highest_caps(problem):
        return state
    if state.covers_all_laws and state.is_good_enough:  # nothing is missing
        return state
    size = least_size(problem)
    if size is None or (state.covers_all_laws and norm.value(size) <= state.lower):
        return state
    least = norm.value(size) * (1.0 - ROUNDING)
    state = replace(state, lower=-inf, covers_all_laws=True)
    return state.raise_bound(least, EVERY_LAW)


def _with_least_size(state: SolveState) -> SolveState:
    """The state with the least size that is allowed as its bound, where the best cam is as small.

    No law is spoken of: it holds for every cam, whatever search has found the best one.
    """
    problem = state.problem
    if problem.objective.norm(problem.machine) is None or not state.is_smallest_sought:
        return state
    return state.raise_bound(problem.least_norm, "all base radii that are allowed")


def _closed_form(state: SolveState) -> tuple[SolveState, bool]:
    """The least size of given laws: a vertex of half-planes (``recovery.closed_form``)."""
    started, problem = time.perf_counter(), state.problem
    if problem.free or weighs_size(problem):
        return state, False
    size = smallest_size(problem)
    if size is None:
        impossible = problem.has_curved_limits and closed_form_size(problem) is None
        return replace(state, infeasible=impossible), impossible
    cam = cam_at_size(problem, (), size)
    norm = problem.objective.norm(problem.machine)
    if problem.has_curved_limits or problem.searched_norm > problem.least_norm:
        size = closed_form_size(problem) or size  # the cam's own was drawn in, or is not the least
    exact = cam.value if norm is None else norm.value(size)
    bound = Bound(exact * (1.0 - ROUNDING), "every size of the given laws")
    state = state.with_bound(bound).with_relaxed(cam)
    seconds, sizes = time.perf_counter() - started, len(problem.sizing.bounds)
    stage = Stage("closed form", "half-planes", "none", sizes, 0, 0, seconds, "solved")
    return state.with_stage(stage), True


def _with_valid_for(state: SolveState) -> SolveState:
    """The state with what its bound covers, and what it leaves out."""
    # A bound of a family of splines took the place of these, which hold over all laws.
    state = _with_least_size(_with_base_circle(_with_size_of_any_law(state)))
    return replace(state, valid_for=state.valid_for + unmodelled_limits(state))


def estimate(
    problem: Problem, grids: Sequence[Grid], guess: float = 1.0, deadline: float = inf
) -> float | None:
    """Estimate a problem's optimum on given grids [problem units]; None where nothing fits.

    A smooth function of the problem's numbers, but for kinks: one cone program and the enlargement
    that nonconvex limits need. For derivative-free searches over such numbers.

    Args:
        problem: the problem. grids: one per free law.
        guess: first trial level of a fractional objective [problem units].
        deadline: ``time.monotonic()`` at which the solver stops.
    """
    state = SolveState(problem, ESTIMATE_TOLERANCE, deadline, DEFAULT_TIGHTENING)
    if problem.vibration_excess:
        return None
    state, presolved = _closed_form(state)
    if presolved:
        return None if state.incumbent is None else state.incumbent.value
    for _ in range(LEVELS):
        model = formulate(problem, grids, guess, Tightening(state.tighten))
        solution = solve(model.program, state.time_left)
        if solution.stopped not in USABLE:
            return None
        fractional = problem.objective.quasiconvex
        if problem.objective.norm(problem.machine) is None and not fractional:
            return in_problem_units(model, model.program.value(solution.x))
        cam = recover_cam(model.problem, *model.recover(solution.x))
        if not fractional or abs(cam.value - guess) <= LEVEL_STAYS * cam.value:
            break
        guess = cam.value
    enlarged = enlarge_until_feasible(cam)
    return None if enlarged is None else enlarged.value
