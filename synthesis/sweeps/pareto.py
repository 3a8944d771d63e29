"""The non-dominated ones among many designs."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def non_dominated(costs: NDArray[np.float64]) -> NDArray[np.intp]:
    """Which rows no other row beats: none is as small in every column and smaller in one.

    Rows equal in every column do not beat each other: all of them stay.

    Args:
        costs: (n, k), what is to be small in each column.

    Returns:
        (m,) indices of the front, in ascending order of the first column, then the next ones.
    """
    distinct, kind = np.unique(costs, axis=0, return_inverse=True)  # in that order already
    on_front = np.zeros(len(distinct), dtype=bool)
    front = np.empty_like(distinct[:, 1:])  # without the first column: none has a smaller one there
    size = 0
    for index, row in enumerate(distinct[:, 1:]):  # whoever beats a row comes before it
        if not np.all(front[:size] <= row, axis=1).any():
            front[size], on_front[index] = row, True
            size += 1
    chosen = np.flatnonzero(on_front[kind.ravel()])
    return chosen[np.argsort(kind.ravel()[chosen], kind="stable")]
