"""The program's own free numbers, angles and lifts: searched for outside of the convex program.

With them fixed all is as ever. A few cone programs on coarse grids say what they are worth, and the
best point found is solved in full. It is a search: that no other numbers are better is not proven.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from math import inf

import numpy as np
from pydantic_core import PydanticCustomError

from synthesis.formulations.grid import Grid, over, uniform
from synthesis.formulations.problem import Problem, pose
from synthesis.formulations.refine import estimate, search
from synthesis.formulations.scene import Scene, yielded
from synthesis.formulations.search import Stage
from synthesis.formulations.tables import smooth_tables
from synthesis.numerics.descent import Found, Function, least
from synthesis.numerics.piecewise import Array
from synthesis.openings import Openings
from synthesis.spec import DesignSpec

SAMPLED, COARSE = 12, 24  # spline intervals: to look around, to descend
CORNERS = 4  # per free direction, towards which samples are taken
SHARES = (0.5, 0.95)  # of the way from the middle to a corner
INSIDE = 0.01  # relative amount by which limits are drawn in while anything possible is sought
STARTS = 3
APART = 0.1  # of the box: starts that are nearer than this lead to the same place
RADIUS, ROUNDS = 0.15, 25
LAST_RADIUS, LAST_ROUNDS = 0.03, 20  # on the knots that the full search came to
POLISHED = 4  # times at most
SHARE_OF_TIME = 0.6  # of what is left


@dataclass(frozen=True, eq=False)
class Mesh:
    """Knots of every free law, that follow the windows while angles change.

    Attributes:
        breaks: per free law. needed: per free law, those among them that windows and points ask
            for.
    """

    breaks: tuple[Array, ...]
    needed: tuple[Array, ...]

    @classmethod
    def of(cls, problem: Problem, grids: Sequence[Grid]) -> Mesh:
        """The mesh of these grids."""
        return cls(tuple(grid.space.breaks for grid in grids), tuple(_needed(problem)))

    def grids(self, problem: Problem) -> list[Grid]:
        """On another problem: between the knots needed, all others keep their shares."""
        return [
            over(stretch, np.interp(breaks, before, after))
            for stretch, breaks, before, after in zip(
                problem.free, self.breaks, self.needed, _needed(problem), strict=True
            )
        ]


def _needed(problem: Problem) -> Iterator[Array]:
    for stretch in problem.free:
        assert stretch.free is not None
        yield np.array([0.0, *stretch.free.knots, 1.0])


@dataclass(eq=False)
class _Worth:
    """What numbers are worth: the relaxation's optimum with the first objective."""

    spec: DesignSpec
    openings: Openings
    deadline: float
    calls: int = 0
    level: float = 1.0

    def problem(self, u: Array) -> Problem | None:
        """The question at a point of the unit box; None where a given law cannot be run there."""
        spec = self.spec.with_numbers(self.openings.numbers(u))
        try:
            stretches = smooth_tables(spec.stretches(), self.deadline).stretches
        except PydanticCustomError:
            return None
        return pose(spec, spec.objectives()[0], (), stretches)

    def uniform(self, u: Array, intervals: int) -> Mesh:
        """Equal intervals, by the windows as they are at u."""
        problem = self.problem(u)
        if problem is None:
            return Mesh((), ())
        return Mesh.of(problem, [uniform(s, intervals) for s in problem.free])

    def refined(self, u: Array) -> Mesh:
        """The knots that the full search comes to at u."""
        problem = self.problem(u)
        assert problem is not None
        grids = search(problem, self.spec.tolerance, self.deadline).grids
        return Mesh.of(problem, grids)

    def on(self, mesh: Mesh) -> Function:
        """The value on a mesh; None where nothing fits, or time is up."""

        @cache
        def value(key: bytes) -> float | None:
            problem = self.problem(np.frombuffer(key))
            self.calls += 1
            if problem is None:
                return None
            found = estimate(problem, mesh.grids(problem), self.level, self.deadline)
            self.level = found or self.level
            return found

        return lambda u: None if time.monotonic() >= self.deadline else value(u.tobytes())

    def excess(self, mesh: Mesh) -> Function:
        """By how much limits must be exceeded at least, in all; 0 where everything fits."""

        def value(u: Array) -> float | None:
            problem = self.problem(u)
            if problem is None or time.monotonic() >= self.deadline:
                return None
            self.calls += 1
            spec = self.spec.with_numbers(self.openings.numbers(u))
            scene = replace(Scene.of(spec, problem, mesh.grids(problem)), drawn=INSIDE)
            found = yielded(scene, scene.plan(), range(len(scene.parts)), exact=False)
            return None if found is None else max(found.total, 0.0)

        return value


