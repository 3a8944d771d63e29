"""The motions among which a design is the best: its own knots, and tables as smoothed."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from synthesis.design import Design
from synthesis.formulations.cone.convex import EXACT, Plan, formulate
from synthesis.formulations.cone.cuts import Region
from synthesis.formulations.question.grid import SettledLaw, over
from synthesis.formulations.question.problem import Problem, pose
from synthesis.numerics.bspline import SplineSpace
from synthesis.numerics.piecewise import Array
from synthesis.spec import DesignSpec


@dataclass(frozen=True, eq=False)
class Family:
    """Splines on given knots, by the index of their stretch.

    Attributes:
        laws: as the design has them. tables: which of them are readings, settled before.
        size: the size variables of the design [mm].
    """

    laws: dict[int, SettledLaw]
    tables: frozenset[int]
    size: tuple[float, ...]

    @staticmethod
    def of(design: Design, spec: DesignSpec) -> Family:
        """That of a finished design."""
        laws, tables = dict[int, SettledLaw](), set[int]()
        for stretch, segment in zip(spec.stretches(), design.motion, strict=True):
            if segment.spline is None:
                continue
            space = SplineSpace(segment.spline.degree, np.array(segment.spline.knots))
            laws[stretch.index] = SettledLaw(space, np.array(segment.spline.coefficients))
            if stretch.readings is not None:
                tables.add(stretch.index)
        return Family(laws, frozenset(tables), tuple(design.size))

    def posed(self, spec: DesignSpec) -> Problem:
        """The first objective of a spec."""
        stretches = [
            stretch.with_law(self.laws[stretch.index].curve())
            if stretch.index in self.tables
            else stretch
            for stretch in spec.stretches()
        ]
        return pose(spec, spec.objectives()[0], (), stretches)

    def stated(self, problem: Problem, level: float = 0.0) -> tuple[Plan, int]:
        """The program on these knots, and how many of its last limits are the objective.

        Args:
            problem: the question. level: trial level of a fractional objective [core units].
        """
        grids = [over(stretch, self.laws[stretch.index].space.breaks) for stretch in problem.free]
        plan = formulate(problem, grids, level, EXACT, Region())
        said = problem.objective.limits(level, problem.machine)  # they give way: no rows of it
        limited = replace(problem, limits=(*problem.limits, *said))
        return replace(plan, problem=limited), len(said)

    def start(self, plan: Plan) -> Array:
        """The design as a point of a program."""
        return plan.point([self.laws[s.index] for s in plan.problem.free], self.size)
