"""Pareto front: the non-dominated designs among many, and those of them that differ noticeably."""

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


def distinct_front(costs: Array, at_best: Array) -> Indices:
    """Indices of non-dominated rows of which none is a small difference from another.

    A row *covers* another where its cost at best is not above the other's cost in any column: the
    other is not better by more than what does not count. Of the non-dominated rows as few as the
    rule below finds are kept, so that each is covered by one of them. Where nothing is left out
    of account (``at_best`` equals ``costs``) these are all.

    Args:
        costs: (n, k), to be minimised. at_best: (n, k), not above the costs: these less the
            difference that does not count.

    Returns:
        indices (m,), in the order of ``non_dominated``; equal rows stay together.
    """
    strict = non_dominated(costs)
    costs, at_best = costs[strict], at_best[strict]
    kept = np.zeros(len(strict), dtype=bool)
    left = np.ones(len(strict), dtype=bool)
    while left.any():
        # The first row left has the smallest first cost of those left. Of the rows that cover it
        # the one that covers most of the others is kept: of two costs that is the farthest along
        # the front, so that no fewer would do.
        first = int(np.argmax(left))
        candidates = np.flatnonzero(np.all(at_best <= costs[first], axis=1))
        covers = np.all(at_best[candidates, None] <= costs[None, left], axis=2)
        best = candidates[int(np.argmax(covers.sum(axis=1)))]
        kept |= np.all(costs == costs[best], axis=1)
        left &= ~np.all(at_best[best] <= costs, axis=1)
    return strict[kept]
