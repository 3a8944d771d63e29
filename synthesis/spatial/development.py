"""The walls of a cylindrical cam on a cylinder about its axis, unrolled.

A place on the cylinder is (φ, z): φ is the cam angle at which it passes the roller's side of the
cam, so that the axis of a roller whose axis is radial stands at φ = θ. Unrolled, the cylinder of
radius r is the plane (r φ, z).

A wall's own curve there is where its contact lines cross the cylinder: with the axis at height y
beside the cam's axis, a contact at place ρ on it lies at ρ and y + r(ρ) m_y across the cam's axis,
so that ρ² + (y + r(ρ) m_y)² = r².

The usual drawing offsets the unrolled path of the roller's axis by the roller's radius instead, and
wraps that: exact in the plane, but the plane's normals are not the roller's. Its ``departure`` is
how far the true wall lies beyond that curve, in the plane of the cylinder where it is looked at.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from synthesis.geometry.swept_roller import Place
from synthesis.numerics.piecewise import Array
from synthesis.spatial.cam import SpatialCam, Wall
from synthesis.spatial.machine import Seat

STEPS = 40  # of iterations that settle within some ten
SETTLED = 1e-13  # of the cylinder's radius
TRIES, NEAR = 12, 1e-8  # steps to the nearest point, and how little the last one is [rad]
SMALL = 1e-5  # of cam angle [rad], for slopes that only lead to the nearest point
Curve = Callable[[Array], Array]


@dataclass(frozen=True, eq=False)
class Line:
    """A curve on the cylinder.

    Attributes:
        seat: the roller. side: of it; 0: the path of its axis.
        theta: (n,) cam angles of the contacts [rad]. phi, z: (n,) where [rad, mm].
        rho: (n,) places on the roller's axis [mm].
    """

    seat: Seat
    side: int
    theta: Array
    phi: Array
    z: Array
    rho: Array

    def plane(self, radius: float) -> Array:
        """(2, n) unrolled [mm]."""
        return np.stack([radius * self.phi, self.z])


def path(cam: SpatialCam, seat: Seat, theta: Array, radius: float) -> Line:
    """Where a roller's axis passes the cylinder of this radius [mm]; NaN where it does not."""
    y, z = _beside(cam, cam.place(seat, theta))
    rho = _root(radius**2 - y**2)
    phi = theta - cam.swept.hand * np.arctan2(y, rho)
    return Line(seat, 0, theta, phi, np.where(np.isnan(rho), np.nan, z), rho)


def wall(cam: SpatialCam, which: Wall, theta: Array, radius: float) -> Line:
    """Where a wall crosses the cylinder of this radius [mm]; NaN where it does not."""
    place = cam.place(which.seat, theta)
    rho = _root(radius**2 - _beside(cam, place)[0] ** 2)
    for _ in range(STEPS):
        found = cam.swept.contacts(place, rho[:, None], which.side).point[:, :, 0]
        y = _across(cam) @ (found - cam.swept.centre[:, None])
        before, rho = rho, _root(radius**2 - y**2)
        if not np.any(np.abs(rho - before) > SETTLED * radius):
            break
    z = cam.swept.axis @ (found - cam.swept.centre[:, None])
    phi = theta - cam.swept.hand * np.arctan2(y, rho)
    return Line(which.seat, which.side, theta, phi, z, rho)


def departures(cam: SpatialCam, line: Line, drawn: float, radius: float) -> Array:
    """How far a wall lies beyond the offset drawn on one cylinder and wrapped to another: (n,).

    Args:
        line: the wall on the cylinder where it is looked at, of ``radius`` [mm].
        drawn: radius of the cylinder on which the roller's path was unrolled and offset [mm].

    Returns:
        [mm], positive where less is cut away by the drawing than by the roller; NaN where the
        drawing has no point beside the wall's.
    """

    def offset(theta: Array) -> Array:
        return _offset(cam, line.seat, line.side, theta, drawn, radius)

    point, theta = line.plane(radius), line.theta
    for _ in range(TRIES):
        slope, away = _slope(offset, theta), point - offset(theta)
        step = (away * slope).sum(axis=0) / (slope**2).sum(axis=0)
        if not np.any(np.abs(step) > NEAR):
            break
        theta = theta + step
    normal = np.stack([-slope[1], slope[0]]) / np.hypot(*slope)
    beyond = line.side * (away * normal).sum(axis=0)
    return np.where(np.abs(step) <= NEAR, beyond, np.nan)


def _offset(
    cam: SpatialCam, seat: Seat, side: int, theta: Array, drawn: float, radius: float
) -> Array:
    """The roller's path unrolled at one radius and offset there, in the plane of another."""
    centre = path(cam, seat, theta, drawn)
    slope = _slope(lambda t: path(cam, seat, t, drawn).plane(drawn), theta)
    normal = np.stack([-slope[1], slope[0]]) / np.hypot(*slope)
    roller = cam.swept.roller.profile(centre.rho)[0]
    found = centre.plane(drawn) + side * roller * normal
    return np.stack([found[0] * radius / drawn, found[1]])


def _slope(curve: Curve, theta: Array) -> Array:
    return (curve(theta + SMALL) - curve(theta - SMALL)) / (2.0 * SMALL)


def _beside(cam: SpatialCam, place: Place) -> tuple[Array, Array]:
    """y and z of the roller's axis: across the cam's axis and along it, (n,) each [mm]."""
    swept = cam.swept
    at = swept.joint.moved(swept.origin.reshape(3, 1, 1), place.q)[:, :, 0]
    away = at - swept.centre[:, None]
    return _across(cam) @ away, swept.axis @ away


def _across(cam: SpatialCam) -> Array:
    return np.cross(cam.swept.axis, cam.swept.along)


def _root(square: Array) -> Array:
    """Its square root, NaN where there is none."""
    return np.asarray(np.sqrt(np.where(square > 0.0, square, np.nan)))
