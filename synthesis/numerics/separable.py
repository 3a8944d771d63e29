"""The least value that the largest of several separable functions has on a polytope.

Each function is constant + slope · u + Σ_k f_k(u_k), known by values at equal distances over a box
whose lower convex envelope is nowhere above f_k. The linear program over the envelopes gives
multipliers; what is returned is a bound from these by weak duality, whatever their errors.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from math import inf, isfinite
from typing import NamedTuple

import numpy as np
from scipy.optimize import linprog

from synthesis.numerics.piecewise import Array
from synthesis.numerics.polytope import Polytope

POINTS = 65
"""Of a function of one number over a box: between two of them it is bent by a thirty-thousandth of
what it is bent by over the box."""
ROUNDING = 1e-12  # relative to the largest term: sums of a thousand are in error by 1e-13


class Separable(NamedTuple):
    """constant + slope · u + Σ_k f_k(u_k): slope (n,).

    ``values``: of some coordinates k, (POINTS,) at equal distances over the box; f_k is nowhere
    below the lower convex envelope of these points.
    """

    constant: float
    slope: Array
    values: dict[int, Array]


def least_of_largest(
    parts: Sequence[Separable], polytope: Polytope, low: Array, high: Array
) -> tuple[float, Array]:
    """A lower bound of min over the box of the largest of separable functions, and where that is.

    The linear program over their lower convex envelopes has multipliers w ≥ 0 of the functions, of
    sum one, and μ of the equations. Any such w and μ bound the minimum by that of Σ w_i L_i(u) − μ
    · (A u − b), coordinate by coordinate.
    """
    parts = [part for part in parts if isfinite(part.constant)]
    if not parts:
        return -inf, 0.5 * (low + high)
    w, mu, numbers = _multipliers(parts, polytope, low, high)
    price = sum(share * part.slope for share, part in zip(w, parts, strict=True))
    price = np.asarray(price - polytope.matrix.T @ mu)
    total = float(sum(share * part.constant for share, part in zip(w, parts, strict=True)))
    total += float(mu @ polytope.rhs)
    magnitude = abs(total) + float(np.abs(mu) @ np.abs(polytope.rhs))
    for k in range(len(low)):
        if k in parts[0].values:
            at = np.linspace(low[k], high[k], len(parts[0].values[k]))
            values = sum(share * part.values[k] for share, part in zip(w, parts, strict=True))
            values = np.asarray(values + price[k] * at)
        else:
            values = price[k] * np.array([low[k], high[k]])
        total += float(np.min(values))
        magnitude += float(np.max(np.abs(values)))
    return total - ROUNDING * magnitude, numbers


def _multipliers(
    parts: Sequence[Separable], polytope: Polytope, low: Array, high: Array
) -> tuple[Array, Array, Array]:
    """Multipliers of the functions (q,) and of the equations (m,), and where the minimum is."""
    count, named = len(low), sorted(parts[0].values)
    width = 1 + len(parts) * len(named)  # t, and one envelope of each part and coordinate
    rows, rhs = [], []
    for i, part in enumerate(parts):
        # constant + slope · u + Σ envelopes ≤ t
        row = np.zeros(count + width)
        row[:count], row[count] = part.slope, -1.0
        first = count + 1 + i * len(named)
        row[first : first + len(named)] = 1.0
        rows.append(row)
        rhs.append(-part.constant)
    for i, part in enumerate(parts):
        for j, k in enumerate(named):
            at = np.linspace(low[k], high[k], len(part.values[k]))
            for a, b in _lower_hull(at, part.values[k]):
                row = np.zeros(count + width)
                row[k], row[count + 1 + i * len(named) + j] = b, -1.0
                rows.append(row)
                rhs.append(-a)
    equations = np.hstack([polytope.matrix, np.zeros((len(polytope.rhs), width))])
    answer = linprog(
        np.eye(count + width)[count], np.array(rows), rhs, equations, polytope.rhs,
        [*zip(low, high, strict=True), *[(None, None)] * width], method="highs",
    )  # fmt: skip
    if answer.status:  # an empty box, or none found: valid all the same
        shares = np.full(len(parts), 1.0 / len(parts))
        return shares, np.zeros(len(polytope.rhs)), 0.5 * (low + high)
    w = np.maximum(-answer.ineqlin.marginals[: len(parts)], 0.0)
    return w / w.sum(), np.asarray(answer.eqlin.marginals), np.array(answer.x)[:count]


def _lower_hull(at: Array, value: Array) -> list[tuple[float, float]]:
    """The lines a + b u of the lower convex hull of points, from left to right."""
    kept: list[tuple[float, float]] = []
    for x, y in zip(at.tolist(), value.tolist(), strict=True):
        while len(kept) > 1 and _is_above(kept[-2], kept[-1], (x, y)):
            kept.pop()
        kept.append((x, y))
    if len(kept) == 1 or kept[-1][0] <= kept[0][0]:
        return [(min(y for _, y in kept), 0.0)]
    lines = []
    for (x, y), (right, other) in pairwise(kept):
        b = (other - y) / (right - x)
        lines.append((y - b * x, b))
    return lines


def _is_above(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float]) -> bool:
    """Whether b is not below the chord from a to c."""
    return (b[1] - a[1]) * (c[0] - a[0]) >= (c[1] - a[1]) * (b[0] - a[0])
