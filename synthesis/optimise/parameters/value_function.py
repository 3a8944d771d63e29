"""The value of free numbers: what the best cam comes to with them in place.

By a whole search, or by one cone program on a mesh that follows the numbers (a smooth function of
them, but for kinks).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from pydantic_core import PydanticCustomError

from synthesis.numerics import clock
from synthesis.numerics.piecewise import Array
from synthesis.numerics.polytope import BundlePoint, Function
from synthesis.optimise.driver import estimate, optimise
from synthesis.optimise.parameters.table_smoothing import smooth_tables
from synthesis.optimise.problem.grid import Grid, grid_through, uniform_grid
from synthesis.optimise.problem.problem import Problem, formulate_problem
from synthesis.optimise.recovery.candidate import Candidate
from synthesis.optimise.state import SolveState
from synthesis.optimise.strategy.phase_one import least_excess
from synthesis.spec.design_spec import DesignSpec
from synthesis.spec.free_parameters import FreeParameters

NOTHING = 1e30  # value of a length at which nothing fits
INSIDE = 0.01
"""Relative tightening of limits while any feasible point is sought: the next search needs slack."""


@dataclass(frozen=True, eq=False)
class SearchedPoint(BundlePoint):
    """A point with its value, and the cam of a whole search there."""

    cam: Candidate | None


Mesh = Callable[[Problem], list[Grid]]
"""Grids of a problem whose knots follow the windows while angles change."""


def mesh_like(problem: Problem, grids: Sequence[Grid]) -> Mesh:
    """The mesh of these grids: between the knots needed, all others keep their shares."""
    breaks, before = [grid.space.breaks for grid in grids], list(_needed(problem))

    def follow(other: Problem) -> list[Grid]:
        return [
            grid_through(segment, np.interp(own, was, now))
            for segment, own, was, now in zip(
                other.free, breaks, before, _needed(other), strict=True
            )
        ]

    return follow


def _needed(problem: Problem) -> Iterator[Array]:
    for segment in problem.free:
        assert segment.free is not None
        yield np.array([0.0, *segment.free.knots, 1.0])


@dataclass(eq=False)
class ValueFunction:
    """The value of numbers: the relaxation's optimum with the first objective [wire]."""

    spec: DesignSpec
    free_parameters: FreeParameters
    deadline: float
    calls: int = 0
    level: float = 1.0

    def problem(self, u: Array) -> Problem | None:
        """The problem at a point of the unit box; None where a given law cannot be run there."""
        spec = self.spec.with_values(self.free_parameters.values_at(u))
        try:
            segments = smooth_tables(spec.placed_segments(), self.deadline).segments
            spec.check_reach()
        except PydanticCustomError:
            return None
        return formulate_problem(spec, spec.objectives()[0], (), segments)

    def uniform(self, u: Array, intervals: int) -> Mesh:
        """Equal intervals, by the windows as they are at u."""
        problem = self.problem(u)
        if problem is None:
            return lambda _: []
        return mesh_like(problem, [uniform_grid(s, intervals) for s in problem.free])

    def refined(self, u: Array) -> Mesh:
        """The knots that the full search comes to at u."""
        problem = self.problem(u)
        assert problem is not None
        return mesh_like(problem, optimise(problem, self.spec.tolerance, self.deadline).grids)

    def on(self, mesh: Mesh) -> Function:
        """The value on a mesh; None where nothing fits, or time is up."""

        @cache
        def value(key: bytes) -> float | None:
            problem = self.problem(np.frombuffer(key))
            self.calls += 1
            if problem is None:
                return None
            result = estimate(problem, mesh(problem), self.level, self.deadline)
            if result is None:
                return None
            self.level = result or self.level
            # the core's unit may depend on the numbers, that of the wire does not
            return problem.objective.to_wire(result, problem.machine)

        return lambda u: None if clock.now() >= self.deadline else value(u.tobytes())

    def state(self, u: Array, tolerance: float, deadline: float | None = None) -> SolveState | None:
        """The whole search at u to a relative gap; None where no law can be run there.

        Args:
            u: numbers. tolerance: the gap. deadline: by default that of all.
        """
        stop = self.deadline if deadline is None else deadline
        problem = self.problem(u) if clock.now() < stop else None
        if problem is None:
            return None
        self.calls += 1
        return optimise(problem, tolerance, stop)

    def solved(self, u: Array, tolerance: float, fixed: float | None) -> SearchedPoint:
        """The best cam that a whole search finds at u; ``fixed``: a value for what can be fixed."""
        problem = self.problem(u) if clock.now() < self.deadline else None
        if problem is None:
            return SearchedPoint(u, NOTHING, None)
        self.calls += 1
        fixable = problem.machine.follower.fixable_dimension()
        if fixed is not None and fixable is not None:
            problem = problem.with_follower(fixable.fixed_at(fixed))
        cam = optimise(problem, max(self.spec.tolerance, tolerance), self.deadline).incumbent
        if cam is None:
            return SearchedPoint(u, NOTHING, None)
        return SearchedPoint(u, cam.problem.objective.to_wire(cam.value, cam.problem.machine), cam)

    def excess(self, mesh: Mesh) -> Function:
        """By how much limits must be exceeded at least, in all; 0 where everything fits."""

        def value(u: Array) -> float | None:
            problem = self.problem(u)
            if problem is None or clock.now() >= self.deadline:
                return None
            self.calls += 1
            result = least_excess(problem, mesh(problem), INSIDE, self.deadline)
            return None if result is None else result + problem.vibration_excess

        return value
