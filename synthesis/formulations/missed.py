"""Where a finished law breaks rows between the points at which they were written."""

from __future__ import annotations

from math import inf

import numpy as np

from synthesis.formulations.candidate import Candidate
from synthesis.formulations.convex import natural_scales
from synthesis.formulations.rows import inside, row_scale, sampled
from synthesis.formulations.search import Search
from synthesis.numerics.piecewise import Array

ALLOWED = 1e-9  # relative excess of a row that is solver noise: the certificate decides


def misses(state: Search, found: Candidate) -> tuple[list[Array], float]:
    """Where rows written at points are exceeded between them on the free laws, and how far.

    Returns:
        points x of every free law, and the largest excess relative to its row.
    """
    scales, worst = natural_scales(state.problem), -inf
    points = []
    settled = {stretch.index: stretch for stretch in found.problem.stretches}
    for free, grid in zip(state.problem.free, state.grids, strict=True):
        x = _between(grid.points)
        law, theta = settled[free.index].placed(), free.start + free.angle * x
        s = law.jet(theta, law.piece_of(theta), 3)
        exceeding = [np.zeros(0)]
        for row in state.problem.limit_rows(free):
            if sampled(row, grid.space):
                size = sum(a * v for a, v in zip(row.size, found.size, strict=False))
                excess = np.array(row.coefficients) @ s + (size - row.upper)
                excess /= row_scale(row, free, scales)
                excess = np.where(inside(row, x), excess, -inf)
                worst = max(worst, float(np.max(excess)))
                exceeding.append(x[excess > ALLOWED])
        for curve in state.problem.curves_on(free):
            for value in curve.excess(s, found.size):
                worst = max(worst, float(np.max(value)))
                exceeding.append(x[value > ALLOWED])
        points.append(np.unique(np.concatenate(exceeding)))
    return points, max(worst, _outgrown(state, found))


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
