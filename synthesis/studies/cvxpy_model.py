"""cvxpy_model(spec): the cone program of a question as a CVXPY problem, to be changed and solved.

It is the very program whose relaxation bounds the answer, on the knots that the search has come to:
the laws' coefficients and the follower's size together. A row can be added, the solver changed, and
multipliers read::

    model = cvxpy_model(spec)
    late = model.motion(0, 0.5)[0] <= 14.0        # of program/0, in mm, halfway
    changed = model.with_constraints(late)
    changed.solve(solver="CLARABEL")
    model.value(changed), model.constraints["pressure_angle_rise of program/0"].dual_value

Units: the size variables are in mm. Laws are coefficients of g, which runs from 0 to 1 along its
segment; ``motion`` has what they mean in the wire's units. A radius that is minimised is in mm,
``value`` has any objective in its unit. Rows are divided by their natural size, so that multipliers
are those of the solver: what the minimised expression changes by per unit of a row's right side.
Limits that are curved are the rows that linearise them at the last solution. Rows are drawn in by
1e-7 of their size, as those of the answer are.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib import import_module
from math import inf, isfinite
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from synthesis.design.design import Effort
from synthesis.errors import InputError
from synthesis.optimise.conic.program import ConicModel, formulate
from synthesis.optimise.driver import optimise
from synthesis.optimise.dual_bound.bound import in_problem_units
from synthesis.pipeline.assembly import Bounded, in_wire_units
from synthesis.pipeline.attempt import Attempt, prepare
from synthesis.pipeline.goal import Goal
from synthesis.spec.design_spec import SMALLEST, DesignSpec

INSTALL = "cvxpy_model needs CVXPY, which is not installed: pip install 'camwright[cvxpy]' (70 MB)."


@dataclass(frozen=True, eq=False)
class CvxpyModel:
    """A cone program in CVXPY.

    Attributes:
        problem: the ``cvxpy.Problem``.
        variables: by name: "law of program/0", the size variables as "offset_mm", what is
            minimised.
        constraints: by name, the limit and the segment that it is on, with ", 2" where a limit has
            a second side; their ``dual_value`` after solving.
        conic: the same program as it is solved here. question: of which, in both units.
    """

    problem: Any
    variables: Mapping[str, Any]
    constraints: Mapping[str, Any]
    conic: ConicModel
    question: Attempt

    def value(self, problem: Any = None) -> float:
        """What is minimised, in the objective's unit on the wire, after solving.

        ``problem``: one with further constraints; None: the model's own.
        """
        scale = self.conic.scales.size * self.question.question.units.length
        found = float((problem or self.problem).value)
        if not isfinite(found):  # infeasible, or unbounded
            return found
        sized = self.conic.problem.objective.norm(self.conic.problem.machine) is not None
        return on_wire(self.question, self.conic, found / scale if sized else found)

    def with_constraints(self, *more: Any) -> Any:
        """The ``cvxpy.Problem`` with further constraints on the same variables."""
        return type(self.problem)(self.problem.objective, [*self.problem.constraints, *more])

    def motion(self, segment: int, x: ArrayLike, order: int = 0) -> Any:
        """Displacement of a free law at fractions x of its segment, or a derivative by time.

        Args:
            segment: its place in the program. x: (n,) from 0 to 1.
            order: 0 for the displacement from the lowest position [mm, on an arm deg], k for the
                k-th derivative [mm/s^k or deg/s^k].

        Returns:
            an expression (n,) in the law's variable.

        Raises:
            KeyError: the segment's law is given.
        """
        placed = [each.index for each in self.conic.problem.free]
        if segment not in placed:
            raise KeyError(f"program/{segment} has no law that is free; those of {placed} are")
        position, machine = placed.index(segment), self.conic.problem.machine
        own, grid = self.conic.problem.free[position], self.conic.grids[position]
        basis = grid.space.basis(np.atleast_1d(np.asarray(x, dtype=float)), order)
        inner, fixed = self.conic.boundary_states[position].split(basis)
        unit = self.question.question.units.of_field(
            f"s_{machine.follower.travel.field_suffix(order)}"
        )
        factor = unit * own.lift / own.angle**order * machine.wire_factor(order)
        start = unit * own.s_start * machine.wire_factor(order) if order == 0 else 0.0
        return start + factor * (inner @ self.variables[law_name(segment)] + fixed)


def law_name(segment: int) -> str:
    """Name of a law's variable."""
    return f"law of program/{segment}"


def on_wire(attempt: Attempt, conic: ConicModel, value: float) -> float:
    """The objective of the program [its own units] in the wire's."""
    objective = conic.problem.objective
    bounded = [Bounded(objective, in_problem_units(conic, value), "")]
    (found,) = in_wire_units(attempt.question, attempt.solved_spec, bounded)
    return found.lower


