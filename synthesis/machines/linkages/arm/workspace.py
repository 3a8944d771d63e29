"""Joint limits, and the workspace that they leave: regions with borders of exact arcs.

The allowed arm angles (θ2, θ3) form a convex polygon whose edges are θ2 = const, θ3 = const or
q = const. The forward kinematics maps each edge to an arc in the plane (r, z): about the elbow,
about the point at the forearm's vector from the shoulder, or about the shoulder. Between two
neighbouring singular values of q (cos q = 0) the map is one to one, as the inverse kinematics
shows: the border of that part of the polygon maps to the border of its image, whose area follows
exactly from Green's theorem over its arcs.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Final, Literal

from synthesis.machines.linkages.arm.geometry import Arm, Elbow, Joints
from synthesis.units import FULL_TURN

Span = tuple[float, float]
Corner = tuple[float, float]  # θ2, θ3 [rad]
Joint = Literal["base", "upper_arm", "forearm", "opening", "tool"]
Edge = Literal["upper_arm", "forearm", "opening"]
JOINTS: Final[tuple[Joint, ...]] = ("base", "upper_arm", "forearm", "opening", "tool")
ROUNDING: Final = 1e-12  # rad, and of a length: by so much a limit may be exceeded
RIGHT_ANGLE: Final = 0.5 * math.pi


@dataclass(frozen=True)
class Limits:
    """Ranges of the joints and of q = θ2 − θ3 [rad]."""

    base: Span
    upper: Span
    fore: Span
    opening: Span
    tool: Span

    def exceeded(self, joints: Joints) -> list[tuple[Joint, float]]:
        """Names of the limits that joint angles exceed, and by how much [rad]."""
        angles = (joints.base, joints.upper, joints.fore, joints.opening, joints.tool)
        spans = (self.base, self.upper, self.fore, self.opening, self.tool)
        excess = [max(low - x, x - high) for x, (low, high) in zip(angles, spans, strict=True)]
        return [(name, by) for name, by in zip(JOINTS, excess, strict=True) if by > ROUNDING]

    def equivalent_angles(self, joints: Joints) -> Iterator[Joints]:
        """The same posture with joints changed by whole turns, within the limits where possible.

        An angle that no whole turn brings inside stays as near to its range as possible. For base
        and tool, whose range may exceed 360°, every equivalent is given.
        """
        upper, fore = _nearest(joints.upper, self.upper), _nearest(joints.fore, self.fore)
        for base in _equivalents(joints.base, self.base):
            for tool in _equivalents(joints.tool, self.tool):
                yield Joints(base, upper, fore, tool)

    def polygon(self) -> list[Corner]:
        """Corners of the allowed arm angles, counter-clockwise; empty where there are none."""
        (a, b), (c, d), (low, high) = self.upper, self.fore, self.opening
        corners = _clip([(a, c), (b, c), (b, d), (a, d)], lambda at: at[0] - at[1] - low)
        return _clip(corners, lambda at: high - at[0] + at[1])

    def restrict_opening(self, low: float, high: float) -> Limits:
        """The same limits with q restricted to an interval [rad]."""
        return replace(self, opening=(max(self.opening[0], low), min(self.opening[1], high)))


@dataclass(frozen=True)
class Arc:
    """An arc of a region's border.

    Attributes:
        keeps: the angle that is constant along it: upper_arm, forearm, or opening.
        x, y: centre in (r, z) [mm]. radius: [mm]. start: angle of its start at the centre [rad].
        sweep: angle that it covers, counter-clockwise positive [rad].
        first, last: arm angles at its ends [rad].
    """

    keeps: Edge
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
        (upper, fore), (upper2, fore2) = self.first, self.last
        return upper + share * (upper2 - upper), fore + share * (fore2 - fore)

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
        places = ((arc, share) for arc in self.border for share in arc.turning_points())
        return max(
            (across * r + up * z, arc.angles(share))
            for arc, share in places
            for r, z in (arc.point(share),)
        )


def regions(arm: Arm, limits: Limits) -> list[Region]:
    """The workspace within the limits, a region for each side of the elbow.

    Neighbouring parts of the polygon meet where the arms are in line; their images may overlap.
    """
    openings = [upper - fore for upper, fore in limits.polygon()]
    if not openings:
        return []
    found = []
    # Cut the polygon where cos q = 0: q = (k ± ½) π.
    first = math.floor((min(openings) + RIGHT_ANGLE + ROUNDING) / math.pi)
    last = math.ceil((max(openings) + RIGHT_ANGLE - ROUNDING) / math.pi)
    for k in range(first, max(last, first + 1)):
        part = limits.restrict_opening(
            k * math.pi - RIGHT_ANGLE, k * math.pi + RIGHT_ANGLE
        ).polygon()
        arcs = (tool_arc(arm, *ends) for ends in zip(part, [*part[1:], *part[:1]], strict=True))
        # Without edges that are points.
        border = tuple(
            arc for arc in arcs if abs(arc.sweep) > ROUNDING and arc.radius > ROUNDING * arm.upper
        )
        if border:
            found.append(Region("up" if k % 2 == 0 else "down", border, tuple(part)))
    return found


def singular_segments(limits: Limits) -> list[tuple[Corner, Corner]]:
    """Segments of arm angles inside the limits at which the arms are in line [rad]."""
    found = []
    for k in range(-3, 4):  # |q| ≤ 360°
        q = k * math.pi + RIGHT_ANGLE
        parts = limits.restrict_opening(q, math.inf), limits.restrict_opening(-math.inf, q)
        corners = [corner for part in parts for corner in part.polygon()]
        at = [corner for corner in corners if abs(corner[0] - corner[1] - q) <= ROUNDING]
        if at and max(at) != min(at):
            found.append((min(at), max(at)))
    return found


def tool_arc(arm: Arm, first: Corner, last: Corner) -> Arc:
    """The tool's path along an edge of the polygon, with θ2, θ3 or q constant."""
    (upper, fore), (upper2, fore2) = first, last
    x, y = arm.shoulder + arm.wrist, arm.height - arm.tool
    if abs(upper2 - upper) <= ROUNDING:
        x, y = x + arm.upper * math.sin(upper), y + arm.upper * math.cos(upper)
        return Arc("upper_arm", x, y, arm.fore, -fore, fore - fore2, first, last)
    if abs(fore2 - fore) <= ROUNDING:
        x, y = x + arm.fore * math.cos(fore), y - arm.fore * math.sin(fore)
        return Arc("forearm", x, y, arm.upper, RIGHT_ANGLE - upper, upper - upper2, first, last)
    r, z = float(arm.radius(*first)) - x, float(arm.level(*first)) - y
    return Arc("opening", x, y, math.hypot(r, z), math.atan2(z, r), upper - upper2, first, last)


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
