"""Measured points to a smooth closed outline that runs clockwise round the cam's axis."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from synthesis.errors import InputError
from synthesis.measured.crossings import first_crossing
from synthesis.numerics.periodic import PeriodicSpline, smoothed
from synthesis.numerics.piecewise import Array

FEWEST: Final = 24
WIDEST_GAP: Final = 6.0  # times the next largest step: wider, and the curve is not closed
MOST_INTERVALS: Final = 1800
FINER: Final = 12  # points read from the outline per knot interval
FIELD: Final = "/points_mm"


@dataclass(frozen=True, eq=False)
class Outline:
    """The smooth outline, read at many places; all (n,) or (2, n) in the frame of a ccw cam [mm].

    Attributes:
        point: profile points. normal: outward unit normals. bend: signed curvature, convex
            positive [1/mm].
        points: how many were measured. rms, largest: their residuals [mm].
    """

    point: Array
    normal: Array
    bend: Array
    points: int
    rms: float
    largest: float


def outline(points: Array, tolerance: float) -> Outline:
    """The smoothest outline that passes within a tolerance of every point.

    Args:
        points: (n, 2) in order round the cam, in either direction, in the frame of a ccw cam [mm].
        tolerance: [mm].

    Raises:
        InputError: too few points, a gap, a curve that crosses itself or misses the axis, or
            points that scatter more than the tolerance.
    """
    ring = _ring(points)
    steps = np.hypot(*(np.roll(ring, -1, axis=0) - ring).T)
    along = np.concatenate([[0.0], np.cumsum(steps)])
    intervals = int(min(max(len(ring) // 2, FEWEST), MOST_INTERVALS))
    curve, residual = smoothed(intervals, float(along[-1]), along[:-1], ring, tolerance)
    off = np.hypot(*residual.T)
    if np.max(off) > tolerance:
        worst = int(np.argmax(off))
        raise InputError(
            "/tolerance_mm", tolerance,
            f"The points scatter by {np.max(off):.3g} mm about any smooth curve, most at "
            f"x = {ring[worst, 0]:.6g}, y = {ring[worst, 1]:.6g} mm.",
            "Allow that much, remove outliers, or measure more points where the curve bends.",
        )  # fmt: skip
    return _read(curve, FINER * intervals, off)


def _read(curve: PeriodicSpline, count: int, off: Array) -> Outline:
    u = curve.period * np.arange(count) / count
    point, (tx, ty), (sx, sy) = (curve(u, order).T for order in range(3))
    speed = np.hypot(tx, ty)
    normal, bend = np.stack([-ty, tx]) / speed, (ty * sx - tx * sy) / speed**3
    rms, largest = float(np.sqrt(np.mean(off**2))), float(np.max(off))
    return Outline(point, normal, bend, len(off), rms, largest)


def _ring(points: Array) -> Array:
    """The points as a clockwise ring without repetitions; checked."""
    apart = np.hypot(*(np.roll(points, -1, axis=0) - points).T)
    size = float(np.max(np.abs(points)))
    ring = points[apart > 1e-9 * size]
    if len(ring) < FEWEST:
        raise InputError(
            FIELD, len(ring), f"There are fewer than {FEWEST} different points.",
            "Measure more: a few hundred make a good reading.",
        )  # fmt: skip
    x, y = ring.T
    following = np.roll(ring, -1, axis=0)
    _closed(ring, following)
    place = first_crossing(ring)
    if place is not None:
        raise InputError(
            FIELD, [round(float(c), 6) for c in place],
            "The curve through the points crosses itself here.",
            "Give the points in order along the profile, without overlap of the ends.",
        )  # fmt: skip
    cross = x * following[:, 1] - y * following[:, 0]
    turn = np.sum(np.arctan2(cross, np.sum(ring * following, axis=1)))
    if abs(turn) < np.pi:
        raise InputError(
            FIELD, [0.0, 0.0], "The cam's axis, x = y = 0, is not inside the curve.",
            "Shift the points so that the axis is their origin.",
        )  # fmt: skip
    clockwise: Array = ring[::-1] if turn > 0.0 else ring
    return clockwise


def _closed(ring: Array, following: Array) -> None:
    """Refuse a curve with a gap: one step far longer than all others."""
    steps = np.hypot(*(following - ring).T)
    widest = int(np.argmax(steps))
    second = float(np.partition(steps, -2)[-2])
    if steps[widest] > WIDEST_GAP * second:
        ends = (*ring[widest], *following[widest])
        raise InputError(
            FIELD, round(float(steps[widest]), 6),
            "The curve is not closed: between ({:.6g}, {:.6g}) and ({:.6g}, {:.6g}) mm there is "
            "a gap this wide, and the next widest step is {:.3g} mm.".format(*ends, second),
            "Measure the whole profile, once round.",
        )  # fmt: skip
