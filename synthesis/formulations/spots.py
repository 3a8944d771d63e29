"""Points of the turn at which a smooth limit is written: where it is in use, and where it peaks."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from synthesis.formulations.problem import Problem
from synthesis.formulations.smooth import Samples, sample
from synthesis.limits import Limit
from synthesis.numerics.piecewise import Array

Vector = tuple[float, ...]
IN_USE = -0.95  # points that are slacker than this at first are left to the exchange
THINNED = 3  # one in so many samples is written at first
SAME_PLACE = 1e-9  # of a stretch: points nearer than this are one


@dataclass(frozen=True, eq=False)
class Spots:
    """Points of one stretch where one limit is written.

    Attributes:
        position: of the stretch in the problem's program.
        x: (k,) where on the stretch, 0 to 1.
        s: (4, k) s to s''' there [mm, per rad]; where the law is given, they stay.
        worst: the limit's largest value among them, dimensionless; positive where it is broken.
    """

    limit: Limit
    position: int
    x: Array
    s: Array
    worst: float


def in_use(settled: Problem, size: Vector) -> list[Spots]:
    """Samples at which the smooth limits are not hopelessly slack."""
    found = []
    for limit, position, samples, values in _traces(settled, size):
        kept = values > IN_USE
        kept[:, :-1] &= np.arange(values.shape[1] - 1) % THINNED == 0
        theta, s = samples.theta[kept.ravel()], samples.s[:, kept.ravel()]
        found += _spots(settled, limit, position, theta, s, size)
    return found


def broken(settled: Problem, size: Vector, above: float = 0.0) -> list[Spots]:
    """Peaks at which a smooth limit's value is above a threshold, refined by a parabola."""
    found = []
    for limit, position, samples, values in _traces(settled, size):
        theta, piece = _peaks(samples.theta.reshape(values.shape), values)
        curve = samples.stretch.placed()
        s = np.stack([curve.at(theta, piece, order) for order in range(4)])
        value = _value(settled, limit, position, s, size)
        kept = value > above
        found += _spots(settled, limit, position, theta[kept], s[:, kept], size)
    return found


def _traces(settled: Problem, size: Vector) -> Iterator[tuple[Limit, int, Samples, Array]]:
    """Every smooth limit along every stretch: its values, (pieces, samples)."""
    for position, samples in enumerate(sample(settled)):
        pieces = samples.stretch.placed().count
        for limit in settled.limits:
            value = _value(settled, limit, position, samples.s, size)
            if len(value):
                yield limit, position, samples, value.reshape(pieces, -1)


def _value(settled: Problem, limit: Limit, position: int, s: Array, size: Vector) -> Array:
    """The largest of a limit's expressions at every point; empty where it has none."""
    said = limit.smooth(settled.stretches[position], settled.machine, s, size)
    return np.max(np.stack(said), axis=0) if said else np.zeros(0)


def _spots(
    settled: Problem, limit: Limit, position: int, theta: Array, s: Array, size: Vector
) -> Sequence[Spots]:
    """The points without repetition, if there are any."""
    if not len(theta):
        return ()
    stretch = settled.stretches[position]
    x = np.clip((theta - stretch.start) / stretch.angle, 0.0, 1.0)
    # a free law is smooth where pieces meet, a dwell is one point; a given law may jump
    told_apart = np.round(x / SAME_PLACE) if stretch.free is not None else s
    _, first = np.unique(np.atleast_2d(told_apart), axis=1, return_index=True)
    worst = float(np.max(_value(settled, limit, position, s, size)))
    return (Spots(limit, position, x[first], s[:, first], worst),)


def _peaks(theta: Array, values: Array) -> tuple[Array, NDArray[np.intp]]:
    """Local maxima of sampled pieces, moved to the top of the parabola through three samples."""
    padded = np.pad(values, ((0, 0), (1, 1)), constant_values=-np.inf)
    before, after = padded[:, :-2], padded[:, 2:]
    piece, column = np.nonzero((values > before) & (values >= after))
    left, top, right = before[piece, column], values[piece, column], after[piece, column]
    step = theta[piece, 1] - theta[piece, 0]
    inner = np.isfinite(left) & np.isfinite(right)
    fall = np.where(inner, 2.0 * top - left - right, 1.0)
    move = np.where(inner, 0.5 * (right - left), 0.0) / np.where(fall > 0.0, fall, 1.0)
    return theta[piece, column] + step * np.clip(move, -1.0, 1.0), piece
