"""Interpolating quintic splines, several in a row, written as polynomials piece by piece.

Between two places where slope and second derivative are known, a spline of degree 5 with four
continuous derivatives goes through all nodes. Its slopes m and second derivatives M at the inner
nodes follow from the continuity of the third and fourth derivative: with the two ends' values of a
piece of length h, and D the difference of its ends,

    f'''(0) h³ = 60 D − (36 m0 + 24 m1) h − (9 M0 − 3 M1) h²
    f'''(h) h³ = 60 D − (24 m0 + 36 m1) h − (3 M0 − 9 M1) h²
    f⁗(0) h⁴  = −360 D + (192 m0 + 168 m1) h + (36 M0 − 24 M1) h²
    f⁗(h) h⁴  =  360 D − (168 m0 + 192 m1) h − (24 M0 − 36 M1) h²
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_banded

from synthesis.numerics.piecewise import Array

BAND = 3


@dataclass(frozen=True, eq=False)
class EndDerivatives:
    """Values, slopes and second derivatives at both ends of each of n pieces, (2, n, k) each.

    The first axis is the piece's beginning and its end; k is the dimension of the values.
    """

    value: Array
    slope: Array
    second: Array


def solve_inner_nodes(
    width: Array, known: EndDerivatives, inner: NDArray[np.bool_]
) -> EndDerivatives:
    """Slopes and second derivatives at inner nodes, so that four derivatives are continuous.

    Args:
        width: (n,) positive widths of the pieces.
        known: data at the ends; what it says at inner nodes of slopes is not looked at.
        inner: (n − 1,) which nodes between neighbouring pieces are inner ones.
    """
    nodes = np.flatnonzero(inner)
    if not len(nodes):
        return known
    slope, second = known.slope.copy(), known.second.copy()
    solved = _solved(width, known, inner, nodes)
    slope[1, nodes] = slope[0, nodes + 1] = solved[0]
    second[1, nodes] = second[0, nodes + 1] = solved[1]
    return EndDerivatives(known.value, slope, second)


def _solved(
    width: Array, known: EndDerivatives, inner: NDArray[np.bool_], nodes: NDArray[np.intp]
) -> tuple[Array, Array]:
    """m and M at the inner nodes, (len(nodes), k) each."""
    a, b = width[nodes], width[nodes + 1]  # of the pieces before and behind a node
    unit = 0.5 * (a + b)  # rows and second derivatives are scaled by it
    p, q = unit / a, unit / b
    rise = known.value[1] - known.value[0]
    before, behind = rise[nodes] / a[:, None], rise[nodes + 1] / b[:, None]
    right = np.empty((len(nodes), 2, rise.shape[1]))
    right[:, 0] = _times(60.0 * q**2, behind) - _times(60.0 * p**2, before)
    right[:, 1] = -_times(360.0 * q**3, behind) - _times(360.0 * p**3, before)
    # rows: third, fourth derivative; columns: m, M·unit of the node before, itself, the next
    own = np.empty((len(nodes), 2, 2))
    own[:, 0, 0] = 36.0 * (q**2 - p**2)
    own[:, 0, 1] = 9.0 * (p + q)
    own[:, 1, 0] = -192.0 * (p**3 + q**3)
    own[:, 1, 1] = 36.0 * (p**2 - q**2)
    back = _neighbour(p, -24.0, -3.0, -168.0, -24.0)
    ahead = _neighbour(q, 24.0, -3.0, -168.0, 24.0)
    linked = np.diff(nodes) == 1
    for side, matrix, piece in ((0, back, nodes), (1, ahead, nodes + 1)):
        told = np.append(linked, False) if side else np.insert(linked, 0, False)
        data = np.stack([known.slope[side, piece], _times(unit, known.second[side, piece])], axis=1)
        right -= np.where(told[:, None, None], 0.0, np.einsum("nij,njk->nik", matrix, data))
    # the neighbour's own unknown is M times its own unit
    back[1:, :, 1] *= (unit[1:] / unit[:-1])[:, None]
    ahead[:-1, :, 1] *= (unit[:-1] / unit[1:])[:, None]
    back[1:][~linked] = 0.0
    ahead[:-1][~linked] = 0.0
    found = _banded(back, own, ahead, right)
    return found[:, 0], found[:, 1] / unit[:, None]


def _neighbour(ratio: Array, m3: float, M3: float, m4: float, M4: float) -> Array:
    """What the data of the next node contribute to the two rows of a node: (n, 2, 2)."""
    block = np.empty((len(ratio), 2, 2))
    block[:, 0, 0] = m3 * ratio**2
    block[:, 0, 1] = M3 * ratio
    block[:, 1, 0] = m4 * ratio**3
    block[:, 1, 1] = M4 * ratio**2
    return block


def _banded(back: Array, own: Array, ahead: Array, right: Array) -> Array:
    """Solve the block tridiagonal system: (n, 2, k)."""
    n = len(own)
    bands = np.zeros((2 * BAND + 1, 2 * n))
    for i in range(2):
        for j in range(2):
            row = np.arange(n) * 2 + i
            for block, column in (
                (back, row - i + j - 2),
                (own, row - i + j),
                (ahead, row - i + j + 2),
            ):
                fits = (column >= 0) & (column < 2 * n)
                bands[BAND + (row - column)[fits], column[fits]] = block[fits, i, j]
    flat = right.reshape(2 * n, -1)
    found: Array = solve_banded((BAND, BAND), bands, flat, check_finite=False)
    return found.reshape(right.shape)


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


def _times(factor: Array, rows: Array) -> Array:
    return np.asarray(factor[:, None] * rows)
