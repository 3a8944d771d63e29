"""Measured quantities from the positions of the output link alone: all derivatives are of series.

Vectors have components in the machine frame. The cam turns by 1 rad per rad, so that seen from it
the vector (x, y) changes at the rate (x' + y, y' − x). P is the curve traced on the cam: it runs
clockwise, and its outward normal is its rate turned by 90° to the left. A flat face is the line
N·X = h; where it touches its envelope, (rate of N)·X = h' as well.

Forces follow by virtual work, in the units of the spec's load. G is a force along a slide or a
moment about a pivot. If the follower's material at the contact moves by w per mm or rad, the
contact force N along the unit normal n satisfies N n·w = G; the torque at the camshaft is G times
the derivative of the displacement.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import pairwise
from typing import Any, Final

from flint import arb, arb_series

from synthesis.catalogue.followers.kinematics import Face, Flank, Link, Tip, Vector2
from synthesis.catalogue.forces.load import WireLoad
from synthesis.certify.second.exact_motion import (
    MotionPiece,
    SeriesVector,
    Span,
    coefficient,
    degree,
)


@dataclass(frozen=True, eq=False)
class LinkState:
    """The output link at some cam angle, as series in that angle.

    Attributes:
        link: the link at displacement 0. displacement: mm or rad.
        drive: force or moment that the cam exerts along it, N or N m; None: not measured.
        flank: the flank for which forces are measured.
    """

    link: Link
    displacement: arb_series
    drive: arb_series | None = None
    flank: Flank | None = None

    @cached_property
    def _rotation(self) -> SeriesVector:
        """Sine and cosine of the angle by which the link has turned about its pivot."""
        angle = self.displacement * self.link.turn
        return angle.sin(), angle.cos()

    def direction_of(self, vector: Vector2) -> SeriesVector:
        """A direction fixed to the link, in the machine frame."""
        x, y = (arb_series([value]) for value in vector)
        if self.link.pivot is None:
            return x, y
        sin, cos = self._rotation
        return x * cos - y * sin, y * cos + x * sin

    def position_of(self, point: Vector2) -> SeriesVector:
        """A point fixed to the link, in the machine frame."""
        if self.link.pivot is None:
            assert self.link.slide is not None
            gx, gy = self.link.slide
            return point[0] + self.displacement * gx, point[1] + self.displacement * gy
        px, py = self.link.pivot
        x, y = self.direction_of((point[0] - px, point[1] - py))
        return x + px, y + py

    def motion_at(self, at: SeriesVector) -> SeriesVector:
        """Velocity, per unit of displacement, of the link's material at a point of the machine."""
        if self.link.pivot is None:
            assert self.link.slide is not None
            gx, gy = self.link.slide
            return arb_series([gx]), arb_series([gy])
        px, py = self.link.pivot
        return (py - at[1]) * self.link.turn, (at[0] - px) * self.link.turn


@dataclass(frozen=True, eq=False)
class TipContact:
    """A roller's centre or a knife edge, and the curve that it traces."""

    state: LinkState
    tip: Tip

    @cached_property
    def curve(self) -> SeriesVector:
        return self.state.position_of(self.tip.at)

    @cached_property
    def normal(self) -> SeriesVector:
        x, y = cam_rate(self.curve)
        return -y, x

    def drive(self) -> SeriesVector:
        x, y = self.state.motion_at(self.curve)
        return x * self.tip.outward, y * self.tip.outward


@dataclass(frozen=True, eq=False)
class FaceContact:
    """A flat face, and the envelope that it leaves on the cam."""

    state: LinkState
    face: Face

    @cached_property
    def normal(self) -> SeriesVector:
        return self.state.direction_of(self.face.normal)

    @cached_property
    def _support(self) -> tuple[arb_series, arb_series, arb_series]:
        """h, the rate dχ/dθ at which N turns on the cam, counter-clockwise, and dh/dχ.

        The last is the way along the face from the foot of the perpendicular on the axis.
        """
        h = dot(self.state.position_of(self.face.at), self.normal)
        turning = cross(self.normal, cam_rate(self.normal))
        return h, turning, h.derivative() / turning

    @cached_property
    def curve(self) -> SeriesVector:
        (nx, ny), (h, _, offset) = self.normal, self._support
        return nx * h - ny * offset, ny * h + nx * offset

    def drive(self) -> SeriesVector:
        return self.state.motion_at(self.curve)

    def radius(self) -> arb_series:
        """ρ = h + d²h/dχ², the radius of curvature of an envelope with support function h."""
        h, turning, offset = self._support
        return h + offset.derivative() / turning

    def reach(self) -> arb_series:
        """Position of the contact along the face, from the face's reference point."""
        (x, y), (fx, fy) = self.curve, self.state.position_of(self.face.at)
        return dot((x - fx, y - fy), self.state.direction_of(self.face.along))


def contact(state: LinkState, path: str) -> Any:
    """What traces the path of this name; the first one if the name is empty."""
    if state.link.face is not None:
        return FaceContact(state, state.link.face)
    tips = [tip for tip in state.link.tips if tip.path == path] or list(state.link.tips)
    return TipContact(state, tips[0])


def cam_rate(vector: SeriesVector) -> SeriesVector:
    """Derivative of a vector with respect to the cam angle, as seen from the cam."""
    x, y = vector
    return x.derivative() + y, y.derivative() - x


