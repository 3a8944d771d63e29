"""Linear programs of one matrix and many objectives, by HiGHS's simplex method called directly.

A basis that was best for one objective is a few steps from the best for the next: that is several
times cheaper than any solve from the start.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf, isfinite

import highspy
import numpy as np
from scipy import sparse

from synthesis.numerics import clock
from synthesis.numerics.piecewise import Array
from synthesis.numerics.solvers.statuses import StopReason

STATUSES = {
    highspy.HighsModelStatus.kOptimal: StopReason.SOLVED,
    highspy.HighsModelStatus.kInfeasible: StopReason.INFEASIBLE,
    highspy.HighsModelStatus.kUnbounded: StopReason.UNBOUNDED,
    highspy.HighsModelStatus.kUnboundedOrInfeasible: StopReason.UNBOUNDED,
    highspy.HighsModelStatus.kTimeLimit: StopReason.OUT_OF_TIME,
    highspy.HighsModelStatus.kIterationLimit: StopReason.OUT_OF_ITERATIONS,
}
PRIMAL = 4  # simplex: another objective leaves the last point feasible
MOST_STEPS = 5000  # simplex iterations
ACCURACY = 1e-7  # of rows and of multipliers


@dataclass(frozen=True, eq=False)
class LinearRows:
    """A x = b in the first rows, A x ≤ b in the others, low ≤ x ≤ high.

    Attributes:
        matrix: A, (m, n). rhs: b, (m,). equalities: how many of the first kind.
        low, high: (n,), may be infinite.
    """

    matrix: sparse.csc_matrix
    rhs: Array
    equalities: int
    low: Array
    high: Array


@dataclass(frozen=True, eq=False)
class LinearMinimum:
    """The least value of one objective: its multipliers (m,), ≥ 0 for inequalities, and why."""

    x: Array
    multipliers: Array
    stopped: StopReason


def minimise_each(
    rows: LinearRows,
    objectives: Array | Sequence[Array],
    time_limit: float = inf,
    *,
    accuracy: float = ACCURACY,
    enough: Array | None = None,
) -> list[LinearMinimum]:
    """Minimise each objective (n,) in turn over the same rows, which hold to ``accuracy``.

    Ends early, with the answer that says so as the last, where a solve does not succeed. After
    ``time_limit`` seconds no further objective is begun.

    Args:
        enough: (q,) values. An objective that is as small at the minimum of an earlier one needs
            none of its own: a point is all that there is in its place, without multipliers.

    Raises:
        Cancelled: nobody waits for it any more.
    """
    solver, deadline = _model(rows, accuracy), clock.now() + time_limit
    columns = np.arange(rows.matrix.shape[1], dtype=np.int32)
    found, smallest = list[LinearMinimum](), np.full(len(objectives), inf)
    for number, objective in enumerate(objectives):
        if enough is not None and found and smallest[number] <= enough[number]:
            known = replace(found[-1], multipliers=0.0 * rows.rhs, stopped=StopReason.NOT_NEEDED)
            found.append(known)
            continue
        left = deadline - clock.now()
        if isfinite(left):
            solver.setOptionValue("time_limit", solver.getRunTime() + max(left, 1e-3))
        solver.changeColsCost(len(columns), columns, objective)
        solver.run()
        solution = solver.getSolution()
        stopped = STATUSES.get(solver.getModelStatus(), StopReason.FAILED)
        point = np.array(solution.col_value)
        found.append(LinearMinimum(point, -np.array(solution.row_dual), stopped))
        if stopped is not StopReason.SOLVED:
            break
        solver.setOptionValue("simplex_strategy", PRIMAL)
        if enough is not None:
            smallest = np.minimum(smallest, np.asarray(objectives) @ point)
    clock.count_program()
    return found


def _model(rows: LinearRows, accuracy: float) -> highspy.Highs:
    solver = highspy.Highs()  # type: ignore[no-untyped-call]
    options = (("output_flag", False), ("presolve", "off"), ("solver", "simplex"), ("threads", 1),
               ("simplex_iteration_limit", MOST_STEPS), ("primal_feasibility_tolerance", accuracy),
               ("dual_feasibility_tolerance", accuracy))  # fmt: skip
    for name, value in options:
        solver.setOptionValue(name, value)
    program = highspy.HighsLp()
    program.num_row_, program.num_col_ = rows.matrix.shape
    program.col_cost_ = np.zeros(program.num_col_)
    program.col_lower_, program.col_upper_ = rows.low, rows.high
    below = np.full(program.num_row_, -np.inf)
    below[: rows.equalities] = rows.rhs[: rows.equalities]
    program.row_lower_, program.row_upper_ = below, rows.rhs
    program.a_matrix_.format_ = highspy.MatrixFormat.kColwise
    program.a_matrix_.start_ = rows.matrix.indptr
    program.a_matrix_.index_ = rows.matrix.indices
    program.a_matrix_.value_ = rows.matrix.data
    solver.passModel(program)
    return solver
