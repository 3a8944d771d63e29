"""Integrals and largest values from Chebyshev's points, of functions whose are known."""

import math

import numpy as np
import pytest

from synthesis.numerics.chebyshev import Grid


def test_the_integral_is_exact_to_rounding():
    grid = Grid.of(np.array([0.0, 0.3, 2.0]), 0.1)
    assert grid.weights @ np.exp(np.sin(3.0 * grid.x)) == pytest.approx(2.5693643843611, rel=1e-12)
    assert grid.weights.sum() == pytest.approx(2.0, rel=1e-14)


def test_the_highest_of_nearly_equal_peaks_is_found_between_the_points():
    """Peaks at 2πk/12, each a ten-thousandth higher than the one before: points hide that."""
    grid = Grid.of(np.array([0.0, 1.0, 2.5]), 0.3)
    shape = np.cos(12.0 * grid.x)
    values = np.stack([shape * (1.0 + 1e-4 * grid.x), shape * (1.0 - 1e-4 * grid.x)])
    interval, x = grid.highest(values, [(0, 1.0), (1, 1.0), (0, -1.0)])
    period = 2.0 * math.pi / 12.0
    expected = [4.0 * period, 0.0, 4.5 * period]
    assert x == pytest.approx(expected, abs=1e-5)
    assert np.all(grid.low[interval] <= x)
    assert np.all(x <= grid.high[interval])
