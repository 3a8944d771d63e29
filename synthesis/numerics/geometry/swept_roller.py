"""What a roller on a moving axis leaves of a turning cam: walls, slip, pressure angle, undercut.

One set of formulas for all spatial cams. The machine's frame stands still. The cam turns about an
axis (c, e) by χθ, where χ = +1 or −1 is its hand; the follower, on a pivot or in a guide, moves by
q(θ) and carries the roller, whose axis is o + ρu. Per radian of cam, a point x of the follower
moves by q' w(x), with w = g × (x − f) on a pivot (f, g) and w = d in a guide along d; against the
cam it moves by

    V(x) = q' w(x) − χ e × (x − c),

which is linear in x. Roller and cam touch where nothing moves along their common normal. A roller
of radius r(ρ) has the normal m − r'u, where m is the direction, across u, from the axis to the
contact; its line meets the axis at the foot ρ + r r', and a turn about it moves nothing along it,
so that the condition holds at the foot as it does at the contact: m·V = r' u·V. With P = u × V / h
across u and V, T = (V − (u·V) u)/h and h their common length, it has two solutions,

    m = ± √(1 − s²) P + s T,   s = r' (u·V)/h,

a contact on either side; s is 0 for cylindrical rollers, and where the follower's way and the cam's
both are across u, as in globoidal cams. The walls of the cam are the contacts as the cam sees them.

The contact called +1 is on the side to which the follower moves with growing q. At rest the cam's
surface passes the roller along χ u × w or against it, as the machine is set up: then m = ± χ P is
that side.

Source: derived here. For a globoidal cam, tan η = ρψ'/(ρ cos ψ − C) and tan α = ρ|ψ'|/(C − ρ cos ψ)
in the literature on roller gear cams (Gonzalez-Palacios and Angeles, Cam Synthesis, 1993).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from synthesis.numerics.piecewise import Array

EDGE = 1e-14  # sin² of the angle between tangents below which they are along one line


@dataclass(frozen=True)
class Roller:
    """A roller of radius Rr at the middle of its width, cylindrical or crowned [mm].

    ``inner``, ``outer``: its ends, as places ρ on its axis; of a turret, from the turret's axis.
    ``crown``: radius of its bulging outline in a plane through its axis; 0: cylindrical.
    """

    radius: float
    inner: float
    outer: float
    crown: float = 0.0

    @property
    def middle(self) -> float:
        """Middle of its width [mm]."""
        return 0.5 * (self.inner + self.outer)

    def places(self, count: int) -> Array:
        """Places from its inner to its outer end, evenly spaced [mm]."""
        return np.linspace(self.inner, self.outer, count)

    def profile(self, rho: Array) -> tuple[Array, Array, Array]:
        """r, r' and r'' at ρ, of ρ's shape [mm, 1, 1/mm]."""
        if self.crown == 0.0:
            return self.radius + 0.0 * rho, 0.0 * rho, 0.0 * rho
        off = rho - self.middle
        root = np.sqrt(self.crown**2 - off**2)
        return self.radius - self.crown + root, -off / root, -(self.crown**2) / root**3


class FollowerState(NamedTuple):
    """Where the follower is: q and its derivatives by the cam angle, all of one shape (n,).

    [rad] on a pivot, [mm] in a guide.
    """

    q: Array
    q1: Array
    q2: Array


@dataclass(frozen=True, eq=False)
class Joint:
    """What the follower moves on: a pivot, or a guide. Per unit of q, w(x) = g × (x − f) + d.

    ``point``: f, of the pivot's line; ``axis``: g along it, a unit vector, 0 in a guide; ``along``:
    d, 0 on a pivot; (3,) each.
    """

    point: Array
    axis: Array
    along: Array

    @classmethod
    def pivot(cls, point: Array, axis: Array) -> Joint:
        """A turning joint about the line through ``point`` along the unit vector ``axis``."""
        return cls(point, axis, 0.0 * axis)

    @classmethod
    def guide(cls, along: Array) -> Joint:
        """A sliding joint."""
        return cls(0.0 * along, 0.0 * along, along)

    def move_points(self, point: Array, q: Array) -> Array:
        """Points (3, 1, m) of the follower at q = 0, at all q (n,): (3, n, m) [mm]."""
        f = _column(self.point)
        return f + rotate(point - f, q, self.axis) + q[None, :, None] * _column(self.along)

    def turn_direction(self, direction: Array, q: Array) -> Array:
        """A direction (3, 1, 1) of the follower at q = 0, at all q (n,): (3, n, 1)."""
        return rotate(direction, q, self.axis)

    def harmonics(self, point: Array, *, turning: bool = False) -> Array:
        """Points (3,) that move with the follower as a + b cos q + c sin q + d q: (4, 3).

        With ``turning``, directions.
        """
        moved = 0.0 if turning else 1.0
        across = cross(self.axis, point - moved * self.point)
        away = -cross(self.axis, across)  # from the pivot's line to the point
        return np.stack([point - away, away, across, moved * self.along])

    def velocity_per_q(self, point: Array) -> Array:
        """w at points (3, n, m): their velocity per unit of q."""
        return cross(_column(self.axis), point - _column(self.point)) + _column(self.along)

    def direction_rate(self, direction: Array) -> Array:
        """g × directions (3, …): their velocity per unit of q."""
        return cross(_column(self.axis), direction)


@dataclass(frozen=True, eq=False)
class Contacts:
    """One wall of the cam: contacts of one side of a roller, at n cam angles θ by m places ρ.

    Vectors are (3, n, m), in the frame of the machine. The normal points from the roller's axis
    into the cam; ``slip``: velocity of roller against cam, per radian of cam [mm];
    ``pressure_angle``: between the normal and the roller's way, 0 to 90° [rad]; ``regular``: area
    of the wall to that of the surface which the roller's axis sweeps, (1 − Rr κ1)(1 − Rr κ2) of a
    cylinder, 0 or less where the wall is undercut.
    """

    point: Array
    normal: Array
    slip: Array
    pressure_angle: Array
    regular: Array


@dataclass(frozen=True, eq=False)
class SweptRoller:
    """A cam's axis, a follower's joint and a roller on it.

    ``centre``, ``axis``: a point of the cam's axis [mm] and its direction e, a unit vector (3,).
    ``origin``, ``along``: where the roller's axis has ρ = 0 at q = 0 [mm], and its direction u.
    ``hand``: χ, +1 where the cam turns about +e as θ grows, −1 about −e.
    """

    centre: Array
    axis: Array
    joint: Joint
    origin: Array
    along: Array
    roller: Roller
    hand: int = 1

    def contacts(self, place: FollowerState, rho: Array, side: int | Array) -> Contacts:
        """The contacts at all ``place`` (n,) and ``rho``, (m,) or (n, m) [mm].

        ``side``: +1 for those on the side to which the follower moves with growing q, −1 for the
        others; or (n, 1) one for every place.
        """
        touch, wall = self._wall(place, rho, side)
        way = self.joint.velocity_per_q(wall.axis)
        return Contacts(
            point=wall.point,
            normal=wall.normal,
            slip=self._slip(wall.point, place.q1[:, None]),
            pressure_angle=np.arctan2(norm(cross(wall.normal, way)), np.abs(dot(wall.normal, way))),
            regular=dot(cross(wall.by_theta, wall.by_rho), wall.normal)
            / dot(cross(touch.slip, touch.u), touch.direction),
        )

    def curvatures(self, place: FollowerState, rho: Array, side: int | Array) -> Array:
        """Principal curvatures of the wall at the contacts, the larger first: (2, n, m) [1/mm].

        Positive where the cam bulges. Where the wall is undercut they say nothing of a cam; on the
        edge where that begins its tangents are along one line, and they are infinite.
        """
        touch, wall = self._wall(place, rho, side)
        _, slope, bend = self.roller.profile(rho)
        root = np.sqrt(1.0 + slope**2)
        spin = place.q1[:, None] * self.joint.direction_rate(touch.u)
        turns = (touch.by_theta - slope * spin) / root - self._carried(wall.normal, turning=True)
        tilts = (touch.by_rho - bend * touch.u) / root - wall.normal * slope * bend / root**2
        e, g = dot(wall.by_theta, wall.by_theta), dot(wall.by_rho, wall.by_rho)
        f = dot(wall.by_theta, wall.by_rho)
        l, m, n = -dot(wall.by_theta, turns), -dot(wall.by_rho, turns), -dot(wall.by_rho, tilts)
        area = e * g - f**2
        edge = ~(area > EDGE * e * g)
        area = np.where(edge, np.inf, area)
        mean, gauss = (l * g - 2.0 * m * f + n * e) / (2.0 * area), (l * n - m**2) / area
        half = np.sqrt(np.maximum(mean**2 - gauss, 0.0))
        return np.where(edge, [[[np.inf]], [[-np.inf]]], [mean + half, mean - half])

    def contact_points(
        self, place: FollowerState, rho: Array, side: int | Array
    ) -> tuple[Array, Array]:
        """Points and normals of ``contacts`` alone, (3, n, m) each: a third of the work."""
        radius, slope, _ = self.roller.profile(rho)
        touch, _ = self._touch(place, rho, side)
        normal = (touch.direction - slope * touch.u) / np.sqrt(1.0 + slope**2)
        return self._axis(place.q, rho) + radius * touch.direction, normal

    def _touch(self, place: FollowerState, rho: Array, side: int | Array) -> tuple[_Touch, Array]:
        """Where the roller touches, and the feet of the normals there on its axis."""
        radius, slope, _ = self.roller.profile(rho)
        u = self.joint.turn_direction(_column(self.along), place.q)
        feet = self._axis(place.q, rho + radius * slope)
        sign = side * self.hand * self._facing
        return _Touch(u, self._slip(feet, place.q1[:, None]), slope, sign), feet

    def _wall(self, place: FollowerState, rho: Array, side: int | Array) -> tuple[_Touch, _Wall]:
        """Where the roller touches, and the wall there with its tangents."""
        radius, slope, bend = self.roller.profile(rho)
        q1, x = place.q1[:, None], self._axis(place.q, rho)
        touch, f = self._touch(place, rho, side)
        u, m = touch.u, touch.direction
        # dV/dθ at a foot that moves with the follower: q'' w, and V's change along its way
        way = self.joint.velocity_per_q(f)
        slip1 = place.q2[:, None] * way + self._slip_along(q1 * way, q1)
        touch.by_theta = touch.change(self.joint.direction_rate(u) * q1, slip1, 0.0)
        shift = 1.0 + slope**2 + radius * bend
        touch.by_rho = touch.change(0.0 * u, shift * self._slip_along(u, q1), bend)
        turned_m = touch.by_theta - self._carried(m, turning=True)
        return touch, _Wall(
            axis=x,
            point=x + radius * m,
            normal=(m - slope * u) / np.sqrt(1.0 + slope**2),
            by_theta=self._slip(x, q1) + radius * turned_m,
            by_rho=u + slope * m + radius * touch.by_rho,
        )

    def on_cam(self, theta: Array, point: Array) -> Array:
        """Points (3, n, …) of the machine's frame at θ (n,) [rad] as the cam has them.

        The cam's frame has its origin at ``centre`` and at θ = 0 the directions of the machine's.
        """
        shape = (3,) + (1,) * (point.ndim - 1)
        return rotate(point - self.centre.reshape(shape), -self.hand * theta, self.axis)

    @cached_property
    def _facing(self) -> int:
        """+1 where at rest, q = 0, the cam's surface passes along χ u × w, −1 against it."""
        x, e, u = self.origin + self.roller.middle * self.along, self.axis, self.along
        way = self.joint.velocity_per_q(_column(x))[:, 0, 0]
        return 1 if float(dot(cross(e, x - self.centre), cross(u, way))) > 0.0 else -1

    def _axis(self, q: Array, rho: Array) -> Array:
        """Points of the roller's axis: (3, n, m)."""
        return self.joint.move_points(_column(self.origin) + rho * _column(self.along), q)

    def _carried(self, x: Array, *, turning: bool = False) -> Array:
        """χ e × (x − c): velocity of the cam at points (3, n, m), or how it turns directions."""
        away = x if turning else x - _column(self.centre)
        return self.hand * cross(_column(self.axis), away)

    def _slip(self, x: Array, q1: Array) -> Array:
        """V at points (3, n, m) of the follower."""
        return q1 * self.joint.velocity_per_q(x) - self._carried(x)

    def _slip_along(self, u: Array, q1: Array) -> Array:
        """Change of V, which is linear, along directions (3, n, m)."""
        return q1 * self.joint.direction_rate(u) - self._carried(u, turning=True)


