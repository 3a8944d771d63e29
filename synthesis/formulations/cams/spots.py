"""Points of the turn at which a smooth limit is written: spread evenly, and where it peaks."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from synthesis.formulations.cams.smooth import Samples, sample
from synthesis.formulations.question.problem import Problem
from synthesis.numerics.piecewise import Array

Vector = tuple[float, ...]
POINTS = 128  # spread over a stretch, about; ends of pieces are always among them
SAME_PLACE = 1e-9  # of a stretch: points nearer than this are one


@dataclass(frozen=True, eq=False)
class Spots:
    """Points of one stretch where one limit is written.

    Attributes:
        limit, position: among the problem's limits and stretches.
        x: (k,) where on the stretch, 0 to 1.
        s: (4, k) s to s''' there [mm, per rad]; where the law is given, they stay.
    """

    limit: int
    position: int
    x: Array
    s: Array


def spread(settled: Problem, size: Vector) -> list[Spots]:
    """Points all along the turn, for every limit that has a smooth form."""
    found = []
    for limit, position, samples, values in _traces(settled, size):
        kept = _thinned(samples, values.shape).ravel()
        found += _distinct(limit, position, samples, samples.theta[kept], samples.s[:, kept])
    return found


def near(settled: Problem, size: Vector, above: float) -> list[Spots]:
    """Points all along the turn where a smooth limit exceeds a value, and peaks between these."""
    found = []
    for limit, position, samples, values in _traces(settled, size):
        kept = (_thinned(samples, values.shape) & (values > above)).ravel()
        theta, piece = _peaks(samples.theta.reshape(values.shape), values)
        s = samples.stretch.placed().jet(theta, piece, 3)
        high = _value(settled, limit, position, theta, s, size) > above
        theta = np.concatenate([samples.theta[kept], theta[high]])
        s = np.concatenate([samples.s[:, kept], s[:, high]], axis=1)
        found += _distinct(limit, position, samples, theta, s)
    return found


def moved(spot: Spots, settled: Problem) -> Spots:
    """The same points with the displacements of another motion; where it is given, as they are."""
    stretch = settled.stretches[spot.position]
    if stretch.free is None:
        return spot
    curve, theta = stretch.placed(), stretch.start + spot.x * stretch.angle
    return replace(spot, s=curve.jet(theta, curve.piece_of(theta), 3))


def broken(settled: Problem, size: Vector, eased: int = 0, above: float = 0.0) -> list[Spots]:
    """Peaks at which a smooth limit is exceeded, refined by a parabola.

    Args:
        settled: the question, laws settled. size: the size [mm].
        eased: how many of the last limits may be exceeded, and by how much (``above``).
    """
    found, firm = [], len(settled.limits) - eased
    for limit, position, samples, values in _traces(settled, size):
        theta, piece = _peaks(samples.theta.reshape(values.shape), values)
        curve = samples.stretch.placed()
        s = curve.jet(theta, piece, 3)
        kept = _value(settled, limit, position, theta, s, size) > above * (limit >= firm)
        found += _distinct(limit, position, samples, theta[kept], s[:, kept])
    return found


def _traces(settled: Problem, size: Vector) -> Iterator[tuple[int, int, Samples, Array]]:
    """Every smooth limit along every stretch: its values, (pieces, samples)."""
    for position, samples in enumerate(sample(settled)):
        pieces = samples.stretch.placed().count
        for limit in range(len(settled.limits)):
            value = _value(settled, limit, position, samples.theta, samples.s, size)
            if len(value):
                yield limit, position, samples, value.reshape(pieces, -1)


def _value(
    settled: Problem, limit: int, position: int, theta: Array, s: Array, size: Vector
) -> Array:
    """The largest of a limit's expressions at every point; empty where it has none."""
    stretch, machine = settled.stretches[position], settled.machine
    said = settled.limits[limit].smooth(stretch, machine, theta, s, size)
    return np.max(np.stack(said), axis=0) if said else np.zeros(0)


def _distinct(limit: int, position: int, samples: Samples, theta: Array, s: Array) -> list[Spots]:
    """The points, each once, if there are any.

    A free law is smooth where pieces meet, and a dwell is one point; a given law may jump.
    """
    if not len(theta):
        return []
    stretch = samples.stretch
    x = np.clip((theta - stretch.start) / stretch.angle, 0.0, 1.0)
    marks = s if stretch.free is None else np.round(x / SAME_PLACE)[None, :]
    _, first = np.unique(marks, axis=1, return_index=True)
    return [Spots(limit, position, x[first], s[:, first])]


def _thinned(samples: Samples, shape: tuple[int, ...]) -> NDArray[np.bool_]:
    """Evenly spread samples, the ends of all pieces among them: (pieces, samples)."""
    breaks, last = samples.stretch.placed().breaks, shape[1] - 1
    wanted = np.ceil(POINTS * np.diff(breaks) / samples.stretch.angle)
    each: Array = np.clip(wanted, 1.0, last)[:, None]
    return np.asarray(np.arange(shape[1]) * each % last < each)


def _peaks(theta: Array, values: Array) -> tuple[Array, NDArray[np.intp]]:
    """Local maxima of sampled pieces, moved to the top of the parabola through three samples.

    One at an end of a piece may top between the last two samples.
    """
    padded = np.pad(values, ((0, 0), (1, 1)), constant_values=-np.inf)
    before, after = padded[:, :-2], padded[:, 2:]
    piece, column = np.nonzero((values > before) & (values >= after))
    middle = np.clip(column, 1, values.shape[1] - 2)
    left, top, right = (values[piece, middle + k] for k in (-1, 0, 1))
    finite = np.isfinite(left) & np.isfinite(top) & np.isfinite(right)
    left, top, right = (np.where(finite, each, 0.0) for each in (left, top, right))
    fall = 2.0 * top - left - right
    curved = fall > 0.0
    move = np.where(curved, 0.5 * (right - left), 0.0) / np.where(curved, fall, 1.0)
    step = theta[piece, 1] - theta[piece, 0]
    return np.where(
        curved, theta[piece, middle] + step * np.clip(move, -1.0, 1.0), theta[piece, column]
    ), piece
