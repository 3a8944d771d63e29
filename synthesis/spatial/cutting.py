"""Where a cylindrical cutter thinner than the roller has to stand to leave the roller's wall.

A cutter of the roller's size goes where the roller goes and leaves both walls. One of radius
Rc < Rr has to keep Rc from the wall: its axis would have to lie in the surface c = p − Rc n through
all contacts p, n the normal into the cam. The roller's contact runs round it along its width, as
the directions of slip at its ends differ, so that c is no straight line and no such cutter leaves
the wall exactly. With the roller's axis direction u, the normal n in the middle, t = u × n, and τ
from −1 to 1 over the width, a line

    c(0) + a n + h τ (u + (b n + d t)/h)

is off the surface by e(τ) = (a + b τ) n·n(τ) + d τ t·n(τ) − (c(τ) − c(0) − h τ u)·n(τ), to first
order; a, b, d are the least squares of e. Tilting the line by d, half of the twist, takes away what
grows with the square of the twist. What is left is measured: by how much the cutter's envelope
lies off the wall, as the least distance of the wall's points from the moving line, less Rc.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from synthesis.geometry.swept_roller import cross, dot, norm
from synthesis.numerics.piecewise import Array
from synthesis.spatial.cam import SpatialCam, Wall

PLACES = 9  # on the roller's axis
STEP = 2e-3  # cam angle to the neighbours between which the cutter is nearest [rad]
FLAT = 1e-9  # of the largest singular value: what least squares leave alone


@dataclass(frozen=True, eq=False)
class Poses:
    """Places of a cutter.

    Attributes:
        theta: (n,) cam angles [rad]. centre: (3, n) of its axis, in the middle of the roller's
            width, and direction: (3, n) of it away from the roller's ρ = 0, in the machine's frame.
    """

    theta: Array
    centre: Array
    direction: Array


def with_roller(cam: SpatialCam, which: Wall, theta: Array) -> Poses:
    """A cutter of the roller's own form at cam angles (n,) [rad]."""
    swept = cam.swept
    q = cam.place(which.seat, theta).q
    middle = swept.origin + swept.roller.middle * swept.along
    centre = swept.joint.moved(middle.reshape(3, 1, 1), q)[:, :, 0]
    return Poses(theta, centre, swept.joint.turned(swept.along.reshape(3, 1, 1), q)[:, :, 0])


def along_wall(cam: SpatialCam, which: Wall, theta: Array, radius: float) -> Poses:
    """A cylindrical cutter of this radius [mm] on one wall, at cam angles (n,) [rad]."""
    roller = cam.swept.roller
    tau = np.linspace(-1.0, 1.0, PLACES)
    half = 0.5 * (roller.outer - roller.inner)
    found = cam.contacts(which, theta, roller.middle + half * tau)
    wanted = found.point - radius * found.normal
    middle = PLACES // 2
    u = with_roller(cam, which, theta).direction
    n = found.normal[:, :, middle]
    n = n - dot(n, u) * u
    n = n / norm(n)
    t = cross(u, n)
    on_n, on_t = (dot(each[:, :, None], found.normal) for each in (n, t))
    columns = np.stack([on_n, tau * on_n, tau * on_t], axis=-1)
    line = wanted[:, :, middle, None] + half * tau * u[:, :, None]
    missed = dot(wanted - line, found.normal)
    a, b, d = np.moveaxis(np.linalg.pinv(columns, rcond=FLAT) @ missed[:, :, None], 1, 0)[..., 0]
    direction = half * u + b * n + d * t
    return Poses(theta, wanted[:, :, middle] + a * n, direction / norm(direction))


def wall_error(
    cam: SpatialCam,
    which: Wall,
    poses: tuple[Poses, Poses, Poses],
    radius: float,
) -> Array:
    """How far the cutter's envelope lies off the wall: (n, m), positive where it leaves material.

    Args:
        poses: a little before, at, and as much after the same cam angles (n,).
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


def _distance(cam: SpatialCam, point: Array, poses: Poses) -> Array:
    """Of points (3, n, m) of the cam from the cutter's axis."""
    swept = cam.swept
    centre = swept.on_cam(poses.theta, poses.centre[:, :, None])
    far = poses.centre + poses.direction
    direction = swept.on_cam(poses.theta, far[:, :, None]) - centre
    away = point - centre
    return norm(cross(away, direction + 0.0 * away))
