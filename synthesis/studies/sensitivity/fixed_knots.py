"""The laws among which a design is optimal: splines on its own knots, and tables as smoothed."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from synthesis.design.design import Design
from synthesis.numerics.bspline import SplineSpace
from synthesis.numerics.piecewise import Array
from synthesis.optimise.conic.program import NO_TIGHTENING, ConicModel, formulate
from synthesis.optimise.conic.tangent_cuts import Region
from synthesis.optimise.problem.grid import SplineLaw, grid_through
from synthesis.optimise.problem.problem import Problem, formulate_problem
from synthesis.spec.design_spec import DesignSpec


@dataclass(frozen=True, eq=False)
class FixedKnots:
    """Splines on the knots of a design, by the index of their segment.

    Attributes:
        laws: of the design. tables: indices of the laws that smooth a table and are given.
        size: the size variables of the design [mm].
    """

    laws: dict[int, SplineLaw]
    tables: frozenset[int]
    size: tuple[float, ...]

    @staticmethod
    def of(design: Design, spec: DesignSpec) -> FixedKnots:
        """The knots of a finished design."""
        laws, tables = dict[int, SplineLaw](), set[int]()
        for placed, segment in zip(spec.placed_segments(), design.motion, strict=True):
            if segment.spline is None:
                continue
            space = SplineSpace(segment.spline.degree, np.array(segment.spline.knots))
            laws[placed.index] = SplineLaw(space, np.array(segment.spline.coefficients))
            if placed.table is not None:
                tables.add(placed.index)
        return FixedKnots(laws, frozenset(tables), tuple(design.size))

    def formulate(self, spec: DesignSpec) -> Problem:
        """The problem of a spec's first objective."""
        segments = [
            segment.with_law(self.laws[segment.index].curve())
            if segment.index in self.tables
            else segment
            for segment in spec.placed_segments()
        ]
        return formulate_problem(spec, spec.objectives()[0], (), segments)

    def program(self, problem: Problem, level: float = 0.0) -> tuple[ConicModel, int]:
        """The conic program on these knots, and how many of its last limits are the objective.

        Args:
            problem: the problem. level: trial level of a fractional objective [core units].
        """
        grids = [
            grid_through(segment, self.laws[segment.index].space.breaks) for segment in problem.free
        ]
        plan = formulate(problem, grids, level, NO_TIGHTENING, Region())
        # An objective that is a limit on its level has no rows in the program but a smooth form.
        extra = problem.objective.equivalent_limits(level, problem.machine)
        limited = replace(problem, limits=(*problem.limits, *extra))
        return replace(plan, problem=limited), len(extra)

    def start(self, plan: ConicModel) -> Array:
        """The design as a point of a program."""
        return plan.point([self.laws[s.index] for s in plan.problem.free], self.size)
