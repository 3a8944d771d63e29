"""A smooth closed outline through measured points, clockwise around the cam's axis."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from synthesis.errors import InputError
from synthesis.numerics.periodic_spline import fit_smoothing
from synthesis.numerics.piecewise import Array

MIN_POINTS: Final = 24
WIDEST_GAP: Final = 6.0  # next largest steps: a wider gap means that the curve is not closed
MAX_INTERVALS: Final = 1800  # of the spline
SAMPLES_PER_INTERVAL: Final = 12  # of the outline
REPEATED: Final = 1e-9  # of the size: nearer points are one
BLOCK: Final = 48  # sides of the polygon that share a bounding box
FIELD: Final = "/points_mm"


@dataclass(frozen=True, eq=False)
class Outline:
    """The outline at many places; arrays (n,) or (2, n) in the frame of a ccw cam [mm].

    Attributes:
        point: profile points. normal: outward unit normals. bend: signed curvature, convex
            positive [1/mm].
        points: number of measured points. rms, largest: of their residuals [mm].
    """

    point: Array
    normal: Array
    bend: Array
    points: int
    rms: float
    largest: float


def outline(points: Array, tolerance: float) -> Outline:
    """The smoothest periodic spline within a tolerance of every point.

    Args:
        points: (n, 2) in order round the cam, in either direction, in the frame of a ccw cam [mm].
        tolerance: [mm].

    Raises:
        InputError: too few points, a gap, a curve that crosses itself or misses the axis, or
            points that scatter more than the tolerance.
    """
    ring = _checked_ring(points)
    # Parameter: the length of the polygon through the points, about that of the curve.
    steps = np.hypot(*(np.roll(ring, -1, axis=0) - ring).T)
    along = np.concatenate([[0.0], np.cumsum(steps)])
    intervals = int(min(max(len(ring) // 2, MIN_POINTS), MAX_INTERVALS))
    curve, residual = fit_smoothing(intervals, float(along[-1]), along[:-1], ring, tolerance)
    off = np.hypot(*residual.T)
    if np.max(off) > tolerance:
        worst = int(np.argmax(off))
        raise InputError(
            "/tolerance_mm", tolerance,
            f"The points scatter by {np.max(off):.3g} mm about a smooth curve, most at "
            f"x = {ring[worst, 0]:.6g}, y = {ring[worst, 1]:.6g} mm.",
            "Increase tolerance_mm, remove outliers, or measure more points where the curve bends.",
        )  # fmt: skip
    count = SAMPLES_PER_INTERVAL * intervals
    u = curve.period * np.arange(count) / count
    point, (tx, ty), (sx, sy) = (curve(u, order).T for order in range(3))
    speed = np.hypot(tx, ty)
    normal, bend = np.stack([-ty, tx]) / speed, (ty * sx - tx * sy) / speed**3
    rms, largest = float(np.sqrt(np.mean(off**2))), float(np.max(off))
    return Outline(point, normal, bend, len(off), rms, largest)


def _checked_ring(points: Array) -> Array:
    """The points as a clockwise ring without repetitions, checked."""
    steps = np.hypot(*(np.roll(points, -1, axis=0) - points).T)
    distinct = steps > REPEATED * float(np.max(np.abs(points)))
    ring = points[distinct]
    if len(ring) < MIN_POINTS:
        raise InputError(
            FIELD, len(ring), f"There are fewer than {MIN_POINTS} different points.",
            "Measure more points; a few hundred give a good result.",
        )  # fmt: skip
    following = np.roll(ring, -1, axis=0)
    # A gap: one step much longer than all others.
    steps = np.hypot(*(following - ring).T)
    widest, second = int(np.argmax(steps)), float(np.partition(steps, -2)[-2])
    if steps[widest] > WIDEST_GAP * second:
        ends = (*ring[widest], *following[widest])
        raise InputError(
            FIELD, round(float(steps[widest]), 6),
            "The curve is not closed: between ({:.6g}, {:.6g}) and ({:.6g}, {:.6g}) mm there is "
            "a gap this wide, and the next widest step is {:.3g} mm.".format(*ends, second),
            "Measure the whole profile.",
        )  # fmt: skip
    place = first_crossing(ring)
    if place is not None:
        raise InputError(
            FIELD, [round(float(c), 6) for c in place],
            "The curve through the points crosses itself here.",
            "Give the points in order along the profile, without overlap at the ends.",
        )  # fmt: skip
    # The winding number about the axis; its sign is the direction of the points.
    angles = np.arctan2(_cross(ring, following), np.sum(ring * following, axis=1))
    turn = float(np.sum(angles))
    if abs(turn) < np.pi:
        raise InputError(
            FIELD, [0.0, 0.0], "The cam's axis, x = y = 0, is not inside the curve.",
            "Shift the points so that the cam's axis is the origin.",
        )  # fmt: skip
    return np.asarray(ring[::-1] if turn > 0.0 else ring)


def first_crossing(ring: Array) -> tuple[float, float] | None:
    """A point where two sides of a closed polygon (n, 2) cross; None where none do.

    Blocks of sides are compared by their bounding boxes first, so that long rings are cheap.
    """
    n, ends = len(ring), np.roll(ring, -1, axis=0)
    sides = ends - ring
    firsts = np.arange(0, n, BLOCK)
    low = np.minimum.reduceat(np.minimum(ring, ends), firsts)
    high = np.maximum.reduceat(np.maximum(ring, ends), firsts)
    meet = np.all((low[:, None] <= high) & (low <= high[:, None]), axis=2)
    for a, b in np.argwhere(np.triu(meet)):
        i, j = (np.arange(k * BLOCK, min((k + 1) * BLOCK, n)) for k in (a, b))
        # p + t r = q + w s, for every side i and every side j that is not its neighbour.
        p, r = ring[i][:, None], sides[i][:, None]
        s, to = sides[j][None], ring[j][None] - p
        across = _cross(r, s)
        separation = (j[None] - i[:, None]) % n
        proper = (separation > 1) & (separation < n - 1) & (across != 0.0)
        safe = np.where(proper, across, 1.0)
        t, w = _cross(to, s) / safe, _cross(to, r) / safe
        hits = np.argwhere(proper & (t >= 0.0) & (t <= 1.0) & (w >= 0.0) & (w <= 1.0))
        if len(hits):
            k, m = hits[0]
            x, y = p[k, 0] + t[k, m] * r[k, 0]
            return float(x), float(y)
    return None


def _cross(a: Array, b: Array) -> Array:
    """z component of the cross product of vectors (…, 2)."""
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])
