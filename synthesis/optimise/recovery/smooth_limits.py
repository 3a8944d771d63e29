"""Nonconvex limits by their smooth form on given motion: where they are violated, and enlarging.

A limit's smooth expressions are at most 0 where it holds. A cam is enlarged until they hold all
along the laws (``enlarged_size``); local searches write them at samples, evenly spread and at their
peaks (``constraint_samples``, ``add_violated``).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from synthesis.catalogue.constraints import enlarged
from synthesis.catalogue.motion import PlacedSegment
from synthesis.numerics.piecewise import Array
from synthesis.optimise.problem.problem import Problem

Vector = tuple[float, ...]
DENSITY, LEAST_DENSITY = 192, 8  # points on a law, and on every piece of it, ends included
PEAK_ITERATIONS = 4  # of enlarging; each samples the peaks that the last one left
NEAR = -0.1  # samples slacker than this have no peak beside them that matters
CROSSED = 1e-9  # relative: how closely a size is raised
ZOOMS = 5  # each narrows a peak to a quarter of the interval
# points that are slacker than this are not looked at while enlarging, in turn: few do as a rule
WATCHED = (-0.15, -0.7, -0.7, -0.7)
MANY = 24  # pieces of a law: what is far from binding is seen where they begin
POINTS = 128  # of initial samples on a segment, about; ends of pieces are always among them
SAME_PLACE = 1e-9  # of a segment: points nearer than this are one
FACTORIALS = np.array([[1.0], [1.0], [2.0], [6.0]])


@dataclass(frozen=True, eq=False)
class Samples:
    """One segment sampled densely, one-sided at breaks: θ (n,), s to s''' (4, n), its pieces."""

    segment: PlacedSegment
    theta: Array
    s: Array
    piece: NDArray[np.intp]

    def at(self, keep: NDArray[np.bool_]) -> Samples:
        """Only the points marked."""
        return Samples(self.segment, self.theta[keep], self.s[:, keep], self.piece[keep])


def sample(problem: Problem) -> list[Samples]:
    """Every segment of a problem without free laws."""
    result, load = [], problem.machine.load
    for whole in problem.segments:
        segment = whole if load is None else load.split_at_jumps(whole)
        curve = segment.placed()
        density = 2 if segment.kind == "dwell" else max(LEAST_DENSITY, DENSITY // curve.count)
        left, right = curve.breaks[:-1, None], curve.breaks[1:, None]
        theta = (left + (right - left) * np.linspace(0.0, 1.0, density)).ravel()
        piece = np.repeat(np.arange(curve.count), density)
        s = curve.jet(theta, piece, 3)
        result.append(Samples(segment, theta, s, piece))
    return result


def violation(problem: Problem, samples: list[Samples], size: Vector) -> float:
    """Largest value of the smooth expressions (≤ 0: all hold); −inf where there are none."""
    return max((float(v.max()) for v in _largest_values(problem, samples, size)), default=-np.inf)


def _largest_values(problem: Problem, samples: list[Samples], size: Vector) -> list[Array]:
    """The largest smooth expression at every point of each part, ∞ where one has no value."""
    if not samples:
        return []
    first, ends = samples[0].segment, np.cumsum([0, *(len(part.theta) for part in samples)])
    theta = np.concatenate([part.theta for part in samples])
    s = np.concatenate([part.s for part in samples], axis=1)
    worst = np.full(len(theta), -np.inf)
    result = [worst[low:high] for low, high in pairwise(ends.tolist())]
    for limit in problem.limits:
        if limit.same_on_every_segment:
            for value in limit.smooth_constraints(first, problem.machine, theta, s, size):
                np.maximum(worst, value, out=worst)
            continue
        for part, own in zip(samples, result, strict=True):
            for value in limit.smooth_constraints(
                part.segment, problem.machine, part.theta, part.s, size
            ):
                np.maximum(own, value, out=own)
    worst[np.isnan(worst)] = np.inf
    return result


def enlarged_size(problem: Problem, size: Vector, margin: float, *, densely: bool) -> Vector | None:
    """The size raised as little as needed for the smooth limits to hold by ``margin``.

    Raising enlarges the prime radius and lowers pressure angle and curvature alike; None where
    even the largest size allowed does not do. Peaks that lie between the samples are looked for
    on the enlarged cam and sampled too, until none is left. ``densely``: sample the laws even
    where the limits seem to be far from binding.
    """
    if not densely and _is_far_from_binding(problem, size):
        return size
    samples, follower = sample(problem), problem.machine.follower
    for _ in range(PEAK_ITERATIONS):
        result = _raise_until_feasible(problem, samples, size, margin)
        if result is None:
            return None
        size, values = result
        peak_samples = peaks(problem, samples, size, values)
        if violation(problem, peak_samples, size) <= -0.5 * margin:
            return size
        samples = [*samples, *peak_samples]
    clear = margin * follower.radius_norm().value(size)
    return enlarged(size, min(clear, problem.max_enlargement(size)))


def _is_far_from_binding(problem: Problem, size: Vector) -> bool:
    """Whether every smooth expression is far from binding, as seen where the pieces begin.

    What the laws are there their coefficients say. In between an expression may rise by as much
    as it changes from one of these points to the next at most.
    """
    curves = [segment.placed() for segment in problem.segments]
    seen = all(c.is_constant or (c.count >= MANY and not c.waves.shape[1]) for c in curves)
    if problem.machine.load is not None or not seen:
        return False
    samples = []
    for segment, curve in zip(problem.segments, curves, strict=True):
        s, known = np.zeros((4, curve.count)), min(curve.poly.shape[1], 4)
        s[:known] = curve.poly.T[:known] * FACTORIALS[:known]
        samples.append(Samples(segment, curve.origins, s, np.arange(curve.count)))
    each = _largest_values(problem, samples, size)
    values = np.concatenate([*each, each[0][:1]])
    top = float(values.max())
    if not np.isfinite(values).all():
        return top == -np.inf  # nothing is said
    return top + float(np.abs(values[1:] - values[:-1]).max()) <= NEAR


def _raise_until_feasible(
    problem: Problem, samples: list[Samples], size: Vector, margin: float
) -> tuple[Vector, list[Array]] | None:
    """The same at given samples alone; with the largest expression at every one of them."""
    follower = problem.machine.follower

    def excess(raised: float) -> float:
        return violation(problem, watched, enlarged(size, raised)) + margin

    high, keep = 0.0, [np.zeros(1, dtype=bool)] * len(samples)
    for slack in WATCHED:
        at = enlarged(size, high)
        value = _largest_values(problem, samples, at)
        worst = max(float(v.max()) for v in value) + margin
        if worst <= 0.0:
            return at, value
        most = problem.max_enlargement(size)
        # points that were slack so far may come to bind on a larger cam: watch them from now on
        keep = [k | (v > slack) for k, v in zip(keep, value, strict=True)]
        watched = [p.at(k) for p, k in zip(samples, keep, strict=True) if np.any(k)]
        low, step = high, max(1e-6 * problem.length, high)
        if np.isfinite(worst):  # a limit eases about as the radius grows
            step = max(step, worst * follower.radius_norm().value(at))
        while excess(min(step, most)) > 0.0:
            if step >= most:
                return None
            low, step = step, 4.0 * step
        high = _crossing(excess, low, min(step, most))
    return None


def peaks(
    problem: Problem, samples: list[Samples], size: Vector, values: list[Array] | None = None
) -> list[Samples]:
    """Local maxima of the smooth expressions, by zooming; ``values``: those at every sample."""
    result, parts = [], samples[: len(problem.segments)]
    if values is None:
        values = _largest_values(problem, parts, size)
    for part, value in zip(parts, values, strict=False):
        if np.max(value) <= NEAR:
            continue
        table = value.reshape(part.piece[-1] + 1, -1)
        padded = np.pad(table, ((0, 0), (1, 1)), constant_values=-np.inf)
        highest = (table >= padded[:, :-2]) & (table >= padded[:, 2:]) & (table > NEAR)
        top = np.flatnonzero(highest)
        if len(top):
            result.append(_refine_peaks(problem, part, size, top))
    return result


def _refine_peaks(problem: Problem, part: Samples, size: Vector, top: NDArray[np.intp]) -> Samples:
    """The tops moved to where their expression is largest between the neighbouring samples."""
    curve, piece, theta = part.segment.placed(), part.piece[top], part.theta[top]
    left, right = curve.breaks[piece], curve.breaks[piece + 1]
    reach = (right - left) / (np.count_nonzero(part.piece == part.piece[0]) - 1)
    for _ in range(ZOOMS):
        step = np.linspace(-1.0, 1.0, 9)
        tried = np.clip(theta[:, None] + reach[:, None] * step, left[:, None], right[:, None])
        on = np.repeat(piece, len(step))
        s = curve.jet(tried.ravel(), on, 3)
        (value,) = _largest_values(problem, [Samples(part.segment, tried.ravel(), s, on)], size)
        best = np.argmax(value.reshape(tried.shape), axis=1)
        theta, reach = tried[np.arange(len(theta)), best], reach / 4.0
    s = curve.jet(theta, piece, 3)
    return Samples(part.segment, theta, s, piece)


def _crossing(excess: Callable[[float], float], low: float, high: float) -> float:
    """A point where ``excess`` is not positive, within 1e-9 relative of where it crosses zero.

    By false position; an end that stays counts half as much from then on (the Illinois rule).
    """
    f_low, f_high, moved = excess(low), excess(high), 0
    for _ in range(60):
        if high - low <= CROSSED * high:
            break
        share = f_low / (f_low - f_high) if np.isfinite(f_low) else 0.5
        aside = 0.5 * CROSSED * high  # next to a root, beyond it
        middle = min(max(low + share * (high - low), low + aside), high - aside)
        value = excess(middle)
        if value > 0.0:
            f_high *= 0.5 if moved > 0 else 1.0
            low, f_low, moved = middle, value, 1
        else:
            f_low *= 0.5 if moved < 0 else 1.0
            high, f_high, moved = middle, value, -1
    return high


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


def add_violated(
    problem: Problem, size: Vector, relaxed_count: int = 0, above: float = 0.0
) -> list[ConstraintSamples]:
    """Peaks at which a smooth limit is exceeded, refined by a parabola.

    ``relaxed_count``: how many of the last limits may be exceeded, and by how much (``above``).
    """
    allowed = [0.0] * (len(problem.limits) - relaxed_count) + [above] * relaxed_count
    return constraint_samples(problem, size, np.inf, allowed)


def constraint_samples(
    problem: Problem, size: Vector, spread_above: float, peaks_above: float | Sequence[float]
) -> list[ConstraintSamples]:
    """Points all along the turn where a smooth limit exceeds a value; peaks above one for every
    limit.
    """
    result = list[ConstraintSamples]()
    for position, samples in enumerate(sample(problem)):
        segment, curve = samples.segment, samples.segment.placed()
        for limit, above in enumerate(np.broadcast_to(peaks_above, len(problem.limits))):
            values = _value(problem, limit, position, samples.theta, samples.s, size)
            if not len(values):
                continue
            table = values.reshape(curve.count, -1)
            wanted = (values > spread_above) | (spread_above == -np.inf)
            # evenly spread samples, the ends of all pieces among them
            last = table.shape[1] - 1
            count = np.ceil(POINTS * np.diff(curve.breaks) / segment.angle)
            each: Array = np.clip(count, 1.0, last)[:, None]
            kept = wanted & (np.arange(last + 1) * each % last < each).ravel()
            theta, s = samples.theta[kept], samples.s[:, kept]
            if above < np.inf:
                top, piece = _peaks(samples.theta.reshape(table.shape), table)
                at_top = curve.jet(top, piece, 3)
                high = _value(problem, limit, position, top, at_top, size) > above
                theta = np.concatenate([theta, top[high]])
                s = np.concatenate([s, at_top[:, high]], axis=1)
            if not len(theta):
                continue
            # Each point once: a free law is smooth where pieces meet, and a dwell is one point; a
            # given law may jump.
            x = np.clip((theta - segment.start) / segment.angle, 0.0, 1.0)
            marks = s if segment.free is None else np.round(x / SAME_PLACE)[None, :]
            _, first = np.unique(marks, axis=1, return_index=True)
            result.append(ConstraintSamples(limit, position, x[first], s[:, first]))
    return result


def move_samples(samples: ConstraintSamples, problem: Problem) -> ConstraintSamples:
    """The same points with the displacements of another motion; where it is given, as they are."""
    segment = problem.segments[samples.position]
    if segment.free is None:
        return samples
    curve, theta = segment.placed(), segment.start + samples.x * segment.angle
    return replace(samples, s=curve.jet(theta, curve.piece_of(theta), 3))


def _value(
    problem: Problem, limit: int, position: int, theta: Array, s: Array, size: Vector
) -> Array:
    """The largest of a limit's expressions at every point; empty where it has none."""
    segment, machine = problem.segments[position], problem.machine
    expressions = problem.limits[limit].smooth_constraints(segment, machine, theta, s, size)
    return np.max(np.stack(expressions), axis=0) if expressions else np.zeros(0)


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
