"""Largest values of combinations of derivatives, against a dense look and against roots."""

import numpy as np
import pytest
from numpy.polynomial import Polynomial

from synthesis.numerics.maxima import maximise
from synthesis.numerics.piecewise import Piecewise


def polynomials(size: int, seed: int) -> tuple[Piecewise, tuple[float, ...]]:
    """Three pieces of one degree, written about either end, and weights of some derivatives."""
    rng = np.random.default_rng(seed)
    breaks = np.cumsum(rng.uniform(0.1, 1.7, 4)) - 1.3
    origins = [breaks[i + end] for i, end in enumerate(rng.integers(0, 2, 3))]
    weights = rng.uniform(-1.5, 1.5, 4) * (rng.random(4) < 0.6)
    curve = Piecewise.of(breaks, rng.uniform(-3.0, 3.0, (3, size)), origins=origins)
    return curve, tuple(weights.tolist())


def largest(curve: Piecewise, weights: tuple[float, ...]) -> float:
    """From the roots of the derivative, piece by piece."""
    found = []
    for i in range(curve.count):
        f = Polynomial(curve.poly[i])
        g = sum((c * f.deriv(k) if k else c * f for k, c in enumerate(weights)), Polynomial([0.0]))
        low, high = curve.breaks[i] - curve.origins[i], curve.breaks[i + 1] - curve.origins[i]
        roots = g.deriv().roots()
        inside = [r.real for r in roots if abs(r.imag) < 1e-9 and low < r.real < high]
        found += [float(g(t)) for t in (low, high, *inside)]
    return max(found)


@pytest.mark.parametrize("size", range(1, 8))
@pytest.mark.parametrize("seed", range(12))
def test_of_polynomials(size: int, seed: int) -> None:
    curve, weights = polynomials(size, seed)
    value, x = maximise(curve, weights)
    scale = sum(abs(c) for c in weights) * float(np.max(np.abs(curve.poly))) * 10.0
    assert value == pytest.approx(largest(curve, weights), abs=1e-12 * scale)
    there = [
        sum(c * curve.at(np.array([x]), np.array([i]), k)[0] for k, c in enumerate(weights))
        for i in range(curve.count)
        if curve.breaks[i] <= x <= curve.breaks[i + 1]
    ]
    assert there
    assert min(abs(np.array(there) - value)) <= 1e-12 * max(scale, 1e-300)


def test_inside_a_piece_and_not_where_the_cubic_goes_on() -> None:
    hill = Piecewise.of([0.0, 1.0], [[0.0, 1.0, 0.0, -1.0]])  # largest at 1/√3, rises again below 0
    assert maximise(hill, (1.0,)) == pytest.approx((2.0 / 27.0**0.5, 1.0 / 3.0**0.5), rel=1e-14)
    assert maximise(hill, (-1.0,)) == (0.0, 0.0)


def test_with_waves() -> None:
    curve = Piecewise.of([0.0, 2.0, 5.0], [[0.3, 0.1], [0.0]], [[(1.7, 3.1, 0.2)], [(0.9, 7.3, 1)]])
    x = np.linspace(0.0, 5.0, 2_000_001)
    dense = 0.4 * curve(x) - 1.1 * curve(x, 1)
    assert maximise(curve, (0.4, -1.1))[0] == pytest.approx(float(dense.max()), abs=1e-9)


def test_a_function_that_stands_still() -> None:
    curve = Piecewise.of([0.3, 1.1, 2.0], [[7.3], [7.9]])
    rows = [(-0.4, 3.0, 0.0, 1.0), (0.9, 0.0, 2.0, 0.0), (0.0, 1.0, 0.0, 0.0)]
    wanted = [maximise(curve, row)[0] for row in rows]
    np.testing.assert_allclose(wanted, [-0.4 * 7.3, 0.9 * 7.9, 0.0], rtol=1e-15)
