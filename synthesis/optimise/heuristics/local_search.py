"""Local search: incumbents under nonconvex limits, from the relaxation or from a neighbour.

Sequential convex programming comes first (``scp``), with its two or three cone programs; IPOPT
where that does not converge. A cam that results is an incumbent and proves nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import inf, isfinite

import numpy as np

from synthesis.catalogue.objectives import RmsAcceleration, RmsJerk
from synthesis.numerics.piecewise import Array
from synthesis.numerics.solvers.clarabel import solve
from synthesis.numerics.solvers.statuses import USABLE, StopReason
from synthesis.optimise.conic.program import formulate
from synthesis.optimise.conic.tangent_cuts import Region
from synthesis.optimise.heuristics.scp import ScpTarget, solve_scp
from synthesis.optimise.problem.derivative_caps import with_tighter_caps
from synthesis.optimise.problem.grid import Grid, SplineLaw, grid_through, merge_knots
from synthesis.optimise.recovery.candidate import Candidate, enlarge_for_rows, recover_cam
from synthesis.optimise.refinement.row_violations import (
    ALLOWED,
    breaks_exact_rows,
    exact_excess,
    row_violations,
)
from synthesis.optimise.state import SolveState, Stage, WarmStart

Vector = tuple[float, ...]
Violations = tuple[list[Array], float]

FAR = 1.5  # value over the bound from which an incumbent is not the only start that is tried
SHARE_STEP, LEAST_SHARE = 0.3, 1e-6
"""From one share of the caps on the highest derivative to the next smaller one, and their end."""
FAR_GAP = 0.2  # gap above which further starts are tried
EXCHANGES = 3  # runs of IPOPT at most, each with points where the run before violated rows
GROWTH = 0.1  # share of the tolerance that IPOPT may leave to the final enlargement; it saves a run
STOP_GAP = 0.08
"""Share of the tolerance that the linearised limits may leave to the final enlargement."""
MAX_STOP_GAP = 4e-4  # the same as a relative value, whatever the tolerance
LEAST_STOP_GAP = 1e-4
"""Relative, of the prime radius of a small cam, whose base radius is but a little part of it:
nearer to the optimum the search takes longer than it gains."""
ROW_FACTOR = 2.0  # factor on the stop gap: what rows written at points may cost besides, in between
TIGHTENING = 1e-6  # relative tightening of limits at the points where they are linearised
QUARTERED = 1.0 / 16.0
"""Of an excess between points, what is left where these come four times as near to each other."""
RETRIES = 2  # repeats with tighter limits, where the enlargement does not repair every violation
RETRY_TIGHTENING = 0.5  # share of the stop gap by which these repeats tighten


def local_search(state: SolveState) -> SolveState:
    """Look for a local optimum: from a neighbour's, else from the best start at hand."""
    state = _from_warm_start(state)
    if state.warm_started:
        return state
    if state.incumbent is None or state.incumbent.value > FAR * state.lower:
        state, _ = smooth_start(state)
    if state.suffices:
        return state
    start = state.incumbent or state.relaxed or state.last
    state = state if start is None else improve_from(state, start)
    return _continue_from_tighter_caps(state)


def _continue_from_tighter_caps(state: SolveState) -> SolveState:
    """Where the gap stays wide, a continuation in the caps on the highest derivative.

    The local optimum may be one of several. That under a share of these caps satisfies the problem
    too, and limits that the relaxation leaves out bind less on laws that bend less sharply: from
    the law of the smallest share on each optimum is the start under wider caps.
    """
    if not _gap_is_far(state):
        return state
    # 1. The law under the smallest share. Whatever satisfies a share satisfies every larger one,
    #    so the first share that has no law ends the series; a straight law keeps all of them.
    start, shares = None, [1.0]
    while shares[0] > LEAST_SHARE:
        tighter = with_tighter_caps(state.problem, shares[0] * SHARE_STEP)
        if tighter is None:
            break
        tighter_cam = _relaxed_cam(replace(state, problem=tighter))
        if tighter_cam is None:
            break
        start, shares = tighter_cam, [shares[0] * SHARE_STEP, *shares]
    if start is None:
        return state  # the problem itself was searched already
    # 2. Its local optimum, and from there on those under wider caps.
    for share in shares:
        tighter = with_tighter_caps(state.problem, share)
        if tighter is None or not _gap_is_far(state):
            break
        trial = replace(state, problem=tighter, incumbent=None, relaxed=None, stages=())
        trial, _ = scp_search(trial, start.laws, start.size, f"tangents, {share:.2g} of the caps")
        if trial.incumbent is not None:
            start = trial.incumbent
            state, _ = offer_local_optimum(state, start.laws, start.size)
        for stage in trial.stages:
            state = state.with_stage(stage)
    return state


def _gap_is_far(state: SolveState) -> bool:
    """Whether further starts are worth their time."""
    wide = state.gap_between(state.incumbent, state.lower) > FAR_GAP
    return wide and not state.suffices and state.time_left > 0.0


