"""Development of a cylindrical cam: curves of its walls on a cylinder about its axis, unrolled.

A point of the cylinder is (φ, z): φ is the cam angle at which it passes the roller's side of the
cam, so that a roller with a radial axis is at φ = θ. Unrolled, the cylinder of radius r is the
plane (r φ, z).

A wall's curve is where its contact lines cross the cylinder: with the roller's axis at an offset y
from the cam's axis, a contact at place ρ has the coordinates ρ and y + r(ρ) m_y across the cam's
axis, so that ρ² + (y + r(ρ) m_y)² = r².

The usual drawing offsets the unrolled path of the roller's axis by the roller's radius instead, and
wraps that: exact in the plane, but the plane's normals are not the roller's. The departure is the
distance by which the true wall lies beyond that curve, in the plane of the cylinder.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from synthesis.machines.spatial.cam import SpatialCam, Wall
from synthesis.machines.spatial.machine import Seat
from synthesis.numerics.geometry.swept_roller import FollowerState
from synthesis.numerics.piecewise import Array

MAX_ITERATIONS = 40  # of the fixed point; it converges within about ten
CONVERGED = 1e-13  # of the cylinder's radius
MAX_STEPS, LAST_STEP = 12, 1e-8  # Gauss–Newton to the nearest point: steps, and the last one [rad]
DIFFERENCE = 1e-5  # rad: central differences; they only lead to the nearest point
Curve = Callable[[Array], Array]


@dataclass(frozen=True, eq=False)
class WallCurve:
    """A curve on the cylinder.

    Attributes:
        seat: the roller. side: its side; 0: the path of its axis.
        theta: (n,) cam angles of the contacts [rad]. phi, z: (n,) points on the cylinder [rad, mm].
        rho: (n,) places on the roller's axis [mm].
    """

    seat: Seat
    side: int
    theta: Array
    phi: Array
    z: Array
    rho: Array

    @property
    def name(self) -> str:
        """Name of the wall, or number of the roller whose axis it is."""
        return f"{self.seat.number}{'L' if self.side < 0 else 'R' if self.side else ''}"

    def plane(self, radius: float) -> Array:
        """(2, n) unrolled [mm]."""
        return np.stack([radius * self.phi, self.z])


def axis_path(cam: SpatialCam, seat: Seat, theta: Array, radius: float) -> WallCurve:
    """Where a roller's axis crosses the cylinder of this radius [mm]; NaN where it does not."""
    y, z = _axis_offset(cam, cam.place(seat, theta))
    rho = _square_root(radius**2 - y**2)
    phi = theta - cam.swept.hand * np.arctan2(y, rho)
    return WallCurve(seat, 0, theta, phi, np.where(np.isnan(rho), np.nan, z), rho)


def wall_curve(cam: SpatialCam, which: Wall, theta: Array, radius: float) -> WallCurve:
    """Where a wall crosses the cylinder of this radius [mm]; NaN where it does not."""
    place = cam.place(which.seat, theta)
    rho = _square_root(radius**2 - _axis_offset(cam, place)[0] ** 2)
    for _ in range(MAX_ITERATIONS):
        found = cam.swept.contacts(place, rho[:, None], which.side).point[:, :, 0]
        y = _transverse(cam) @ (found - cam.swept.centre[:, None])
        before, rho = rho, _square_root(radius**2 - y**2)
        if not np.any(np.abs(rho - before) > CONVERGED * radius):
            break
    z = cam.swept.axis @ (found - cam.swept.centre[:, None])
    phi = theta - cam.swept.hand * np.arctan2(y, rho)
    return WallCurve(which.seat, which.side, theta, phi, z, rho)


def offset_errors(cam: SpatialCam, line: WallCurve, drawn: float, radius: float) -> Array:
    """Departure of a wall from the offset drawn on one cylinder and wrapped to another: (n,).

    Args:
        line: the wall on the cylinder of ``radius`` [mm].
        drawn: radius of the cylinder on which the roller's path was unrolled and offset [mm].

    Returns:
        [mm], positive where the drawing removes less than the roller; NaN where the drawing has no
        point near the wall's.
    """

    def offset(theta: Array) -> Array:
        return _plane_offset(cam, line.seat, line.side, theta, drawn, radius)

    point, theta = line.plane(radius), line.theta
    for _ in range(MAX_STEPS):
        slope, away = _derivative(offset, theta), point - offset(theta)
        step = (away * slope).sum(axis=0) / (slope**2).sum(axis=0)
        if not np.any(np.abs(step) > LAST_STEP):
            break
        theta = theta + step
    normal = np.stack([-slope[1], slope[0]]) / np.hypot(*slope)
    beyond = line.side * (away * normal).sum(axis=0)
    return np.where(np.abs(step) <= LAST_STEP, beyond, np.nan)


def _plane_offset(
    cam: SpatialCam, seat: Seat, side: int, theta: Array, drawn: float, radius: float
) -> Array:
    """The roller's path unrolled and offset at one radius, in the plane of another."""
    centre = axis_path(cam, seat, theta, drawn)
    slope = _derivative(lambda t: axis_path(cam, seat, t, drawn).plane(drawn), theta)
    normal = np.stack([-slope[1], slope[0]]) / np.hypot(*slope)
    roller = cam.swept.roller.profile(centre.rho)[0]
    found = centre.plane(drawn) + side * roller * normal
    return np.stack([found[0] * radius / drawn, found[1]])


def _derivative(curve: Curve, theta: Array) -> Array:
    return (curve(theta + DIFFERENCE) - curve(theta - DIFFERENCE)) / (2.0 * DIFFERENCE)


def _axis_offset(cam: SpatialCam, place: FollowerState) -> tuple[Array, Array]:
    """Offset y and height z of the roller's axis, across and along the cam's axis, (n,) [mm]."""
    swept = cam.swept
    at = swept.joint.move_points(swept.origin.reshape(3, 1, 1), place.q)[:, :, 0]
    away = at - swept.centre[:, None]
    return _transverse(cam) @ away, swept.axis @ away


def _transverse(cam: SpatialCam) -> Array:
    return np.cross(cam.swept.axis, cam.swept.along)


def _square_root(square: Array) -> Array:
    """The square root; NaN where there is none."""
    return np.asarray(np.sqrt(np.where(square > 0.0, square, np.nan)))
