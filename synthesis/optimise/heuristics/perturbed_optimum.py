"""The best cam beside a finished one: on its own knots, from its own laws and size.

At an optimum x* of  min f(x) under rows g(x) ≤ b, multipliers z, data that depend on a number p
change the best value by  dV/dp = ∂f/∂p + z · (∂g/∂p − ∂b/∂p)  at x* (envelope theorem; Boyd and
Vandenberghe, Convex Optimization, 5.6.3; Fiacco, Sensitivity and Stability, 3.2). So what stating
the program with another number changes at x* is the change of what is best, to first order;
solving it again from x* is the change itself.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from functools import cached_property
from math import inf

import casadi
import numpy as np

from synthesis.numerics import clock
from synthesis.numerics.piecewise import Array
from synthesis.numerics.solvers import clarabel
from synthesis.numerics.solvers.clarabel import ConeSolution
from synthesis.numerics.solvers.ipopt import SmoothProgram
from synthesis.numerics.solvers.statuses import USABLE
from synthesis.optimise.conic.program import ConicModel
from synthesis.optimise.dual_bound.bound import in_problem_units
from synthesis.optimise.heuristics.ipopt_search import (
    NonlinearModel,
    NonlinearSolution,
    recover_problem,
    solve_ipopt,
    solve_with_exchange,
)
from synthesis.optimise.problem.problem import Problem
from synthesis.optimise.recovery.smooth_limits import ConstraintSamples, sample, violation

TIGHTENING = 1e-7  # relative, of smooth limits; between samples they may be exceeded by as much
ACCURACY = 1e-10  # relative, of the optimum: differences over steps of 1e-4 keep five digits
KEPT = 1e-6  # relative excess of rows up to which the optimum is said to satisfy them
VIOLATED = 1e-6  # excess of a smooth limit from which on a cone program does not know enough


class PerturbedOptimum(ABC):
    """The optimum of one program, and what becomes of it when the program changes a little.

    Attributes:
        noise: relative error of its values.
    """

    noise: float

    @property
    @abstractmethod
    def value(self) -> float:
        """The program's objective."""

    @abstractmethod
    def first_order_value(self, model: ConicModel) -> float | None:
        """The objective of another model to first order; None where that has another form."""

    def remains_optimal(self, model: ConicModel) -> bool:
        """Whether the optimum is known to keep all rows of another model, and its value there."""
        return False

    @abstractmethod
    def solve_near(self, model: ConicModel, deadline: float) -> PerturbedOptimum | None:
        """The optimum of another model, sought from here; None where there is none."""


@dataclass(frozen=True, eq=False)
class ConvexOptimum(PerturbedOptimum):
    """Of a cone program; limits that are not convex hold at it by themselves."""

    model: ConicModel
    solution: ConeSolution
    noise = 1e-9

    @staticmethod
    def solve(model: ConicModel, deadline: float = inf) -> ConvexOptimum | None:
        """The optimum, where cone programs say all that matters."""
        solution = clarabel.solve(model.program, deadline - clock.now())
        if solution.stopped not in USABLE:
            return None
        problem, size = recover_problem(model, solution.x)
        violated = violation(problem, sample(problem), size) > VIOLATED
        if violated or _is_below_least_radius(problem, size):
            return None
        return ConvexOptimum(model, solution)

    @property
    def value(self) -> float:
        return self.model.program.value(self.solution.x)

    def first_order_value(self, model: ConicModel) -> float | None:
        one, other = self.model.program, model.program
        if one.matrix.shape != other.matrix.shape or one.cones != other.cones:
            return None
        x, z = self.solution.x, self.solution.multipliers
        rows = (other.matrix - one.matrix) @ x - (other.rhs - one.rhs)
        return float(z @ rows) + other.value(x)

    def solve_near(self, model: ConicModel, deadline: float) -> ConvexOptimum | None:
        return ConvexOptimum.solve(model, deadline)


def _is_below_least_radius(problem: Problem, size: tuple[float, ...]) -> bool:
    """Whether a size stays below a least radius, the inner edge of a ring that no cone knows."""
    prime = problem.machine.follower.radius_norm().value(size)
    rings = [(prime, problem.searched_norm)]
    rings += [(cone.norm.value(size), cone.lower) for cone in problem.norm_bounds]
    return any(radius < least * (1.0 - VIOLATED) for radius, least in rings)


@dataclass(frozen=True, eq=False)
class NonlinearOptimum(PerturbedOptimum):
    """Of the nonlinear program with every limit in it: a local optimum."""

    model: ConicModel
    result: NonlinearSolution
    relaxed_count: int
    noise = 2e-7

    @staticmethod
    def solve(
        model: ConicModel, start: Array, relaxed_count: int, deadline: float = inf
    ) -> NonlinearOptimum | None:
        """The local optimum that IPOPT comes to from a point."""
        result = solve_ipopt(
            model, start, deadline, TIGHTENING, ACCURACY, relaxed_count=relaxed_count
        )
        return NonlinearOptimum(model, result, relaxed_count) if result.stopped in USABLE else None

    @property
    def value(self) -> float:
        return self.model.program.value(self.result.x)

    def first_order_value(self, model: ConicModel) -> float | None:
        there = self._stated(model)
        if len(there.lower) != len(self._here.lower):
            return None
        return self.value + self._lagrangian(there) - self._lagrangian(self._here)

    def remains_optimal(self, model: ConicModel) -> bool:
        program = self._stated(model)
        value, rows = self._at_optimum(program)
        here = in_problem_units(self.model, self.value)
        same = abs(in_problem_units(model, value) - here) <= ACCURACY * abs(here)
        kept = (rows >= program.lower - KEPT) & (rows <= program.upper + KEPT)
        return same and bool(np.all(kept))

    def solve_near(self, model: ConicModel, deadline: float) -> NonlinearOptimum | None:
        result = solve_with_exchange(
            model, self._placed(model), self.result.end, deadline, TIGHTENING, ACCURACY,
            self.relaxed_count,
        )  # fmt: skip
        if result.stopped in USABLE:
            return NonlinearOptimum(model, result, self.relaxed_count)
        return NonlinearOptimum.solve(model, self.result.x, self.relaxed_count, deadline)

    def _placed(self, model: ConicModel) -> list[ConstraintSamples]:
        """The samples on the motion of another model, whose unit of length may be another one."""
        ratio = model.problem.length / self.model.problem.length
        return [replace(one, s=one.s * ratio) for one in self.result.samples]

    @cached_property
    def _here(self) -> SmoothProgram:
        return self._stated(self.model)

    def _stated(self, model: ConicModel) -> SmoothProgram:
        return NonlinearModel(model, self.result.x, self.relaxed_count).program(
            self._placed(model), TIGHTENING
        )

    def _at_optimum(self, program: SmoothProgram) -> tuple[float, Array]:
        """Objective and rows of a program at x*."""
        both = casadi.Function("both", [program.x], [program.objective, program.rows])
        value, rows = (np.asarray(part, dtype=float).ravel() for part in both(self.result.end.x))
        return float(value[0]), rows

    def _lagrangian(self, program: SmoothProgram) -> float:
        """f(x*) + z · (g(x*) − b), b the side on which a row is held."""
        value, rows = self._at_optimum(program)
        z = np.zeros(len(rows)) if self.result.end.rows is None else self.result.end.rows
        z = np.pad(z, (0, len(rows) - len(z)))
        side = np.where(z > 0.0, program.upper, program.lower)
        held = np.isfinite(side)  # the multiplier of a side that is open is rounding
        return float(value + z[held] @ (rows[held] - side[held]))
