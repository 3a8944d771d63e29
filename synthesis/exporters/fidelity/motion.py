"""The motion of a follower on a curve that nearly is the cam's.

At each sample Q of such a curve, with unit tangent T and curvature κ, the follower touches it. From
these alone follow, one after the other, in the frame of a ccw cam:

    cam angle θ and displacement s    the follower's point, turned into the cam, lies on the curve
    velocity s'                       its path on the cam runs along T
    acceleration s''                  and has the curvature κ

which is exact: no difference is taken of positions. A roller's centre runs along p = Q + g n, g the
gap between the curves, n the normal to the left of T, and p has the curvature κ / (1 + g κ). Where
1 + g κ is not positive the roller does not fit the hollow, knocks from one side of it to the other,
and the acceleration is infinite. Under a flat face θ, s and s' follow from point and normal
together, and the radius of curvature gives s''. The cam's own formulas are used in one direction
only, from motion to path (``position``).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from synthesis.catalogue.followers.base import flat_face
from synthesis.exporters.samples.cam import Cam
from synthesis.numerics.geometry.plane import to_cam
from synthesis.numerics.piecewise import Array

MAX_ITERATIONS = 12  # of Newton's method, from the neighbourhood of the answer
# Of what is left, relative to the cam's size. With exact derivatives it is about the square of the
# last step, for the path's curvatures are of the order of one in this unit.
TOLERANCE = 1e-12
STEP = 1e-6  # of its difference quotients, relative to the cam's size


class CurveSamples(NamedTuple):
    """A curve in the frame of a ccw cam, in the order of rising cam angle, clockwise; (n,) each.

    x, y: points [mm]. tx, ty: unit tangents. curvature: convex positive [1/mm].
    """

    x: Array
    y: Array
    tx: Array
    ty: Array
    curvature: Array


class FollowerMotion(NamedTuple):
    """The follower's motion, sample by sample: cam angle [rad], s, s', s'' [mm, per radian], (n,).

    s'' is infinite where the roller does not reach the curve.
    """

    theta: Array
    s: Array
    v: Array
    a: Array


def follower_motion(cam: Cam, curve: CurveSamples, near: Array) -> FollowerMotion:
    """The motion on a curve that nearly is the cam's; ``near``: (n,) cam angles nearby [rad]."""
    gap = cam.gap
    shrunk = 1.0 + gap * curve.curvature
    with np.errstate(divide="ignore", invalid="ignore"):
        curvature = np.where(shrunk > 0.0, curve.curvature / shrunk, np.nan)
    x, y = curve.x - gap * curve.ty, curve.y + gap * curve.tx
    path = CurveSamples(x, y, curve.tx, curve.ty, curvature)
    with_face = flat_face(cam.follower) is not None
    return (_face_motion if with_face else _roller_motion)(cam, path, near)


def _point(cam: Cam, s: Any, v: Any, a: Any) -> Any:
    """The traced point, its first and second derivative at motions s, s', s'' with s''' = 0."""
    zero = 0.0 * s
    return cam.flank.trace.position((s, v + zero, a + zero, zero), cam.size)


def _roller_motion(cam: Cam, path: CurveSamples, near: Array) -> FollowerMotion:
    theta, s = near, cam.motion.derivatives(near, 0)[0]
    # Newton's method in θ and s: R(−θ) of the path's point is the traced point p(s)
    for _ in range(MAX_ITERATIONS):
        x, y = to_cam(-theta, path.x, path.y)
        (px, py), (ax, ay), *_ = _point(cam, s, 1.0, 0.0)
        bx, by = py, -px  # J p
        det = bx * ay - by * ax
        rx, ry = x - px, y - py
        turn = (rx * ay - ry * ax) / det
        theta, s = theta + turn, s + (bx * ry - by * rx) / det
        if np.max(np.abs(turn)) ** 2 < TOLERANCE:
            break
    tx, ty = to_cam(-theta, path.tx, path.ty)
    (px, py), (ax, ay), *_ = _point(cam, s, 1.0, 0.0)
    v = -(py * ty + px * tx) / (ax * ty - ay * tx)
    # The path's curvature is linear in s'': its values at 0 and 1 give the s'' of any other.
    at = []
    for a in (0.0, 1.0):
        (px, py), (dx, dy), (ax, ay), *_ = _point(cam, s, v, a)
        tx, ty = dx + py, dy - px
        sx, sy = ax + dy + ty, ay - dx - tx
        at.append((ty * sx - tx * sy) / np.hypot(tx, ty) ** 3)
    a = (path.curvature - at[0]) / (at[1] - at[0])
    return FollowerMotion(theta, s, v, np.where(np.isnan(path.curvature), np.inf, a))


def _face_motion(cam: Cam, path: CurveSamples, near: Array) -> FollowerMotion:
    trace, z = cam.flank.trace, cam.size
    size = float(np.max(np.hypot(path.x, path.y)))
    motion = np.stack([near, *cam.motion.derivatives(near, 1)])

    def residual(motion: Array) -> Array:
        """(3, n) how far contact and normal lie from the curve's, all as the machine sees it."""
        theta, s, v = motion
        (px, py), *_ = _point(cam, s, v, 0.0)
        nx, ny = trace.normal((path.tx, path.ty), (s, v, 0.0 * s, 0.0 * s), z)
        (x, y), (tx, ty) = to_cam(-theta, path.x, path.y), to_cam(-theta, path.tx, path.ty)
        return np.stack([px - x, py - y, size * (nx * tx + ny * ty)])

    # Newton's method in θ, s and s', its Jacobian by difference quotients
    scales = np.array([1.0, size, size])
    steps = STEP * np.diag(scales)[:, :, None]
    for _ in range(MAX_ITERATIONS):
        at = residual(motion)
        jacobian = np.stack([residual(motion + step) - at for step in steps], axis=1)
        solved = np.linalg.solve(np.moveaxis(jacobian, -1, 0), at.T[:, :, None])[:, :, 0].T
        turn = scales[:, None] * STEP * solved
        motion = motion - turn
        if np.max(np.abs(turn) / scales[:, None]) < TOLERANCE:  # its Jacobian is inexact
            break
    theta, s, v = motion
    (tx, ty), zero = to_cam(-theta, path.tx, path.ty), 0.0 * s
    face = flat_face(trace)
    assert face is not None
    # The contact runs along the curve at the rate of its normal over κ, which is linear in s''.
    wx, wy = face.face_normal_rate((s, v, zero, zero), z)
    along = []
    for a in (0.0, 1.0):
        (px, py), (dx, dy), *_ = _point(cam, s, v, a)
        along.append((dx + py) * tx + (dy - px) * ty)
    with np.errstate(divide="ignore", invalid="ignore"):
        rate = np.where(path.curvature > 0.0, (wx * tx + wy * ty) / path.curvature, np.inf)
    return FollowerMotion(theta, s, v, (rate - along[0]) / (along[1] - along[0]))
