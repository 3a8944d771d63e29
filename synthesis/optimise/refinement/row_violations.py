"""Where a recovered cam violates rows between the points at which they were written.

This is the separation step of a semi-infinite program: a row that holds for every cam angle is
written at collocation points, and the points of largest violation join the mesh.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import inf

import numpy as np

from synthesis.catalogue.constraints import LinearInequality
from synthesis.catalogue.motion import PlacedSegment
from synthesis.numerics.piecewise import Array, Mask, sorted_unique
from synthesis.optimise.conic.linear_rows import applies_at, is_sampled, row_excess, row_scale
from synthesis.optimise.conic.program import natural_scales
from synthesis.optimise.problem.grid import Grid
from synthesis.optimise.problem.problem import Problem
from synthesis.optimise.recovery.candidate import Candidate
from synthesis.optimise.state import SolveState

ALLOWED = 1e-9  # relative excess of a row that is the solver's noise; the certificate decides

CAP_SLACK = 0.01  # share of the tolerance by which a cam may exceed the cap on a radius


def row_violations(state: SolveState, cam: Candidate) -> tuple[list[Array], float]:
    """Points x of every free law where a cam violates rows between theirs, and the largest excess,
    relative to its row.
    """
    worst, points = _excess_of_earlier_objectives(state, cam), []
    laws = {segment.index: segment for segment in cam.problem.segments}
    for free, grid in zip(state.problem.free, state.grids, strict=True):
        violated = [np.zeros(0)]
        for x, excess, refinable in _excesses(state.problem, free, laws[free.index], grid, cam):
            worst = max(worst, float(np.max(excess)))
            if refinable:
                violated.append(x[excess > ALLOWED])
        points.append(sorted_unique(np.concatenate(violated)))
    return points, worst


def row_violation_peaks(state: SolveState, cam: Candidate, below: int) -> list[Array]:
    """Points x of every free law where a cam violates a linear row between their points most.

    ``below``: rows of derivatives of a lower order alone.
    """
    laws, points = {segment.index: segment for segment in cam.problem.segments}, []
    for free, grid in zip(state.problem.free, state.grids, strict=True):
        peaks = [np.zeros(0)]
        own = (state.problem, free, laws[free.index], grid, cam)
        for orders, x, excess in _row_excesses(*own):
            if max(orders) >= below:
                continue
            peaks.append(x[is_peak(excess, ALLOWED)])
        points.append(sorted_unique(np.concatenate(peaks)))
    return points


def is_peak(excess: Array, least: float) -> Mask:
    """Where an excess at points in order is above a least one, and not below that beside it."""
    beside = np.pad(excess, 1, constant_values=-inf)
    above = (excess > least) & (excess >= beside[:-2]) & (excess >= beside[2:])
    return np.asarray(above, dtype=bool)


def breaks_exact_rows(state: SolveState, cam: Candidate) -> bool:
    """Whether a cam breaks rows that a spline keeps all along once its coefficients keep them.

    A cone program keeps these to its accuracy. A nonlinear one may have stopped before it did, and
    its start need not: on another mesh the laws of a cam are no longer the same.
    """
    return exact_excess(state, cam) > ALLOWED


def exact_excess(state: SolveState, cam: Candidate) -> float:
    """By how much a cam breaks such rows, relative; at most 0 where it keeps them.

    The narrower intervals are, the more rounding in the coefficients of a law is in its jerk.
    """
    laws, scales = {s.index: s for s in cam.problem.segments}, natural_scales(state.problem)
    return max(
        (
            row_excess(row, laws[free.index], cam.size) / row_scale(row, free, scales)
            for free, grid in zip(state.problem.free, state.grids, strict=True)
            for row in state.problem.limit_rows(free)
            if not row.equality and not is_sampled(row, grid.space)
        ),
        default=0.0,
    )


def _excesses(
    problem: Problem, free: PlacedSegment, law: PlacedSegment, grid: Grid, cam: Candidate
) -> Iterator[tuple[Array, Array, bool]]:
    """Per row of one law: points between its own, the relative excess there, and whether the row
    could be written at them.
    """
    for _, x, excess in _row_excesses(problem, free, law, grid, cam):
        yield x, excess, True
    curves = list(problem.curved_limits_on(free))
    if not curves:
        return
    x, s = _between_points(free, law, grid)
    for limit in curves:
        for value in limit.excess(s, cam.size):
            yield x, value, limit.linearises


def _row_excesses(
    problem: Problem, free: PlacedSegment, law: PlacedSegment, grid: Grid, cam: Candidate
) -> Iterator[tuple[Sequence[int], Array, Array]]:
    """Per linear row of one law: its orders, points between its own, the relative excess there."""
    rows = [row for row in problem.limit_rows(free) if _can_be_violated(row, grid, cam)]
    if not rows:
        return
    scales, (x, s) = natural_scales(problem), _between_points(free, law, grid)
    for row in rows:
        size = sum(a * v for a, v in zip(row.size, cam.size, strict=False))
        excess = np.array(row.coefficients) @ s + (size - row.upper)
        relative = np.where(applies_at(row, x), excess / row_scale(row, free, scales), -inf)
        yield row.orders, x, relative


def _between_points(free: PlacedSegment, law: PlacedSegment, grid: Grid) -> tuple[Array, Array]:
    """Three points inside every interval of a mesh, and the motion there: (n,) and (4, n)."""
    gaps = np.diff(grid.points)[:, None] * np.array([0.25, 0.5, 0.75])
    x = np.asarray((grid.points[:-1, None] + gaps).ravel())
    curve, theta = law.placed(), free.start + free.angle * x
    return x, curve.jet(theta, curve.piece_of(theta), 3)


def _can_be_violated(row: LinearInequality, grid: Grid, cam: Candidate) -> bool:
    """Whether a row holds at points only; a size fitted to the whole law satisfies it everywhere.

    A cam that has grown in its last size variable since then still satisfies rows that this eases.
    """
    fitted = cam.fitted and bool(row.size) and row.size[-1] <= 0.0
    return not fitted and is_sampled(row, grid.space)


def _excess_of_earlier_objectives(state: SolveState, cam: Candidate) -> float:
    """How far the cam exceeds the radius that an earlier objective holds it to, relative."""
    caps, machine = state.problem.objective_caps, state.problem.machine
    excesses = (cap.excess(cam.size, machine) - CAP_SLACK * state.tolerance for cap in caps)
    return max(excesses, default=-inf)
