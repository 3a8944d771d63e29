"""The optimal value of specs near that of a design: estimated by multipliers, and solved again.

The laws that are compared are splines on the design's own knots, and tables as they were smoothed.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import inf

import numpy as np

from synthesis.design.design import Design
from synthesis.numerics.bspline import SplineSpace
from synthesis.numerics.piecewise import Array
from synthesis.optimise.conic.program import NO_TIGHTENING, ConicModel, formulate
from synthesis.optimise.conic.tangent_cuts import Region
from synthesis.optimise.dual_bound.bound import in_problem_units
from synthesis.optimise.heuristics.perturbed_optimum import (
    ConvexOptimum,
    NonlinearOptimum,
    PerturbedOptimum,
)
from synthesis.optimise.problem.grid import SplineLaw, grid_through
from synthesis.optimise.problem.problem import ObjectiveCap, Problem, formulate_problem
from synthesis.optimise.recovery.candidate import objective_value
from synthesis.spec.design_spec import DesignSpec

LEVEL_STEP = 1e-3  # relative: finite step of the excess by the trial level
SECANTS = 4  # steps to the level without excess; each gains several digits
LEVEL_ACCURACY = 1e-9  # relative: of that level
CONE_PROGRAM = "multipliers of the cone program"
LOCAL_OPTIMUM = "multipliers of IPOPT's local optimum"


@dataclass(frozen=True, eq=False)
class FixedKnots:
    """Laws of a design on its knots by the index of their segment, those that smooth a table too.

    ``size``: its size variables [mm]. ``caps``: objectives before the main one, as they are.
    """

    laws: dict[int, SplineLaw]
    size: tuple[float, ...]
    caps: tuple[ObjectiveCap, ...] = ()

    @staticmethod
    def of(design: Design, spec: DesignSpec) -> FixedKnots:
        """The knots of a finished design."""
        machine, main = spec.machine(), spec.main_objective()
        earlier = spec.objectives()[: spec.objectives().index(main)]
        values = [design.objectives[each.name_on_wire(machine)] for each in earlier]
        caps = tuple(
            ObjectiveCap(each, each.from_wire(value, machine))
            for each, value in zip(earlier, values, strict=True)
        )
        laws = {
            placed.index: SplineLaw(
                SplineSpace(segment.spline.degree, np.array(segment.spline.knots)),
                np.array(segment.spline.coefficients),
            )
            for placed, segment in zip(spec.placed_segments(), design.motion, strict=True)
            if segment.spline is not None
        }
        return FixedKnots(laws, tuple(design.size), caps)

    def formulate(self, spec: DesignSpec) -> Problem:
        """The problem of a spec's main objective; laws of tables are given."""
        segments = [
            segment if segment.table is None else segment.with_law(self.laws[segment.index].curve())
            for segment in spec.placed_segments()
        ]
        return formulate_problem(spec, spec.main_objective(), self.caps, segments)

    def program(self, problem: Problem, level: float = 0.0) -> tuple[ConicModel, int]:
        """The conic program on these knots, and how many of its last limits are the objective.

        ``level``: trial level of a fractional objective [core units].
        """
        grids = [
            grid_through(segment, self.laws[segment.index].space.breaks) for segment in problem.free
        ]
        model = formulate(problem, grids, level, NO_TIGHTENING, Region())
        # An objective that is a limit on its level has no rows in the program but a smooth form.
        extra = problem.objective.equivalent_limits(level, problem.machine)
        limited = replace(problem, limits=(*problem.limits, *extra))
        return replace(model, problem=limited), len(extra)

    def start(self, model: ConicModel) -> Array:
        """The design as a point of a program."""
        return model.point([self.laws[s.index] for s in model.problem.free], self.size)