class _Wall(NamedTuple):
    """Points of the roller's axis, contacts, normals, and tangents by θ, as the cam has it, and ρ.

    All of (3, n, m).
    """

    axis: Array
    point: Array
    normal: Array
    by_theta: Array
    by_rho: Array


class _Touch:
    """The direction m from the roller's axis to the contact, and its derivatives."""

    by_theta: Array
    by_rho: Array

    def __init__(self, u: Array, slip: Array, slope: Array, sign: int | Array) -> None:
        self.u, self.slip, self.slope, self.sign = u, slip, slope, sign
        self.along = dot(u, slip)
        self.p = cross(u, slip)
        self.length = norm(self.p)
        self.p = self.p / self.length
        self.t = (slip - self.along * u) / self.length
        self.sin = slope * self.along / self.length
        self.cos = sign * np.sqrt(1.0 - self.sin**2)
        self.direction = self.cos * self.p + self.sin * self.t

    def change(self, u1: Array, slip1: Array, slope1: Array | float) -> Array:
        """Derivative of m from those of u, V and r' by the same variable."""
        along1 = dot(u1, self.slip) + dot(self.u, slip1)
        growth = (dot(self.slip, slip1) - self.along * along1) / self.length**2
        p1 = (cross(u1, self.slip) + cross(self.u, slip1)) / self.length - growth * self.p
        t1 = (slip1 - along1 * self.u - self.along * u1) / self.length - growth * self.t
        sin1 = (slope1 * self.along + self.slope * along1) / self.length - growth * self.sin
        return np.asarray(
            self.cos * p1 + self.sin * t1 + sin1 * (self.t - self.sin / self.cos * self.p)
        )


