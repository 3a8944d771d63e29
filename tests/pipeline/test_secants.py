"""Slopes and zeros of excesses, some of which say nothing."""

from __future__ import annotations

import pytest

from synthesis.pipeline.secants import approach_zero, slope_of, zero_of

CONVEX = {1.0: 0.2, 2.0: 0.1, 3.0: 0.02, 3.4: -0.001}  # the last one next to zero


def test_the_slope_is_that_next_to_the_zero_of_excesses_that_tell_it() -> None:
    assert slope_of(CONVEX, 0.0) == pytest.approx(0.021 / 0.4)
    assert slope_of(CONVEX, 0.05) == pytest.approx(0.101 / 1.4)
    assert slope_of(CONVEX, 0.5) == pytest.approx(0.201 / 2.4)  # all too near: the farthest
    assert slope_of({1.0: 0.2}, 0.0) == 0.0


def test_a_cam_that_is_much_smaller_than_asked_says_nothing_of_the_slope() -> None:
    assert slope_of({**CONVEX, 9.0: -0.012}, 0.01) == slope_of(CONVEX, 0.01)


def test_the_zero_is_that_of_the_two_least_excesses() -> None:
    assert zero_of(CONVEX, [1.0, 2.0], 3.4) == pytest.approx(3.0)
    assert zero_of(CONVEX, [1.0], 3.4) == pytest.approx(1.0 + 2.4 * 0.2 / 0.201)
    assert zero_of(CONVEX, [], 9.0) is None


@pytest.mark.parametrize("at", [2.0, 3.9, 5.3])
def test_a_bound_with_a_kink_is_followed_to_its_zero(at: float) -> None:
    """Positive up to 4 exactly; beyond ``at`` it falls three times as fast as the slope says."""
    tried = dict[float, float]()

    def falling(x: float) -> float:
        tried[x] = 4.0 - x if at > 4.0 else (4.0 - at) - (x - at) * (3.0 if x > at else 1.0)
        return tried[x]

    assert approach_zero(falling, at, 4.0, 1e-3)
    zero = 4.0 if at > 4.0 else at + (4.0 - at) / 3.0
    assert zero - 3e-3 <= max(x for x, value in tried.items() if value > 0.0) <= zero
    assert len(tried) < 20


def test_a_bound_that_is_nowhere_positive_is_given_up_after_a_few_steps() -> None:
    tried = list[float]()

    def falling(x: float) -> float:
        tried.append(x)
        return -1.0

    assert not approach_zero(falling, 5.0, 4.0, 1e-3)
    assert not approach_zero(falling, 1e-3, 5e-4, 1e-3)
    assert len(tried) < 12
    assert min(tried) > 0.0