@dataclass(frozen=True, eq=False)
class PerturbedDesign:
    """A finished design as the optimum of its problem.

    A fractional objective is not minimised by one program: programs minimise the excess over a
    trial level, and the optimal value is the level without excess.

    Attributes:
        method: how its multipliers are known. knots: the laws that are compared.
        problem: with the design's first objective. optimum: of its program, or of the excess.
        core_value: of the objective [core units].
        fall: decrease of the excess per unit of the level; None: the objective is not fractional.
    """

    method: str
    knots: FixedKnots
    problem: Problem
    optimum: PerturbedOptimum
    core_value: float
    fall: float | None = None

    @property
    def noise(self) -> float:
        """Relative error of values."""
        return self.optimum.noise

    @property
    def value(self) -> float:
        """The objective on the wire."""
        return self.problem.objective.to_wire(self.core_value, self.problem.machine)

    def _program(self, problem: Problem) -> ConicModel:
        return self.knots.program(problem, 0.0 if self.fall is None else self.core_value)[0]

    def estimate(self, spec: DesignSpec) -> float | None:
        """The optimal value of a near spec to first order, by multipliers.

        None where the spec's program has another form.
        """
        problem = self.knots.formulate(spec)
        model = self._program(problem)
        moved = self.optimum.first_order_value(model)
        if moved is None:
            return None
        if self.fall is None:
            value = in_problem_units(model, moved)
        else:  # implicit differentiation: the level rises by what the excess gains, over its fall
            value = self.core_value + (moved - self.optimum.value) / self.fall
        return problem.objective.to_wire(value, problem.machine)

    def remains_optimal(self, spec: DesignSpec) -> bool:
        """Whether the optimum is known to keep every limit of another spec, at the same value."""
        return self.optimum.remains_optimal(self._program(self.knots.formulate(spec)))

    def solve(self, spec: DesignSpec, deadline: float) -> float | None:
        """The optimal value of a near spec by solving; None where nothing fits."""
        problem = self.knots.formulate(spec)
        if self.fall is not None:
            value = self._level_without_excess(problem, self.fall, deadline)
        else:
            model = self._program(problem)
            optimum = self.optimum.solve_near(model, deadline)
            value = None if optimum is None else in_problem_units(model, optimum.value)
        return None if value is None else problem.objective.to_wire(value, problem.machine)

    def _level_without_excess(self, problem: Problem, fall: float, deadline: float) -> float | None:
        """The optimal value of a fractional objective, by steps with a fixed fall."""
        level = self.core_value
        for _ in range(SECANTS):
            optimum = self.optimum.solve_near(self.knots.program(problem, level)[0], deadline)
            if optimum is None:
                return None
            step = optimum.value / fall
            level += step
            if abs(step) <= LEVEL_ACCURACY * level:
                break
        return level

    def at_optimal_level(self, deadline: float) -> PerturbedDesign | None:
        """A fractional objective's optimum at the level without excess, from that at another."""
        knots, problem, first, level = self.knots, self.problem, self.optimum, self.core_value
        # The excess at the design's own level and a little above gives its fall.
        above = first.solve_near(knots.program(problem, level * (1.0 + LEVEL_STEP))[0], deadline)
        if above is None or above.value >= first.value:
            return None
        fall = (first.value - above.value) / (LEVEL_STEP * level)
        best = self._level_without_excess(problem, fall, deadline)
        if best is None:
            return None
        optimum = first.solve_near(knots.program(problem, best)[0], deadline)
        if optimum is None:
            return None
        return replace(self, optimum=optimum, core_value=best, fall=fall)


def perturbed_designs(
    knots: FixedKnots, spec: DesignSpec, deadline: float = inf
) -> Iterator[PerturbedDesign]:
    """The design as an optimum: of the cone program where it is one, then of the nonlinear one."""
    problem, level = knots.formulate(spec), 0.0
    fractional = problem.objective.quasiconvex
    if fractional:  # the trial level is the design's own value at first
        segments = [s.with_law(knots.laws[s.index].curve()) for s in problem.free]
        level = objective_value(problem.with_laws(segments), knots.size)
    model, relaxed = knots.program(problem, level)
    for method in (CONE_PROGRAM, LOCAL_OPTIMUM):
        optimum: PerturbedOptimum | None = None
        if method == LOCAL_OPTIMUM:
            relaxed = relaxed if fractional else 0
            optimum = NonlinearOptimum.solve(model, knots.start(model), relaxed, deadline)
        elif not model.problem.has_curved_limits:
            optimum = ConvexOptimum.solve(model, deadline)
        if optimum is None:
            continue
        value = level if fractional else in_problem_units(model, optimum.value)
        design = PerturbedDesign(method, knots, problem, optimum, value)
        at_best = design.at_optimal_level(deadline) if fractional else design
        if at_best is not None:
            yield at_best
