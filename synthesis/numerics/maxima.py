"""Largest value of a linear combination of a function's derivatives, found in floating point.

Fast and accurate to rounding, but a finding, not a proof: proofs are the certificate's business.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import accumulate
from math import perm

import numpy as np

from synthesis.numerics.piecewise import Array, Piecewise

SAMPLES = 24


def maximise(curve: Piecewise, coefficients: Sequence[float]) -> tuple[float, float]:
    """Largest value of Σ_k coefficients[k] f^(k) over the closed pieces, and where.

    Every piece is sampled; around each sample that is not below its neighbours Newton's method
    finds the stationary point, kept only within the neighbours.

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
    samples = SAMPLES if curve.waves.shape[1] or curve.poly.shape[1] > 6 else 5
    left, width = curve.breaks[:-1], np.diff(curve.breaks)
    step = np.linspace(0.0, 1.0, samples)
    x: Array = (left[:, None] + width[:, None] * step).ravel()
    piece = np.repeat(np.arange(curve.count), samples)

    def combined(at: Array, on: np.ndarray, highest: int) -> list[Array]:
        f = curve.jet(at, on, weights[-1][0] + highest)
        return [sum(c * f[k + raised] for k, c in weights) for raised in range(highest + 1)]

    (value,) = combined(x, piece, 0)
    best = int(np.argmax(value))
    spread = float(value[best] - value.min())
    # a stationary point between two samples can top its neighbours by no more than their spread
    table = value.reshape(curve.count, samples)
    rough = np.max(np.abs(table[:, 1:] - table[:, :-1]), axis=1) + 1e-15 * spread
    keep = np.repeat(table.max(axis=1) + rough >= value[best], samples)
    y, on = x[keep], piece[keep]
    half = (width[on] / (samples - 1)) if samples > 1 else width[on]
    low, high = np.maximum(y - half, left[on]), np.minimum(y + half, left[on] + width[on])
    with np.errstate(divide="ignore", invalid="ignore"):
        for _ in range(4):
            _, slope, bend = combined(y, on, 2)
            move = np.where(bend < 0.0, -slope / bend, 0.0)
            y = np.minimum(np.maximum(y + move, low), high)
    (refined,) = combined(y, on, 0)
    top = int(np.argmax(refined))
    if refined[top] > value[best]:
        return float(refined[top]), float(y[top])
    return float(value[best]), float(x[best])


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

    As ``peak`` finds them; polynomials up to the third degree are worked out together.

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
    """``heights`` of polynomials up to the third degree."""
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


FAN = np.linspace(-1.0, 1.0, 17)
ZOOMS = 9  # each narrows the place of a peak eightfold


def maximise_formula(curve: Piecewise, formula: Callable[[Array], Array], highest: int) -> float:
    """Largest value of any formula of f to its derivative ``highest`` over the closed pieces.

    Args:
        formula: from (highest + 1, n) values to (n,).
    """
    piece = np.arange(curve.count)

    def at(x: Array) -> Array:
        f = curve.jet(x.ravel(), np.repeat(piece, x.shape[1]), highest)
        return np.asarray(formula(f)).reshape(x.shape)

    return maximise_between(at, curve.breaks[:-1], curve.breaks[1:])


def maximise_between(function: Callable[[Array], Array], low: Array, high: Array) -> float:
    """Largest value of a function over several intervals.

    Every interval is sampled, and its largest value is closed in on between its neighbours; two
    peaks of one whose heights differ by less than sampling shows are not told apart.

    Args:
        function: values at points (n, k), k on each interval. low, high: (n,) ends.
    """
    rows, reach, best = np.arange(len(low)), (high - low) / 64.0, np.zeros(0)
    x = low[:, None] + (high - low)[:, None] * np.linspace(0.0, 1.0, 65)
    for _ in range(ZOOMS):
        value = function(x)
        top = np.argmax(value, axis=1)
        best = value[rows, top]
        x = np.clip(x[rows, top][:, None] + reach[:, None] * FAN, low[:, None], high[:, None])
        reach = reach / 8.0
    return float(np.max(best))
