"""Smooth nonlinear programs, stated in CasADi and solved by IPOPT with MUMPS."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import casadi
import numpy as np

from synthesis.numerics import clock
from synthesis.numerics.piecewise import Array
from synthesis.numerics.solvers.statuses import StopReason

# so that one formula with np.cos serves numbers and symbols: results keep CasADi's types and shapes
casadi.GlobalOptions.setNumpyMode(1)

STATUSES = {
    "Solve_Succeeded": StopReason.SOLVED,
    "Solved_To_Acceptable_Level": StopReason.INACCURATE,
    "Feasible_Point_Found": StopReason.INACCURATE,
    "Search_Direction_Becomes_Too_Small": StopReason.INACCURATE,
    "Infeasible_Problem_Detected": StopReason.INFEASIBLE,
    "Diverging_Iterates": StopReason.UNBOUNDED,
    "Maximum_CpuTime_Exceeded": StopReason.OUT_OF_TIME,
    "Maximum_WallTime_Exceeded": StopReason.OUT_OF_TIME,
    "Maximum_Iterations_Exceeded": StopReason.OUT_OF_ITERATIONS,
}
OPTIONS: dict[str, Any] = {
    "print_time": False,
    "no_nlp_grad": True,
    "calc_lam_p": False,
    "ipopt.sb": "yes",
    "ipopt.print_level": 0,
    "ipopt.linear_solver": "mumps",
    "ipopt.constr_viol_tol": 1e-9,
    "ipopt.dual_inf_tol": 1e-6,
    "ipopt.bound_relax_factor": 1e-9,
    "ipopt.acceptable_constr_viol_tol": 1e-6,
    "ipopt.max_iter": 200,
    # a step that needs more of it is given up: MUMPS takes seconds over such a matrix
    "ipopt.max_hessian_perturbation": 1e5,
}
COLD: dict[str, Any] = {"ipopt.mu_init": 1e-3}
WARM: dict[str, Any] = {
    "ipopt.warm_start_init_point": "yes",
    "ipopt.warm_start_bound_push": 1e-6,
    "ipopt.warm_start_bound_frac": 1e-6,
    "ipopt.warm_start_slack_bound_push": 1e-6,
    "ipopt.warm_start_slack_bound_frac": 1e-6,
    "ipopt.warm_start_mult_bound_push": 1e-6,
    "ipopt.mu_init": 1e-8,
}
ONE_AT_A_TIME = threading.Lock()  # MUMPS keeps global state


@dataclass(frozen=True, eq=False)
class SmoothProgram:
    """Minimise objective(x) with lower ≤ rows(x) ≤ upper and low ≤ x ≤ high.

    Attributes:
        x: the unknowns, (n, 1). objective: a scalar. rows: (m, 1) expressions of x.
        lower, upper: (m,), equal where the row is an equality. low, high: (n,).
    """

    x: Any
    objective: Any
    rows: Any
    lower: Array
    upper: Array
    low: Array
    high: Array


@dataclass(frozen=True, eq=False)
class StartingPoint:
    """Where to begin: a point, and multipliers of rows and bounds where they are known.

    There may be fewer than the program has rows: those at the end have none yet.
    """

    x: Array
    rows: Array | None = None
    bounds: Array | None = None


@dataclass(frozen=True, eq=False)
class SmoothSolution:
    """A point with its multipliers, and why the solver stopped there."""

    x: Array
    rows: Array
    bounds: Array
    stopped: StopReason
    word: str
    iterations: int


def solve(
    program: SmoothProgram,
    guess: StartingPoint,
    time_limit: float = math.inf,
    accuracy: float = 1e-9,
) -> SmoothSolution:
    """Solve from a guess, for ``time_limit`` seconds at most; with multipliers it is a warm start.

    ``accuracy``: scaled optimality error; rows are kept to 1e-9 whatever it is.

    Raises:
        Cancelled: nobody waits for it any more.
    """
    if np.any(program.lower > program.upper) or np.any(program.low > program.high):
        none = np.zeros(len(program.lower)), np.zeros(len(program.low))
        return SmoothSolution(guess.x, *none, StopReason.INFEASIBLE, "bounds cross", 0)
    options = OPTIONS | (COLD if guess.rows is None else WARM)
    options |= {"ipopt.tol": accuracy, "ipopt.compl_inf_tol": max(10.0 * accuracy, 1e-8)}
    if math.isfinite(time_limit):
        options["ipopt.max_wall_time"] = max(time_limit, 1e-3)
    start: dict[str, Any] = {"x0": guess.x, "lbx": program.low, "ubx": program.high}
    if guess.rows is not None:
        rows = np.pad(guess.rows, (0, len(program.lower) - len(guess.rows)))
        start |= {"lam_g0": rows, "lam_x0": guess.bounds}
    must_stop = clock.stop_callback()
    if must_stop is not None:
        options["iteration_callback"] = _Look(len(guess.x), len(program.lower), must_stop)
    stated = {"x": program.x, "f": program.objective, "g": program.rows}
    solver: Any = casadi.nlpsol("nonlinear", "ipopt", stated, options)
    with ONE_AT_A_TIME:
        found = solver(**start, lbg=program.lower, ubg=program.upper)
    clock.now()
    stats = solver.stats()
    word = str(stats["return_status"])
    return SmoothSolution(
        _column(found["x"]), _column(found["lam_g"]), _column(found["lam_x"]), stop_reason(word),
        word, int(stats["iter_count"]),
    )  # fmt: skip


class _Look(casadi.Callback):
    """Asks between iterations whether to stop; IPOPT hands it the point, (n, 1) and (m, 1)."""

    def __init__(self, n: int, m: int, must_stop: Callable[[], bool]) -> None:
        casadi.Callback.__init__(self)
        self._must_stop, self._sizes = must_stop, {"f": 1, "x": n, "lam_x": n, "g": m, "lam_g": m}
        self.construct("look", {})

    def get_n_in(self) -> int:
        return int(casadi.nlpsol_n_out())

    def get_n_out(self) -> int:
        return 1

    def get_sparsity_in(self, position: int) -> Any:
        size = self._sizes.get(casadi.nlpsol_out(position), 0)
        return casadi.Sparsity.dense(size, 1)

    def eval(self, _point: Any) -> list[float]:
        return [float(self._must_stop())]


def stop_reason(word: str) -> StopReason:
    """IPOPT's word in the common vocabulary."""
    return STATUSES.get(word, StopReason.FAILED)


def _column(values: Any) -> Array:
    return np.asarray(values, dtype=float).ravel()
