"""Points of the turn at which a smooth limit is written: spread evenly, and where it peaks."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from synthesis.numerics.piecewise import Array
from synthesis.optimise.problem.problem import Problem
from synthesis.optimise.recovery.smooth_limits import Samples, sample

Vector = tuple[float, ...]
POINTS = 128  # spread over a segment, about; ends of pieces are always among them
SAME_PLACE = 1e-9  # of a segment: points nearer than this are one


@dataclass(frozen=True, eq=False)
class ConstraintSamples:
    """Points of one segment where one limit is written.

    Attributes:
        limit, position: among the problem's limits and segments.
        x: (k,) where on the segment, 0 to 1.
        s: (4, k) s to s''' there [length/rad^k]; where the law is given, they stay.
    """

    limit: int
    position: int
    x: Array
    s: Array


def initial_samples(problem: Problem, size: Vector) -> list[ConstraintSamples]:
    """Points all along the turn, for every limit that has a smooth form."""
    result = []
    for limit, position, samples, values in _traces(problem, size):
        kept = _evenly_spread(samples, values.shape).ravel()
        result += _unique_samples(limit, position, samples, samples.theta[kept], samples.s[:, kept])
    return result


def samples_near(problem: Problem, size: Vector, above: float) -> list[ConstraintSamples]:
    """Points all along the turn where a smooth limit exceeds a value, and peaks between these."""
    result = []
    for limit, position, samples, values in _traces(problem, size):
        kept = (_evenly_spread(samples, values.shape) & (values > above)).ravel()
        theta, piece = _peaks(samples.theta.reshape(values.shape), values)
        s = samples.segment.placed().jet(theta, piece, 3)
        high = _value(problem, limit, position, theta, s, size) > above
        theta = np.concatenate([samples.theta[kept], theta[high]])
        s = np.concatenate([samples.s[:, kept], s[:, high]], axis=1)
        result += _unique_samples(limit, position, samples, theta, s)
    return result


def move_samples(point_samples: ConstraintSamples, problem: Problem) -> ConstraintSamples:
    """The same points with the displacements of another motion; where it is given, as they are."""
    segment = problem.segments[point_samples.position]
    if segment.free is None:
        return point_samples
    curve, theta = segment.placed(), segment.start + point_samples.x * segment.angle
    return replace(point_samples, s=curve.jet(theta, curve.piece_of(theta), 3))


def add_violated(
    problem: Problem, size: Vector, relaxed_count: int = 0, above: float = 0.0
) -> list[ConstraintSamples]:
    """Peaks at which a smooth limit is exceeded, refined by a parabola.

    Args:
        problem: the problem, laws fixed. size: the size [length].
        relaxed_count: how many of the last limits may be exceeded, and by how much (``above``).
    """
    result, hard_count = [], len(problem.limits) - relaxed_count
    for limit, position, samples, values in _traces(problem, size):
        theta, piece = _peaks(samples.theta.reshape(values.shape), values)
        curve = samples.segment.placed()
        s = curve.jet(theta, piece, 3)
        kept = _value(problem, limit, position, theta, s, size) > above * (limit >= hard_count)
        result += _unique_samples(limit, position, samples, theta[kept], s[:, kept])
    return result


def _traces(problem: Problem, size: Vector) -> Iterator[tuple[int, int, Samples, Array]]:
    """Every smooth limit along every segment: its values, (pieces, samples)."""
    for position, samples in enumerate(sample(problem)):
        pieces = samples.segment.placed().count
        for limit in range(len(problem.limits)):
            value = _value(problem, limit, position, samples.theta, samples.s, size)
            if len(value):
                yield limit, position, samples, value.reshape(pieces, -1)


def _value(
    problem: Problem, limit: int, position: int, theta: Array, s: Array, size: Vector
) -> Array:
    """The largest of a limit's expressions at every point; empty where it has none."""
    segment, machine = problem.segments[position], problem.machine
    expressions = problem.limits[limit].smooth_constraints(segment, machine, theta, s, size)
    return np.max(np.stack(expressions), axis=0) if expressions else np.zeros(0)


def _unique_samples(
    limit: int, position: int, samples: Samples, theta: Array, s: Array
) -> list[ConstraintSamples]:
    """The points, each once, if there are any.

    A free law is smooth where pieces meet, and a dwell is one point; a given law may jump.
    """
    if not len(theta):
        return []
    segment = samples.segment
    x = np.clip((theta - segment.start) / segment.angle, 0.0, 1.0)
    marks = s if segment.free is None else np.round(x / SAME_PLACE)[None, :]
    _, first = np.unique(marks, axis=1, return_index=True)
    return [ConstraintSamples(limit, position, x[first], s[:, first])]


def _evenly_spread(samples: Samples, shape: tuple[int, ...]) -> NDArray[np.bool_]:
    """Evenly spread samples, the ends of all pieces among them: (pieces, samples)."""
    breaks, last = samples.segment.placed().breaks, shape[1] - 1
    wanted = np.ceil(POINTS * np.diff(breaks) / samples.segment.angle)
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
