"""Largest values of functions, found in floating point: fast, but not proven.

``maximise`` and its like find one largest value to rounding. ``locate_extrema`` finds roughly where
many functions on boxes have theirs: it tells a proof where to look closely, and what it misses
costs the proof time and nothing else.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Final

import numpy as np
from numpy.polynomial.legendre import legvander

from synthesis.numerics.box_search import Boxes
from synthesis.numerics.piecewise import Array, Indices, Piecewise, sorted_unique


def maximise(curve: Piecewise, coefficients: Sequence[float]) -> tuple[float, float]:
    """Largest value of Σ_k coefficients[k] f^(k) over the closed pieces, and its x."""
    weights = [(k, c) for k, c in enumerate(coefficients) if c != 0.0]
    if not weights:
        return 0.0, float(curve.breaks[0])
    if not curve.waves.shape[1]:
        curve, weights = curve.combine_derivatives(coefficients), [(0, 1.0)]
        if curve.poly.shape[1] <= 4:
            return _of_cubics(curve)

    return maximise_formula(curve, lambda f: sum(c * f[k] for k, c in weights), weights[-1][0])


def _of_cubics(curve: Piecewise) -> tuple[float, float]:
    """The same of polynomials up to the third degree, whose stationary points have a formula."""
    left, right = curve.breaks[:-1] - curve.origins, curve.breaks[1:] - curve.origins
    c0, c1, c2, c3 = columns = np.zeros((4, curve.count))
    columns[: curve.poly.shape[1]] = curve.poly.T
    # ends and stationary points; of what is no number, an end
    t = np.empty_like(columns)
    t[0], t[1] = left, right
    t[2], t[3] = quadratic_roots(3.0 * c3, 2.0 * c2, c1)
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


def maximise_formula(
    curve: Piecewise, formula: Callable[[Array], Any], highest: int
) -> tuple[float, float]:
    """Largest value over the closed pieces of a formula of f to its derivative ``highest``, and x.

    It makes (n,) values of (highest + 1, n).
    """

    def at(x: Array, piece: Indices) -> Array:
        f = curve.jet(x.ravel(), np.repeat(piece, x.shape[1]), highest)
        return np.asarray(formula(f)).reshape(x.shape)

    return maximise_between(at, curve.breaks[:-1], curve.breaks[1:])


def maximise_between(
    function: Callable[[Array, Indices], Array], low: Array, high: Array
) -> tuple[float, float]:
    """Largest value of a function over several intervals, and where it is.

    Every interval is sampled, and the largest value is closed in on between its neighbours; two
    peaks of an interval whose heights differ by less than sampling shows are not distinguished.
    ``function``: values at points (n, k), k on each of n intervals, whose indices (n,) are given.
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


# (pieces (n,), points (n,)) -> (questions, n), of each question how large its function is there
ExcessFunction = Callable[[Indices, Array], Array]

PEAKS: Final = 3  # of a question, that are nearly as high as its highest
NEARLY: Final = 0.5  # of what lies between the values on its box
STEPS: Final = 2.0 ** -np.arange(1.0, 12.0)  # of a box: how far from a peak it is cut
LADDER: Final = np.concatenate([-STEPS, STEPS])
ALIKE: Final = 2.0**-44  # relative: points of one peak that differ by less are equally high
EQUAL: Final = 2.0**-34  # the same of peaks


# even places on a box, closer ones, and from values at the first to their polynomial at the others
PLACES: Final = np.linspace(0.0, 1.0, 5)
CLOSE: Final = np.linspace(0.0, 1.0, 257)
TO_CLOSE: Final = np.linalg.solve(*(legvander(2.0 * x - 1.0, 4).T for x in (PLACES, CLOSE)))


def locate_extrema(
    boxes: Boxes, heights: ExcessFunction, bounds: Array
) -> tuple[Indices, Indices, Array, Array]:
    """The highest point of every question's function on its active boxes.

    Of several that are equally high the first: roundings do not choose. To be run under
    ``np.errstate(all="ignore")``: what has no value is passed over. ``heights`` are over ``bounds``
    (questions,), and no better known than to roundings of these.

    Returns:
        question, piece and point (k,) of each; and sorted points (n,) at which to cut boxes, the
        closer to a peak the closer.
    """
    # 1. samples on every box, and the height of the parabola through its ends and centre
    x = boxes.lo[:, None] + (boxes.hi - boxes.lo)[:, None] * PLACES
    x[:, -1] = boxes.hi
    seen = heights(boxes.piece.repeat(len(PLACES)), x.ravel())
    seen = seen.reshape(len(seen), -1, len(PLACES))
    left, middle, right = seen[..., 0], seen[..., len(PLACES) // 2], seen[..., -1]
    slope, bend = 0.5 * (right - left), middle - 0.5 * (left + right)
    vertex = np.where(np.abs(slope) < 2.0 * bend, 0.25 * slope * slope / bend, 0.0)
    height = np.maximum(np.maximum(left, right), middle + vertex)
    height = np.where(boxes.active & (height > -np.inf), height, -np.inf)
    # 2. the boxes that are no lower than their neighbours, and may be as high as the highest
    top = height.max(axis=1, initial=-np.finfo(float).max)
    size = np.abs(top) + bounds
    rising = height[:, 1:] > height[:, :-1] + (ALIKE * size)[:, None]
    hill = np.ones(height.shape, dtype=bool)
    hill[:, 1:] &= rising
    hill[:, :-1] &= ~rising
    nearly = height + NEARLY * (np.abs(slope) + np.abs(bend)) >= top[:, None]
    question, box = np.nonzero(hill & nearly)
    kept = _highest(question, height[question, box], EQUAL * size, PEAKS)
    question, box = question[kept], box[kept]
    # 3. there the polynomial through all samples, and a parabola about its highest place
    curve = seen[question, box] @ TO_CLOSE
    top = curve.max(axis=1)
    best = (curve >= (top - ALIKE * (np.abs(top) + bounds[question]))[:, None]).argmax(axis=1)
    middle = np.clip(best, 1, len(CLOSE) - 2)
    before, there, after = (curve[np.arange(len(box)), middle + k] for k in (-1, 0, 1))
    bend = before + after - 2.0 * there
    inner = (best == middle) & (bend < 0.0)
    place = np.where(inner, best + 0.5 * (before - after) / bend, best) / (len(CLOSE) - 1.0)
    width = (boxes.hi - boxes.lo)[box]
    at = np.minimum(boxes.lo[box] + width * place, boxes.hi[box])
    # 4. the highest of each question
    first = _highest(question, top, EQUAL * size, 1)
    cuts = sorted_unique(at[:, None] + width[:, None] * LADDER)
    return question[first], boxes.piece[box[first]], at[first], cuts


def _highest(question: Indices, height: Array, grain: Array, count: int) -> Indices:
    """Which (k,) of the sorted questions are the ``count`` highest of each; of equals the first.

    ``grain``: (questions,) by how much heights have to differ to count as different.
    """
    top = np.full(len(grain), -np.inf)
    np.maximum.at(top, question, height)
    below = np.floor((top[question] - height) / grain[question])
    order = np.lexsort((np.where(np.isnan(below), 0.0, below), question))
    rank = np.arange(len(order)) - np.searchsorted(question, question)
    return np.sort(order[rank < count])
