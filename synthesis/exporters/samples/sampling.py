"""At which cam angles a file has its rows, evenly or so that chords keep a tolerance.

Two orders are needed. A table runs from cam angle 0 to 360°, both included, and has two rows,
the limits from the left and from the right, where a derivative jumps. A point file is one closed
ring that begins in the middle of the longest dwell and holds no point twice. Both hit every border
between two segments exactly.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from synthesis.catalogue.profile import CamProfile
from synthesis.errors import InputError
from synthesis.exporters.options import MAX_POINTS, CurveOptions, PointOptions, Sampled
from synthesis.exporters.samples.cam import Cam, Turn
from synthesis.numerics.piecewise import Array, Mask
from synthesis.units import DEGREE, FULL_TURN

COARSEST = 10.0 * DEGREE  # no two points further apart than this
FINEST = 0.5 * DEGREE  # spacing at which the curvature is looked at
PROBES = np.arange(1, 8) / 8.0  # where a chord is measured
MARGIN = 0.93  # measured at the probes, a lobe's top is missed by at most (1/8)² · 4 of its height


def chord_angles(cam: Cam, ends: Array, tolerance: float) -> Array:
    """Angles whose chords keep to a tolerance [mm], all of ``ends`` among them.

    On each span between two ends the spacing follows the curvature, so that all chords depart
    about alike; then every chord is measured, and spans that exceed are sampled more densely.

    ``ends``: (m,) increasing angles [rad], between which the curve is smooth.
    """
    density = [_density(cam, a, b, tolerance) for a, b in pairwise(ends.tolist())]
    most = np.array([max(1.0, np.ceil(total[-1])) for _, total in density])
    while True:
        if not most.sum() <= MAX_POINTS:
            rule = f"This chord tolerance would need more than {MAX_POINTS} points."
            raise InputError("/tolerance_um", tolerance * 1e3, rule, "Allow a larger one.")
        spans = [
            np.interp(np.linspace(0.0, total[-1], int(n) + 1), total, angle)
            for (angle, total), n in zip(density, most, strict=True)
        ]
        excess = np.array([_departure(cam, span) for span in spans]) / (MARGIN * tolerance)
        if np.all(excess <= 1.0):
            return np.concatenate([span[:-1] for span in spans] + [ends[-1:]])
        most = np.where(excess > 1.0, np.ceil(most * np.clip(np.sqrt(excess), 1.02, 4.0)), most)


def _density(cam: Cam, start: float, end: float, tolerance: float) -> tuple[Array, Array]:
    """Angles on a span and the number of chords needed from its start up to them, (k,) each.

    A chord over dθ departs by κ (v dθ)²/8 from a curve of curvature κ run through at v = ds/dθ.
    """
    angle = np.linspace(start, end, max(8, int(np.ceil((end - start) / FINEST))) + 1)
    middle = 0.5 * (angle[1:] + angle[:-1])
    at = cam.at(middle)
    speed_squared = cam.flank.trace.curvature_terms(at.s, cam.size)[1]
    # along a curve at the gap g, v shrinks by 1 − κ g, and κ grows by its inverse
    bend = np.abs(at.curvature * (1.0 - at.curvature * cam.gap))
    needed = np.sqrt(bend * speed_squared / (8.0 * MARGIN * tolerance))
    needed = np.maximum(needed, max(0.1 * float(np.mean(needed)), 1.0 / COARSEST))
    return angle, np.concatenate([[0.0], np.cumsum(needed * np.diff(angle))])


def _departure(cam: Cam, span: Array) -> float:
    """Largest distance of the curve from the chords of one span [mm]."""
    last = np.arange(len(span)) == len(span) - 1  # a span ends with the limit from its own side
    x, y = cam.place(cam.at(span, last))
    probe = span[:-1, None] + PROBES * np.diff(span)[:, None]
    px, py = (value.reshape(probe.shape) for value in cam.place(cam.at(probe.ravel())))
    dx, dy = np.diff(x)[:, None], np.diff(y)[:, None]
    rx, ry = px - x[:-1, None], py - y[:-1, None]
    length = np.maximum(dx * dx + dy * dy, np.finfo(float).tiny)
    along = np.clip((rx * dx + ry * dy) / length, 0.0, 1.0)
    return float(np.max(np.hypot(rx - along * dx, ry - along * dy)))


SAME_ANGLE = 1e-9  # [rad]
CROWDED = 0.25  # in a ring, a point nearer to a joint than this part of the step gives way to it
LEAST_RING = 3  # points of a closed polygon
RUNS = {"ccw": "cw", "cw": "ccw"}  # how cam angles run round a cam, by its rotation


@dataclass(frozen=True, eq=False)
class Rows:
    """Cam angles of a table.

    Attributes:
        theta: (n,) cam angle [rad]. degrees: (n,) the same in degrees, short where it is short.
        side: (n,) −1 and +1: limits from the left and from the right of a jump; otherwise 0.
        left: (n,) where to evaluate from the left: on side −1, and at the turn's end.
    """

    theta: Array
    degrees: Array
    side: NDArray[np.int64]
    left: Mask


def table_rows(cam: Cam, options: Sampled) -> Rows:
    """Rows of a table of one of the cam's curves: cam angle 0 to 360°."""
    if options.chord_mm is None:
        return motion_rows(cam, options.count)
    marks = np.append(cam.joints.marked(3), FULL_TURN)
    return _rows(cam, chord_angles(cam, marks, options.chord_mm))


