"""What is measured, from the link's positions alone: all derivatives are of series.

All vectors are components in the machine's frame, against which the cam turns by 1 rad per rad: as
seen from the cam a vector (x, y) changes at the rate (x' + y, y' − x). P is the curve traced there:
it runs clockwise, so its outward normal is its rate turned by a quarter to the left. A face is the
line N·X = h; where it touches its envelope, the rate of N times X is h' too.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from flint import arb, arb_series

from synthesis.confirmation.arithmetic import Pair, term
from synthesis.followers.flank import Flank
from synthesis.followers.link import Face, Link, Tip
from synthesis.followers.trace import Vector2


@dataclass(frozen=True, eq=False)
class View:
    """The link at some cam angle, as series in that angle.

    Attributes:
        link: at displacement 0. moved: displacement, mm or rad.
        drive: force or moment that the cam gives along it, N or N m; None: not asked about.
        flank: which is looked at.
    """

    link: Link
    moved: arb_series
    drive: arb_series | None = None
    flank: Flank | None = None

    @cached_property
    def _turning(self) -> Pair:
        """Sine and cosine of what the link has turned; of a slide none."""
        angle = self.moved * self.link.turn
        return angle.sin(), angle.cos()

    def carried(self, vector: Vector2) -> Pair:
        """A direction fixed to the link, in the machine."""
        x, y = (arb_series([value]) for value in vector)
        if self.link.pivot is None:
            return x, y
        sin, cos = self._turning
        return x * cos - y * sin, y * cos + x * sin

    def placed(self, point: Vector2) -> Pair:
        """A point fixed to the link, in the machine."""
        if self.link.pivot is None:
            assert self.link.slide is not None
            gx, gy = self.link.slide
            return point[0] + self.moved * gx, point[1] + self.moved * gy
        px, py = self.link.pivot
        x, y = self.carried((point[0] - px, point[1] - py))
        return x + px, y + py

    def driven(self, at: Pair) -> Pair:
        """Which way a point of the link at this place of the machine moves as it is lifted."""
        if self.link.pivot is None:
            assert self.link.slide is not None
            gx, gy = self.link.slide
            return arb_series([gx]), arb_series([gy])
        px, py = self.link.pivot
        return (py - at[1]) * self.link.turn, (at[0] - px) * self.link.turn


@dataclass(frozen=True, eq=False)
class TipContact:
    """A roller's centre or a knife edge."""

    view: View
    tip: Tip

    @cached_property
    def _place(self) -> Pair:
        return self.view.placed(self.tip.at)

    def curve(self) -> Pair:
        return self._place

    def normal(self) -> Pair:
        x, y = rate(self._place)
        return -y, x

    def drive(self) -> Pair:
        x, y = self.view.driven(self._place)
        return x * self.tip.outward, y * self.tip.outward


@dataclass(frozen=True, eq=False)
class FaceContact:
    """A flat face and its envelope."""

    view: View
    face: Face

    @cached_property
    def _parts(self) -> tuple[Pair, arb_series, arb_series]:
        """N, h, and how fast N turns on the cam, counter-clockwise."""
        normal = self.view.carried(self.face.normal)
        place = self.view.placed(self.face.at)
        return normal, dot(place, normal), cross(normal, rate(normal))

    @cached_property
    def _beside(self) -> arb_series:
        """Contact from the foot of the axis on the face, along N turned by a quarter: dh/dχ."""
        _, h, turning = self._parts
        return h.derivative() / turning

    def curve(self) -> Pair:
        (nx, ny), h, _ = self._parts
        return nx * h - ny * self._beside, ny * h + nx * self._beside

    def normal(self) -> Pair:
        return self._parts[0]

    def drive(self) -> Pair:
        return self.view.driven(self.curve())

    def radius(self) -> arb_series:
        """ρ = h + d²h/dχ², χ the angle of N on the cam."""
        _, h, turning = self._parts
        return h + self._beside.derivative() / turning

    def reach(self) -> arb_series:
        """Contact along the face, from where its reach is measured."""
        x, y = self.curve()
        fx, fy = self.view.placed(self.face.at)
        return dot((x - fx, y - fy), self.view.carried(self.face.along))


def contact(view: View, path: str) -> Any:
    """What draws this path; the first one for none."""
    if view.link.face is not None:
        return FaceContact(view, view.link.face)
    tips = [tip for tip in view.link.tips if tip.path == path] or list(view.link.tips)
    return TipContact(view, tips[0])


def rate(vector: Pair) -> Pair:
    """How fast a vector changes as seen from the cam, per radian."""
    x, y = vector
    return x.derivative() + y, y.derivative() - x


def dot(a: Pair, b: Pair) -> arb_series:
    """a · b."""
    return a[0] * b[0] + a[1] * b[1]


def cross(a: Pair, b: Pair) -> arb_series:
    """a × b."""
    return a[0] * b[1] - a[1] * b[0]


def _pressure_angle(view: View, path: str) -> arb_series:
    """α from the outward normal to the drive; its rate without an angle, so that it is steady."""
    touching = contact(view, path)
    n, g = touching.normal(), touching.drive()
    along, across = dot(g, n), cross(g, n)
    turning = (along * across.derivative() - across * along.derivative()) / (
        along * along + across * across
    )
    return turning.integral() + arb.atan2(term(across, 0), term(along, 0))


def curvature(view: View, path: str) -> arb_series:
    """κ of the traced curve, run clockwise: convex positive."""
    tangent = rate(contact(view, path).curve())
    square = dot(tangent, tangent)
    return cross(rate(tangent), tangent) / (square * square.sqrt())


def _radius(view: View, path: str) -> arb_series:
    """How far the traced curve is from the axis."""
    curve = contact(view, path).curve()
    return dot(curve, curve).sqrt()


def _derivative(order: int) -> Callable[[View, str], arb_series]:
    def rated(view: View, path: str) -> arb_series:
        found = view.moved
        for _ in range(order):
            found = found.derivative()
        return found

    return rated


QUANTITIES: dict[str, Callable[[View, str], arb_series]] = {
    "travel": _derivative(0),
    "displacement": _derivative(0),
    "velocity": _derivative(1),
    "acceleration": _derivative(2),
    "jerk": _derivative(3),
    "pressure_angle": _pressure_angle,
    "pitch_curvature": curvature,
    "pitch_radius": _radius,
    "face_radius": lambda view, path: contact(view, path).radius(),
    "contact": lambda view, path: contact(view, path).reach(),
    "contact_left": lambda view, path: -contact(view, path).reach(),
    "contact_right": lambda view, path: contact(view, path).reach(),
}
"""By the names that claims know."""
