"""Largest and smallest values of piecewise polynomials, from the roots of the derivative."""

from __future__ import annotations

from typing import Final

import numpy as np

from synthesis.numerics.maxima import quadratic_roots
from synthesis.numerics.piecewise import Array, Indices, Piecewise, horner

Extremum = tuple[float, float]  # value and x

EQUAL: Final = 1e-10  # relative: on a plateau values that differ by less are rounding
NEGLIGIBLE: Final = 1e-14  # of the largest term on a piece: a leading term below moves no root


def extreme_values(curve: Piecewise, order: int = 0) -> tuple[Extremum, Extremum]:
    """Largest and smallest value of f^(order) over the closed pieces, and where first.

    ``curve`` has no sinusoids. A value at a break is one-sided; on a plateau the place is its
    beginning.
    """
    poly = _trimmed(_differentiated(curve.poly, order))
    left, right = curve.breaks[:-1] - curve.origins, curve.breaks[1:] - curve.origins
    # 1. the ends of all pieces
    t, owner = np.concatenate([left, right]), np.tile(np.arange(curve.count), 2)
    value = _values(poly, owner, t)
    # 2. stationary points, of all pieces that may hold a higher or a lower value: a value inside
    #    differs from the nearer end's by at most half the width times the largest slope
    if poly.shape[1] > 2:
        slope = poly[:, 1:] * np.arange(1.0, poly.shape[1])
        reach = np.maximum(np.abs(left), np.abs(right))
        steepest = (np.abs(slope) * reach[:, None] ** np.arange(slope.shape[1])).sum(axis=1)
        both = value.reshape(2, -1)
        spread = 0.5 * (right - left) * steepest
        high, low = both.max(axis=0), both.min(axis=0)
        kept = np.flatnonzero((high + spread > high.max()) | (low - spread < low.min()))
        piece, inner = _roots(slope, kept, left, right)
        t, owner = np.concatenate([t, inner]), np.concatenate([owner, piece])
        value = np.concatenate([value, _values(poly, piece, inner)])
    x = np.clip(curve.origins[owner] + t, curve.breaks[owner], curve.breaks[owner + 1])
    found = []
    for sign in (1.0, -1.0):
        top = (sign * value).max()
        first = np.flatnonzero(sign * value >= top - EQUAL * abs(top))
        found.append((sign * float(top), float(x[first].min())))
    return found[0], found[1]


def product(curve: Piecewise, first: int, second: int) -> Piecewise:
    """f^(first) f^(second) of a piecewise polynomial, as a function of its own."""
    a, b = (_trimmed(_differentiated(curve.poly, order)) for order in (first, second))
    poly = np.zeros((curve.count, a.shape[1] + b.shape[1] - 1))
    for power in range(b.shape[1]):
        poly[:, power : power + a.shape[1]] += a * b[:, power : power + 1]
    return Piecewise(curve.breaks, curve.origins, poly, curve.waves[:, :0])


def _differentiated(poly: Array, order: int) -> Array:
    for _ in range(order):
        poly = poly[:, 1:] * np.arange(1.0, poly.shape[1])
    return poly if poly.shape[1] else np.zeros((len(poly), 1))


def _trimmed(poly: Array) -> Array:
    """Without columns of zeros behind the last one that is not."""
    used = np.flatnonzero(poly.any(axis=0))
    return poly[:, : used[-1] + 1 if len(used) else 1]


def _values(poly: Array, piece: Indices, t: Array) -> Array:
    return np.asarray(horner(poly[piece].T[::-1], t, 0)[0])


def _roots(slope: Array, kept: Indices, left: Array, right: Array) -> tuple[Indices, Array]:
    """Real roots of polynomials (n, d) inside their pieces, of the pieces ``kept``: piece and t."""
    if slope.shape[1] <= 3:
        c = np.zeros((3, len(kept)))
        c[: slope.shape[1]] = slope[kept].T
        with np.errstate(divide="ignore", invalid="ignore"):
            t = np.stack(
                quadratic_roots(c[2], c[1], c[0]) if slope.shape[1] == 3 else [-c[0] / c[1]]
            )
        owner = np.broadcast_to(kept, t.shape)
    else:
        # an eigenvalue's error counts twice in the value, whose slope vanishes there
        t, owner = _companion_roots(slope, kept, np.maximum(np.abs(left), np.abs(right)))
    inside = (t > left[owner]) & (t < right[owner])
    return owner[inside], t[inside]


def _companion_roots(slope: Array, kept: Indices, reach: Array) -> tuple[Array, Indices]:
    """Real parts of all roots near the pieces: eigenvalues of companion matrices, by degree."""
    scaled = slope[kept] * reach[kept, None] ** np.arange(slope.shape[1])  # roots in units of reach
    size = np.abs(scaled).max(axis=1)
    real = np.abs(scaled) > NEGLIGIBLE * size[:, None]
    degree = np.where(size > 0.0, real.shape[1] - 1 - real[:, ::-1].argmax(axis=1), 0)
    t, owner = [np.zeros(0)], [kept[:0]]
    for d in range(1, slope.shape[1]):
        mine = np.flatnonzero(degree == d)
        if not len(mine):
            continue
        matrix = np.zeros((len(mine), d, d))
        matrix[:, range(1, d), range(d - 1)] = 1.0
        matrix[:, :, -1] = -scaled[mine, :d] / scaled[mine, d : d + 1]
        roots = np.linalg.eigvals(matrix)
        # real parts, also of complex pairs: a double root may come out as one, and a point more
        # that is no root is compared with the others and does no harm
        near = np.abs(roots) < 1.5
        row = np.nonzero(near)[0]
        owner.append(kept[mine[row]])
        t.append(roots.real[near] * reach[owner[-1]])
    return np.concatenate(t), np.concatenate(owner)