def chosen(spec: DesignSpec, deadline: float = inf) -> tuple[DesignSpec, list[float], Stage]:
    """The spec with numbers in place of all that its program leaves free.

    Args:
        spec: with numbers left free. deadline: ``time.monotonic()``; the search takes a part of
            what is left.

    Returns:
        the spec, the numbers in the order of its openings, and what it took.
    """
    started = time.perf_counter()
    now, openings = time.monotonic(), spec.openings
    stop = inf if deadline == inf else now + SHARE_OF_TIME * max(deadline - now, 0.0)
    worth = _Worth(spec, openings, stop)
    middle = openings.polytope.centre()
    assert middle is not None  # the spec has been checked
    best = _search(worth, middle)
    numbers = openings.numbers(middle if best is None else best.u)
    freedom = openings.polytope.directions.shape[1]
    stage = Stage(
        "proportions", f"search over {freedom} of {len(numbers)} free numbers", "Clarabel",
        len(numbers), 0, worth.calls, time.perf_counter() - started,
        _ended(best, late=time.monotonic() >= stop),
        "angles and lifts of the program, by cutting planes from several starts",
    )  # fmt: skip
    return spec.with_numbers(numbers), numbers, stage


def _ended(best: Found | None, *, late: bool) -> str:
    """Why the search stopped."""
    if best is None or best.value == inf:
        return "out of time" if late else "nothing found"
    return "out of time, with the best so far" if late else "searched"


def _search(worth: _Worth, middle: Array) -> Found | None:
    """The best point found: samples, descents from the best of them, and a polish."""
    polytope = worth.openings.polytope
    corners = polytope.corners(CORNERS * polytope.directions.shape[1])
    points = [middle, *(middle + k * (c - middle) for c in corners for k in SHARES)]
    rough = worth.uniform(middle, SAMPLED)
    around = _best_of(worth.on(rough), points) or _possible(worth, points)
    coarse = worth.on(worth.uniform(middle, COARSE))
    starts = _best_of(coarse, [found.u for found in _apart(around)])
    ends = [least(coarse, polytope, start, RADIUS, ROUNDS) for start in starts]
    if not ends:
        return next(iter(around), None)
    best = min(ends, key=lambda one: one.value)
    for _ in range(POLISHED):
        before, fine = best, worth.on(worth.refined(best.u))
        for start in _best_of(fine, [best.u]):
            before, best = start, least(fine, polytope, start, LAST_RADIUS, LAST_ROUNDS)
        if before.value - best.value <= 0.1 * worth.spec.tolerance * abs(best.value):
            break
    return best


def _possible(worth: _Worth, points: Iterable[Array]) -> list[Found]:
    """Where everything fits, if at none of these: downhill from the nearest to it.

    Where nothing fits at all, the point that comes nearest to it, worth ∞.
    """
    mesh = worth.uniform(next(iter(points)), COARSE)
    excess = worth.excess(mesh)
    for start in _best_of(excess, points)[:1]:
        end = least(excess, worth.openings.polytope, start, RADIUS, ROUNDS)
        return _best_of(worth.on(mesh), [end.u]) or [Found(end.u, inf)]
    return []


def _best_of(function: Function, points: Iterable[Array]) -> list[Found]:
    """Those of the points where the function has a value, the best first."""
    found = [Found(u, value) for u in points if (value := function(u)) is not None]
    return sorted(found, key=lambda one: one.value)


def _apart(found: list[Found]) -> list[Found]:
    """The best few that are not close together."""
    kept: list[Found] = []
    for one in found:
        if all(float(np.max(np.abs(one.u - other.u))) > APART for other in kept):
            kept.append(one)
    return kept[:STARTS]
