"""The relaxation on one mesh: its bound, its cam, and the points that separate it from its rows.

A row that holds for every cam angle is written at points; a law may break it between them.
"""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np

from synthesis.numerics.double_double import round_mantissa
from synthesis.numerics.piecewise import Array
from synthesis.numerics.solvers.clarabel import ConeSolution
from synthesis.optimise.conic.program import ConicModel
from synthesis.optimise.dual_bound.bound import Bound
from synthesis.optimise.recovery.candidate import Candidate, recover_cam
from synthesis.optimise.refinement.row_violations import ALLOWED, row_violations
from synthesis.optimise.separation.outer_approximation import solve_on_mesh
from synthesis.optimise.state import SolveState, program_stage

MARGIN_BITS = 16  # of the margin for rows written at points: it is known no better
MOST_SEPARATIONS = 3  # of rows between points, on the same knots


def solve_and_separate(state: SolveState, number: int) -> tuple[SolveState, Candidate | None]:
    """The relaxation on the present knots, reported; its best cam, if it has one.

    A cam is as large as its laws need it, between points too: where these would break rows at the
    program's own size, points are added. Of the cams the best one that keeps its rows is returned;
    where none does, the last.

    The margin of other meshes says nothing of this one: it begins without. The first cam that
    breaks rows adds points alone, since between more of them rows need far less of a margin.
    """
    best, keeps, separated = None, False, False
    state = replace(state, margin=0.0)
    for separation in range(number, number + MOST_SEPARATIONS):
        started = time.perf_counter()
        state, model, solution, bound = solve_on_mesh(state, 0.0)
        offered, cam, violated = offer_cam(state, model, solution, bound)
        state = offered if separated else replace(offered, margin=0.0)
        seconds = time.perf_counter() - started
        state = state.with_stage(program_stage(f"convex {separation}", model, solution, seconds))
        if cam is None:
            break
        breaks = any(map(len, violated))
        if best is None or not keeps or (not breaks and cam.value < best.value):
            best, keeps = cam, not breaks
        separated = separated or breaks
        unfitted = recover_cam(model.problem, *model.recover(solution.x), keep_size=True)
        points, _ = row_violations(state, unfitted)
        if state.time_left <= 0.0 or not any(map(len, points)):
            break
        finer = zip(state.grids, points, strict=True)
        state = replace(state, grids=tuple(grid.with_points(x) for grid, x in finer))
    return state, best


def offer_cam(
    state: SolveState, model: ConicModel, solution: ConeSolution, bound: Bound | None
) -> tuple[SolveState, Candidate | None, list[Array]]:
    """Offer the cam and the bound of one relaxation.

    Returns:
        the state, the cam, and the points of every law at which it violates rows.
    """
    if bound is None:
        return state, None, [np.zeros(0)] * len(state.grids)
    # the outer approximation has recovered the cam already
    last = state.last if state.problem.has_curved_limits else None
    cam = last or recover_cam(model.problem, *model.recover(solution.x))
    violations, excess = row_violations(state, cam)
    if excess <= ALLOWED:
        state = state.with_relaxed(cam)
    elif rows_cannot_separate(state):
        violations = [np.zeros(0)] * len(violations)
    elif state.tangent:
        margin = float(round_mantissa(1.1 * (state.margin + excess), MARGIN_BITS))
        state = replace(state, margin=margin)
    return replace(state.with_bound(bound), relaxation=(model, solution, bound)), cam, violations


def rows_cannot_separate(state: SolveState) -> bool:
    """Whether rows of curved limits are exceeded at their own points: more are of no use."""
    cam = state.incumbent or state.relaxed
    return state.problem.has_curved_limits and not state.tangent and cam is None
