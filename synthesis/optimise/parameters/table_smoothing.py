"""Tables smoothed before anything else: least mean square jerk within a tolerance at every row.

Each table joins what is known beside it. The ideal motion is a quintic spline with its knots at the
rows that bind, so uniform knots are halved until that gains no more. Unknowns are the coefficients,
in tolerances from a least-squares spline: so the rows are of size one whatever the tolerance is,
and the solver's own accuracy is a small part of it.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf, sqrt
from typing import Any

import numpy as np
from scipy import sparse
from scipy.interpolate import BSpline
from scipy.sparse.linalg import splu

from synthesis.catalogue.motion import PlacedSegment
from synthesis.numerics import clock
from synthesis.numerics.bspline import SplineSpace
from synthesis.numerics.piecewise import Array, gauss_points
from synthesis.numerics.solvers.clarabel import ConeProgram, solve
from synthesis.numerics.solvers.statuses import USABLE, StopReason
from synthesis.optimise.problem.boundary import given_end, required_end
from synthesis.optimise.state import Stage

FIRST, MOST = 16, 2048  # intervals
GAIN = 1e-2  # relative: halving the knots is worth it from this gain on
TIGHTENING = 1e-4  # of the tolerance: what the solver's accuracy may use up
JERK = 3  # order of the derivative
SPARE = 1.01  # of the least deviation there is, so that the jerk has something to gain


@dataclass(frozen=True, eq=False)
class Rows:
    """What a fit has to meet, normalised: x in [0, 1], displacement g in units of the table.

    Attributes:
        x, g: (m,) the rows. tolerance: how far the spline may pass them.
        start, end: known g, g', … at x = 0 and x = 1.
        closed: how many derivatives have to be equal at both ends (a table of a whole turn).
    """

    x: Array
    g: Array
    tolerance: float
    start: Array
    end: Array
    closed: int = 0


@dataclass(frozen=True, eq=False)
class Fit:
    """The spline found, how far it passes the rows at most, ∫ (g''')² dx, and what it cost."""

    space: SplineSpace
    coefficients: Array
    deviation: float
    energy: float
    unknowns: int
    rows: int
    iterations: int
    stopped: StopReason


@dataclass(frozen=True, eq=False)
class Tables:
    """The program with its tables smoothed, their splines by index, and what that took."""

    segments: tuple[PlacedSegment, ...]
    splines: dict[int, tuple[SplineSpace, Array]]
    stages: tuple[Stage, ...]


def smooth_tables(segments: Sequence[PlacedSegment], deadline: float = inf) -> Tables:
    """Smooth every table in order, until a deadline; each joins what is known beside it."""
    result = list(segments)
    splines, stages = {}, []
    turning = [i for i, segment in enumerate(result) if segment.angle > 0.0]
    for place, i in enumerate(turning):
        segment = result[i]
        free, table, unit = segment.free, segment.table, segment.scale
        if table is None or free is None:
            continue
        started = time.perf_counter()
        left, right = result[turning[place - 1]], result[turning[(place + 1) % len(turning)]]
        rows = Rows(
            table.x, (table.s - segment.s_start) / unit, table.tolerance / unit,
            _known(segment, left, at_start=True), _known(segment, right, at_start=False),
            free.smoothness if left is segment else 0,
        )  # fmt: skip
        fit = smooth_table(rows, free.smoothness + 1, max(deadline - clock.now(), 1e-3))
        result[i] = segment.with_law(fit.space.curve(fit.coefficients))
        splines[i] = (fit.space, fit.coefficients)
        intervals = len(fit.space.breaks) - 1
        stages.append(
            Stage(
                f"table program/{i}", f"QP, {intervals} spline intervals", "Clarabel", fit.unknowns,
                fit.rows, fit.iterations, time.perf_counter() - started, fit.stopped.value,
            )
        )  # fmt: skip
    return Tables(tuple(result), splines, tuple(stages))


def _known(segment: PlacedSegment, neighbour: PlacedSegment, *, at_start: bool) -> Array:
    """g, g', … at an end: of the known neighbour, but for what is required."""
    if neighbour.law is None or neighbour is segment:
        state = segment.start_state if at_start else segment.end_state
        return required_end(segment, state, at_start=at_start)
    return given_end(segment, neighbour, at_start=at_start)


def smooth_table(rows: Rows, degree: int, time_limit: float = inf) -> Fit:
    """The smoothest spline of a degree through all rows; as near as can be if none is.

    ``time_limit``: for each solve [s].
    """
    best: Fit | None = None
    intervals, iterations, most = FIRST, 0, min(MOST, max(FIRST, 2 * len(rows.x)))
    while intervals <= most:
        fit = _fit(rows, SplineSpace(degree, np.linspace(0.0, 1.0, intervals + 1)), time_limit)
        if fit is not None:
            iterations += fit.iterations
            if best is not None and fit.energy > (1.0 - GAIN) * best.energy:
                return replace(min(fit, best, key=lambda one: one.energy), iterations=iterations)
            best = fit
        intervals *= 2
    if best is not None:
        return replace(best, iterations=iterations)
    finest = SplineSpace(degree, np.linspace(0.0, 1.0, intervals // 2 + 1))
    return _nearest(rows, finest, time_limit)


def _fit(rows: Rows, space: SplineSpace, time_limit: float) -> Fit | None:
    """The smoothest spline of one space that meets all rows, None where there is none."""
    frame = _Frame.of(rows, space)
    n, q = frame.basis.shape[1], frame.jerk.shape[0]
    unit = max(1.0, sqrt(float(np.mean(frame.jerk_before**2)) * q))
    slack = 1.0 - TIGHTENING
    blocks: list[Any] = [
        [rows.tolerance / unit * frame.jerk, -sparse.eye(q)],
        [frame.closed, None], [frame.basis, None], [-frame.basis, None],
    ]  # fmt: skip
    rhs = [-frame.jerk_before / unit, frame.closed_rhs, frame.miss + slack, slack - frame.miss]
    squares = np.repeat([0.0, 2.0], [n, q])
    fit = frame.solve(squares, np.zeros(n + q), blocks, rhs, time_limit)
    return fit if fit.stopped in USABLE else None


def _nearest(rows: Rows, space: SplineSpace, time_limit: float) -> Fit:
    """The smoothest of the splines that come (almost) as near to the rows as any of the space."""
    frame = _Frame.of(rows, space)
    n, one = frame.basis.shape[1], sparse.csc_matrix(-np.ones((len(rows.x), 1)))
    blocks: list[Any] = [[frame.closed, None], [frame.basis, one], [-frame.basis, one]]
    rhs = [frame.closed_rhs, frame.miss, -frame.miss]
    nearest = frame.solve(np.zeros(n + 1), np.eye(n + 1)[n], blocks, rhs, time_limit)
    wider = replace(rows, tolerance=SPARE * max(nearest.deviation, rows.tolerance))
    return _fit(wider, space, time_limit) or nearest


@dataclass(frozen=True, eq=False)
class _Frame:
    """The rows on one space, about a least-squares spline that has the known ends.

    Attributes:
        around: all coefficients of that spline. inner: which of them are unknown.
        basis: (m, n) values at the rows, jerk: (q, n) g''' at Gauss points times the roots of
            their weights, both of the unknown ones. jerk_before: (q,) that of ``around``.
        miss: (m,) the table less ``around``, in tolerances.
        closed, closed_rhs: rows of equal derivatives at both ends.
    """

    rows: Rows
    space: SplineSpace
    around: Array
    inner: slice
    basis: sparse.csr_matrix
    jerk: sparse.csr_matrix
    jerk_before: Array
    miss: Array
    closed: sparse.csr_matrix
    closed_rhs: Array

    @classmethod
    def of(cls, rows: Rows, space: SplineSpace) -> _Frame:
        basis = sparse_basis(space, rows.x)
        x, shares = (each.ravel() for each in gauss_points(space.breaks, space.degree - JERK + 1))
        jerk = sparse.csr_matrix(sparse.diags(np.sqrt(shares)) @ sparse_basis(space, x, JERK))
        # the spline nearest to the rows; a trace of the jerk fills what they leave open
        near, bend = basis.T @ basis, jerk.T @ jerk
        trace = 1e-10 * near.diagonal().mean() / bend.diagonal().mean()
        around: Array = splu((near + trace * bend).tocsc()).solve(basis.T @ rows.g)
        first, last = len(rows.start), len(rows.end)
        inner = slice(first, space.size - last)
        starts, ends = (
            space.end_derivatives(x, max(first, last, rows.closed + 1)) for x in (0.0, 1.0)
        )
        around[:first] = np.linalg.solve(starts[:first, :first], rows.start)
        around[inner.stop :] = np.linalg.solve(ends[:last, inner.stop :], rows.end)
        closed = (ends - starts)[1 : rows.closed + 1]
        closed /= np.abs(closed).max(axis=1, keepdims=True)
        return cls(
            rows, space, around, inner, basis[:, inner], jerk[:, inner], jerk @ around,
            (rows.g - basis @ around) / rows.tolerance,
            sparse.csr_matrix(closed[:, inner]), -closed @ around / rows.tolerance,
        )  # fmt: skip

    def solve(
        self, squares: Array, linear: Array, blocks: list[Any], rhs: list[Array], time_limit: float
    ) -> Fit:
        """The best spline: unknown coefficients come first, rows ≤ rhs of the table last."""
        quadratic = sparse.csc_matrix(sparse.diags(squares))
        quadratic.eliminate_zeros()
        matrix, bounds = sparse.csc_matrix(sparse.bmat(blocks)), np.concatenate(rhs)
        both = 2 * len(self.miss)
        program = ConeProgram(quadratic, linear, matrix, bounds, len(bounds) - both, both, ())
        solution = solve(program, time_limit)
        step, coefficients = solution.x[: self.basis.shape[1]], self.around.copy()
        coefficients[self.inner] += self.rows.tolerance * step
        miss = self.miss - self.basis @ step
        jerk = self.jerk_before + self.rows.tolerance * (self.jerk @ step)
        deviation = float(np.max(np.abs(miss))) * self.rows.tolerance
        return Fit(
            self.space, coefficients, deviation, float(jerk @ jerk), len(squares), len(bounds),
            solution.iterations, solution.stopped,
        )  # fmt: skip


def sparse_basis(space: SplineSpace, x: Array, order: int = 0) -> sparse.csr_matrix:
    """The ``order``-th derivative of every basis function at x in [0, 1]: (len(x), size)."""
    knots, matrix = space.knots, sparse.csr_matrix(sparse.eye(space.size))
    for k in range(order):
        p, n = space.degree - k, space.size - k - 1
        rise = knots[k + p + 1 : len(knots) - k - 1] - knots[k + 1 : len(knots) - k - p - 1]
        row = np.repeat(np.arange(n), 2)
        column = row + np.tile([0, 1], n)
        steps = np.repeat(p / rise, 2) * np.tile([-1.0, 1.0], n)
        matrix = sparse.csr_matrix((steps, (row, column)), shape=(n, n + 1)) @ matrix
    inner = knots[order : len(knots) - order]
    values = BSpline.design_matrix(x, inner, space.degree - order)
    return sparse.csr_matrix(values) @ matrix
