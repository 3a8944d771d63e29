"""Extremes of piecewise polynomials against numpy's roots, piece by piece."""

import numpy as np
import pytest
from numpy.polynomial import Polynomial

from synthesis.numerics.piecewise import Piecewise
from synthesis.numerics.polynomial_extrema import extreme_values, product


def by_roots(curve: Piecewise, order: int) -> tuple[float, float]:
    """Largest and smallest value: every root of every piece's own derivative, and its ends."""
    seen = []
    for low, high, origin, row in zip(
        curve.breaks[:-1], curve.breaks[1:], curve.origins, curve.poly, strict=True
    ):
        f = Polynomial(row).deriv(order) if order else Polynomial(row)
        roots = f.deriv().roots() if f.degree() > 1 else np.zeros(0)
        real = roots.real[np.abs(roots.imag) < 1e-7]
        inside = real[(real > low - origin) & (real < high - origin)]
        seen.append(f(np.concatenate([inside, [low - origin, high - origin]])))
    values = np.concatenate(seen)
    return float(values.max()), float(values.min())


@pytest.mark.parametrize("degree", [1, 2, 3, 4, 5, 8, 11])
def test_extremes_are_at_ends_or_roots(degree):
    rng = np.random.default_rng(degree)
    for _ in range(20):
        breaks = np.concatenate([[0.0], np.cumsum(rng.uniform(0.1, 1.0, 6))])
        origins = np.where(rng.random(6) < 0.5, breaks[:-1], breaks[1:])
        poly = rng.normal(size=(6, degree + 1)) * 2.0 ** rng.integers(-3, 3, degree + 1)
        poly[rng.random(6) < 0.3, degree // 2 + 1 :] = 0.0  # pieces of lower degree
        curve = Piecewise(breaks, origins, poly, np.zeros((6, 0, 3)))
        for order in range(min(3, degree)):
            (high, at), (low, below) = extreme_values(curve, order)
            expected = by_roots(curve, order)
            size = max(map(abs, expected))
            assert (high, low) == pytest.approx(expected, rel=1e-11, abs=1e-11 * size)
            either = [curve([at], order, side)[0] for side in ("left", "right")]
            assert min(abs(each - high) for each in either) <= 1e-11 * size
            either = [curve([below], order, side)[0] for side in ("left", "right")]
            assert min(abs(each - low) for each in either) <= 1e-11 * size


def test_a_product_is_that_of_its_factors():
    curve = Piecewise.of([0.0, 1.0, 2.5], [[1.0, 2.0, -3.0, 0.5], [0.2, -1.0]])
    x = np.linspace(0.0, 2.5, 41)
    assert product(curve, 1, 2)(x) == pytest.approx(curve(x, 1) * curve(x, 2), abs=1e-13)


def test_of_equal_extremes_the_first_counts():
    curve = Piecewise.of([0.0, 1.0, 2.0], [[0.0, 4.0, -4.0], [0.0, 4.0, -4.0]])
    assert extreme_values(curve) == ((1.0, 0.5), (0.0, 0.0))
