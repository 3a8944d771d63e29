"""Polynomials of a spline are those of exact arithmetic, rounded once."""

from __future__ import annotations

from fractions import Fraction
from math import factorial, nextafter

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import BSpline

from synthesis.numerics.bspline import SplineSpace
from synthesis.numerics.double_double import difference, product, quotient

FLOATS = st.floats(1e-9, 1e9) | st.floats(-1e9, -1e-9)


def exact(space: SplineSpace, coefficients: np.ndarray, i: int) -> list[Fraction]:
    """The polynomial on interval i about its left end, by de Boor's recurrence in fractions."""
    p, k = space.degree, i + space.degree
    knots = [Fraction(float(x)) for x in space.knots]
    left = Fraction(float(space.breaks[i]))
    row = [[Fraction(float(c))] for c in coefficients[k - p : k + 1]]

    def times(constant: Fraction, slope: Fraction, poly: list[Fraction]) -> list[Fraction]:
        lower, upper = [*poly, Fraction(0)], [Fraction(0), *poly]
        return [constant * a + slope * b for a, b in zip(lower, upper, strict=True)]

    for r in range(1, p + 1):
        for j in range(p, r - 1, -1):
            low, high = knots[j + k - p], knots[j + 1 + k - r]
            share, slope = (left - low) / (high - low), 1 / (high - low)
            here, there = times(share, slope, row[j]), times(1 - share, -slope, row[j - 1])
            row[j] = [a + b for a, b in zip(here, there, strict=True)]
    return row[p]


@pytest.mark.parametrize("degree", [3, 4, 5])
def test_polynomials_to_the_last_digits(degree: int) -> None:
    rng = np.random.default_rng(degree)
    breaks = np.unique([0.0, 1.0, *rng.uniform(0.01, 0.99, 17), *(0.313 + 1.01e-3 * np.arange(5))])
    space = SplineSpace(degree, breaks)
    coefficients = (
        3.0 * space.greville**2 - 2.0 * space.greville**3 + rng.normal(0, 1e-7, space.size)
    )
    found = space.curve(coefficients).poly
    true = np.array([[float(c) for c in exact(space, coefficients, i)] for i in range(len(found))])
    largest = np.abs(true).max(axis=0)
    assert np.all(np.abs(found - true) <= 4e-16 * largest)
    other = space.greville**3
    both = space.curves(np.stack([other, coefficients]))
    np.testing.assert_array_equal(both[0].poly, space.curve(other).poly)
    np.testing.assert_array_equal(both[1].poly, found)
    # plain differences keep fewer of the highest derivative, which is why these are not
    plain = BSpline(space.knots, coefficients, degree).derivative(degree)(space.breaks[:-1])
    assert np.max(np.abs(plain / factorial(degree) - true[:, -1])) > 1e-15 * largest[-1]


@given(FLOATS, FLOATS)
def test_differences_and_products_are_exact(a: float, b: float) -> None:
    x, y = np.array([a]), np.array([b])
    for (high, low), true in (
        (difference(x, y), Fraction(a) - Fraction(b)),
        (product(x, y), Fraction(a) * Fraction(b)),
    ):
        assert Fraction(float(high[0])) + Fraction(float(low[0])) == true


@given(FLOATS, FLOATS)
def test_quotients_have_thirty_digits(a: float, b: float) -> None:
    c, d = a * 1e-17, b * 1e-17
    (high,), (low,) = quotient((np.array([a]), np.array([c])), (np.array([b]), np.array([d])))
    true = (Fraction(a) + Fraction(c)) / (Fraction(b) + Fraction(d))
    assert abs(Fraction(float(high)) + Fraction(float(low)) - true) <= Fraction(1, 2**100) * abs(
        true
    )
    assert high == float(true) or nextafter(high, float(true)) == float(true)
