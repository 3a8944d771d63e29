"""Largest value of a linear combination of a function's derivatives, found in floating point.

Fast and accurate to rounding, but a finding, not a proof: proofs are the certificate's business.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

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
    c0, c1, c2, c3 = columns = np.zeros((4, curve.count))
    columns[: curve.poly.shape[1]] = curve.poly.T
    # ends and stationary points; of what is no number, an end
    t = np.stack([left, right, *quadratic_roots(3.0 * c3, 2.0 * c2, c1)])
    t = np.fmin(np.fmax(t, left), right)
    value = c0 + t * (c1 + t * (c2 + t * c3))
    k, i = np.unravel_index(np.argmax(value), value.shape)
    x = min(max(curve.origins[i] + t[k, i], curve.breaks[i]), curve.breaks[i + 1])
    return float(value[k, i]), float(x)


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
