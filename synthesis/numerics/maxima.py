"""Largest value of a linear combination of a function's derivatives, found in floating point.

Fast and accurate to rounding, but a finding, not a proof: proofs are the certificate's business.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import accumulate
from math import perm

import numpy as np

from synthesis.numerics.piecewise import Array, Indices, Piecewise


def maximise(curve: Piecewise, coefficients: Sequence[float]) -> tuple[float, float]:
    """Largest value of Σ_k coefficients[k] f^(k) over the closed pieces, and where.

    Returns:
        value and x.
    """
    weights = [(k, c) for k, c in enumerate(coefficients) if c != 0.0]
    if not weights:
        return 0.0, float(curve.breaks[0])
    if not curve.waves.shape[1]:
        curve, weights = curve.combine_derivatives(coefficients), [(0, 1.0)]
        if curve.poly.shape[1] <= 4:
            return _of_cubics(curve)

    def combined(x: Array, piece: Indices) -> Array:
        f = curve.jet(x.ravel(), np.repeat(piece, x.shape[1]), weights[-1][0])
        return np.asarray(sum(c * f[k] for k, c in weights)).reshape(x.shape)

    return maximise_between(combined, curve.breaks[:-1], curve.breaks[1:])


def _of_cubics(curve: Piecewise) -> tuple[float, float]:
    """The same of polynomials up to the third degree, whose stationary points have a formula."""
    left, right = curve.breaks[:-1] - curve.origins, curve.breaks[1:] - curve.origins
    columns = np.zeros((4, curve.count))
    columns[: curve.poly.shape[1]] = curve.poly.T
    t, value = _candidates(columns, left, right)
    k, i = np.unravel_index(np.argmax(value), value.shape)
    x = min(max(curve.origins[i] + t[k, i], curve.breaks[i]), curve.breaks[i + 1])
    return float(value[k, i]), float(x)


def maximise_all(
    asked: Sequence[tuple[Piecewise, Sequence[Sequence[float]]]],
) -> list[Array]:
    """The largest values of several combinations of each of several functions.

    As ``maximise`` finds them; polynomials up to the third degree are worked out together.

    Args:
        asked: functions, each with (k, 4) coefficients.

    Returns:
        (k,) for every function.
    """
    cubics = [each for each in asked if _cubic(each[0])]
    known = iter(_summits(cubics))
    return [
        next(known)
        if _cubic(curve)
        else np.array([maximise(curve, each)[0] for each in coefficients])
        for curve, coefficients in asked
    ]


def _cubic(curve: Piecewise) -> bool:
    return curve.poly.shape[1] <= 4 and not curve.waves.shape[1]


def _summits(asked: Sequence[tuple[Piecewise, Sequence[Sequence[float]]]]) -> list[Array]:
    """``maximise_all`` of polynomials up to the third degree."""
    if not asked:
        return []
    first = list(accumulate((len(rows) * curve.count for curve, rows in asked), initial=0))
    columns, ends = np.zeros((4, first[-1])), np.empty((2, first[-1]))
    for (curve, rows), low, high in zip(asked, first, first[1:], strict=False):
        degree, shape = curve.poly.shape[1], (len(rows), curve.count)
        mixed = (np.array(rows) @ _RAISED).reshape(-1, 4, 4)[:, :degree, :degree]
        columns[:degree, low:high] = (curve.poly @ mixed).reshape(-1, degree).T
        ends[0, low:high].reshape(shape)[:] = curve.breaks[:-1] - curve.origins
        ends[1, low:high].reshape(shape)[:] = curve.breaks[1:] - curve.origins
    _, value = _candidates(columns, *ends)
    each = [
        low + curve.count * k
        for (curve, rows), low in zip(asked, first, strict=False)
        for k in range(len(rows))
    ]
    tops = np.maximum.reduceat(value.max(axis=0), each)
    return np.split(tops, np.cumsum([len(rows) for _, rows in asked[:-1]]))


# coefficients of a cubic to those of its derivatives, one after the other: (4, 4 · 4)
_RAISED = np.array(
    [[[perm(j, m) if j == i + m else 0 for i in range(4)] for j in range(4)] for m in range(4)],
    dtype=float,
).reshape(4, 16)


def _candidates(columns: Array, left: Array, right: Array) -> tuple[Array, Array]:
    """Ends and stationary points of cubics (4, n), constant first, with values: (4, n) both."""
    c0, c1, c2, c3 = columns
    t = np.empty_like(columns)
    t[0], t[1] = left, right
    t[2], t[3] = quadratic_roots(3.0 * c3, 2.0 * c2, c1)
    t = np.fmin(np.fmax(t, left), right)  # of what is no number, an end
    return t, c0 + t * (c1 + t * (c2 + t * c3))


def quadratic_roots(a: Array, b: Array, c: Array) -> tuple[Array, Array]:
    """Real roots of a x² + b x + c, nan where there is none; stable for small a."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        root = np.sqrt(b * b - 4.0 * a * c)
        half = -0.5 * (b + np.where(b < 0.0, -1.0, 1.0) * root)
        return half / a, c / half


