"""What the follower does on a curve that somebody made of a cam.

The curve is known by its points, its directions and its curvature: Q, T and κ, at each of which the
follower touches it. From these alone follow, one after the other, in the frame of a ccw cam:

    cam angle θ and displacement s    the follower's point, turned into the cam, lies on the curve
    velocity s'                       its path on the cam runs along T
    acceleration s''                  and bends as κ says

which is exact: no difference is taken of positions. A roller's centre runs along p = Q + g n, g the
gap between the curves, n the normal to the left of T, and p has the curvature κ / (1 + g κ). Where
1 + g κ is not positive the roller does not fit the hollow, knocks from one side of it to the other,
and the acceleration is infinite. Under a flat face Q itself is traced, θ and s follow from the
normal together with s', and the radius of curvature gives s''.

The cam's own formulas are used in one direction only, from motion to path (``position``).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from synthesis.catalogue.followers.flat_face import flat_face
from synthesis.exporters.samples.cam import Cam
from synthesis.numerics.geometry.plane import to_cam
from synthesis.numerics.piecewise import Array

ROUNDS = 12  # of Newton's method at most, from the neighbourhood of the answer
SETTLED = 1e-12  # last step, relative to the cam's size
STEP = 1e-6  # of its differences, by the cam's size


@dataclass(frozen=True, eq=False)
class Touched:
    """A curve in the frame of a ccw cam, run through with rising cam angle, clockwise.

    Attributes:
        x, y: (n,) points [mm]. tx, ty: (n,) unit vectors along it. bend: (n,) its curvature,
            convex positive [1/mm].
    """

    x: Array
    y: Array
    tx: Array
    ty: Array
    bend: Array


@dataclass(frozen=True, eq=False)
class Ridden:
    """The follower's motion, point by point: cam angle [rad], s, s', s'' [mm, per radian], (n,).

    s'' is infinite where the roller does not reach the curve.
    """

    theta: Array
    s: Array
    v: Array
    a: Array


def ride(cam: Cam, curve: Touched, near: Array) -> Ridden:
    """Let the follower run along a curve.

    Args:
        cam: the cam whose curve it nearly is. near: (n,) cam angles nearby [rad].
    """
    return (
        _faced(cam, curve, near)
        if flat_face(cam.follower) is not None
        else _rolled(cam, curve, near)
    )


def traced(cam: Cam, curve: Touched) -> Touched:
    """The path of the point that the follower carries; no curvature where it turns back."""
    gap = cam.gap
    shrunk = 1.0 + gap * curve.bend
    with np.errstate(divide="ignore", invalid="ignore"):
        bend = np.where(shrunk > 0.0, curve.bend / shrunk, np.nan)
    return Touched(curve.x - gap * curve.ty, curve.y + gap * curve.tx, curve.tx, curve.ty, bend)


def _point(cam: Cam, s: Any, v: Any, a: Any) -> Any:
    """The traced point, its first and second derivative at motions s, s', s'' with s''' = 0."""
    zero = 0.0 * s
    return cam.flank.trace.position((s, v + zero, a + zero, zero), cam.size)


def _rolled(cam: Cam, curve: Touched, near: Array) -> Ridden:
    path = traced(cam, curve)
    theta, s = near, cam.motion.derivatives(near, 0)[0]
    for _ in range(ROUNDS):
        x, y = to_cam(-theta, path.x, path.y)
        (px, py), (ax, ay), *_ = _point(cam, s, 1.0, 0.0)
        bx, by = py, -px  # J p
        det = bx * ay - by * ax
        rx, ry = x - px, y - py
        turn = (rx * ay - ry * ax) / det
        theta, s = theta + turn, s + (bx * ry - by * rx) / det
        if np.max(np.abs(turn)) < SETTLED:
            break
    tx, ty = to_cam(-theta, path.tx, path.ty)
    (px, py), (ax, ay), *_ = _point(cam, s, 1.0, 0.0)
    v = -(py * ty + px * tx) / (ax * ty - ay * tx)
    return Ridden(theta, s, v, _bent(cam, s, v, path.bend))


def _bent(cam: Cam, s: Array, v: Array, bend: Array) -> Array:
    """s'' of a path of this curvature, in which it is linear; infinite where there is none."""
    at = []
    for a in (0.0, 1.0):
        (px, py), (dx, dy), (ax, ay), *_ = _point(cam, s, v, a)
        tx, ty = dx + py, dy - px
        sx, sy = ax + dy + ty, ay - dx - tx
        at.append((ty * sx - tx * sy) / np.hypot(tx, ty) ** 3)
    found = (bend - at[0]) / (at[1] - at[0])
    return np.where(np.isnan(bend), np.inf, found)


def _faced(cam: Cam, curve: Touched, near: Array) -> Ridden:
    trace, z = cam.flank.trace, cam.size
    size = float(np.max(np.hypot(curve.x, curve.y)))
    found = np.stack([near, *cam.motion.derivatives(near, 1)])

    def missed(motion: Array) -> Array:
        """(3, n) how far contact and normal lie from the curve's, all as the machine sees it."""
        theta, s, v = motion
        (px, py), *_ = _point(cam, s, v, 0.0)
        nx, ny = trace.normal((curve.tx, curve.ty), (s, v, 0.0 * s, 0.0 * s), z)
        (x, y), (tx, ty) = to_cam(-theta, curve.x, curve.y), to_cam(-theta, curve.tx, curve.ty)
        return np.stack([px - x, py - y, size * (nx * tx + ny * ty)])

    scales = np.array([1.0, size, size])
    steps = STEP * np.diag(scales)[:, :, None]
    for _ in range(ROUNDS):
        at = missed(found)
        columns = [missed(found + step) - at for step in steps]
        turn = scales[:, None] * STEP * _solved(np.stack(columns, axis=1), at)
        found = found - turn
        if np.max(np.abs(turn) / scales[:, None]) < SETTLED:
            break
    theta, s, v = found
    (tx, ty), zero = to_cam(-theta, curve.tx, curve.ty), 0.0 * s
    face = flat_face(trace)
    assert face is not None
    wx, wy = face.face_normal_rate((s, v, zero, zero), z)
    along = []
    for a in (0.0, 1.0):
        (px, py), (dx, dy), *_ = _point(cam, s, v, a)
        along.append((dx + py) * tx + (dy - px) * ty)
    with np.errstate(divide="ignore", invalid="ignore"):
        wanted = np.where(curve.bend > 0.0, (wx * tx + wy * ty) / curve.bend, np.inf)
    return Ridden(theta, s, v, (wanted - along[0]) / (along[1] - along[0]))


def _solved(matrix: Array, right: Array) -> Array:
    """Solve (3, 3, n) systems with right sides (3, n) by Cramer's rule."""
    a, b, c = matrix[:, 0], matrix[:, 1], matrix[:, 2]

    def det(one: Array, two: Array, three: Array) -> Array:
        return np.asarray(np.sum(one * np.cross(two, three, axis=0), axis=0))

    found = np.stack([det(right, b, c), det(a, right, c), det(a, b, right)]) / det(a, b, c)
    return np.asarray(found)
