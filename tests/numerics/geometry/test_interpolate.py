"""Splines of degree 5 with given slopes at some nodes, against SciPy's and against the truth."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import BSpline, make_interp_spline

from synthesis.numerics.geometry.closed_spline import interpolate

X = np.cumsum(np.concatenate([[0.0], np.random.default_rng(7).uniform(0.1, 2.0, 12)]))
TRUTH = (
    lambda x: np.column_stack([np.sin(x), np.exp(0.3 * x)]),
    lambda x: np.column_stack([np.cos(x), 0.3 * np.exp(0.3 * x)]),
    lambda x: np.column_stack([-np.sin(x), 0.09 * np.exp(0.3 * x)]),
)
ENDS = np.stack([[each(X[:-1]), each(X[1:])] for each in TRUTH])


def test_without_given_slopes_it_is_the_interpolating_spline() -> None:
    knots, points = interpolate(X, ENDS, np.full(11, 4))
    edge = [[(k, TRUTH[k](X[[i]])[0]) for k in (1, 2)] for i in (0, -1)]
    known = make_interp_spline(X, TRUTH[0](X), k=5, bc_type=tuple(edge))
    np.testing.assert_allclose(knots, known.t, rtol=0, atol=0)
    np.testing.assert_allclose(points, known.c, rtol=0, atol=1e-11)


@pytest.mark.parametrize("order", [0, 1, 2])
@pytest.mark.parametrize("given", [[3], [3, 4, 8], [0, 10], list(range(11))], ids=str)
def test_it_has_the_slopes_that_are_given(given: list[int], order: int) -> None:
    smooth = np.full(11, 4)
    smooth[given] = order
    knots, points = interpolate(X, ENDS, smooth)
    assert len(points) == 6 + np.sum(5 - smooth)
    found = BSpline(knots, points, 5)
    np.testing.assert_allclose(found(X), TRUTH[0](X), rtol=0, atol=1e-11)
    for k in range(3):
        for side in (-1e-13, 1e-13):
            at = X[1:-1][given]
            np.testing.assert_allclose(found(at + side, k), TRUTH[k](at), rtol=0, atol=1e-10)
    # between them its third and fourth derivative do not jump
    inner = X[1:-1][smooth == 4]
    for k in (3, 4):
        before, after = found(inner - 1e-9, k), found(inner + 1e-9, k)
        np.testing.assert_allclose(before, after, rtol=0, atol=1e-5)
