"""Where a finished law breaks rows between the points at which they were written."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf

import numpy as np

from synthesis.formulations.cams.candidate import Candidate
from synthesis.formulations.cone.convex import natural_scales
from synthesis.formulations.cone.rows import inside, row_scale, sampled
from synthesis.formulations.question.grid import Grid
from synthesis.formulations.question.problem import Problem
from synthesis.formulations.rounds.search import Search
from synthesis.motion import Stretch
from synthesis.numerics.piecewise import Array, distinct
from synthesis.terms import Row

ALLOWED = 1e-9  # relative excess of a row that is solver noise: the certificate decides


def misses(state: Search, found: Candidate) -> tuple[list[Array], float]:
    """Where rows written at points are exceeded between them on the free laws, and how far.

    Returns:
        points x of every free law, and the largest excess relative to its row.
    """
    worst, points = -inf, []
    settled = {stretch.index: stretch for stretch in found.problem.stretches}
    for free, grid in zip(state.problem.free, state.grids, strict=True):
        exceeding = [np.zeros(0)]
        each = _excesses(state.problem, free, settled[free.index], grid, found)
        for x, excess, writable in each:
            worst = max(worst, float(np.max(excess)))
            if writable:
                exceeding.append(x[excess > ALLOWED])
        points.append(distinct(np.concatenate(exceeding)))
    return points, max(worst, _outgrown(state, found))


def _excesses(
    problem: Problem, free: Stretch, law: Stretch, grid: Grid, found: Candidate
) -> Iterator[tuple[Array, Array, bool]]:
    """Points between those of one law's rows, by how much each row is exceeded there, and whether
    rows could be written there.
    """
    rows = [row for row in problem.limit_rows(free) if _may_miss(row, grid, found)]
    curves = list(problem.curves_on(free))
    if not rows and not curves:
        return
    scales, x, curve = natural_scales(problem), _between(grid.points), law.placed()
    theta = free.start + free.angle * x
    s = curve.jet(theta, curve.piece_of(theta), 3)
    for row in rows:
        size = sum(a * v for a, v in zip(row.size, found.size, strict=False))
        excess = np.array(row.coefficients) @ s + (size - row.upper)
        yield x, np.where(inside(row, x), excess / row_scale(row, free, scales), -inf), True
    for limit in curves:
        for value in limit.excess(s, found.size):
            yield x, value, limit.turns


def _may_miss(row: Row, grid: Grid, found: Candidate) -> bool:
    """Whether a row is kept at points only: the size was not fitted to it, or has outgrown it."""
    met = found.fitted and bool(row.size) and row.size[-1] <= 0.0
    return not met and sampled(row, grid.space)


def _outgrown(state: Search, found: Candidate) -> float:
    """How far the cam has outgrown an earlier objective's radius, closed up between points."""
    worst = -inf
    for earlier in state.problem.held:
        norm = earlier.objective.norm(state.problem.machine)
        if norm is not None:
            ratio = norm.value(found.size) / earlier.value
            worst = max(worst, ratio - 1.0 - 0.01 * state.tolerance)
    return worst


def _between(points: Array) -> Array:
    """Three points inside every interval."""
    gaps = np.diff(points)[:, None] * np.array([0.25, 0.5, 0.75])
    return np.asarray((points[:-1, None] + gaps).ravel())
