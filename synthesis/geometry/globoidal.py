"""Globoidal (roller gear) cams: contact lines, walls, pressure angle, curvature.

Cam and turret axes are perpendicular, their common perpendicular is C long. The machine's frame
stands still: its origin on the turret's axis, x along the common perpendicular to the cam's axis,
z = k along the turret's axis; the cam's axis passes through (C, 0, 0) along y. The turret turns
about z by ψ, the cam about y by χθ, where χ = +1 or −1 is its hand.

A roller's axis is radial: u = (cos ψ, sin ψ, 0); it moves along w = k × u. At the point ρ u of the
axis the turret moves by ρψ' w per radian of cam, the cam by χ(C − ρ cos ψ) k, both across u. So the
direction m from the axis to the contact, across u as well, fulfils

    m = cos η w + sin η k,   ρψ' cos η = χ (C − ρ cos ψ) sin η

and −m is the second contact. A crowned roller has the radius r(ρ): its normal at ρ meets the axis
at ρ + r r', where the same condition holds, because a turn about a normal's line moves nothing
along it. The walls of the cam are the contacts, seen by the cam.

Source: derived here; with cylindrical rollers the pressure angle is tan α = ρ|ψ'|/(C − ρ cos ψ), as
in the literature on roller gear cams (Gonzalez-Palacios and Angeles, Cam Synthesis, 1993).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from synthesis.numerics.piecewise import Array


@dataclass(frozen=True)
class Roller:
    """A roller on a turret, cylindrical or crowned.

    Attributes:
        radius: Rr at the middle of its width [mm].
        inner, outer: its ends, from the turret's axis [mm].
        crown: radius of its bulging outline in a plane through its axis [mm]; 0: cylindrical.
    """

    radius: float
    inner: float
    outer: float
    crown: float = 0.0

    @property
    def middle(self) -> float:
        """Middle of its width, from the turret's axis [mm]."""
        return 0.5 * (self.inner + self.outer)

    def profile(self, rho: Array) -> tuple[Array, Array, Array]:
        """r, r' and r'' at ρ, of ρ's shape [mm, 1, 1/mm]."""
        if self.crown == 0.0:
            return self.radius + 0.0 * rho, 0.0 * rho, 0.0 * rho
        off = rho - self.middle
        root = np.sqrt(self.crown**2 - off**2)
        return self.radius - self.crown + root, -off / root, -(self.crown**2) / root**3


class Place(NamedTuple):
    """Where a roller is: ψ and its derivatives by the cam angle, all of one shape (n,) [rad]."""

    psi: Array
    psi1: Array
    psi2: Array


@dataclass(frozen=True, eq=False)
class Contacts:
    """One wall of the cam: contacts of one side of a roller, at cam angles θ by places ρ.

    Attributes:
        point, normal: (3, n, m) contact and unit normal, from the roller's axis into the cam, in
            the frame of the machine [mm].
        slip: (3, n, m) velocity of roller against cam there, per radian of cam [mm].
        pressure_angle: (n, m) angle between the normal and the roller's way, 0 to 90° [rad].
        regular: (n, m) area of the wall to that of the surface which the roller's axis sweeps, (1 −
            Rr κ1)(1 − Rr κ2) of a cylinder; 0 or less where the wall is undercut.
    """

    point: Array
    normal: Array
    slip: Array
    pressure_angle: Array
    regular: Array


@dataclass(frozen=True)
class Globoidal:
    """A globoidal cam and one roller of its turret.

    Attributes:
        distance: C between the axes [mm]. roller: what runs on the cam.
        hand: χ, +1 where the cam turns about +y as θ grows, −1 about −y.
    """

    distance: float
    roller: Roller
    hand: int = 1

    def contacts(self, place: Place, rho: Array, side: int) -> Contacts:
        """The contacts at all ``place`` (n,) and ``rho`` (m,) [rad, mm].

        Args:
            side: +1 for those in the direction of w, −1 for those against it.
        """
        psi1 = place.psi1[:, None]
        radius, slope, bend = self.roller.profile(rho)
        foot = rho + radius * slope
        u, w, k = _directions(place.psi[:, None])
        eta, by_theta, by_foot = self._eta(place, foot)
        cos, sin = side * np.cos(eta), side * np.sin(eta)
        m, q = cos * w + sin * k, cos * k - sin * w
        normal = (m - slope * u) / np.sqrt(1.0 + slope**2)
        point = rho * u + radius * m
        along = u + slope * m + radius * by_foot * (1.0 + slope**2 + radius * bend) * q
        still = rho * psi1 * w - radius * cos * psi1 * u + radius * by_theta * q
        axis = foot * psi1 * w - self._carried(foot * u)
        return Contacts(
            point=point,
            normal=normal,
            slip=psi1 * np.stack([-point[1], point[0], 0.0 * point[2]]) - self._carried(point),
            pressure_angle=np.arctan2(
                np.hypot(_dot(normal, u), _dot(normal, k)), np.abs(_dot(normal, w))
            ),
            regular=_dot(_cross(still - self._carried(point), along), normal)
            / _dot(_cross(axis, u), m),
        )

    def on_cam(self, theta: Array, point: Array) -> Array:
        """Points (3, n, …) of the machine's frame at θ (n,) [rad] as the cam has them.

        The cam's frame has its origin on its axis, which is y, and at θ = 0 the directions of the
        machine's.
        """
        return turned(
            point - np.array([self.distance, 0.0, 0.0])[:, None, None], -self.hand * theta
        )

    def _carried(self, point: Array) -> Array:
        """Velocity of the cam at points (3, n, m) of the machine, per radian of cam [mm]."""
        x, _, z = point
        return self.hand * np.stack([z, 0.0 * z, self.distance - x])

    def _eta(self, place: Place, rho: Array) -> tuple[Array, Array, Array]:
        """η (n, m) and its derivatives by θ and by ρ."""
        psi, psi1, psi2 = (each[:, None] for each in place)
        a, b = rho * psi1, self.hand * (self.distance - rho * np.cos(psi))
        squared = a**2 + b**2
        by_theta = rho * psi2 * b - a * self.hand * rho * np.sin(psi) * psi1
        by_rho = psi1 * b + a * self.hand * np.cos(psi)
        return np.arctan(a / b), by_theta / squared, by_rho / squared


def _dot(a: Array, b: Array) -> Array:
    return np.asarray((a * b).sum(axis=0))


def _cross(a: Array, b: Array) -> Array:
    (ax, ay, az), (bx, by, bz) = a, b
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])


def _directions(psi: Array) -> tuple[Array, Array, Array]:
    """u, w and k at ψ (n, 1), each (3, n, 1)."""
    zero, one = 0.0 * psi, 1.0 + 0.0 * psi
    cos, sin = np.cos(psi), np.sin(psi)
    return np.stack([cos, sin, zero]), np.stack([-sin, cos, zero]), np.stack([zero, zero, one])


def turned(point: Array, angle: Array) -> Array:
    """Points (3, n, …) turned about y by ``angle`` (n,) [rad]."""
    shape = (-1,) + (1,) * (point.ndim - 2)
    cos, sin = np.cos(angle).reshape(shape), np.sin(angle).reshape(shape)
    x, y, z = point
    return np.stack([x * cos + z * sin, y + 0.0 * cos, z * cos - x * sin])
