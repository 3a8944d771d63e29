"""Cone programs, solved by Clarabel called directly."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import clarabel
import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from synthesis.numerics import clock
from synthesis.numerics.piecewise import Array
from synthesis.numerics.solvers.statuses import USABLE, StopReason

STATUSES = {
    "Solved": StopReason.SOLVED,
    "AlmostSolved": StopReason.INACCURATE,
    "PrimalInfeasible": StopReason.INFEASIBLE,
    "AlmostPrimalInfeasible": StopReason.INFEASIBLE,
    "DualInfeasible": StopReason.UNBOUNDED,
    "AlmostDualInfeasible": StopReason.UNBOUNDED,
    "MaxTime": StopReason.OUT_OF_TIME,
    "MaxIterations": StopReason.OUT_OF_ITERATIONS,
    "InsufficientProgress": StopReason.INACCURATE,
}
MOST_ITERATIONS = 100  # of the solver: programs that it solves take 10 to 60
ACCURACY, ROUGH = 1e-10, 1e-6  # relative: of a program, and of many whose multipliers alone count
WORK = 4e5  # iterations times entries of the matrix: of a program of all laws, 20 to 40 ms
DAMPED, REPEATED = 1e-10, 4  # share of the largest diagonal; steps
REGULAR, LESS_REGULAR = 1e-8, 1e-12
"""What is added to the diagonal of the solver's matrix, and corrected by iterative refinement: its
own, and what is tried where that fails. On fine knots a small pivot may be no larger than the
first; then the steps are wrong and iterations drift away from the optimum that they were near."""


@dataclass(frozen=True, eq=False)
class ConeProgram:
    """Minimise ½ xᵀPx + qᵀx with b − A x in a product of cones, in this order of rows.

    Attributes:
        quadratic: P, upper triangle, (n, n). linear: q, (n,).
        matrix: A, (m, n). rhs: b, (m,).
        equalities: number of rows with b − Ax = 0.
        inequalities: number of rows with b − Ax ≥ 0.
        cones: sizes of the second-order cones that follow.
    """

    quadratic: sparse.csc_matrix
    linear: Array
    matrix: sparse.csc_matrix
    rhs: Array
    equalities: int
    inequalities: int
    cones: tuple[int, ...]

    def value(self, x: Array) -> float:
        """The objective at a point."""
        half = self.quadratic @ x - 0.5 * self.quadratic.diagonal() * x  # of both triangles
        return float(x @ half + self.linear @ x)


@dataclass(frozen=True, eq=False)
class ConeSolution:
    """A point, its multipliers (one per row of A), and why the solver stopped there."""

    x: Array
    multipliers: Array
    stopped: StopReason
    iterations: int


def project_on_equalities(program: ConeProgram, x: Array) -> Array:
    """The nearest point that keeps the equalities to rounding instead of to the tolerance.

    Joints of motion laws are among them, and a joint must not show in the finished cam. Equalities
    may depend on each other, so that the normal equations are singular; a little added to their
    diagonal, and the step done again on what is left, comes to the same point.
    """
    if program.equalities == 0 or not np.all(np.isfinite(x)):
        return x
    # An equality joins neighbouring coefficients alone: the normal equations are as sparse.
    rows, rhs = program.matrix[: program.equalities], program.rhs[: program.equalities]
    normal = rows @ rows.T
    # rows of zeros are kept by every point
    damped = DAMPED * (float(normal.diagonal().max()) or 1.0)
    normal.setdiag(normal.diagonal() + damped)
    factor = splu(normal.tocsc(), "MMD_AT_PLUS_A", diag_pivot_thresh=0.0)
    for _ in range(REPEATED):
        x = x + rows.T @ factor.solve(rhs - rows @ x)
    return x


def solve(
    program: ConeProgram, time_limit: float = math.inf, *, project: bool = True
) -> ConeSolution:
    """Solve to 1e-10 relative where rounding allows, for ``time_limit`` seconds at most.

    ``project``: whether equalities are kept to rounding. Without time nothing is solved: a small
    program would be through before the solver looks at the clock.

    Raises:
        Cancelled: nobody waits for it any more.
    """
    if time_limit <= 0.0:
        return _out_of_time(program)
    until = clock.now() + time_limit
    found = _solve_once(program, time_limit, REGULAR)
    if found.iterations >= MOST_ITERATIONS and clock.now() < until:
        found = _solve_once(program, until - clock.now(), LESS_REGULAR)
    if not project:
        return found
    return replace(found, x=project_on_equalities(program, found.x))


def minimise_each(
    program: ConeProgram,
    objectives: Sequence[Array],
    time_limit: float = math.inf,
    last_program: float = math.inf,
) -> list[ConeSolution]:
    """Minimise each linear objective (n,) in turn over a program's rows.

    Ends early, with the answer that says so as the last, where a solve does not succeed. After
    ``time_limit`` seconds no further objective is begun, nor after the work of so many programs
    that ``clock.programs_solved()`` comes to ``last_program``.

    Raises:
        Cancelled: nobody waits for it any more.
    """
    solver = _solver(program, time_limit, REGULAR, ROUGH)
    until, work = clock.now() + time_limit, 0
    most = WORK * (last_program - clock.programs_solved())
    found = list[ConeSolution]()
    for objective in objectives:
        if clock.now() >= until or work >= most:
            found.append(_out_of_time(program))
            break
        solver.update(q=objective)
        found.append(_run(solver))
        work += found[-1].iterations * program.matrix.nnz
        if found[-1].stopped not in USABLE:
            break
    clock.count_program(math.ceil(work / WORK))
    return found


def _out_of_time(program: ConeProgram) -> ConeSolution:
    """The answer where a program is not begun."""
    rows, unknowns = program.matrix.shape
    return ConeSolution(np.zeros(unknowns), np.zeros(rows), StopReason.OUT_OF_TIME, 0)


def _solve_once(program: ConeProgram, time_limit: float, regular: float) -> ConeSolution:
    """The same, with so much regularisation."""
    found = _run(_solver(program, time_limit, regular))
    clock.count_program()
    clock.now()
    return found


def _solver(
    program: ConeProgram, time_limit: float, regular: float, accuracy: float = ACCURACY
) -> clarabel.DefaultSolver:
    """A program as the solver's own."""
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.presolve_enable = False
    settings.max_threads = 1
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = accuracy
    settings.max_iter = MOST_ITERATIONS
    settings.static_regularization_constant = regular
    if math.isfinite(time_limit):
        settings.time_limit = max(time_limit, 1e-3)
    kinds = [
        clarabel.ZeroConeT(program.equalities),
        clarabel.NonnegativeConeT(program.inequalities),
        *(clarabel.SecondOrderConeT(size) for size in program.cones),
    ]
    solver = clarabel.DefaultSolver(
        program.quadratic, program.linear, program.matrix, program.rhs, kinds, settings
    )
    must_stop = clock.stop_callback()
    if must_stop is not None:
        solver.set_termination_callback(lambda _: must_stop())
    return solver


def _run(solver: clarabel.DefaultSolver) -> ConeSolution:
    found = solver.solve()
    return ConeSolution(
        np.asarray(found.x),
        np.asarray(found.z),
        STATUSES.get(str(found.status), StopReason.FAILED),
        found.iterations,
    )
