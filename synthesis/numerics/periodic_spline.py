"""Periodic B-splines through many points: least squares, as smooth as a tolerance allows."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final

import numpy as np
from scipy import sparse
from scipy.interpolate import BSpline, PPoly
from scipy.sparse.linalg import splu

from synthesis.errors import SolverFailed
from synthesis.numerics.piecewise import Array, Piecewise

DEGREE: Final = 5  # acceleration and jerk are continuous
ROUGHEST, SMOOTHEST = -10.0, 6.0  # decimal logarithms of the penalty
REFINED: Final = (0.5, 0.25)  # steps by which the best is looked for more closely
PROBES: Final = 12  # random vectors that estimate a trace (Hutchinson)
SEED: Final = 20_240_517  # of these: the same answer at every call


@dataclass(frozen=True, eq=False)
class PeriodicSpline:
    """A spline of degree 5, with coefficients (n, d), that repeats itself after a period.

    ``knots``: (n,) increasing in [0, period); one that is repeated takes a derivative away.
    """

    knots: Array
    period: float
    coefficients: Array

    @cached_property
    def _spline(self) -> BSpline:
        extended, columns = _extended(self.knots, self.period)
        return BSpline(extended, self.coefficients[columns], DEGREE)

    def __call__(self, x: Array, order: int = 0) -> Array:
        """The ``order``-th derivative at x (k,): (k, d)."""
        return np.asarray(self._spline(np.mod(x, self.period), nu=order), dtype=float)

    def piecewise(self) -> Piecewise:
        """One component, the first, over [0, period], piece by piece."""
        table = PPoly.from_spline((self._spline.t, self._spline.c[:, 0], DEGREE))
        inside = (table.x >= 0.0) & (table.x <= self.period)
        starts = np.flatnonzero(
            inside[:-1] & (np.diff(table.x) > 0.0) & (table.x[:-1] < self.period)
        )
        breaks = np.append(table.x[starts], self.period)
        return Piecewise.of(breaks, list(table.c[::-1, starts].T), origins=table.x[starts])


def _extended(knots: Array, period: float) -> tuple[Array, Any]:
    """The knots with a neighbourhood either side, and which coefficient stands for which function.

    The first knot must be 0, so that [0, period] is a union of pieces.
    """
    around = [knots[-DEGREE:] - period, knots, knots[: DEGREE + 1] + period]
    return np.concatenate(around), np.arange(len(knots) + DEGREE) % len(knots)


def design_matrix(knots: Array, period: float, x: Array) -> sparse.csr_array:
    """The basis functions at x in [0, period): (k, n)."""
    extended, columns = _extended(knots, period)
    table = BSpline.design_matrix(np.mod(x, period), extended, DEGREE).tocoo()
    shape = (len(x), len(knots))
    return sparse.coo_array((table.data, (table.row, columns[table.col])), shape=shape).tocsr()


def _solve(matrix: Any, right: Array) -> Array:
    """Solve a sparse system; SolverFailed where it is singular."""
    try:
        solved: Array = splu(matrix.tocsc()).solve(right)
    except RuntimeError as error:
        raise SolverFailed("SuperLU", str(error), "Measure points more evenly.") from None
    return solved


def fit_least_squares(
    knots: Array, period: float, x: Array, values: Array
) -> tuple[PeriodicSpline, Array]:
    """The spline through values (k, d) at x (k,) by least squares, and its residuals (k, d).

    The first of the knots (n,) is at 0.
    """
    matrix = design_matrix(knots, period, x)
    normal = (matrix.T @ matrix).tocsc()
    ridge = 1e-13 * normal.diagonal().max()  # a knot interval without points keeps a solution
    solved = _solve(normal + ridge * sparse.eye_array(len(knots)), matrix.T @ values)
    return PeriodicSpline(knots, period, solved), values - matrix @ solved


def fit_smoothing(
    intervals: int, period: float, x: Array, values: Array, tolerance: float
) -> tuple[PeriodicSpline, Array]:
    """A smoothing spline on even knots that passes within a tolerance of every point.

    P-splines (Eilers & Marx, Statist. Sci. 11 (1996) 89): least squares plus a multiple of the
    squared third differences of the coefficients. The multiple is the one of least generalised
    cross-validation (Craven & Wahba, Numer. Math. 31 (1979) 377), so that it is the scatter of
    the points that decides, among those that keep every residual within the tolerance. The trace
    in it is estimated from random signs (Hutchinson), always the same ones.

    The ``tolerance`` is of |residual|, over all d components of values (k, d) at x (k,) together.

    Returns:
        the spline, and its residuals (k, d); larger ones than the tolerance where no multiple
        is small enough.
    """
    knots = period * np.arange(intervals) / intervals
    matrix = design_matrix(knots, period, x)
    normal = (matrix.T @ matrix).tocsc()
    eye = sparse.eye_array(intervals, format="csr")
    shifted = [eye[np.roll(np.arange(intervals), -k)] for k in range(4)]
    rough = shifted[3] - 3.0 * shifted[2] + 3.0 * shifted[1] - shifted[0]
    penalty = normal.diagonal().mean() * (rough.T @ rough).tocsc()
    k, d = values.shape
    signs = np.random.default_rng(SEED).choice([-1.0, 1.0], (k, PROBES))
    right = matrix.T @ np.hstack([values, signs])

    def attempt(power: float) -> tuple[float, Array, Array]:
        """Score, coefficients and residuals; the score is infinite out of tolerance."""
        solved = _solve(normal + 10.0**power * penalty, right)
        residual = values - matrix @ solved[:, :d]
        freedom = k - np.sum(right[:, d:] * solved[:, d:]) / PROBES
        score = float(np.sum(residual**2)) / max(float(freedom), 1e-3 * k) ** 2
        near = np.max(np.hypot.reduce(residual, axis=1)) <= tolerance
        return score if near else np.inf, solved[:, :d], residual

    tried = {power: attempt(power) for power in np.arange(ROUGHEST, SMOOTHEST + 0.5)}
    for step in REFINED:
        best = min(tried, key=lambda power: (tried[power][0], power))
        for power in (best - step, best + step):
            tried[power] = attempt(power)
    best = min(tried, key=lambda power: (tried[power][0], power))
    _, coefficients, residual = tried[best]
    return PeriodicSpline(knots, period, coefficients), residual
