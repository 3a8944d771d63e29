"""B-spline form of a piecewise polynomial: knots and control points.

A control point is the polynomial's blossom at the p knots inside its basis function's support
(Ramshaw 1987): any piece within that support gives the same point, so long as the polynomials are
as smooth at the breaks as the knots say.
"""

from __future__ import annotations

from itertools import combinations
from math import comb

import numpy as np
from numpy.typing import NDArray

from synthesis.numerics.piecewise import Array


def clamped_knots(breaks: Array, degree: int, smooth: NDArray[np.intp]) -> Array:
    """Clamped knots.

    Args:
        breaks: (n + 1,) increasing.
        smooth: (n − 1,) continuous derivatives at each inner break, 0 to degree − 1.
    """
    times = np.concatenate([[degree + 1], degree - smooth, [degree + 1]])
    return np.repeat(breaks, times)


def control_points(breaks: Array, table: Array, knots: Array) -> Array:
    """Control points (len(knots) − degree − 1, k).

    Args:
        breaks: (n + 1,). table: (n, degree + 1, k) polynomials about each piece's beginning.
        knots: as from ``knots_of``.
    """
    degree = table.shape[1] - 1
    count = len(knots) - degree - 1
    inside = np.stack([knots[j : j + count] for j in range(1, degree + 1)])
    # the piece in the middle of the support, where the blossom's arguments are least far away
    middle = 0.5 * (knots[:count] + knots[degree + 1 :])
    piece = np.clip(np.searchsorted(breaks, middle, side="right") - 1, 0, len(table) - 1)
    u = inside - breaks[piece]
    found = table[piece, 0].copy()
    for k in range(1, degree + 1):
        # elementary symmetric polynomials of the arguments
        symmetric = sum(
            np.prod(u[list(chosen)], axis=0) for chosen in combinations(range(degree), k)
        )
        found += (np.asarray(symmetric) / comb(degree, k))[:, None] * table[piece, k]
    return np.asarray(found)
