"""Slopes and zeros of excesses, some of which say nothing."""

from __future__ import annotations

from collections.abc import Callable
from math import inf

import numpy as np
import pytest

from synthesis.pipeline.secants import SecantBracket, approach_zero, slope_of, zero_of

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


GAP = 2e-5  # between a cam's excess and its bound's, in all of these trials
SHAPES: dict[str, Callable[[float], float]] = {
    "straight": lambda x: 0.4 * (1.0 - x),
    "steeper at first": lambda x: 0.4 * (1.0 - x) * (2.0 - min(x, 1.5)),
    "flat at first": lambda x: 0.4 - max(x - 0.6, 0.0),
    "an infimum of 0 from there on": lambda x: max(0.4 - 0.4 * x**3, -0.98),
    "a kink at the zero, steeper before": lambda x: (3.0 if x < 1.0 else 0.03) * (1.0 - x),
    "a kink at the zero, steeper beyond": lambda x: (0.03 if x < 1.0 else 3.0) * (1.0 - x),
    "next to nothing, then a fall": lambda x: 0.05 - 0.01 * x - 2.0 * max(x - 0.9, 0.0),
}  # fmt: skip


def trials(shape: str, first: float) -> int:
    """How many a bracket takes whose far end is at ``first``, each cam anywhere in its gap."""
    falling, random = SHAPES[shape], np.random.default_rng(11)
    bad, good, width, number = 0.0, first, 2.5e-4, 0
    search = SecantBracket((falling(0.0) - falling(first)) / first, 1e-4)
    search.zero = search.zero_from(first, falling(first))
    while good - bad > 2.0 * max(width, search.open_way) and number < 30:
        way, exactly = search.next_way(bad, good, width)
        assert bad <= way <= good
        number += 1
        excess = falling(way) + GAP * random.uniform(0.0, 1.0)
        bound = excess - GAP
        if not exactly and excess <= 0.0:
            excess *= 0.5  # any cam that is small enough ends it
        good = min(good, way) if excess <= 0.0 else good
        bad = max(bad, way) if bound > 0.0 else bad
        search.learn(
            way, excess, bound, certified=excess <= 0.0, exactly=exactly, slope=0.1, noise=2.0 * GAP
        )
        if exactly:
            search.has_proof |= bound > 0.0
    assert falling(bad) >= 0.0 >= falling(good)
    return number


def test_cam_and_proof_come_next_to_the_zero_in_few_trials() -> None:
    """Whatever the first slope is, and wherever in its gap a trial's cam lies."""
    numbers = [trials(shape, first) for shape in SHAPES for first in (1.04, 1.9, 7.3)]
    assert max(numbers) <= 16
    assert sum(numbers) <= 166


def test_a_slope_that_leads_back_to_the_request_halves_the_bracket() -> None:
    assert SecantBracket(0.5, 1e-3, zero=-3.0).next_way(0.2, 2.0, 0.01) == (1.1, True)
    assert SecantBracket(0.5, 1e-3, zero=9.0).next_way(0.2, 2.0, 0.01)[0] == pytest.approx(1.994)


def test_a_gap_leaves_as_much_of_the_way_as_the_steeper_slope_says() -> None:
    """A slope of 0.01 on a flat part, one of 2 from there to the zero."""
    search = SecantBracket(0.01, 1e-3)
    assert search.open_way == 0.0
    search.learn(1.0, -0.16, -0.161, certified=True, exactly=True, slope=0.1, noise=1e-5)
    assert search.open_way == pytest.approx(1e-3 / 0.01)
    search.learn(0.92, 8e-3, 7e-3, certified=False, exactly=True, slope=0.1, noise=1.0)
    assert search.open_way == pytest.approx(1e-3 / 2.1)
    search.learn(0.9, 9e-3, None, certified=False, exactly=True, slope=0.1, noise=1.0)
    assert search.open_way == pytest.approx(1e-3 / 2.1)  # nearer ones are known


def test_any_cam_may_bring_the_far_end_near_once_then_it_is_the_smallest() -> None:
    search = SecantBracket(0.5, 1e-3, zero=1.0, has_proof=True)
    assert search.next_way(0.9, 3.0, 0.01) == (pytest.approx(1.005), False)
    assert search.next_way(0.9, 1.7, 0.01) == (pytest.approx(1.005), True)


def test_a_proof_is_sought_ever_farther_as_long_as_no_bound_is_known() -> None:
    search, ways = SecantBracket(0.5, 1e-3, zero=1.0), list[float]()
    for _ in range(3):
        ways.append(1.0 - search.next_way(0.0, 3.0, 0.0)[0])
        search.halved_above = inf  # as if the bracket had become half as wide
    assert ways == pytest.approx([1.3e-3, 5.2e-3, 2.08e-2])
    search.gap = 1e-3
    assert search.next_way(0.0, 3.0, 0.0)[0] == pytest.approx(1.0 - 2.6e-3)


def test_a_trial_without_an_excess_is_a_cam_or_nothing() -> None:
    search = SecantBracket(0.5, 1e-3, zero=3.0)
    search.learn(2.0, None, certified=False, exactly=True, slope=9.0, noise=0.0)
    assert (search.zero, search.slope) == (3.0, 0.5)
    search.learn(2.0, None, certified=True, exactly=True, slope=9.0, noise=0.0)
    assert search.zero == 2.0
    search.learn(2.5, 0.25, certified=False, exactly=False, slope=9.0, noise=0.0)
    assert search.zero == 2.0  # a search for any cam ends anywhere
    search.learn(1.5, 0.05, certified=False, exactly=True, slope=9.0, noise=0.0)
    assert search.zero == pytest.approx(1.6)


def test_the_slope_is_that_of_two_exact_trials_that_differ_by_more_than_noise() -> None:
    search = SecantBracket(0.0, 1e-3)
    search.learn(1.0, 0.4, certified=False, exactly=True, slope=0.3, noise=0.01)
    assert search.slope == 0.3
    search.learn(2.0, 0.2, certified=False, exactly=False, slope=0.1, noise=0.01)
    assert search.slope == 0.3
    search.learn(1.1, 0.395, certified=False, exactly=True, slope=0.1, noise=0.01)
    assert search.slope == 0.3
    search.learn(1.2, 0.32, certified=False, exactly=True, slope=0.1, noise=0.01)
    assert search.slope == pytest.approx(0.75)
    search.learn(1.7, 0.34, certified=False, exactly=True, slope=0.1, noise=0.01)
    assert search.slope == 0.1  # it does not rise
    search.learn(1.7, 0.38, certified=False, exactly=True, slope=0.2, noise=0.01)
    assert search.slope == 0.1  # the same way twice
