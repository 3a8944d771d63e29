"""Pareto front: the non-dominated designs among many."""

from __future__ import annotations

import numpy as np

from synthesis.numerics.piecewise import Array, Indices


def non_dominated(costs: Array) -> Indices:
    """Indices of the rows that no other row dominates (as small in all columns, smaller in one).

    Rows equal in all columns do not dominate each other: all of them stay. The ``costs`` (n, k) are
    to be minimised; indices (m,) are in ascending order of the first column, then the next ones.
    """
    # sorted by the first column, then the next
    distinct, kind = np.unique(costs, axis=0, return_inverse=True)
    on_front = np.zeros(len(distinct), dtype=bool)
    front = np.empty_like(distinct[:, 1:])  # first column omitted: later rows are not smaller there
    size = 0
    for index, row in enumerate(distinct[:, 1:]):  # a dominating row comes before
        if not np.all(front[:size] <= row, axis=1).any():
            front[size], on_front[index] = row, True
            size += 1
    chosen = np.flatnonzero(on_front[kind.ravel()])
    return chosen[np.argsort(kind.ravel()[chosen], kind="stable")]
