"""Geometry of the palletising arm: kinematics, statics, joint limits, and the workspace they leave.

Axis 1 turns the arm about the vertical z. Two parallelograms keep the wrist upright, so that both
arm angles are absolute: θ2 of the upper arm from the vertical, forwards, and θ3 of the forearm
below the horizontal. In the plane through axis 1 a point is the complex number r + i z [mm], and
the tool is at

    t = o + i a2 e^(−i θ2) + a3 e^(−i θ3)          o = (a1 + a4) + i (d1 − tool)

With q = θ2 − θ3 its distance from o depends on q alone, |t − o|² = a2² + a3² + 2 a2 a3 sin q. The
arms are in line, and the posture is singular, where cos q = 0.

The allowed arm angles (θ2, θ3) form a convex polygon whose edges are θ2 = const, θ3 = const or
q = const. The forward kinematics maps each edge to an arc: about o + i a2 e^(−i θ2), about
o + a3 e^(−i θ3), or about o. Between two neighbouring singular values of q the map is one to one,
as the inverse kinematics shows: the border of that part of the polygon maps to the border of its
image, whose area follows exactly from Green's theorem over its arcs.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any, Final, Literal

import numpy as np

from synthesis.units import FULL_TURN

Value = Any  # a number or an array
Span = tuple[float, float]
Corner = tuple[float, float]  # θ2, θ3 [rad]
Base = Literal["front", "over"]
Elbow = Literal["up", "down"]
Edge = Literal["upper_arm", "forearm", "opening"]
Joint = Literal["base", "upper_arm", "forearm", "opening", "tool"]
JOINTS: Final[tuple[Joint, ...]] = ("base", "upper_arm", "forearm", "opening", "tool")
ROUNDING: Final = 1e-12  # rad, and relative: by so much a limit or the reach may be exceeded
RIGHT_ANGLE: Final = 0.5 * math.pi  # rad
G: Final = 9.80665  # m/s², standard gravity
METRE: Final = 1e-3  # m per mm


@dataclass(frozen=True)
class Joints:
    """The four driven angles [rad]."""

    base: float
    upper_arm: float
    forearm: float
    tool: float

    @property
    def opening(self) -> float:
        """q = θ2 − θ3: the arms are in line at ±90°."""
        return self.upper_arm - self.forearm


@dataclass(frozen=True)
class Place:
    """Position of the tool [mm] and its angle about the vertical [rad]."""

    x: float
    y: float
    z: float
    yaw: float


@dataclass(frozen=True)
class Posture:
    """One posture that reaches a place; angles of base and tool in (−π, π]."""

    base: Base  # `front`, turned towards the place; `over`, turned away and reaching back
    elbow: Elbow  # `up` while q lies between −90° and 90°, `down` beyond
    joints: Joints


@dataclass(frozen=True)
class Arm:
    """Lengths of the arm [mm]."""

    height: float  # d1, of the shoulder
    shoulder: float  # a1, from axis 1
    upper: float  # a2
    fore: float  # a3
    wrist: float  # a4, from the forearm's end to the tool's axis
    tool: float  # below the forearm's end

    @property
    def origin(self) -> complex:
        """o: where the tool would be with arms of no length."""
        return complex(self.shoulder + self.wrist, self.height - self.tool)

    def tool_point(self, upper: Value, fore: Value) -> Value:
        """t = r + i z of the tool; r is negative behind axis 1."""
        arms = 1j * self.upper * np.exp(-1j * upper) + self.fore * np.exp(-1j * fore)
        return self.origin + arms

    def place(self, joints: Joints) -> Place:
        """Forward kinematics: the place of the tool."""
        tool = self.tool_point(joints.upper_arm, joints.forearm)
        level = cmath.rect(tool.real, joints.base)
        return Place(
            level.real, level.imag, float(tool.imag), wrap_angle(joints.base + joints.tool)
        )

    def postures(self, place: Place) -> Iterator[Posture]:
        """Inverse kinematics: every posture, limits aside; none where the place is out of reach."""
        distance, front = math.hypot(place.x, place.y), math.atan2(place.y, place.x)
        bases: tuple[tuple[Base, float, float], ...] = (
            ("front", front, distance), ("over", front + math.pi, -distance),
        )  # fmt: skip
        for base, angle, r in bases:
            for elbow, upper, fore in self._arm_angles(complex(r, place.z) - self.origin):
                joints = Joints(wrap_angle(angle), upper, fore, wrap_angle(place.yaw - angle))
                yield Posture(base, elbow, joints)

    def _arm_angles(self, arms: complex) -> Iterator[tuple[Elbow, float, float]]:
        """Both pairs of arm angles (elbow, θ2, θ3) for a value of t − o."""
        square, a, b = arms.real**2 + arms.imag**2, self.upper, self.fore
        sine = (square - a * a - b * b) / (2.0 * a * b)
        # (2 a b cos q)² as a product: accurate also where the arms are nearly in line.
        discriminant = ((a + b) ** 2 - square) * (square - (a - b) ** 2)
        if discriminant < -ROUNDING * (2.0 * a * b) ** 2 or square == 0.0:
            return
        cosine = math.sqrt(max(discriminant, 0.0)) / (2.0 * a * b)
        elbows: tuple[tuple[Elbow, float], ...] = (("up", cosine), ("down", -cosine))
        for elbow, cos in elbows[: 1 if cosine == 0.0 else 2]:
            # t − o = e^(−i θ2) (b cos q + i (a + b sin q)), with θ3 = θ2 − q.
            upper = cmath.phase(complex(b * cos, a + b * sine) * arms.conjugate())
            yield elbow, upper, upper - math.atan2(sine, cos)


def static_moments(
    parts: Iterable[tuple[float, float, float]], gravity: float = G
) -> tuple[float, float]:
    """g Σ m p and g Σ m w [N·m]: the torques with both arms horizontal, of parts (m, p, w).

    The centre of a mass m [kg] is at distances p, w along both arms [mm]. Elbow plate and tool do
    not rotate about a horizontal axis. So the height of every part is that of the shoulder plus
    p cos θ2 − w sin θ3 and a constant, and virtual work gives the torques that hold it:
    τ2 = −g Σ m p sin θ2, τ3 = −g Σ m w cos θ3.
    """
    mass, p, w = np.array([*parts]).T
    return float(gravity * METRE * (mass @ p)), float(gravity * METRE * (mass @ w))


def holding_torques(moments: tuple[float, float], upper: Value, fore: Value) -> tuple[Value, Value]:
    """Torques [N·m] of axes 2 and 3 at arm angles [rad], positive along their angles."""
    return 0.0 - moments[0] * np.sin(upper), 0.0 - moments[1] * np.cos(fore)


def wrap_angle(angle: float) -> float:
    """The same direction in (−π, π]."""
    wrapped = math.remainder(angle, FULL_TURN)
    return math.pi if wrapped == -math.pi else wrapped


@dataclass(frozen=True)
class Limits:
    """Ranges of the joints and of q = θ2 − θ3 [rad]."""

    base: Span
    upper_arm: Span
    forearm: Span
    opening: Span
    tool: Span

    def exceeded(self, joints: Joints) -> list[tuple[Joint, float]]:
        """Names of the limits that joint angles exceed, and by how much [rad]."""
        found = ((name, getattr(joints, name), getattr(self, name)) for name in JOINTS)
        excess = [(name, max(low - x, x - high)) for name, x, (low, high) in found]
        return [(name, by) for name, by in excess if by > ROUNDING]

    def equivalent_angles(self, joints: Joints) -> Iterator[Joints]:
        """The same posture with joints changed by whole turns, within the limits where possible.

        An angle that no whole turn brings inside stays as near to its range as possible. For base
        and tool, whose range may exceed 360°, every equivalent is given.
        """
        upper = _nearest(joints.upper_arm, self.upper_arm)
        fore = _nearest(joints.forearm, self.forearm)
        for base in _equivalents(joints.base, self.base):
            for tool in _equivalents(joints.tool, self.tool):
                yield Joints(base, upper, fore, tool)

    def polygon(self, least: float = -math.inf, most: float = math.inf) -> list[Corner]:
        """Corners of the allowed arm angles with q from ``least`` to ``most``, counter-clockwise.

        None where there are no such angles.
        """
        (a, b), (c, d) = self.upper_arm, self.forearm
        low, high = max(self.opening[0], least), min(self.opening[1], most)
        corners = _clip([(a, c), (b, c), (b, d), (a, d)], lambda at: at[0] - at[1] - low)
        return _clip(corners, lambda at: high - at[0] + at[1])

    def singular_segments(self) -> list[tuple[Corner, Corner]]:
        """Segments of allowed arm angles at which the arms are in line [rad]."""
        (a, b), (c, d), (low, high) = self.upper_arm, self.forearm, self.opening
        singular = [k * math.pi + RIGHT_ANGLE for k in range(-2, 2)]  # |q| ≤ 360°
        # θ2 on the line θ3 = θ2 − q within the rectangle of both ranges.
        spans = [(q, max(a, c + q), min(b, d + q)) for q in singular
                 if low - ROUNDING <= q <= high + ROUNDING]  # fmt: skip
        return [((first, first - q), (last, last - q)) for q, first, last in spans if first < last]


def _equivalents(angle: float, span: Span) -> list[float]:
    """The angle plus whole turns: all that lie in the range, or the one nearest to it."""
    low, high = span
    first = math.ceil((low - ROUNDING - angle) / FULL_TURN)
    last = math.floor((high + ROUNDING - angle) / FULL_TURN)
    inside = [angle + k * FULL_TURN for k in range(first, last + 1)]
    if high - low <= FULL_TURN + ROUNDING:  # the ends of a full turn are one place
        inside = inside[-1:]
    return inside or [_nearest(angle, span)]


def _nearest(angle: float, span: Span) -> float:
    """The angle plus whole turns that exceeds the range least."""
    return min(
        (angle + k * FULL_TURN for k in range(-2, 3)),
        key=lambda each: max(span[0] - each, each - span[1], 0.0),
    )


def _clip(corners: list[Corner], keep: Callable[[Corner], float]) -> list[Corner]:
    """The part of a convex polygon where a linear function is ≥ 0 (Sutherland and Hodgman)."""
    kept: list[Corner] = []
    for here, there in zip(corners, [*corners[1:], *corners[:1]], strict=True):
        first, second = keep(here), keep(there)
        if first >= 0.0:
            kept.append(here)
        if (first > 0.0 > second) or (first < 0.0 < second):
            share = first / (first - second)  # where the function is 0 along this edge
            (a, b), (c, d) = here, there
            kept.append((a + share * (c - a), b + share * (d - b)))
    return kept


@dataclass(frozen=True)
class Arc:
    """An arc of a region's border."""

    keeps: Edge  # the angle that is constant along it
    centre: complex  # r + i z [mm]
    radius: float  # [mm]
    start: float  # angle of its start at the centre [rad]
    sweep: float  # angle that it covers, counter-clockwise positive [rad]
    first: Corner  # arm angles at its start [rad]
    last: Corner  # the same at its end

    def point(self, share: float) -> complex:
        """The point r + i z at a share of its length, from 0 to 1 [mm]."""
        return self.centre + cmath.rect(self.radius, self.start + share * self.sweep)

    def angles(self, share: float) -> Corner:
        """The arm angles there [rad]."""
        (upper, fore), (upper2, fore2) = self.first, self.last
        return upper + share * (upper2 - upper), fore + share * (fore2 - fore)

    def area(self) -> float:
        """Its contribution to ½ ∮ (r dz − z dr) [mm²]."""
        chord = self.point(1.0) - self.point(0.0)
        return 0.5 * (self.radius**2 * self.sweep + (self.centre.conjugate() * chord).imag)

    def moment(self) -> float:
        """Its contribution to ½ ∮ r² dz, the region's first moment about axis 1 [mm³]."""
        a, b, R, x = self.start, self.start + self.sweep, self.radius, self.centre.real
        # ∫ cos α, ∫ cos² α and ∫ cos³ α over the arc.
        sine = math.sin(b) - math.sin(a)
        square = 0.5 * self.sweep + 0.25 * (math.sin(2.0 * b) - math.sin(2.0 * a))
        cube = sine - (math.sin(b) ** 3 - math.sin(a) ** 3) / 3.0
        return 0.5 * R * (x * x * sine + 2.0 * x * R * square + R * R * cube)

    def turning_points(self) -> Iterator[float]:
        """Shares of its length at which r or z may be extreme."""
        yield from (0.0, 1.0)
        low, high = sorted((self.start, self.start + self.sweep))
        for k in range(math.ceil(low / RIGHT_ANGLE), math.floor(high / RIGHT_ANGLE) + 1):
            yield (k * RIGHT_ANGLE - self.start) / self.sweep


