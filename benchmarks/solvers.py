"""One convex program, several solvers: called directly, by CVXPY, by IPOPT, by SciPy's SLSQP.

The program is the first one of the main job: both laws and the size together. Every solver gets the
same matrices and is asked for several accuracies; what it returns is judged outside of it.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import casadi
import clarabel
import numpy as np
from scipy import sparse
from scipy.optimize import minimize

from benchmarks.axis import Axis, relative, seconds
from benchmarks.diagram import Diagram, Point, Series
from benchmarks.effort import FULL, Effort
from benchmarks.main_job import CONVEX
from benchmarks.section import Section, Table
from benchmarks.timing import Call, Timing, in_turns
from synthesis.numerics.piecewise import Array
from synthesis.optimise.conic.program import ConicModel, formulate
from synthesis.optimise.problem.grid import uniform_grid
from synthesis.optimise.problem.problem import formulate_problem
from synthesis.spec.design_spec import DesignSpec
from tests.optimise.conic.reference import optimum

INTERVALS = 42  # of each law
ACCURACIES = (1e-8, 1e-6, 1e-4, 1e-2)
NOISE = 1e-9  # what is nearer to the reference than that counts as equal to it
DIRECT, COLD, AGAIN = "Clarabel, called directly", "CVXPY, cold", "CVXPY, solved again"
IPOPT, SLSQP = "IPOPT", "SciPy SLSQP"
TEXT = """The cone program of the main job on {intervals} intervals a law, {unknowns} unknowns and
{rows} rows: the same matrices for every solver, four accuracies asked of each. *Error* is the
larger of two: how far the prime radius is from the optimum (relative), and how far the worst row is
broken (rows are of order 1). The optimum comes from a second statement of the problem that shares
no row with this one. CVXPY cold states the problem anew; solved again it is stated once, its
right-hand side being a parameter. IPOPT and SLSQP get exact derivatives, sparse ones for IPOPT, and
start from the 3-4-5 law."""


@dataclass(frozen=True, eq=False)
class Scene:
    """The program, and the optimum to judge by [of the program's unit]."""

    plan: ConicModel
    optimum: float

    @property
    def split(self) -> tuple[slice, slice]:
        """Rows that are equalities, and inequalities; the cone's come after them."""
        first = self.plan.program.equalities
        return slice(0, first), slice(first, first + self.plan.program.inequalities)

    @property
    def size(self) -> slice:
        """The unknowns whose norm is the prime radius."""
        return slice(self.plan.size.start, self.plan.size.stop)

    def error(self, x: Array) -> float:
        """Of the objective or of the worst row, whichever is larger."""
        program, (equal, below) = self.plan.program, self.split
        left = program.matrix @ x - program.rhs
        broken = max(np.max(np.abs(left[equal]), initial=0.0), np.max(left[below]), 0.0)
        return max(float(broken), abs(float(np.linalg.norm(x[self.size])) / self.optimum - 1.0))

    def start(self) -> Array:
        """The 3-4-5 law's coefficients and a prime radius that is generous."""
        plan = self.plan
        x = np.zeros(plan.program.matrix.shape[1])
        each = zip(plan.grids, plan.boundary_states, plan.columns, strict=True)
        for grid, known, columns in each:
            at = grid.space.greville
            law = 10.0 * at**3 - 15.0 * at**4 + 6.0 * at**5
            fit = np.linalg.solve(grid.space.basis(at), law)
            x[columns] = fit[len(known.first) : grid.space.size - len(known.last)]
        x[plan.size] = np.array([0.3, 2.5]) * 30.0 / plan.scales.size
        return x


def run(effort: Effort = FULL) -> Section:
    """Time and error of every solver at every accuracy."""
    scene = posed(12 if effort.trial else INTERVALS)
    solvers: dict[str, Callable[[float], Array]] = {
        DIRECT: partial(by_clarabel, scene),
        COLD: partial(by_cvxpy, scene),
        AGAIN: Restated(scene),
        IPOPT: partial(by_ipopt, scene),
        SLSQP: partial(by_slsqp, scene),
    }
    cases = {
        (name, question): partial(solver, question)
        for name, solver in solvers.items()
        for question in effort.some(ACCURACIES)
    }
    errors = {case: scene.error(call()) for case, call in cases.items()}
    calls: dict[str, Call] = {
        f"{name} {question}": call for (name, question), call in cases.items()
    }
    measured = in_turns(calls, effort.repeats(7), 0)
    times = dict(zip(cases, measured.values(), strict=True))
    program = scene.plan.program
    rows, unknowns = program.matrix.shape
    text = TEXT.format(intervals=INTERVALS, unknowns=unknowns, rows=rows)
    parts = [_diagram(times, errors), _table(times, errors)]
    return Section("One cone program, several solvers", text, parts, list(_front(times, errors)))


Case = tuple[str, float]


def _table(times: Mapping[Case, Timing], errors: Mapping[Case, float]) -> Table:
    base = times[DIRECT, ACCURACIES[0]]
    rows = [
        (name, f"{question:.0e}", str(time), time.over(base), f"{errors[name, question]:.1e}")
        for (name, question), time in times.items()
    ]
    note = "The ratio is to the first row."
    return Table(("solver", ">accuracy asked", ">time", ">ratio", ">error"), rows, note)


def _diagram(times: Mapping[Case, Timing], errors: Mapping[Case, float]) -> Diagram:
    names = dict.fromkeys(name for name, _ in times)
    series = [
        Series(
            name,
            [
                Point(time.median, errors[case], time.low, time.high)
                for case, time in times.items()
                if case[0] == name
            ],
        )
        for name in names
    ]
    reported = "Error against time of five ways to solve one program, each at several accuracies."
    return Diagram(
        "solvers",
        "One cone program: error against time",
        reported,
        Axis("time", seconds),
        Axis("error: objective or worst row", relative, least=NOISE),
        series,
    )


def _front(
    times: Mapping[Case, Timing], errors: Mapping[Case, float]
) -> list[tuple[str, str, str]]:
    base = times[DIRECT, ACCURACIES[0]]
    rows = [("its first cone program, by Clarabel as Camwright calls it", DIRECT)]
    rows += [(f"the same by {name}, against that", name) for name in (COLD, AGAIN, IPOPT, SLSQP)]
    found = []
    for reported, name in rows:
        case = (name, ACCURACIES[0])
        time = str(base) if name == DIRECT else f"{times[case].over(base)} times"
        found.append((reported, time, f"{errors[case]:.0e}"))
    return found


def posed(intervals: int) -> Scene:
    """The program on equal intervals, and its optimum by the second statement."""
    spec = DesignSpec.model_validate(CONVEX)
    problem = formulate_problem(spec, spec.objectives()[0])
    grids = [uniform_grid(segment, intervals) for segment in problem.free]
    plan = formulate(problem, grids)
    best = optimum(problem, grids).value
    assert best is not None
    return Scene(plan, best / plan.scales.size)


def by_clarabel(scene: Scene, accuracy: float) -> Array:
    """As the product calls it."""
    program = scene.plan.program
    settings = clarabel.DefaultSettings()
    settings.verbose = settings.presolve_enable = False
    settings.max_threads = 1
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = accuracy
    kinds = [
        clarabel.ZeroConeT(program.equalities),
        clarabel.NonnegativeConeT(program.inequalities),
        *(clarabel.SecondOrderConeT(size) for size in program.cones),
    ]
    solver = clarabel.DefaultSolver(
        program.quadratic, program.linear, program.matrix, program.rhs, kinds, settings
    )
    return np.asarray(solver.solve().x)


def by_cvxpy(scene: Scene, accuracy: float) -> Array:
    """Stated anew."""
    return Restated(scene)(accuracy)


class Restated:
    """Stated once, solved as often as it is called; the right-hand side is a parameter."""

    def __init__(self, scene: Scene) -> None:
        import cvxpy  # takes more than a second

        cp: Any = cvxpy
        program, (equal, below) = scene.plan.program, scene.split
        self.x = cp.Variable(program.matrix.shape[1])
        rhs = cp.Parameter(below.stop)
        rhs.value = program.rhs[: below.stop]
        rows = program.matrix[: below.stop] @ self.x
        said = [rows[below] <= rhs[below]]
        if equal.stop:
            said.append(rows[equal] == rhs[equal])
        self.problem = cp.Problem(cp.Minimize(cp.norm(self.x[scene.size])), said)

    def __call__(self, accuracy: float) -> Array:
        question = dict.fromkeys(("tol_gap_abs", "tol_gap_rel", "tol_feas"), accuracy)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of reduced accuracy: the error is measured
            self.problem.solve(solver="CLARABEL", **question)
        return np.asarray(self.x.value)


def by_ipopt(scene: Scene, accuracy: float) -> Array:
    """Built and solved, with MUMPS."""
    program, (equal, below) = scene.plan.program, scene.split
    packed = sparse.csc_matrix(program.matrix[: below.stop])
    packed.sort_indices()
    pattern = casadi.Sparsity(*packed.shape, packed.indptr.tolist(), packed.indices.tolist())
    x = casadi.MX.sym("x", packed.shape[1])
    stated = {
        "x": x,
        "f": casadi.norm_2(x[scene.size]),
        "g": casadi.mtimes(casadi.DM(pattern, packed.data.tolist()), x),
    }
    reported = {
        "ipopt.tol": accuracy, "ipopt.constr_viol_tol": accuracy, "ipopt.compl_inf_tol": accuracy,
        "ipopt.bound_relax_factor": 0.1 * accuracy, "ipopt.print_level": 0, "ipopt.sb": "yes",
        "ipopt.linear_solver": "mumps", "print_time": False,
    }  # fmt: skip
    lower, upper = np.full(below.stop, -np.inf), program.rhs[: below.stop]
    lower[equal] = upper[equal]
    solver: Any = casadi.nlpsol("program", "ipopt", stated, reported)
    found = solver(x0=scene.start(), lbg=lower, ubg=upper)
    return np.asarray(found["x"]).ravel()


def by_slsqp(scene: Scene, accuracy: float) -> Array:
    """At most 300 iterations."""
    program, (equal, below) = scene.plan.program, scene.split
    matrix, rhs, size = program.matrix.toarray(), program.rhs, scene.size

    def radius(x: Array) -> tuple[float, Array]:
        gradient = np.zeros_like(x)
        value = float(np.linalg.norm(x[size]))
        gradient[size] = x[size] / value
        return value, gradient

    kinds = (("ineq", below), ("eq", equal))
    said = [
        {
            "type": kind,
            "fun": lambda x, r=r: rhs[r] - matrix[r] @ x,
            "jac": lambda _, r=r: -matrix[r],
        }
        for kind, r in kinds
        if r.stop > r.start
    ]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = minimize(
            radius, scene.start(), jac=True, method="SLSQP", constraints=said,
            options={"maxiter": 300, "ftol": accuracy},
        )  # fmt: skip
    return np.asarray(found.x)
