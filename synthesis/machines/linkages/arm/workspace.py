"""Workspace of the tool: regions of the plane (r, z) with borders of exact arcs.

The allowed arm angles form a convex polygon whose edges are θ2 = const, θ3 = const or q = const.
The forward kinematics maps each edge to an arc: about the elbow, about the point at the forearm's
vector from the shoulder, or about the shoulder. Between two neighbouring singular values of q (cos
q = 0) the map is one to one, as the inverse kinematics shows: the border of that part of the
polygon maps to the border of its image, whose area follows exactly from Green's theorem over its
arcs.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

from synthesis.machines.linkages.arm.geometry import Arm, Elbow
from synthesis.machines.linkages.arm.limits import Corner, Limits

POINT: Final = 1e-12  # rad, and of a length: a shorter edge is a point
RIGHT_ANGLE: Final = 0.5 * math.pi


@dataclass(frozen=True)
class Arc:
    """An arc of a region's border.

    Attributes:
        keeps: the angle that is constant along it: upper_arm, forearm, or opening.
        x, y: centre in (r, z) [mm]. radius: [mm]. start: angle of its start at the centre [rad].
        sweep: angle that it covers, counter-clockwise positive [rad].
        first, last: arm angles at its ends [rad].
    """

    keeps: str
    x: float
    y: float
    radius: float
    start: float
    sweep: float
    first: Corner
    last: Corner

    def point(self, share: float) -> tuple[float, float]:
        """The point (r, z) at a share of its length, from 0 to 1 [mm]."""
        at = self.start + share * self.sweep
        return self.x + self.radius * math.cos(at), self.y + self.radius * math.sin(at)

    def angles(self, share: float) -> Corner:
        """The arm angles there [rad]."""
        pairs = zip(self.first, self.last, strict=True)
        upper, fore = (a + share * (b - a) for a, b in pairs)
        return upper, fore

    def area(self) -> float:
        """Its contribution to ½ ∮ (r dz − z dr) [mm²]."""
        (x0, y0), (x1, y1) = self.point(0.0), self.point(1.0)
        return 0.5 * (self.radius**2 * self.sweep + self.x * (y1 - y0) - self.y * (x1 - x0))

    def moment(self) -> float:
        """Its contribution to ½ ∮ r² dz, the region's first moment about axis 1 [mm³]."""
        a, b, R = self.start, self.start + self.sweep, self.radius
        sine, double = math.sin(b) - math.sin(a), math.sin(2.0 * b) - math.sin(2.0 * a)
        cube = sine - (math.sin(b) ** 3 - math.sin(a) ** 3) / 3.0
        squares = 0.5 * self.sweep + 0.25 * double
        return 0.5 * R * (self.x**2 * sine + 2.0 * self.x * R * squares + R * R * cube)

    def turning_points(self) -> Iterator[float]:
        """Shares of its length at which r or z may be extreme."""
        yield 0.0
        yield 1.0
        low, high = sorted((self.start, self.start + self.sweep))
        for k in range(math.ceil(low / RIGHT_ANGLE), math.floor(high / RIGHT_ANGLE) + 1):
            yield min(max((k * RIGHT_ANGLE - self.start) / self.sweep, 0.0), 1.0)


@dataclass(frozen=True)
class Region:
    """The part of the workspace with the elbow on one side.

    Attributes:
        elbow: `up` or `down`. border: arcs, each beginning where the one before ends.
        corners: of the polygon of arm angles [rad].
    """

    elbow: Elbow
    border: tuple[Arc, ...]
    corners: tuple[Corner, ...]

    @property
    def area(self) -> float:
        """Of the region in the plane (r, z) [mm²]."""
        return abs(math.fsum(arc.area() for arc in self.border))

    @property
    def moment(self) -> float:
        """∫ r dA [mm³]; times the angle of the base it is the volume (Pappus)."""
        sign = math.copysign(1.0, math.fsum(arc.area() for arc in self.border))
        return sign * math.fsum(arc.moment() for arc in self.border)

    def farthest(self, across: float, up: float) -> tuple[float, Corner]:
        """Largest value of across · r + up · z, one of them 0, and the arm angles there."""
        found = []
        for arc in self.border:
            for share in arc.turning_points():
                r, z = arc.point(share)
                found.append((across * r + up * z, arc.angles(share)))
        return max(found)


def regions(arm: Arm, limits: Limits) -> list[Region]:
    """The workspace within the limits, a region for each side of the elbow.

    Neighbouring parts of the polygon meet where the arms are in line; their images may overlap.
    """
    corners = limits.polygon()
    if not corners:
        return []
    openings = [upper - fore for upper, fore in corners]
    found = []
    first = math.floor((min(openings) + RIGHT_ANGLE + POINT) / math.pi)
    last = math.ceil((max(openings) + RIGHT_ANGLE - POINT) / math.pi)
    for k in range(first, max(last, first + 1)):
        part = limits.within(k * math.pi - RIGHT_ANGLE, k * math.pi + RIGHT_ANGLE).polygon()
        border = tuple(_border(arm, part))
        if border:
            elbow: Elbow = "up" if k % 2 == 0 else "down"
            found.append(Region(elbow, border, tuple(part)))
    return found


def singular_segments(limits: Limits) -> list[tuple[Corner, Corner]]:
    """Segments of arm angles inside the limits at which the arms are in line [rad]."""
    corners = limits.polygon()
    found = []
    for k in range(-3, 4):
        q = k * math.pi + RIGHT_ANGLE
        at = [
            corner for part in (limits.within(q, math.inf), limits.within(-math.inf, q))
            for corner in part.polygon() if abs(corner[0] - corner[1] - q) <= POINT
        ]  # fmt: skip
        if corners and at and max(at) != min(at):
            found.append((min(at), max(at)))
    return found


def _border(arm: Arm, corners: Sequence[Corner]) -> Iterator[Arc]:
    for first, last in zip(corners, [*corners[1:], *corners[:1]], strict=True):
        arc = tool_arc(arm, first, last)
        if abs(arc.sweep) > POINT and arc.radius > POINT * arm.upper:
            yield arc


def tool_arc(arm: Arm, first: Corner, last: Corner) -> Arc:
    """The tool's path along an edge of the polygon, with θ2, θ3 or q constant."""
    (upper, fore), (upper2, fore2) = first, last
    x, y = arm.shoulder + arm.wrist, arm.height - arm.tool
    if abs(upper2 - upper) <= POINT:
        x, y = x + arm.upper * math.sin(upper), y + arm.upper * math.cos(upper)
        return Arc("upper_arm", x, y, arm.fore, -fore, fore - fore2, first, last)
    if abs(fore2 - fore) <= POINT:
        x, y = x + arm.fore * math.cos(fore), y - arm.fore * math.sin(fore)
        return Arc("forearm", x, y, arm.upper, RIGHT_ANGLE - upper, upper - upper2, first, last)
    r, z = float(arm.radius(*first)) - x, float(arm.level(*first)) - y
    return Arc("opening", x, y, math.hypot(r, z), math.atan2(z, r), upper - upper2, first, last)