def _relaxed_cam(state: SolveState) -> Candidate | None:
    """The cam of the relaxation on the present mesh; None where there is none."""
    model = formulate(state.problem, state.grids, 0.0, state.tightening)
    solution = solve(model.program, state.time_left)
    if solution.stopped not in USABLE:
        return None
    return recover_cam(state.problem, *model.recover(solution.x))


def improve_from(state: SolveState, start: Candidate) -> SolveState:
    """Look for a local optimum on the present mesh from a start.

    Where the size is held the domain is so thin that only a start inside of it leads to a cam: the
    incumbent, whose knots join the mesh. There IPOPT, which leaves it, ends outside.
    """
    thin, best = state.problem.holds_size, state.incumbent
    if thin and best is not None:
        start, state = best, _with_knots_of(state, best.laws)
    state, converged = scp_search(state, start.laws, start.size)
    if converged or state.suffices or state.time_left <= 0.0 or (thin and best is not None):
        return state
    from synthesis.optimise.heuristics.ipopt_search import (  # CasADi where it is needed
        solve_ipopt,
        solver_tolerances,
    )

    known = (cam for cam in (state.incumbent, start, state.relaxed) if cam is not None)
    start = next((cam for cam in known if _is_on(state.grids, cam.laws)), start)
    accuracies, growth = solver_tolerances(state.tolerance), GROWTH * state.tolerance
    for _ in range(EXCHANGES):
        started = state.stopwatch
        model = formulate(state.problem, state.grids, 0.0, state.tightening, Region())
        point = model.point(start.laws, start.size)
        solution = solve_ipopt(model, point, state.deadline, *accuracies, growth=growth)
        laws, size = model.recover(solution.x)
        state, violations = offer_local_optimum(state, laws, size)
        if violations[1] <= ALLOWED:
            state = replace(state, local_optimum=WarmStart(state.grids, tuple(laws), size))
        report = Stage(
            "nonlinear", "NLP", "IPOPT", len(solution.x), solution.rows, solution.iterations,
            state.stopwatch - started, solution.stopped.value,
        )  # fmt: skip
        state = state.with_stage(report)
        # once more with points where rows were violated between theirs
        refined = add_violated_points(state, violations)
        if refined is state or solution.stopped not in USABLE:
            break  # more rows make nothing feasible, and nothing easier
        state = refined
    return state


def _with_knots_of(state: SolveState, laws: Sequence[SplineLaw]) -> SolveState:
    """The state on a mesh that has the knots of laws besides its own, where these are apart."""
    every = zip(state.problem.free, state.grids, laws, strict=True)
    grids = tuple(
        grid if np.isin(law.space.breaks, grid.space.breaks).all()
        else grid_through(segment, merge_knots(grid.space.breaks, law.space.breaks))
        for segment, grid, law in every
    )  # fmt: skip
    return replace(state, grids=grids)


def _is_on(grids: Sequence[Grid], laws: Sequence[SplineLaw]) -> bool:
    """Whether laws are splines of a mesh: it has all of their knots."""
    return all(
        law.space.degree == grid.space.degree and np.isin(law.space.breaks, grid.space.breaks).all()
        for law, grid in zip(laws, grids, strict=True)
    )


def scp_search(
    state: SolveState, laws: Sequence[SplineLaw], size: Vector, stage: str = "tangents"
) -> tuple[SolveState, bool]:
    """Look for a local optimum on the present mesh by sequential convex programming.

    Args:
        state: the solve. laws, size: the start. stage: its name in the report.

    Returns:
        the state, and whether the iteration converged to a cam that satisfies all limits.
    """
    # What the tolerance is in the problem's unit: of a small cam a little part of its prime radius.
    known = state.smallest_value if isfinite(state.smallest_value) else state.lower
    tolerance = state.problem_tolerance(known) if isfinite(known) else state.tolerance
    gap = min(STOP_GAP * state.tolerance, MAX_STOP_GAP, max(STOP_GAP * tolerance, LEAST_STOP_GAP))
    first = ScpTarget(gap, TIGHTENING, sufficient=(1.0 - ROW_FACTOR * gap) * state.sufficient_value)
    # a size that is held leaves no room for tighter limits: more points must do
    tightened = TIGHTENING if state.problem.holds_size else RETRY_TIGHTENING * gap
    repeats, drawn_in = RETRIES * [ScpTarget(gap, tightened, anew=True)], state.tighten
    near = False
    for target in (first, *repeats):
        started = state.stopwatch
        # Nonconvex limits enter through their tangents, so rows of curved limits are left out.
        tightening = replace(state.tightening, every_row=drawn_in)
        model = formulate(state.problem, state.grids, 0.0, tightening, Region())
        result = solve_scp(model, laws, size, state.deadline, target)
        stopped = StopReason.SOLVED if result.converged else StopReason.INACCURATE
        cam = result.cam
        if cam is not None:
            enough = cam.value * (1.0 + gap)
            state, violations = offer_local_optimum(state, cam.laws, cam.size, enough)
            state = replace(state, local_optimum=WarmStart(state.grids, cam.laws, cam.size))
        report = Stage(
            stage, f"{result.programs} SOCPs", "Clarabel", model.program.matrix.shape[1],
            result.rows, result.iterations, state.stopwatch - started, stopped.value,
        )  # fmt: skip
        state = state.with_stage(report)
        if cam is None:
            return state, False
        best = state.incumbent
        if best is not None and best.value <= cam.value * (1.0 + ROW_FACTOR * gap):
            return state, result.converged
        # what rows cost between their points is all that another search could gain then
        near = best is not None and best.value <= cam.value * (1.0 + tolerance)
        if not result.converged or state.time_left <= 0.0:
            return state, False
        # Once more with tighter limits: the enlargement broke what it cannot repair, a least
        # contact force or a row of a counter roller; or the solver a row that needs no point.
        drawn_in += ROW_FACTOR * max(exact_excess(state, cam), 0.0)
        if violations[1] > ALLOWED:  # more points alone first: they may need far less of a margin
            state = add_violated_points(state, violations, between=target is first)
        else:  # rows between their points cost more size than they would with more of them
            state = add_violated_points(state, row_violations(state, cam), between=True)
        laws, size = cam.laws, cam.size
    return state, near


