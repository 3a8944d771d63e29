"""Poses of a cylindrical cutter thinner than the roller that machines the roller's wall.

A cutter of the roller's size moves as the roller does and machines both walls. One of radius Rc <
Rr has to keep the distance Rc from the wall: its axis would have to lie on the curve c = p − Rc n
through all contacts p, n the normal into the cam. The normal rotates along the roller's width (the
wall is twisted), so that c is not straight and no such cutter machines the wall exactly. With the
roller's axis direction u, the normal n in the middle, t = u × n, and τ from −1 to 1 over the width,
a line

    c(0) + a n + h τ (u + (b n + d t)/h)

deviates by e(τ) = (a + b τ) n·n(τ) + d τ t·n(τ) − (c(τ) − c(0) − h τ u)·n(τ), to first order; a, b,
d minimise the sum of squares of e. The tilt d, half of the twist, removes the error that grows with
the square of the twist. The rest is measured: the deviation of the cutter's envelope from the wall,
as the least distance of the wall's points from the moving axis, minus Rc.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from synthesis.machines.spatial.cam import SpatialCam, Wall
from synthesis.numerics.geometry.swept_roller import cross, dot, norm
from synthesis.numerics.piecewise import Array

PLACES = 9  # on the roller's axis
STEP = 2e-3  # rad: to the neighbouring poses, between which the cutter is nearest (by a parabola)
RANK = 1e-9  # of the largest singular value: smaller ones count as 0 in the least squares


@dataclass(frozen=True, eq=False)
class CutterPoses:
    """Poses of a cutter.

    Attributes:
        theta: (n,) cam angles [rad].
        centre: (3, n) points of its axis at the middle of the roller's width, machine's frame [mm].
        direction: (3, n) of its axis, away from the roller's ρ = 0.
    """

    theta: Array
    centre: Array
    direction: Array


def roller_poses(cam: SpatialCam, which: Wall, theta: Array) -> CutterPoses:
    """Poses of a cutter of the roller's own form, at cam angles (n,) [rad]."""
    swept = cam.swept
    q = cam.place(which.seat, theta).q
    middle = swept.origin + swept.roller.middle * swept.along
    centre = swept.joint.move_points(middle.reshape(3, 1, 1), q)[:, :, 0]
    return CutterPoses(
        theta, centre, swept.joint.turn_direction(swept.along.reshape(3, 1, 1), q)[:, :, 0]
    )


def flank_poses(cam: SpatialCam, which: Wall, theta: Array, radius: float) -> CutterPoses:
    """Poses of a cylindrical cutter of this radius [mm] on one wall, at cam angles (n,) [rad]."""
    roller = cam.swept.roller
    tau = np.linspace(-1.0, 1.0, PLACES)
    half = 0.5 * (roller.outer - roller.inner)
    found = cam.contacts(which, theta, roller.middle + half * tau)
    wanted = found.point - radius * found.normal
    middle = PLACES // 2
    u = roller_poses(cam, which, theta).direction
    n = found.normal[:, :, middle]
    n = n - dot(n, u) * u
    n = n / norm(n)
    t = cross(u, n)
    on_n, on_t = (dot(each[:, :, None], found.normal) for each in (n, t))
    columns = np.stack([on_n, tau * on_n, tau * on_t], axis=-1)
    line = wanted[:, :, middle, None] + half * tau * u[:, :, None]
    missed = dot(wanted - line, found.normal)
    a, b, d = np.moveaxis(np.linalg.pinv(columns, rcond=RANK) @ missed[:, :, None], 1, 0)[..., 0]
    direction = half * u + b * n + d * t
    return CutterPoses(theta, wanted[:, :, middle] + a * n, direction / norm(direction))


def envelope_error(
    cam: SpatialCam,
    which: Wall,
    poses: tuple[CutterPoses, CutterPoses, CutterPoses],
    radius: float,
) -> Array:
    """Deviation of the cutter's envelope from the wall: (n, m), positive where material is left.

    Args:
        poses: ``STEP`` before, at, and ``STEP`` after the same cam angles (n,).
        radius: of the cutter [mm].
    """
    roller, swept = cam.swept.roller, cam.swept
    theta = poses[1].theta
    rho = np.linspace(roller.inner, roller.outer, PLACES)
    point = swept.on_cam(theta, cam.contacts(which, theta, rho).point)
    before, at, after = (_distance(cam, point, each) for each in poses)
    bend = before + after - 2.0 * at
    least = at - np.where(bend > 0.0, (after - before) ** 2 / (8.0 * np.abs(bend)), 0.0)
    return np.asarray(least - radius)


def _distance(cam: SpatialCam, point: Array, poses: CutterPoses) -> Array:
    """Distance of points (3, n, m) of the cam from the cutter's axis."""
    swept = cam.swept
    centre = swept.on_cam(poses.theta, poses.centre[:, :, None])
    far = poses.centre + poses.direction
    direction = swept.on_cam(poses.theta, far[:, :, None]) - centre
    away = point - centre
    return norm(cross(away, direction + 0.0 * away))
