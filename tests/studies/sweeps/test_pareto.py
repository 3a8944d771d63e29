"""The front against its definition, pair by pair."""

from __future__ import annotations

import numpy as np
import pytest

from synthesis.studies.sweeps.pareto import non_dominated


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