def add_violated_points(
    state: SolveState, violations: Violations, *, between: bool = False
) -> SolveState:
    """The state with collocation points where rows were violated between theirs.

    The same state where more points are of no use: nothing is violated, or curved limits are
    linearised, which the outer approximation refines by itself. ``between``: what is left between
    the new points, the size or the margin's own share of it makes up for.
    """
    points, excess = violations
    if excess <= ALLOWED or state.problem.has_curved_limits or state.time_left <= 0.0:
        return state
    both = zip(state.grids, points, strict=True)
    grids = tuple(grid.with_points(more) for grid, more in both)
    if between or state.problem.holds_size:  # the margin takes of the room that there is
        return replace(state, grids=grids, margin=state.margin + QUARTERED * excess)
    return replace(state, grids=grids, margin=1.1 * (state.margin + excess))


def offer_local_optimum(
    state: SolveState, laws: Sequence[SplineLaw], size: Vector, good_enough: float = -inf
) -> tuple[SolveState, Violations]:
    """Make cams of a local optimum and offer them as incumbents.

    The laws with the size that is best for them come first, then with the size at hand.

    Args:
        state: the solve. laws, size: the local optimum.
        good_enough: value of the incumbent at which the second cam is not tried.

    Returns:
        the state, and the violations of rows between their points in the last cam tried.
    """
    for keep_size in (False, True):
        found = cam = recover_cam(state.problem, laws, size, keep_size=keep_size)
        cam = enlarge_for_rows(cam) if keep_size and not state.problem.has_curved_limits else cam
        violations = row_violations(state, cam)
        if state.problem.holds_size and violations[1] > ALLOWED:
            violations = row_violations(state, found)  # it may not grow for rows: they need points
        if violations[1] > ALLOWED or breaks_exact_rows(state, cam):
            continue
        state = state.with_local_optimum(cam)
        if state.incumbent is not None and state.incumbent.value <= good_enough:
            break
    return state, violations


def smooth_start(state: SolveState) -> tuple[SolveState, Candidate | None]:
    """Another start: the law of least mean square jerk, enlarged until all limits hold.

    The relaxation's own law uses its freedom to the full and may be bent so sharply that only a
    very large cam can carry it. Where laws need not be of class C2, the mean square acceleration
    is minimised instead.

    Returns:
        the state, and the cam as it was before it was enlarged; None where there is no such law.
    """
    if not state.problem.free:
        return state, None
    roughest = min(segment.free.smoothness for segment in state.problem.free if segment.free)
    smooth = replace(state.problem, objective=RmsJerk() if roughest > 1 else RmsAcceleration())
    model = formulate(smooth, state.grids, 0.0, state.tightening)
    solution = solve(model.program, state.time_left)
    if solution.stopped not in USABLE:
        return state, None
    cam = recover_cam(state.problem, *model.recover(solution.x))
    if row_violations(state, cam)[1] <= ALLOWED:
        state = state.with_local_optimum(cam)
    return state, cam


def _from_warm_start(state: SolveState) -> SolveState:
    """The search from a neighbour's local optimum, on its mesh.

    A neighbour's mesh is used if it is at least as fine as the one that the bound asks for here.
    The cam found depends on the neighbour, in its last digits or, where there are several local
    optima, in more; all limits are certified on it as on any other.
    """
    near, before = state.warm_start, state
    if near is None or not _is_as_fine(near.grids, state.grids):
        return state
    state = replace(state, grids=near.grids)
    state, converged = scp_search(state, near.laws, near.size, "tangents, from a neighbour")
    if converged and state.incumbent is not before.incumbent:
        return replace(state, warm_started=True)
    return replace(state, grids=before.grids)


def _is_as_fine(grids: Sequence[Grid], wanted: Sequence[Grid]) -> bool:
    """Whether every law has the degree of the wanted mesh and at least as many knots."""
    return len(grids) == len(wanted) and all(
        grid.space.degree == other.space.degree and grid.space.size >= other.space.size
        for grid, other in zip(grids, wanted, strict=True)
    )
