"""Linear programs of one matrix and many objectives: which of these need a minimum of their own."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse

from synthesis.numerics.solvers.highs import LinearRows, minimise_each
from synthesis.numerics.solvers.statuses import StopReason

ANGLES = np.linspace(0.1, 2.0 * np.pi + 0.1, 37, endpoint=False)
NORMALS = np.stack([np.cos(ANGLES), np.sin(ANGLES)], axis=1)
ROWS = LinearRows(
    sparse.csc_matrix(NORMALS), np.full(len(ANGLES), 1.7), 0, np.full(2, -9.0), np.full(2, 9.0)
)
OBJECTIVES = [np.array([np.cos(a), np.sin(a)]) for a in np.linspace(0.0, 1.5, 29)]


def test_each_minimum_and_its_multipliers_are_those_of_the_polygon() -> None:
    corners = [np.linalg.solve(NORMALS[[k - 1, k]], [1.7, 1.7]) for k in range(len(ANGLES))]
    for objective, found in zip(OBJECTIVES, minimise_each(ROWS, OBJECTIVES), strict=True):
        assert found.stopped is StopReason.SOLVED
        assert objective @ found.x == pytest.approx(min(objective @ c for c in corners))
        assert objective @ found.x == pytest.approx(-1.7 * found.multipliers.sum())
        np.testing.assert_allclose(objective + found.multipliers @ NORMALS, 0.0, atol=1e-9)


def test_an_objective_that_an_earlier_point_makes_small_enough_is_not_minimised() -> None:
    least = np.array(
        [o @ m.x for o, m in zip(OBJECTIVES, minimise_each(ROWS, OBJECTIVES), strict=True)]
    )
    for slack in (0.1, 1e-3):
        found = minimise_each(ROWS, OBJECTIVES, enough=least + slack)
        sought = [each.stopped is StopReason.SOLVED for each in found]
        assert sought[0]
        for k, (objective, each) in enumerate(zip(OBJECTIVES, found, strict=True)):
            earlier = [objective @ m.x for m, own in zip(found[:k], sought, strict=False) if own]
            small = min(earlier, default=np.inf) <= least[k] + slack
            assert sought[k] is not small
            if small:
                assert each.stopped is StopReason.NOT_NEEDED
                assert not np.any(each.multipliers)
    assert 1 < sum(sought) < len(OBJECTIVES)


def test_without_values_that_are_enough_every_objective_is_minimised() -> None:
    never = np.full(len(OBJECTIVES), -np.inf)
    for found in (minimise_each(ROWS, OBJECTIVES), minimise_each(ROWS, OBJECTIVES, enough=never)):
        assert {each.stopped for each in found} == {StopReason.SOLVED}
