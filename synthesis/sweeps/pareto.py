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
    order = np.lexsort(costs.T[::-1])
    front: list[int] = []
    kept = np.empty_like(costs)  # its first rows are the front so far
    for index in order:  # whoever beats a row comes before it in this order
        row, so_far = costs[index], kept[: len(front)]
        beaten = np.all(so_far <= row, axis=1) & np.any(so_far < row, axis=1)
        if not beaten.any():
            kept[len(front)] = row
            front.append(int(index))
    return np.array(front, dtype=np.intp)
