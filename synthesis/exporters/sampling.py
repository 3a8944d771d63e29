"""At which cam angles a file has its rows.

Two orders are needed. A table runs from cam angle 0 to 360°, both included, and has two rows,
the limits from the left and from the right, where a derivative jumps. A point file is one closed
ring that begins in the middle of the longest dwell and holds no point twice. Both hit every border
between two segments exactly.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from synthesis.exporters.cam import Cam, Mask
from synthesis.exporters.chords import COARSEST, chord_angles
from synthesis.exporters.options import MotionOptions, ProfileOptions
from synthesis.exporters.placement import placed
from synthesis.numerics.piecewise import Array
from synthesis.profile import CamProfile
from synthesis.units import DEGREE, FULL_TURN

SAME_ANGLE = 1e-9  # [rad]
CROWDED = 0.25  # in a ring, a point nearer to a joint than this part of the step gives way to it
RING_DECIMALS = 10  # points that agree so far [mm] are one point


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


def table_rows(cam: Cam, options: ProfileOptions | MotionOptions) -> Rows:
    """Rows of a table: cam angle 0 to 360°."""
    joints = cam.joints.marked(3)
    if isinstance(options, ProfileOptions) and options.tolerance_um is not None:
        ends = np.append(joints, FULL_TURN)
        theta = chord_angles(cam, ends, options.curve, options.tolerance_um * 1e-3)
    else:
        theta = _merged(_uniform(options.points_per_degree), joints, SAME_ANGLE)
        theta = np.append(theta, FULL_TURN)
    jumps = cam.joints.breaking(3)
    twice = np.isin(theta, jumps[jumps > 0.0])
    rows = np.repeat(theta, 1 + twice)
    before = np.repeat(twice, 1 + twice) & (np.append(np.diff(rows), 1.0) == 0.0)
    side = np.where(np.isin(rows, jumps), 1, 0) - np.where(before, 2, 0)
    side[-1] = -side[0]  # the turn's two ends are the two sides of cam angle 0
    left = side < 0
    left[-1] = True
    return Rows(rows, in_degrees(rows), side, left)


def ring(cam: Cam, options: ProfileOptions) -> CamProfile:
    """The closed curve from its seam, in the order of rising cam angle, not yet closed."""
    theta = _ring_angles(cam, options)
    # Only where s' jumps does the point itself have two sides.
    twice = np.isin(theta, cam.joints.breaking(1))
    rows = np.repeat(theta, 1 + twice)
    left = np.repeat(twice, 1 + twice) & (np.append(np.diff(rows), 1.0) == 0.0)
    return cam.at(rows, left)


def ring_points(cam: Cam, options: ProfileOptions) -> Array:
    """Points (n, 2) of the closed curve [mm] from its seam; none is repeated, the first neither.

    They are turned as the options ask.
    """
    points = np.column_stack(placed(options, ring(cam, options)))
    rounded = np.round(points, RING_DECIMALS)
    new = np.any(rounded != np.roll(rounded, 1, axis=0), axis=1)
    new[0] = True
    return points[new]


def in_degrees(theta: Array) -> Array:
    """Radians to degrees, without the last digits' noise: 60, not 60.00000000000001."""
    exact = theta / DEGREE
    short = np.round(exact, 9)
    return np.where(np.abs(exact - short) < 1e-12, short, exact)


def _uniform(points_per_degree: float) -> Array:
    """Angles k · 360°/N in [0, 360°) [rad], N rounded up to a whole number."""
    least = 360.0 / (COARSEST / DEGREE)
    count = math.ceil(max(360.0 * points_per_degree - 1e-9, least))
    return np.arange(count) * 360.0 / count * DEGREE


def _merged(grid: Array, joints: Array, apart: float) -> Array:
    """Both, increasing; grid angles within ``apart`` of a joint, also across 2π, give way."""
    around = np.concatenate([[joints[-1] - FULL_TURN], joints, [joints[0] + FULL_TURN]])
    after = np.searchsorted(around, grid)
    gap = np.minimum(around[np.clip(after, 0, len(around) - 1)] - grid, grid - around[after - 1])
    return np.sort(np.concatenate([grid[gap > apart], joints]))


def _ring_angles(cam: Cam, options: ProfileOptions) -> Array:
    """Angles of a ring in [0, 2π) [rad], the seam first; joints and the seam are exact."""
    joints = cam.joints.marked(2)
    nearest = float(joints[np.argmin(np.abs(joints - cam.seam))])
    seam = nearest if abs(nearest - cam.seam) <= SAME_ANGLE else cam.seam
    marks = np.union1d(joints, [seam])
    if options.tolerance_um is not None:
        ends = np.append(marks, FULL_TURN)
        theta = chord_angles(cam, ends, options.curve, options.tolerance_um * 1e-3)[:-1]
    else:
        grid = (seam + _uniform(options.points_per_degree)) % FULL_TURN
        theta = _merged(grid, marks, CROWDED * FULL_TURN / len(grid))
    return np.roll(theta, -int(np.searchsorted(theta, seam)))