def motion_rows(turn: Turn, count: float) -> Rows:
    """Rows of a table of the motion, so many in a turn, evenly: cam angle 0 to 360°."""
    theta = _merged(_uniform(count), turn.joints.marked(3), SAME_ANGLE)
    return _rows(turn, np.append(theta, FULL_TURN))


def _rows(turn: Turn, theta: Array) -> Rows:
    """The rows at these cam angles, two of them where a derivative jumps."""
    jumps = turn.joints.breaking(3)
    rows, before = _twice(theta, jumps[jumps > 0.0])
    side = np.where(np.isin(rows, jumps), 1, 0) - np.where(before, 2, 0)
    side[-1] = -side[0]  # the turn's two ends are the two sides of cam angle 0
    left = side < 0
    left[-1] = True
    return Rows(rows, in_degrees(rows), side, left)


def _twice(theta: Array, jumps: Array) -> tuple[Array, Mask]:
    """Angles with the jumps among them twice, and where they stand for the limit from the left."""
    twice = np.isin(theta, jumps)
    rows = np.repeat(theta, 1 + twice)
    return rows, np.repeat(twice, 1 + twice) & (np.append(np.diff(rows), 1.0) == 0.0)


def ring(cam: Cam, count: float, chord_mm: float | None, start: float | None = None) -> CamProfile:
    """The closed curve in the order of rising cam angle, not yet closed.

    So many points in a turn, or as many as chords need to keep to ``chord_mm``; ``start``: cam
    angle of the first point [rad], None: the seam.
    """
    theta = _ring_angles(cam, count, chord_mm, cam.seam if start is None else start % FULL_TURN)
    # Only where s' jumps does the point itself have two sides.
    return cam.at(*_twice(theta, cam.joints.breaking(1)))


@dataclass(frozen=True, eq=False)
class Written:
    """The points of a curve as a file holds them.

    Attributes:
        theta: (n,) cam angles [rad]. points: (n, 2) turned as asked and rounded [mm]; no two
            neighbours are the same, nor are the last and the first.
    """

    theta: Array
    points: Array

    def ended(self, options: PointOptions, closed: bool) -> Array:
        """The points (m, 2) with what is repeated past the end.

        ``closed``: whether the format's readers expect the first point at the end once more.
        """
        repeat_first = closed if options.closed is None else options.closed
        more = options.overlap_points + (repeat_first or options.overlap_points > 0)
        count = len(self.points)
        if more > count:
            rule = f"Of {count} points no more than {count - 1} can be repeated."
            raise options.refusal("overlap_points", rule, "Ask for fewer.")
        return np.vstack([self.points, self.points[:more]])


