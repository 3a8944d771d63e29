"""Linear rows on the size that nonconvex limits imply over a box of sizes.

* Of a limit on a traced point where the motion is given (dwells, given laws): only the size is open
  there, so that a box of sizes is all that has to be known. A limit that is linear in the size for
  a fixed motion has half-planes there, exactly.
* Of a norm that may not be too small: ‖y‖ ≥ least is not convex, but over a box every y_k² lies
  below its chord, so that the chords together are no less than least²: a row that is exact at the
  corners, the tighter the narrower the box.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from synthesis.catalogue.constraints import AffineNorm, MotionBox, SlideCoordinates
from synthesis.catalogue.limits import Limit
from synthesis.catalogue.motion import PlacedSegment
from synthesis.numerics.piecewise import Array
from synthesis.optimise.conic.linear_rows import LinearBlock, Scales
from synthesis.optimise.problem.problem import Problem

SAMPLES = 48  # of a segment
WORST = 12
"""Angles of a segment at which a limit is asked whether it excludes a box: where the box's middle
keeps a limit, so does it keep each row, and where it exceeds it most, rows are broken first."""
PIECES, SLICES = 16, 24  # of a box of sizes
REPEATED, SHRUNK = 4, 0.8  # times that it is cut anew, where less than that share is left of it
ROUNDING = 1e-12  # relative: half-planes and norms are loosened by it, far above their rounding
NEAR = -0.15  # a smooth limit above this, relative, is near to binding

Sizes = Sequence[tuple[float, float]]
Ends = tuple[tuple[float, float], ...]


def relative_excess(
    problem: Problem,
    segment: PlacedSegment,
    theta: Array,
    size: tuple[float, ...],
    limits: Sequence[Limit] | None = None,
) -> Array:
    """By how much limits, by default those on a traced point, are exceeded at angles, relative."""
    machine, s = problem.machine, segment.placed().derivatives(theta)
    if limits is None:
        limits = [limit for limit in problem.limits if limit.box_bounds(segment, machine)]
    values = [v for x in limits for v in x.smooth_constraints(segment, machine, theta, s, size)]
    return np.asarray(np.max([np.full(len(theta), -np.inf), *values], axis=0))


def binds_on_fixed_motion(problem: Problem, size: tuple[float, ...]) -> bool:
    """Whether a traced limit is near to binding on a given segment at a size, or broken."""
    given = (segment for segment in problem.segments if segment.law is not None)
    return any(np.max(relative_excess(problem, s, _angles(problem, s), size)) > NEAR for s in given)


def fixed_motion_rows(problem: Problem, sizes: Sizes, scales: Scales) -> Iterator[LinearBlock]:
    """What traced limits imply on given segments within a box of sizes [length].

    Rows that all of the box keeps are left out.
    """
    ends = np.array(sizes)
    for rows, upper, source in _rows(problem, ends[:, :, None]):
        broken = np.sum(np.max(rows[:, None] * ends[:, :, None], axis=1), axis=0) > upper
        size = rows[:, broken].T * scales.size
        unit = np.maximum(np.max(np.abs(size), axis=1), 1e-300)
        if len(size):
            yield LinearBlock.of_size(size / unit[:, None], upper[broken] / unit, source)


def tighten_sizes(problem: Problem, sizes: Ends) -> Ends:
    """The box of sizes without what given segments exclude of it, as far as that goes."""
    if all(segment.law is None for segment in problem.segments):
        return sizes
    for _ in range(REPEATED):
        before, sizes = sizes, _remove_excluded_slices(problem, sizes)
        (low, high), (first, last) = sizes[0], before[0]
        if high - low > SHRUNK * (last - first):
            break
    return sizes


def _remove_excluded_slices(problem: Problem, sizes: Ends) -> Ends:
    """Cut into pieces across its first size, a box loses slice after slice from below in the last.

    It may end up empty: then its last size is from what is above all of it to below.
    """
    ends = np.array(sizes, dtype=float)
    first, last = ends[0].tolist()
    pieces = PIECES if last > first and len(ends) > 1 else 1
    cuts = np.linspace(first, last, pieces + 1)
    boxes = np.repeat(ends[:, :, None], pieces, axis=2)
    boxes[0] = np.stack([cuts[:-1], cuts[1:]])
    step, gone = np.ptp(boxes[-1], axis=0), np.zeros(pieces, dtype=bool)
    slices = boxes.copy()
    slices[-1, 1] = slices[-1, 0] + step * 0.5**SLICES
    if not np.any(is_excluded(problem, slices)):
        return sizes  # nor is any thicker slice, which holds one of these
    for _ in range(SLICES):
        slices = boxes.copy()
        slices[-1, 1] = np.minimum(boxes[-1, 0] + step, boxes[-1, 1])
        empty = is_excluded(problem, slices)
        boxes[-1, 0] = np.where(empty, slices[-1, 1], boxes[-1, 0])
        gone |= empty & (slices[-1, 1] >= boxes[-1, 1])
        step = np.where(empty, 1.5 * step, 0.5 * step)
    left = ~gone
    if not np.any(left):
        above = float(ends[-1, 1])
        return (*sizes[:-1], (above + 1.0, above))
    return tuple((float(np.min(low[left])), float(np.max(high[left]))) for low, high in boxes)


def is_excluded(
    problem: Problem, boxes: Array, samples: int = SAMPLES, *, worst: int | None = WORST
) -> NDArray[np.bool_]:
    """Whether some row is broken all over boxes of sizes: (d, 2, b) to (b,).

    ``samples``: of a segment; the narrower boxes are, the more tell something. ``worst``: angles at
    which a traced limit is asked, as in ``_rows``.
    """
    result = np.zeros(boxes.shape[2], dtype=bool)
    for rows, upper, _ in _rows(problem, boxes, samples, worst=worst):
        least = np.sum(
            np.min(rows.reshape(len(rows), 1, -1, len(result)) * boxes[:, :, None], axis=1), axis=0
        )
        result |= np.any(least > upper.reshape(-1, len(result)), axis=0)
    for cone in (*problem.norm_bounds, *problem.least_norms):
        nearest, farthest = norm_range(cone.norm, boxes)
        beyond = nearest > cone.upper * (1.0 + ROUNDING)
        result |= beyond | (farthest < cone.lower * (1.0 - ROUNDING))
    return result


def norm_range(norm: AffineNorm, boxes: Array) -> tuple[Array, Array]:
    """A lower and an upper bound of a norm on boxes of sizes: (d, 2, b) to (b,) each."""
    matrix, shift = np.array(norm.matrix), np.array(norm.shift)
    middle, half = boxes.mean(axis=1), 0.5 * np.ptp(boxes, axis=1)
    away, reach = np.abs(matrix @ middle + shift[:, None]), np.abs(matrix) @ half
    nearest = np.maximum(away - reach, 0.0)
    return np.linalg.norm(nearest, axis=0), np.linalg.norm(away + reach, axis=0)


def _rows(
    problem: Problem, boxes: Array, samples: int = SAMPLES, *, worst: int | None = None
) -> Iterator[tuple[Array, Array, str]]:
    """Rows · z ≤ upper of every limit on every given segment: (d, n b) and (n b,), its source.

    ``boxes``: (d, 2, b) of sizes; each has n rows of its own, which run slower.
    ``worst``: of a traced limit, no more angles of a segment in each box, those at which the box's
    middle exceeds it most; None: all.
    """
    farthest, count = np.abs(boxes).max(axis=(1, 2)), boxes.shape[2]
    for segment in problem.segments:
        if segment.law is None:
            continue
        theta = _angles(problem, segment, samples)
        motion = segment.placed().derivatives(theta)
        for limit in problem.limits:
            traced = limit.curvature_bounds(segment, problem.machine)
            if traced:
                where = np.tile(np.arange(len(theta))[:, None], count)
                if worst is not None and worst < len(theta):
                    excess = _excess_in_middle(problem, segment, limit, theta, motion, boxes)
                    if excess is not None:
                        where = np.argpartition(-excess, worst, axis=0)[:worst]
                each, sizes = motion[:3, where.ravel()], np.tile(boxes, len(where))
                ends = tuple((size[0], size[1]) for size in sizes)
                box = MotionBox(theta[where.ravel()], each, each, ends)
            for implied in traced:
                low, high = _box(implied.coordinates, each, sizes)
                for cuts in implied.linear_relaxation(low, high, None, box):
                    upper = cuts.upper - np.sum(cuts.coefficients[:3] * each, axis=0)
                    yield cuts.size, upper, implied.source
            # Of a fixed motion these are linear in the size, whatever the box.
            for curve in limit.nonconvex(segment, problem.machine):
                for planes in curve.half_planes(motion):
                    terms = np.abs(planes.upper) + farthest @ np.abs(planes.size)
                    upper = np.repeat(planes.upper + ROUNDING * terms, count)
                    yield np.repeat(planes.size, count, axis=1), upper, curve.source


def _excess_in_middle(
    problem: Problem, segment: PlacedSegment, limit: Limit, theta: Array, motion: Array,
    boxes: Array,
) -> Array | None:  # fmt: skip
    """By how much a limit is exceeded in the middle of each box at each angle: (n, b).

    None where that is said by rows alone.
    """
    count = boxes.shape[2]
    each, middle = np.repeat(motion, count, axis=1), np.tile(boxes.mean(axis=1), len(theta))
    with np.errstate(all="ignore"):
        values = limit.smooth_constraints(
            segment, problem.machine, np.repeat(theta, count), each, tuple(middle)
        )
    return np.max(values, axis=0).reshape(-1, count) if values else None


def _angles(problem: Problem, segment: PlacedSegment, samples: int = SAMPLES) -> Array:
    """Cam angles of a segment at which its rows are written."""
    load = problem.machine.load
    bends = np.zeros(0) if load is None else load.process.breaks
    inner = bends[(bends > segment.start) & (bends < segment.end)]
    # nothing but the load changes along a dwell, and that is straight between these
    count = samples if segment.lift else 1
    return np.union1d(np.linspace(segment.start, segment.end, count + 1), inner)


def _box(seen: SlideCoordinates, s: Array, boxes: Array) -> tuple[Array, Array]:
    """Bounds of X, u and e, (3, n), for a motion (3, n) and boxes (d, 2, n) of sizes.

    They are linear in the size.
    """
    middle, half = boxes.mean(axis=1), 0.5 * np.ptp(boxes, axis=1)
    by = np.array(seen.size_factors)
    at = np.stack(seen.evaluate(s, [0.0] * len(middle))) + by @ middle
    reach = np.abs(by) @ half
    return at - reach, at + reach


def reverse_convex_rows(
    problem: Problem, sizes: Sequence[tuple[float, float]], scales: Scales
) -> Iterator[LinearBlock]:
    """What least norms and the least prime radius imply within ranges of the size [length]."""
    yield from least_norm_rows(problem, sizes, scales)
    if problem.sizing.min_norm > 0.0:
        yield from outside_ball_rows(
            problem.machine.follower.radius_norm(), problem.sizing.min_norm, sizes, scales
        )


def least_norm_rows(
    problem: Problem, sizes: Sequence[tuple[float, float]], scales: Scales
) -> Iterator[LinearBlock]:
    """What least norms that limits state imply within ranges of the size [length]."""
    for bound in problem.least_norms:
        yield from outside_ball_rows(bound.norm, bound.lower, sizes, scales)


def outside_ball_rows(
    norm: AffineNorm, least: float, sizes: Sequence[tuple[float, float]], scales: Scales
) -> Iterator[LinearBlock]:
    """What a norm of the size from ``least`` on implies within ranges [length].

    −Σ (low + high) y ≤ −least² − Σ low · high, y = matrix · z + shift; none where all is far.
    """
    matrix, shift = np.array(norm.matrix), np.array(norm.shift)
    middle, half = np.array(sizes).mean(axis=1), 0.5 * np.ptp(np.array(sizes), axis=1)
    centre, reach = matrix @ middle + shift, np.abs(matrix) @ half
    low, high = centre - reach, centre + reach
    nearest = np.where((low < 0.0) & (high > 0.0), 0.0, np.minimum(np.abs(low), np.abs(high)))
    if np.sum(nearest**2) >= least**2 or not np.all(np.isfinite(reach)):
        return
    size = -(low + high) @ matrix * scales.size
    upper = -(least**2) - float(low @ high) + float((low + high) @ shift)
    unit = max(float(np.max(np.abs(size))), 1e-300)
    yield LinearBlock.of_size(size / unit, np.array([upper / unit]), "farther")
