"""Linear programs: what a stated accuracy means."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse

from synthesis.numerics.solvers.highs import LinearRows, minimise_each
from synthesis.numerics.solvers.statuses import StopReason

ACCURACY = 1e-10


@pytest.mark.parametrize("seed", [3, 7, 11, 13])
def test_rows_hold_as_they_are_written_whatever_their_scale(seed: int) -> None:
    """Rows from 1e-5 to 1e5 in one program: none is exceeded by more than its rounding."""
    random, n, m = np.random.default_rng(seed), 60, 200
    scale = 10.0 ** random.uniform(-5.0, 5.0, m)
    matrix = random.normal(size=(m, n)) * (random.random((m, n)) < 0.2) * scale[:, None]
    inside = random.normal(size=n)
    most = matrix @ inside + 0.1 * np.abs(matrix).sum(axis=1) * random.uniform(0.0, 1.0, m)
    cost = -(matrix.T @ random.uniform(0.0, 1.0, m)) / np.abs(matrix).max()
    rows = LinearRows(sparse.csc_matrix(matrix), most, 0, np.full(n, -100.0), np.full(n, 100.0))
    (found,) = minimise_each(rows, [cost], accuracy=ACCURACY)
    assert found.stopped is StopReason.SOLVED
    rounding = 1e-15 * (np.abs(matrix) @ np.abs(found.x))
    assert np.max(matrix @ found.x - most - rounding) <= 3.0 * ACCURACY  # of HiGHS's own sums