def cvxpy_model(spec: DesignSpec) -> CvxpyModel:
    """State a question's cone program in CVXPY.

    Of an ordered list of objectives it is the program of the first; where no objective is named, of
    the base radius under the cap on rms jerk that the answer has. What is left free besides laws
    and size has the numbers of the answer.

    Raises:
        ImportError: CVXPY is not installed.
        InputError: what is minimised is a ratio, the peak pressure angle: not one program.
    """
    try:
        cp = import_module("cvxpy")
    except ImportError as error:
        raise ImportError(INSTALL) from error
    attempt, conic = relaxation(spec)
    return _stated(cp, attempt, conic)


def relaxation(spec: DesignSpec) -> tuple[Attempt, ConicModel]:
    """A question as it is solved, and the last cone program of its main objective."""
    if spec.main_objective().quasiconvex:
        raise InputError(
            "/objective", spec.main_objective().kind, "It is a ratio, and no single cone program.",
            "Limit the pressure angle, and make the base radius small.",
        )  # fmt: skip
    attempt = prepare(spec, Goal(inf), list[Effort]())
    for rank, problem in enumerate(attempt.problems(SMALLEST)):
        earlier = attempt.searches[-1].incumbent if rank else None
        attempt.searches.append(optimise(problem, attempt.tolerance(rank), earlier=earlier))
        if problem.objective == spec.main_objective():
            break
    last = attempt.searches[-1]
    if last.relaxation is not None:
        return attempt, last.relaxation[0]
    return attempt, formulate(last.problem, last.grids, 0.0, last.tightening, last.region)


def _stated(cp: Any, attempt: Attempt, conic: ConicModel) -> CvxpyModel:
    """The program's unknowns as variables, its rows as constraints with names."""
    program, unit = conic.program, conic.scales.size * attempt.question.units.length
    # 1. Variables in the order of the unknowns, and what each is of them.
    variables, unknowns = dict[str, Any](), list[Any]()
    for segment, columns in zip(conic.problem.free, conic.columns, strict=True):
        name = law_name(segment.index)
        variables[name] = cp.Variable(columns.stop - columns.start, name=name)
        unknowns.append(variables[name])
    for name in conic.problem.machine.follower.size_names:
        variables[f"{name}_mm"] = cp.Variable(name=f"{name}_mm")
        unknowns.append(variables[f"{name}_mm"] / unit)
    norm = conic.problem.objective.norm(conic.problem.machine)
    if conic.energy is not None:
        count = conic.energy_columns.stop - conic.energy_columns.start
        minimised = variables["derivative at Gauss points"] = cp.Variable(count, name="y")
        unknowns.append(minimised)
        objective = cp.sum_squares(minimised)
    else:
        name = "radius_mm" if norm is not None else "level"
        objective = variables[name] = cp.Variable(name=name)
        unknowns.append(objective / unit if norm is not None else objective)
    x = cp.hstack([cp.vec(each, order="C") if each.ndim else each for each in unknowns])
    # 2. Rows, named by what they say, in the order of the program.
    constraints, at = dict[str, Any](), 0
    for name, count, kind in _groups(conic):
        rows, rhs = program.matrix[at : at + count], program.rhs[at : at + count]
        at += count
        if count == 0:
            continue
        if kind == "=":
            row = rows @ x == rhs
        elif kind == "≤":
            row = rows @ x <= rhs
        else:
            slack = rhs - rows @ x
            row = cp.SOC(slack[0], slack[1:])
        constraints[_unused(name, constraints)] = row
    problem = cp.Problem(cp.Minimize(objective), list(constraints.values()))
    return CvxpyModel(problem, variables, constraints, conic, attempt)


def _groups(conic: ConicModel) -> Iterator[tuple[str, int, str]]:
    """Name, number of rows and kind of every group of rows, in the program's order."""
    program, free = conic.program, conic.problem.free
    fixed = sum(low == high for low, high in conic.problem.sizing.bounds)
    squares = 0 if conic.energy is None else conic.energy.rows
    still = 2 * len(conic.vibration_equalities)
    exact = sum(len(block.rhs) for block in conic.equality_blocks)
    yield "joints", program.equalities - fixed - squares - still - exact, "="
    yield "given sizes", fixed, "="
    yield "derivative", squares, "="
    yield "no residual vibration", still, "="
    for blocks, kind in ((conic.equality_blocks, "="), (conic.blocks, "≤")):
        for block in blocks:
            on = "" if block.segment is None else f" of program/{free[block.segment].index}"
            if not on and block.origin is not None:
                on = f" of program/{block.origin.segment.index}"
            yield f"{block.source or block.kind}{on}", len(block.rhs), kind
    for cone in conic.cone_blocks:
        name = cone.source or "size"
        if cone.bound_column is not None:
            name = "radius"
        elif cone.energy is not None:
            name = "mean square held"
        elif cone.vibration is not None:
            name = "residual vibration"
        yield name, 1 + len(cone.shift), "cone"


def _unused(name: str, known: Mapping[str, Any]) -> str:
    """The name, with a number where it is taken."""
    number, tried = 2, name
    while tried in known:
        tried, number = f"{name}, {number}", number + 1
    return tried
