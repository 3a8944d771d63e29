"""Polytopes in the unit box, and descent on functions with kinks."""

from __future__ import annotations

import numpy as np
import pytest

from synthesis.numerics.polytope import BundlePoint, Polytope, minimise, minimise_linear

TIED = Polytope(np.array([[1.3, 0.7, 2.1, 0.0], [0.0, 1.1, -0.4, 0.9]]), np.array([1.9, 0.8]))
OPEN = Polytope(np.zeros((0, 3)), np.zeros(0))
EMPTY = Polytope(np.array([[1.0, 1.0]]), np.array([2.3]))


def test_the_centre_is_inside_and_on_the_equations() -> None:
    centre = TIED.centre()
    assert centre is not None
    np.testing.assert_allclose(TIED.matrix @ centre, TIED.rhs, rtol=0.0, atol=1e-15)
    assert 0.1 < centre.min() <= centre.max() < 0.9
    assert OPEN.centre() == pytest.approx([0.5] * 3)
    assert EMPTY.centre() is None


def test_directions_keep_the_equations() -> None:
    assert TIED.directions.shape == (4, 2)
    np.testing.assert_allclose(TIED.matrix @ TIED.directions, 0.0, atol=1e-15)
    np.testing.assert_allclose(TIED.directions.T @ TIED.directions, np.eye(2), atol=1e-15)
    repeated = Polytope(np.vstack([TIED.matrix, TIED.matrix[:1] * 2.0]), np.array([1.9, 0.8, 3.8]))
    assert repeated.directions.shape == (4, 2)
    assert OPEN.directions.shape == (3, 3)


def test_corners_are_corners_and_the_same_every_time() -> None:
    first, again = TIED.corners(7), TIED.corners(7)
    for corner, same in zip(first, again, strict=True):
        assert corner.tolist() == same.tolist()
        np.testing.assert_allclose(TIED.matrix @ corner, TIED.rhs, atol=1e-14)
        assert np.sum((np.abs(corner) < 1e-9) | (np.abs(corner - 1.0) < 1e-9)) >= 2
    assert len({tuple(np.round(corner, 6)) for corner in first}) > 2


def test_nothing_is_least_where_nothing_is() -> None:
    nothing = (np.zeros((0, 2)), np.zeros(0))
    found = minimise_linear(np.ones(2), nothing, (EMPTY.matrix, EMPTY.rhs), [(0.0, 1.0)] * 2)
    assert found is None


def started(function, polytope: Polytope) -> BundlePoint:
    centre = polytope.centre()
    return BundlePoint(centre, function(centre))


def test_a_kink_in_every_direction_is_found() -> None:
    """max h_i/β_i² with Σ β_i = 1: β_i ~ √h_i, all three equal there."""
    h = np.array([0.37, 1.9, 1.21])
    shares = Polytope(np.ones((1, 3)), np.ones(1))

    def worst(u: np.ndarray) -> float:
        return float(np.max(h / np.maximum(u, 1e-9) ** 2))

    found = minimise(worst, shares, started(worst, shares), 0.15, 40)
    expected = np.sqrt(h) / np.sqrt(h).sum()
    assert found.u == pytest.approx(expected, abs=3e-4)
    assert found.value == pytest.approx(float(np.sqrt(h).sum() ** 2), rel=1e-3)


def test_a_smooth_valley_is_found_too() -> None:
    target = np.array([0.31, 0.62, 0.44])

    def bowl(u: np.ndarray) -> float:
        d = u - target
        return float(1.0 + d @ d + 0.7 * d[0] * d[1])

    found = minimise(bowl, OPEN, started(bowl, OPEN), 0.2, 60)
    assert found.u == pytest.approx(target, abs=5e-3)


def test_the_box_is_not_left_and_its_side_may_be_best() -> None:
    seen: list[np.ndarray] = []

    def slope(u: np.ndarray) -> float:
        seen.append(u)
        return float(3.0 - u[0] + 0.2 * u[1])

    found = minimise(slope, OPEN, started(slope, OPEN), 0.3, 30)
    assert found.u[:2] == pytest.approx([1.0, 0.0], abs=1e-6)
    assert np.array(seen).min() >= -1e-12
    assert np.array(seen).max() <= 1.0 + 1e-12


def test_where_there_is_no_value_it_does_not_go() -> None:
    """A disc without values lies on the way."""

    def value(u: np.ndarray) -> float | None:
        return None if np.hypot(u[0] - 0.75, u[1] - 0.5) < 0.1 else float(2.0 - u[0])

    found = minimise(value, OPEN, started(value, OPEN), 0.2, 60)
    assert value(found.u) is not None
    assert found.value < 2.0 - 0.5


def test_without_a_direction_the_start_is_the_answer() -> None:
    point = Polytope(np.eye(2), np.array([0.3, 0.4]))
    start = BundlePoint(np.array([0.3, 0.4]), 7.0)
    assert minimise(lambda u: 0.0, point, start, 0.1, 5) is start


def test_from_near_a_maximum_down_to_the_minimum() -> None:
    """Concave there, it lies below its tangents: these may not cut off what is known."""

    def wave(u: np.ndarray) -> float:
        return float(2.0 + np.cos(6.0 * u[0]) + 0.3 * np.cos(5.0 * u[1]) + 0.1 * u[2])

    start = np.array([0.04, 0.07, 0.8])
    found = minimise(wave, OPEN, BundlePoint(start, wave(start)), 0.12, 60)
    assert found.u[:2] == pytest.approx([np.pi / 6.0, np.pi / 5.0], abs=4e-3)
    assert found.u[2] == pytest.approx(0.0, abs=1e-6)
