"""Interpolating quintic splines, several in a row: as polynomials, and in B-spline form.

Between two places where slope and second derivative are known, a spline of degree 5 with four
continuous derivatives goes through all nodes. Its slopes m and second derivatives M at the inner
nodes follow from the continuity of the third and fourth derivative: with the two ends' values of a
piece of length h, and D the difference of its ends,

    f'''(0) h³ = 60 D − (36 m0 + 24 m1) h − (9 M0 − 3 M1) h²
    f'''(h) h³ = 60 D − (24 m0 + 36 m1) h − (3 M0 − 9 M1) h²
    f⁗(0) h⁴  = −360 D + (192 m0 + 168 m1) h + (36 M0 − 24 M1) h²
    f⁗(h) h⁴  =  360 D − (168 m0 + 192 m1) h − (24 M0 − 36 M1) h²

A control point is the polynomial's blossom at the p knots inside its basis function's support
(Ramshaw 1987): any piece within that support gives the same point, so long as the polynomials are
as smooth at the breaks as the knots say.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from math import comb

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from synthesis.numerics.piecewise import Array, Indices, Mask

# m h, M h², f''' h³ and f⁗ h⁴ at a piece's beginning and end: of m0 h, M0 h², m1 h, M1 h², and of D
AT_START = np.array([[1, 0, 0, 0], [0, 1, 0, 0], [-36, -9, -24, 3], [192, 36, 168, -24]], float)
AT_END = np.array([[0, 0, 1, 0], [0, 0, 0, 1], [-24, -3, -36, 9], [-168, -24, -192, 36]], float)
RISE_AT_START, RISE_AT_END = np.array([[0, 0, 60, -360], [0, 0, 60, 360]], float)


@dataclass(frozen=True, eq=False)
class EndDerivatives:
    """Values, slopes and second derivatives at both ends of each of n pieces, (2, n, k) each.

    The first axis is the piece's beginning and its end; k is the dimension of the values.
    """

    value: Array
    slope: Array
    second: Array


def solve_inner_nodes(width: Array, known: EndDerivatives, inner: Mask) -> EndDerivatives:
    """Slopes and second derivatives at inner nodes, so that four derivatives are continuous.

    Args:
        width: (n,) positive widths of the pieces.
        known: data at the ends; what it says at inner nodes of slopes is not looked at.
        inner: (n − 1,) which nodes between neighbouring pieces are inner ones.
    """
    nodes = np.flatnonzero(inner)
    if not len(nodes):
        return known
    n, dimension = known.value.shape[1:]
    # 1. unknowns: m0 h, M0 h², m1 h, M1 h² of piece after piece; those not at inner nodes are known
    scale = np.column_stack([width, width**2, width, width**2])[..., None]
    data = np.stack([known.slope[0], known.second[0], known.slope[1], known.second[1]], axis=1)
    fixed = np.ones((n, 4), dtype=bool)
    fixed[nodes, 2:] = fixed[nodes + 1, :2] = False
    # 2. four continuous derivatives at each inner node, in units of the mean width beside it
    order, rise = np.arange(1, 5), known.value[1] - known.value[0]
    unit = 0.5 * (width[nodes] + width[nodes + 1])
    before, after = ((unit / width[i])[:, None] ** order for i in (nodes, nodes + 1))
    jumps = np.concatenate(
        [before[..., None] * AT_END, -after[..., None] * AT_START], axis=2
    )  # fmt: skip
    right = (after * RISE_AT_START)[..., None] * rise[nodes + 1, None]
    right -= (before * RISE_AT_END)[..., None] * rise[nodes, None]
    # 3. one sparse system, and one step of iterative refinement against elimination's roundings
    row = np.broadcast_to(np.arange(4 * len(nodes)).reshape(-1, 4, 1), jumps.shape)
    column = np.broadcast_to((4 * nodes)[:, None, None] + np.arange(8), jumps.shape)
    continuity = sparse.coo_array(
        (jumps.ravel(), (row.ravel(), column.ravel())), shape=(4 * len(nodes), 4 * n)
    )
    given = sparse.eye_array(4 * n, format="csr")[fixed.ravel()]
    matrix = sparse.vstack([given, continuity], format="csc")
    rhs = np.concatenate([(data * scale)[fixed], right.reshape(-1, dimension)])
    factors = splu(matrix)
    found = factors.solve(rhs)
    found = (found + factors.solve(rhs - matrix @ found)).reshape(n, 4, dimension) / scale
    slope, second = (np.stack([found[:, k], found[:, k + 2]]) for k in (0, 1))
    return EndDerivatives(known.value, slope, second)


def to_polynomials(width: Array, ends: EndDerivatives) -> Array:
    """Polynomials about each piece's beginning: (n, 6, k), constant first."""
    h = width[:, None]
    rise = ends.value[1] - ends.value[0]
    (m0, m1), (s0, s1) = ends.slope * h, ends.second * h**2
    table = np.stack(
        [
            ends.value[0],
            m0,
            0.5 * s0,
            0.5 * (20.0 * rise - 8.0 * m1 - 12.0 * m0 - 3.0 * s0 + s1),
            0.5 * (-30.0 * rise + 14.0 * m1 + 16.0 * m0 + 3.0 * s0 - 2.0 * s1),
            0.5 * (12.0 * rise - 6.0 * (m1 + m0) - s0 + s1),
        ],
        axis=1,
    )
    return np.asarray(table / width[:, None, None] ** np.arange(6)[:, None])


def clamped_knots(breaks: Array, degree: int, smooth: Indices) -> Array:
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
        knots: as from ``clamped_knots``.
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
