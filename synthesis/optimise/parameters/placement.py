"""Where the segments of a program lie, as functions of its free angles and lifts.

The numbers are points u of the unit box at which angles sum to a turn and lifts to nothing. Levels
and lifts are affine in u, an angle is affine in one coordinate. All else that rows are made of must
not depend on u; ``Placement.of`` compares it at corners of the box.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from synthesis.catalogue.constraints import LinearInequality
from synthesis.numerics.piecewise import Array
from synthesis.numerics.polytope import Polytope
from synthesis.optimise.problem.problem import Problem
from synthesis.spec.free_parameters import FreeParameters

CORNERS = 3  # per free direction, at which rows are compared
SHARES = (1.0, 0.37)  # of the way from the centre to a corner
ROUNDING = 1e-9  # relative: by how much what is equal, or affine, may differ


@dataclass(frozen=True, eq=False)
class Affine:
    """value + slope · (u − centre), of scalars: value (q,), slope (q, n)."""

    centre: Array
    value: Array
    slope: Array

    def at(self, u: Array) -> Array:
        """The values at a point: (q,)."""
        return np.asarray(self.value + self.slope @ (u - self.centre))

    def range_over(self, low: Array, high: Array) -> tuple[Array, Array]:
        """Least and largest values over a box: (q,) each."""
        middle, half = 0.5 * (low + high), 0.5 * (high - low)
        value, spread = self.at(middle), np.abs(self.slope) @ half
        return value - spread, value + spread


@dataclass(frozen=True, eq=False)
class Placement:
    """Segments as functions of the free numbers u: (n,).

    Attributes:
        problem: at its centre. polytope: where u may lie.
        coordinates: of every free law the coordinate that is its angle; None: it is given.
        angles: [rad] of every free law. lifts: its lift [length].
        starts: s_start [length] of every segment, in the problem's order.
        index: position in ``starts`` by the segment's place in the program.
    """

    problem: Problem
    polytope: Polytope
    coordinates: tuple[int | None, ...]
    angles: Affine
    lifts: Affine
    starts: Affine
    index: dict[int, int]

    @classmethod
    def of(
        cls, parameters: FreeParameters, problem_at: Callable[[Array], Problem | None]
    ) -> Placement | None:
        """That of a spec; None where rows depend on the numbers otherwise.

        Where a given law has a free angle or lift, a law with windows a free angle, or a length of
        the machine is free, they do.
        """
        polytope, free = parameters.polytope, parameters.parameters
        centre = polytope.centre()
        if centre is None or parameters.machine_indices:
            return None
        corners = polytope.corners(CORNERS * polytope.directions.shape[1])
        points = [centre, *(centre + k * (c - centre) for c in corners for k in SHARES)]
        problems = [problem_at(u) for u in points]
        first = problems[0]
        if first is None or not all(p is not None and _same_rows(first, p) for p in problems[1:]):
            return None
        if first.objective.equivalent_limits(1.0, first.machine) or first.vibration_limits:
            return None
        known = [p for p in problems if p is not None]
        named = {(p.segment, p.name): k for k, p in enumerate(free)}
        for segment in first.segments:
            own = [name for index, name in named if index == segment.index]
            windows = segment.free is not None and segment.free.knots and "angle_deg" in own
            moves = segment.law is not None and segment.kind != "dwell" and own
            if windows or moves or segment.table is not None:
                return None
        fit = _Fit(polytope, points)
        angles = fit([[s.angle for s in p.free] for p in known])
        lifts = fit([[s.lift for s in p.free] for p in known])
        starts = fit([[s.s_start for s in p.segments] for p in known])
        if angles is None or lifts is None or starts is None:
            return None
        coordinates = tuple(named.get((s.index, "angle_deg")) for s in first.free)
        # an angle is a function of its own coordinate alone
        slope = np.zeros_like(angles.slope)
        for position, k in enumerate(coordinates):
            if k is not None:
                slope[position, k] = np.radians(free[k].high - free[k].low)
        angles = Affine(centre, angles.value, slope)
        index = {s.index: k for k, s in enumerate(first.segments)}
        return cls(first, polytope, coordinates, angles, lifts, starts, index)


@dataclass(frozen=True, eq=False)
class _Fit:
    """Affine functions on a polytope from their values at points of it."""

    polytope: Polytope
    points: Sequence[Array]

    def __call__(self, values: Sequence[Sequence[float]]) -> Affine | None:
        """The functions with these values (points, q); None where they are not affine."""
        table, centre = np.array(values, dtype=float), self.points[0]
        steps = (np.array(self.points) - centre) @ self.polytope.directions
        slope, *_ = np.linalg.lstsq(steps, table - table[0], rcond=None)
        missed = np.abs(table[0] + steps @ slope - table)
        if np.max(missed, initial=0.0) > ROUNDING * max(1.0, np.max(np.abs(table), initial=0.0)):
            return None
        return Affine(centre, table[0], (self.polytope.directions @ slope).T)


def _same_rows(one: Problem, other: Problem) -> bool:
    """Whether two problems differ in angles, levels and lifts of their segments alone."""
    if len(one.segments) != len(other.segments) or not is_same_question(one, other):
        return False
    for a, b in zip(one.segments, other.segments, strict=True):
        if (a.kind, a.law is None, a.lift > 0.0) != (b.kind, b.law is None, b.lift > 0.0):
            return False
        rows, others = tuple(one.rows_on(a, 0.0)), tuple(other.rows_on(b, 0.0))
        if len(rows) != len(others):
            return False
        for x, y in zip(rows, others, strict=True):
            if (x.source, x.equality) != (y.source, y.equality):
                return False
            if not np.allclose(_numbers(x), _numbers(y), ROUNDING, 0.0):
                return False
    return True


def is_same_question(one: Problem, other: Problem) -> bool:
    """Whether objective, limits, earlier objectives and sizes of two problems are the same."""
    named = (
        (p.objective, p.limits, p.objective_caps, p.norm_bounds, p.open_above) for p in (one, other)
    )
    first, second = map(repr, named)
    bounds = one.sizing.bounds, other.sizing.bounds
    return first == second and np.shape(bounds[0]) == np.shape(bounds[1]) and np.allclose(
        *bounds, ROUNDING, 0.0
    )  # fmt: skip


def _numbers(row: LinearInequality) -> list[float]:
    return [*row.coefficients, *row.size, row.upper, row.level, *(row.interval or ())]