def written_points(cam: Cam, options: PointOptions) -> Written:
    """The points of the cam's curve, in the order and with the decimals that are asked for."""
    start = None if options.start_deg is None else options.start_deg * DEGREE
    at = ring(cam, options.count, _chord_before_rounding(options), start)
    exact = np.column_stack(place_on_shaft(cam, options, at))
    rounded: Array = np.round(exact, options.decimals) + 0.0  # no −0
    new = np.any(rounded != np.roll(rounded, 1, axis=0), axis=1)
    new[0] = True
    other = np.flatnonzero(np.any(rounded != rounded[0], axis=1))
    new[int(other[-1]) + 1 if len(other) else 1 :] = False  # what repeats the first
    if np.count_nonzero(new) < LEAST_RING:
        rule = f"So rounded, fewer than {LEAST_RING} different points are left of the curve."
        raise options.refusal("decimals", rule, "Keep more decimals.")
    theta, points = at.theta[new], rounded[new]
    if options.direction not in ("cam_angle", RUNS[cam.rotation]):
        theta, points = (np.roll(each[::-1], 1, axis=0) for each in (theta, points))
    return Written(theta, points)


def _chord_before_rounding(options: PointOptions) -> float | None:
    """A chord tolerance [mm] that rounded points keep too: a chord moves as its ends do."""
    moved = math.sqrt(0.5) * 10.0 ** (3 - options.decimals)  # [µm]
    if options.tolerance_um is None:
        return None
    if options.tolerance_um < 2.0 * moved:
        raise options.refusal(
            "decimals",
            f"Rounding alone moves points by up to {moved:.3g} µm, too much for a chord tolerance "
            f"of {options.tolerance_um:.6g} µm.",
            "Keep more decimals, or allow more.",
        )
    return 1e-3 * (options.tolerance_um - moved)


def in_degrees(theta: Array) -> Array:
    """Radians to degrees, without the last digits' noise: 60, not 60.00000000000001."""
    exact = theta / DEGREE
    short = np.round(exact, 9)
    return np.where(np.abs(exact - short) < 1e-12, short, exact)


def whole_count(count: float) -> int:
    """Points in a turn, rounded up to a whole number, none further apart than ``COARSEST``."""
    return math.ceil(max(count - 1e-9, 360.0 / (COARSEST / DEGREE)))


def _uniform(count: float) -> Array:
    """Angles k · 360°/N in [0, 360°) [rad], N rounded up to a whole number."""
    whole = whole_count(count)
    return np.arange(whole) * 360.0 / whole * DEGREE


def _merged(grid: Array, joints: Array, nearest: float) -> Array:
    """Both, increasing; grid angles within ``nearest`` of a joint, also across 2π, give way."""
    around = np.concatenate([[joints[-1] - FULL_TURN], joints, [joints[0] + FULL_TURN]])
    after = np.searchsorted(around, grid)
    gap = np.minimum(around[np.clip(after, 0, len(around) - 1)] - grid, grid - around[after - 1])
    return np.sort(np.concatenate([grid[gap > nearest], joints]))


def _ring_angles(cam: Cam, count: float, chord_mm: float | None, start: float) -> Array:
    """Angles of a ring in [0, 2π) [rad], from its start; joints and the start are exact."""
    joints = cam.joints.marked(2)
    seam = nearby(joints, start)
    marks = np.union1d(joints, [seam])
    if chord_mm is not None:
        theta = chord_angles(cam, np.append(marks, FULL_TURN), chord_mm)[:-1]
    else:
        grid = (seam + _uniform(count)) % FULL_TURN
        theta = _merged(grid, marks, CROWDED * FULL_TURN / len(grid))
    return np.roll(theta, -int(np.searchsorted(theta, seam)))


def nearby(angles: Array, start: float) -> float:
    """The one of some angles that ``start`` is but for rounding, or ``start`` itself [rad]."""
    nearest = float(angles[np.argmin(np.abs(angles - start))])
    return nearest if abs(nearest - start) <= SAME_ANGLE else start


def place_on_shaft(cam: Cam, options: CurveOptions, at: CamProfile) -> tuple[Array, Array]:
    """x and y of the cam's curve [mm], turned by the options' angle to its place on a shaft."""
    return rotate(options.turn_deg, *cam.place(at))


def rotate(degrees: float, x: Array, y: Array) -> tuple[Array, Array]:
    """Turned about the cam's axis, counter-clockwise positive; exact at quarters of a turn."""
    if degrees == 0.0:
        return x, y
    quarters, rest = divmod(degrees, 90.0)
    cos, sin = math.cos(math.radians(rest)), math.sin(math.radians(rest))
    for _ in range(int(quarters) % 4):
        cos, sin = -sin, cos
    return cos * x - sin * y, sin * x + cos * y