def dot(a: SeriesVector, b: SeriesVector) -> arb_series:
    """a · b."""
    return a[0] * b[0] + a[1] * b[1]


def cross(a: SeriesVector, b: SeriesVector) -> arb_series:
    """a × b."""
    return a[0] * b[1] - a[1] * b[0]


def _pressure_angle(touching: Any) -> Any:
    """α from the outward normal to the drive.

    The arc tangent is taken of the constant term only; the rest is the integral of dα/dθ, which is
    a rational function.
    """
    n, g = touching.normal, touching.drive()
    along, across = dot(g, n), cross(g, n)
    turning = (along * across.derivative() - across * along.derivative()) / (
        along * along + across * across
    )
    return turning.integral() + arb.atan2(coefficient(across, 0), coefficient(along, 0))


def curvature(touching: Any) -> arb_series:
    """κ of the traced curve, which runs clockwise: convex positive."""
    tangent = cam_rate(touching.curve)
    square = dot(tangent, tangent)
    return cross(cam_rate(tangent), tangent) / (square * square.sqrt())


def _derivative(touching: Any, order: int) -> Any:
    found = touching.state.displacement
    for _ in range(order):
        found = found.derivative()
    return found


ORDERS: Final = {"travel": 0, "displacement": 0, "velocity": 1, "acceleration": 2, "jerk": 3}
# of what touches the cam, by the names that claims use
QUANTITIES: Final[Mapping[str, Callable[[Any], arb_series]]] = {
    **{name: partial(_derivative, order=order) for name, order in ORDERS.items()},
    "pressure_angle": _pressure_angle,
    "pitch_curvature": curvature,
    "pitch_radius": lambda touching: dot(touching.curve, touching.curve).sqrt(),
    "face_radius": FaceContact.radius,
    "contact": FaceContact.reach,
    "contact_left": lambda touching: -touching.reach(),
    "contact_right": FaceContact.reach,
}


@dataclass(frozen=True, eq=False)
class ExactLoad:
    """The load of the follower as the spec states it, at ω [rad/s].

    ``side``: sign of the spring force; ``has_friction``: whether guide friction acts.
    """

    stated: WireLoad
    omega: arb
    side: int
    has_friction: bool

    @property
    def process_lines(self) -> list[tuple[arb, arb, arb, arb]]:
        """The process force as straight lines: from and to [rad], value at the start, slope."""
        turn, points = arb(360), [(arb(a), arb(f)) for a, f in self.stated.points]
        if not points:
            return [(arb(0), 2 * arb.pi(), arb(0), arb(0))]
        # a turn earlier and a turn later, so that every angle of this one lies between two points
        around = [(a + k * turn, f) for k in (-1, 0, 1) for a, f in points]
        unit = degree()
        return [
            (a * unit, b * unit, f, (g - f) / ((b - a) * unit))
            for (a, f), (b, g) in pairwise(around)
            if b > a
        ]

    def split(self, piece: MotionPiece, low: arb, high: arb) -> Iterator[Span]:
        """The parts of a span on which the process force is one straight line."""
        for start, end, value, slope in self.process_lines:
            first = ((start - piece.start) / piece.angle).max(low).mid()
            last = ((end - piece.start) / piece.angle).min(high).mid()
            if first < last or (low == high and first == last):
                yield replace(piece, process=(start, value, slope)), first, last

    def drive(self, displacement: arb_series, piece: MotionPiece, x: arb) -> arb_series:
        """G as a series in the cam angle [N or N m]."""
        assert piece.process is not None
        start, value, slope = piece.process
        stated, rate = self.stated, displacement.derivative()
        process = arb_series([value + slope * (piece.angle_at(x) - start), slope])
        metre = arb(1) if stated.metre == 1.0 else arb(1) / 1000
        inertia = rate.derivative() * (arb(stated.mass) * self.omega**2 * metre)
        damping = rate * (arb(stated.damping) * self.omega * metre)
        constant = self.side * arb(stated.preload) + arb(stated.weight)
        return inertia + damping + displacement * arb(stated.rate) + process + constant


def contact_force(touching: Any) -> arb_series:
    """N, positive along the outward normal [N]."""
    state = touching.state
    n, w = touching.normal, state.motion_at(touching.curve)
    metre = 1 if state.link.pivot is None else 1000  # N m over mm
    found: arb_series = state.drive * metre * dot(n, n).sqrt() / dot(n, w)
    return found


def camshaft_torque(touching: Any) -> arb_series:
    """T [N m]."""
    state = touching.state
    work: arb_series = state.drive * state.displacement.derivative()
    return work if state.link.pivot is not None else work / 1000


def pressure_square(touching: Any) -> Any:
    """Square of the Hertzian pressure times the compliance of the line contact [N/mm].

    It is the contact force times the sum of both curvatures.
    """
    flank = touching.state.flank
    force = contact_force(touching) * flank.side
    if touching.state.link.face is not None:
        return force / touching.radius()
    bend = curvature(touching) * flank.side
    return force * (bend / (1 - bend * arb(flank.distance)) + 1 / arb(flank.roller))


FORCES: Final[Mapping[str, Callable[[Any], arb_series]]] = {
    "contact_force": contact_force,
    "camshaft_torque": camshaft_torque,
    "pressure_square": pressure_square,
}
