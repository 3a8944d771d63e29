"""Quintic splines against SciPy's, and their B-spline form."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import BSpline, PPoly, make_interp_spline

from synthesis.numerics.quintic_spline import (
    EndDerivatives,
    clamped_knots,
    control_points,
    solve_inner_nodes,
    to_polynomials,
)

X = np.cumsum(np.concatenate([[0.0], np.random.default_rng(7).uniform(0.1, 2.0, 12)]))
TRUTH = (
    lambda x: np.column_stack([np.sin(x), np.exp(0.3 * x)]),
    lambda x: np.column_stack([np.cos(x), 0.3 * np.exp(0.3 * x)]),
    lambda x: np.column_stack([-np.sin(x), 0.09 * np.exp(0.3 * x)]),
)


def spline(inner: np.ndarray) -> np.ndarray:
    both = [np.stack([each(X[:-1]), each(X[1:])]) for each in TRUTH]
    both[1][:, 1:-1][:, inner[1:] & inner[:-1]] = np.nan  # what is unknown is not looked at
    ends = solve_inner_nodes(np.diff(X), EndDerivatives(*both), inner)
    return to_polynomials(np.diff(X), ends)


def test_it_is_the_interpolating_spline_of_degree_five() -> None:
    table = spline(np.ones(11, bool))
    edge = [[(k, TRUTH[k](X[[i]])[0]) for k in (1, 2)] for i in (0, -1)]
    known = make_interp_spline(X, TRUTH[0](X), k=5, bc_type=tuple(edge))
    x = np.linspace(X[0], X[-1], 777)
    np.testing.assert_allclose(
        PPoly(np.moveaxis(table, 1, 0)[::-1], X)(x), known(x), rtol=0, atol=1e-12
    )
    knots = clamped_knots(X, 5, np.full(11, 4))
    np.testing.assert_allclose(knots, known.t, rtol=0, atol=0)
    np.testing.assert_allclose(control_points(X, table, knots), known.c, rtol=0, atol=1e-11)


@pytest.mark.parametrize("given", [[3], [3, 4, 8], [0, 10], list(range(11))], ids=str)
def test_where_slopes_are_given_it_has_them_and_control_points_follow(given: list[int]) -> None:
    inner = np.ones(11, bool)
    inner[given] = False
    table = spline(inner)
    pieces = PPoly(np.moveaxis(table, 1, 0)[::-1], X)
    for k in range(3):
        found = pieces(X[1:-1][given], k)
        np.testing.assert_allclose(found, TRUTH[k](X[1:-1][given]), rtol=0, atol=1e-11)
    smooth = np.where(inner, 4, 2)
    knots = clamped_knots(X, 5, smooth)
    points = control_points(X, table, knots)
    assert len(points) == 6 + np.sum(5 - smooth)
    x = np.linspace(X[0], X[-1], 777)
    np.testing.assert_allclose(BSpline(knots, points, 5)(x), pieces(x), rtol=0, atol=1e-12)
