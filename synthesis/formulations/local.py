"""The third rung as a stage of a search: local optima under limits that are not convex."""

from __future__ import annotations

import time

import numpy as np

from synthesis.formulations.candidate import Candidate, settle
from synthesis.formulations.convex import formulate
from synthesis.formulations.cuts import Region
from synthesis.formulations.missed import ALLOWED, misses
from synthesis.formulations.rows import Drawn
from synthesis.formulations.search import Search, Stage
from synthesis.objectives.rms_jerk import RmsJerk
from synthesis.solvers.clarabel import solve
from synthesis.solvers.statuses import Stopped

USABLE = (Stopped.SOLVED, Stopped.INACCURATE)


def nonlinear(state: Search) -> None:
    """From the relaxation's cam grown out of the limits, or from a gentler one."""
    started = time.perf_counter()
    gentle(state)
    start = state.best or state.relaxed or state.last
    if start is not None:
        improve_from(state, start, started)


def improve_from(state: Search, start: Candidate, started: float) -> None:
    """IPOPT on the present knots; ``started``: when the stage began, ``time.perf_counter()``."""
    from synthesis.formulations.nonlinear import improve  # CasADi only where it is needed

    drawn = Drawn(state.tighten, state.margin)
    plan = formulate(state.problem, state.grids, 0.0, drawn, Region())  # smooth forms say more
    # rows drawn in by a little of what the caller allows save rounds: peaks may lie between them
    spare = float(np.clip(0.04 * state.tolerance, 1e-7, 1e-3))
    solution = improve(plan, plan.point(start.laws, start.size), state.deadline, spare)
    laws, size = plan.recover(solution.x)
    for keep_hint in (True, False):
        found = settle(state.problem, laws, size, keep_hint=keep_hint)
        if misses(state, found)[1] <= ALLOWED:
            state.accept(found)
    state.stages.append(
        Stage(
            "nonlinear", "NLP", "IPOPT", len(solution.x), solution.rows, solution.iterations,
            time.perf_counter() - started, solution.stopped.value,
        )
    )  # fmt: skip


def gentle(state: Search) -> None:
    """Another cam to start from: the law of least mean square jerk, grown until limits hold.

    The relaxation's own law uses its freedom to the full, and may be bent so sharply that only
    a huge cam could carry it.
    """
    if not state.problem.free:
        return
    quiet = state.problem.with_objective(RmsJerk())
    plan = formulate(quiet, state.grids, 0.0, Drawn(state.tighten, state.margin))
    solution = solve(plan.program, state.left())
    if solution.stopped in USABLE:
        laws, size = plan.recover(solution.x)
        found = settle(state.problem, laws, size)
        if misses(state, found)[1] <= ALLOWED:
            state.accept(found)