SAMPLES = 33  # on an interval
FAN = np.linspace(-1.0, 1.0, 17)  # places about the highest sample, in steps between samples
ZOOMS = 4  # each narrows the place of a peak eightfold; then a parabola is exact to rounding


def maximise_formula(curve: Piecewise, formula: Callable[[Array], Array], highest: int) -> float:
    """Largest value of any formula of f to its derivative ``highest`` over the closed pieces.

    Args:
        formula: from (highest + 1, n) values to (n,).
    """

    def at(x: Array, piece: Indices) -> Array:
        f = curve.jet(x.ravel(), np.repeat(piece, x.shape[1]), highest)
        return np.asarray(formula(f)).reshape(x.shape)

    return maximise_between(at, curve.breaks[:-1], curve.breaks[1:])[0]


def maximise_between(
    function: Callable[[Array, Indices], Array], low: Array, high: Array
) -> tuple[float, float]:
    """Largest value of a function over several intervals, and where it is.

    Every interval is sampled, and the largest value is closed in on between its neighbours; two
    peaks of an interval whose heights differ by less than sampling shows are not told apart.

    Args:
        function: values at points (n, k), k on each of n intervals, whose indices (n,) are given.
        low, high: ends of the intervals.
    """
    which, reach = np.arange(len(low)), (high - low) / (SAMPLES - 1)
    x = low[:, None] + (high - low)[:, None] * np.linspace(0.0, 1.0, SAMPLES)
    x[:, -1] = high
    value = function(x, which)
    # a stationary point between two samples tops them by no more than their difference, as a rule:
    # intervals that cannot hold the largest value by that are left out
    with np.errstate(invalid="ignore"):
        top, steps = value.max(axis=1), np.abs(np.diff(value, axis=1)).max(axis=1)
        which = np.flatnonzero(~(top + steps < top.max()))
    x, value, rows = x[which], value[which], np.arange(len(which))
    low, high, reach = (each[which][:, None] for each in (low, high, reach))
    for _ in range(ZOOMS):
        best = x[rows, value.argmax(axis=1)][:, None]
        x = np.clip(best + reach * FAN, low, high)
        value, reach = function(x, which), reach / 8.0
    # the vertex of the parabola through the highest and its neighbours: closer than by comparing
    # values, which near a peak differ by less than their roundings
    middle = np.clip(value.argmax(axis=1), 1, len(FAN) - 2)
    before, here, after = (value[rows, middle + k] for k in (-1, 0, 1))
    with np.errstate(divide="ignore", invalid="ignore"):
        shift = np.clip(0.5 * (after - before) / (2.0 * here - before - after), -1.0, 1.0)
    vertex = np.clip(x[rows, middle][:, None] + np.nan_to_num(shift)[:, None] * reach, low, high)
    x, value = np.hstack([vertex, x]), np.hstack([function(vertex, which), value])
    place = np.unravel_index(value.argmax(), value.shape)
    return float(value[place]), float(x[place])
