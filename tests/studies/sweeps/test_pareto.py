"""The front against its definition, pair by pair."""

from __future__ import annotations

import numpy as np
import pytest

from synthesis.studies.sweeps.pareto import distinct_front, non_dominated


def by_definition(costs: np.ndarray) -> set[int]:
    """Rows that no row beats, by looking at every pair."""
    return {
        i
        for i, row in enumerate(costs)
        if not any(np.all(other <= row) and np.any(other < row) for other in costs)
    }


@pytest.mark.parametrize("columns", [1, 2, 3, 5])
def test_the_front_is_what_its_definition_says(columns: int) -> None:
    random = np.random.default_rng(columns)
    for rows, digits in ((0, 2), (1, 2), (37, 1), (203, 1), (151, 4)):
        costs = np.round(random.normal(size=(rows, columns)), digits)  # few digits: equal rows
        front = non_dominated(costs)
        assert set(front) == by_definition(costs)
        assert len(set(front)) == len(front)
        assert list(costs[front, 0]) == sorted(costs[front, 0])


def test_equal_rows_stay_together() -> None:
    costs = np.array([[2.0, 1.0], [1.0, 2.0], [2.0, 1.0], [2.0, 2.0]])
    assert set(non_dominated(costs)) == {0, 1, 2}


@pytest.mark.parametrize("columns", [1, 2, 4])
def test_what_is_left_of_a_front_covers_all_of_it(columns: int) -> None:
    random = np.random.default_rng(columns)
    for rows, share in ((0, 0.1), (40, 0.0), (40, 0.02), (200, 0.1)):
        costs = np.round(1.0 + random.random(size=(rows, columns)), 2)
        at_best = costs * (1.0 - share)
        strict, kept = non_dominated(costs), distinct_front(costs, at_best)
        assert set(kept) <= set(strict)
        assert share > 0.0 or list(kept) == list(strict)
        for row in costs[strict]:
            assert np.all(at_best[kept] <= row, axis=1).any()


def test_differences_that_do_not_count_are_no_front() -> None:
    """Radii that differ by half a per mille, bought with ever more acceleration."""
    radius, acceleration = np.linspace(36.23, 36.21, 9), np.linspace(10.0, 20.0, 9)
    costs = np.stack([acceleration, radius], axis=1)
    at_best = costs * [1.0, 1.0 - 5e-3]
    assert len(non_dominated(costs)) == 9
    assert list(distinct_front(costs, at_best)) == [0]
    # a step that counts is one; what is nearly as good in the first cost and better in the second
    # stands for both
    costs = np.array([[10.0, 36.2], [10.001, 35.0], [20.0, 30.0]])
    assert list(distinct_front(costs, costs * 0.995)) == [1, 2]
