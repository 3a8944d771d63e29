"""The program's own free numbers, angles and lifts: searched for outside of the convex program.

With them fixed all is as ever. A few cone programs on coarse grids say what they are worth, and the
best point found is solved in full. It is a search: that no other numbers are better is not proven.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from math import inf, isfinite

import numpy as np
from pydantic_core import PydanticCustomError

from synthesis.formulations.problem import pose
from synthesis.formulations.refine import estimate
from synthesis.formulations.search import Stage
from synthesis.formulations.tables import smooth_tables
from synthesis.numerics.descent import Found, least
from synthesis.numerics.piecewise import Array
from synthesis.openings import Openings
from synthesis.spec import DesignSpec

SAMPLED, COARSE, FINE = 12, 24, 64  # spline intervals: to look around, to descend, to finish
CORNERS = 4  # per free direction, towards which samples are taken
SHARES = (0.5, 0.95)  # of the way from the middle to a corner
MORE = (0.25, 0.75, 0.999)  # where those found nothing
STARTS = 3
APART = 0.1  # of the box: starts that are nearer than this lead to the same place
RADIUS, ROUNDS = 0.15, 25
LAST_RADIUS, LAST_ROUNDS = 0.02, 12
SHARE_OF_TIME = 0.6  # of what is left


@dataclass(eq=False)
class _Worth:
    """What numbers are worth: the relaxation's optimum with the first objective."""

    spec: DesignSpec
    openings: Openings
    deadline: float
    calls: int = 0
    known: dict[tuple[int, bytes], float | None] = field(default_factory=dict)

    def at(self, u: Array, intervals: int) -> float | None:
        """The value at a point of the unit box; None where nothing fits, or time is up."""
        key = (intervals, u.tobytes())
        if key not in self.known:
            if time.monotonic() >= self.deadline:
                return None
            self.calls += 1
            self.known[key] = self._measured(u, intervals)
        return self.known[key]

    def _measured(self, u: Array, intervals: int) -> float | None:
        spec = self.spec.with_numbers(self.openings.numbers(u))
        try:
            stretches = smooth_tables(spec.stretches(), self.deadline).stretches
        except PydanticCustomError:  # with these numbers a given law cannot meet its neighbours
            return None
        problem = pose(spec, spec.objectives()[0], (), stretches)
        return estimate(problem, intervals, self.deadline)

    def best_of(self, points: list[Array], intervals: int) -> list[Found]:
        """Those of the points that are worth something, the best first."""
        values = [(u, self.at(u, intervals)) for u in points]
        found = [Found(u, value) for u, value in values if value is not None and isfinite(value)]
        return sorted(found, key=lambda one: one.value)


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
        "nothing found" if best is None else "searched",
        "angles and lifts of the program, by cutting planes from several starts",
    )  # fmt: skip
    return spec.with_numbers(numbers), numbers, stage


def _search(worth: _Worth, middle: Array) -> Found | None:
    """The best point found: samples, descents from the best of them, a finer descent."""
    polytope = worth.openings.polytope
    corners = polytope.corners(CORNERS * polytope.directions.shape[1])
    around: list[Found] = []
    for shares in (SHARES, MORE):
        points = [middle, *(middle + k * (c - middle) for c in corners for k in shares)]
        around = around or worth.best_of(points, SAMPLED)
    starts = worth.best_of([found.u for found in _apart(around)], COARSE)
    ends = [
        least(lambda u: worth.at(u, COARSE), polytope, start, RADIUS, ROUNDS) for start in starts
    ]
    ends.sort(key=lambda one: one.value)
    for end in ends:
        for fine in worth.best_of([end.u], FINE):
            return least(lambda u: worth.at(u, FINE), polytope, fine, LAST_RADIUS, LAST_ROUNDS)
    return next(iter([*ends, *around]), None)


def _apart(found: list[Found]) -> list[Found]:
    """The best few that are not close together."""
    kept: list[Found] = []
    for one in found:
        if all(float(np.max(np.abs(one.u - other.u))) > APART for other in kept):
            kept.append(one)
    return kept[:STARTS]
