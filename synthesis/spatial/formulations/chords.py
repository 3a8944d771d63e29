"""A lower bound over all laws, from rows that refuse none that keeps the limit: chords over a tube.

Weak duality, as for planar cams: the multipliers are used as numbers.
"""

from __future__ import annotations

import time

from synthesis.formulations.bounds.bound import Bound, bound
from synthesis.formulations.cone.control import controls
from synthesis.formulations.cone.convex import Plan, formulate
from synthesis.formulations.cone.cuts import Region
from synthesis.formulations.cone.rows import Drawn
from synthesis.formulations.rounds.search import Search, Stage
from synthesis.solvers.clarabel import ConeSolution, solve
from synthesis.solvers.statuses import USABLE
from synthesis.spatial.formulations.envelope import envelopes


def bounded(state: Search, size: float, number: int) -> Bound | None:
    """The bound over all laws whose cam is no larger than ``size`` [mm]; the search learns it.

    None where nothing steers the laws, so that no multipliers bound all of them.
    """
    began, problem = time.perf_counter(), state.problem
    bare = formulate(problem, state.grids, 0.0, Drawn(), Region())
    if not controls(bare):
        return None
    region = Region(problem.sizing.bounds, (), envelopes(bare, size))
    plan = formulate(problem, state.grids, 0.0, Drawn(state.tighten), region)
    solution = solve(plan.program, state.left())
    lower = bound(plan, solution) if solution.stopped in USABLE else None
    if lower is not None:
        state.raise_to(lower.value, lower.over)
    report(state, f"chords {number}", plan, solution, solution.iterations, began)
    return lower


def report(
    state: Search, name: str, plan: Plan, solution: ConeSolution, iterations: int, began: float
) -> None:
    """Tell what a stage has cost that began at a ``time.perf_counter()``."""
    rows, unknowns = plan.program.matrix.shape
    intervals = sum(len(grid.space.breaks) - 1 for grid in plan.grids)
    state.stages.append(
        Stage(name, f"LP, {intervals} spline intervals", "Clarabel", unknowns, rows, iterations,
              time.perf_counter() - began, solution.stopped.value)
    )  # fmt: skip
