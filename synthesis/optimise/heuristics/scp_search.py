"""Sequential convex programming as a heuristic of the driver: from a start to an incumbent."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from math import inf

from synthesis.numerics.piecewise import Array
from synthesis.numerics.solvers.statuses import StopReason
from synthesis.optimise.conic.program import formulate
from synthesis.optimise.conic.tangent_cuts import Region
from synthesis.optimise.heuristics.scp import ScpResult, ScpTarget, solve_scp
from synthesis.optimise.problem.grid import SplineLaw
from synthesis.optimise.recovery.candidate import enlarge_for_rows, recover_cam
from synthesis.optimise.refinement.row_violations import ALLOWED, row_violations
from synthesis.optimise.state.solve_state import SolveState, Stage
from synthesis.optimise.state.warm_start import WarmStart

Vector = tuple[float, ...]
Violations = tuple[list[Array], float]

STOP_GAP = 0.08
"""Share of the tolerance that the linearised limits may leave to the final enlargement."""
MAX_STOP_GAP = 4e-4
"""The same as a relative value, whatever the tolerance."""
ROW_FACTOR = 2.0
"""Factor on the stop gap: what rows written at points may cost besides, in between."""
TIGHTENING = 1e-6
"""Relative tightening of limits at the points where they are linearised."""
RETRIES = 2
"""Repeats with tighter limits, where the enlargement does not repair every violation."""
RETRY_TIGHTENING = 0.5
"""Share of the stop gap by which these repeats tighten."""


def scp_search(
    state: SolveState, laws: Sequence[SplineLaw], size: Vector, stage: str = "tangents"
) -> tuple[SolveState, bool]:
    """Look for a local optimum on the present mesh by sequential convex programming.

    Args:
        state: the solve. laws, size: the start. stage: its name in the report.

    Returns:
        the state, and whether the iteration converged to a cam that satisfies all limits.
    """
    if state.problem.objective.norm(state.problem.machine) is None:
        return state, False  # the cost of the final enlargement is known for sizes only
    gap = min(STOP_GAP * state.tolerance, MAX_STOP_GAP)
    repeats = RETRIES * [ScpTarget(gap, RETRY_TIGHTENING * gap, anew=True)]
    first = ScpTarget(gap, TIGHTENING, sufficient=(1.0 - ROW_FACTOR * gap) * state.sufficient_value)
    for target in (first, *repeats):
        state, result = _solve(state, laws, size, target, stage)
        cam = result.cam
        if cam is None:
            return state, False
        state, violations = offer_local_optimum(state, cam.laws, cam.size, cam.value * (1.0 + gap))
        state = replace(state, local_optimum=WarmStart(state.grids, cam.laws, cam.size))
        best = state.incumbent
        if best is not None and best.value <= cam.value * (1.0 + ROW_FACTOR * gap):
            return state, result.settled
        if not result.settled or state.time_left <= 0.0:
            return state, False
        # The enlargement broke what it cannot repair, a least contact force or a row of a counter
        # roller: once more with tighter limits, and with points where rows were violated.
        state = add_violated_points(state, violations)
        laws, size = cam.laws, cam.size
    return state, False


def _solve(
    state: SolveState, laws: Sequence[SplineLaw], size: Vector, target: ScpTarget, stage: str
) -> tuple[SolveState, ScpResult]:
    """One run of sequential convex programming, with its stage in the report."""
    started = time.perf_counter()
    # Nonconvex limits enter through their linearisations, so the rows of curved limits are left out
    model = formulate(state.problem, state.grids, 0.0, state.tightening, Region())
    result = solve_scp(model, laws, size, state.deadline, target)
    stopped = StopReason.SOLVED if result.settled else StopReason.INACCURATE
    report = Stage(
        stage, f"{result.rounds} SOCPs", "Clarabel", model.program.matrix.shape[1], result.rows,
        result.iterations, time.perf_counter() - started, stopped.value,
    )  # fmt: skip
    return state.with_stage(report), result


def add_violated_points(state: SolveState, violations: Violations) -> SolveState:
    """The state with collocation points where rows were violated between theirs.

    The same state where more points are of no use: nothing is violated, or curved limits are
    linearised, which the outer approximation refines by itself.
    """
    points, excess = violations
    if excess <= ALLOWED or state.problem.has_curved_limits or state.time_left <= 0.0:
        return state
    both = zip(state.grids, points, strict=True)
    grids = tuple(grid.with_points(more) for grid, more in both)
    return replace(state, grids=grids, margin=1.1 * (state.margin + excess))


def offer_local_optimum(
    state: SolveState, laws: Sequence[SplineLaw], size: Vector, good_enough: float = -inf
) -> tuple[SolveState, Violations]:
    """Make cams of a local optimum and offer them as incumbents.

    The laws with the size that is best for them come first, then with the size that was found.

    Args:
        state: the solve. laws, size: the local optimum.
        good_enough: value of the incumbent at which the second cam is not tried.

    Returns:
        the state, and the violations of rows between their points in the last cam tried.
    """
    for keep_hint in (False, True):
        cam = recover_cam(state.problem, laws, size, keep_hint=keep_hint)
        cam = enlarge_for_rows(cam) if keep_hint and not state.problem.has_curved_limits else cam
        violations = row_violations(state, cam)
        if violations[1] > ALLOWED:
            continue
        state = state.with_local_optimum(cam)
        if state.incumbent is not None and state.incumbent.value <= good_enough:
            break
    return state, violations