def dot(a: Array, b: Array) -> Array:
    """Inner products of vectors (3, …)."""
    return np.asarray(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


def norm(a: Array) -> Array:
    """Lengths of vectors (3, …)."""
    return np.asarray(np.sqrt(dot(a, a)))


def cross(a: Array, b: Array) -> Array:
    """Cross products of vectors (3, …)."""
    (ax, ay, az), (bx, by, bz) = a, b
    found = np.empty((3, *np.broadcast_shapes(a.shape[1:], b.shape[1:])))
    found[0] = ay * bz - az * by
    found[1] = az * bx - ax * bz
    found[2] = ax * by - ay * bx
    return found


def rotate(point: Array, angle: Array, axis: Array) -> Array:
    """Points (3, n or 1, …) turned by ``angle`` (n,) [rad] about a unit vector ``axis`` (3,).

    Rodrigues' formula; about an axis of 0 they stay.
    """
    rest = (1,) * (point.ndim - 2)
    e, angle = axis.reshape(3, 1, *rest), angle.reshape(-1, *rest)
    along = dot(e, point) * e - float(axis @ axis) * point
    return np.asarray(point + np.sin(angle) * cross(e, point) + (1.0 - np.cos(angle)) * along)


def _column(vector: Array) -> Array:
    return vector.reshape(3, 1, 1)