@dataclass(frozen=True)
class Region:
    """The part of the workspace with the elbow on one side."""

    elbow: Elbow
    border: tuple[Arc, ...]  # each beginning where the one before ends

    @property
    def area(self) -> float:
        """Of the region in the plane (r, z) [mm²]."""
        return abs(math.fsum(arc.area() for arc in self.border))

    @property
    def moment(self) -> float:
        """∫ r dA [mm³]; times the angle of the base it is the volume (Pappus)."""
        sign = math.copysign(1.0, math.fsum(arc.area() for arc in self.border))
        return sign * math.fsum(arc.moment() for arc in self.border)

    def farthest(self, way: complex) -> tuple[float, Corner]:
        """How far the region extends along 1, i, −1 or −i from 0 [mm], and the arm angles there."""
        return max(
            ((way.conjugate() * arc.point(share)).real, arc.angles(share))
            for arc in self.border for share in arc.turning_points()
        )  # fmt: skip


def regions(arm: Arm, limits: Limits) -> list[Region]:
    """The workspace within the limits, a region for each side of the elbow.

    Neighbouring parts of the polygon meet where the arms are in line; their images may overlap.
    """
    openings = [upper - fore for upper, fore in limits.polygon()]
    if not openings:
        return []
    workspace = []
    # Cut the polygon where cos q = 0: q = (k ± ½) π.
    first = math.floor((min(openings) + RIGHT_ANGLE + ROUNDING) / math.pi)
    last = math.ceil((max(openings) + RIGHT_ANGLE - ROUNDING) / math.pi)
    for k in range(first, max(last, first + 1)):
        part = limits.polygon(k * math.pi - RIGHT_ANGLE, k * math.pi + RIGHT_ANGLE)
        arcs = (tool_arc(arm, *ends) for ends in zip(part, [*part[1:], *part[:1]], strict=True))
        # Without edges that are points.
        border = tuple(
            arc for arc in arcs if abs(arc.sweep) > ROUNDING and arc.radius > ROUNDING * arm.upper
        )
        if border:
            workspace.append(Region("up" if k % 2 == 0 else "down", border))
    return workspace


def tool_arc(arm: Arm, first: Corner, last: Corner) -> Arc:
    """The tool's path along an edge of the polygon, with θ2, θ3 or q constant."""
    (upper, fore), (upper2, fore2), o = first, last, arm.origin
    if abs(upper2 - upper) <= ROUNDING:
        centre = o + cmath.rect(arm.upper, RIGHT_ANGLE - upper)
        return Arc("upper_arm", centre, arm.fore, -fore, fore - fore2, first, last)
    if abs(fore2 - fore) <= ROUNDING:
        centre = o + cmath.rect(arm.fore, -fore)
        return Arc("forearm", centre, arm.upper, RIGHT_ANGLE - upper, upper - upper2, first, last)
    radius, start = cmath.polar(arm.tool_point(*first) - o)
    return Arc("opening", o, radius, start, upper - upper2, first, last)
