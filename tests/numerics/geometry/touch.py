"""The finished cam run by touch: polygons, circles and rotation matrices, and nothing of a cam.

The cam is a closed polygon of profile points. It is turned as a rigid body, and the roller, a
circle whose centre slides on a vertical line or hangs on an arm, is let down until it touches. No
law, no offset formula, no normal and no curvature occurs here, so nothing here can share an error
with them.
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Roller:
    """A circle on a vertical slide: the line of its centre, and its radius (0: a point)."""

    line: float
    radius: float


@dataclass(frozen=True)
class Line:
    """A straight edge on a vertical slide, turned counter-clockwise from horizontal [rad]."""

    tilt: float


@dataclass(frozen=True)
class Swing:
    """A circle at the end of an arm, let down from where the arm points away from the origin.

    Attributes:
        pivot: where it turns. arm: its length. radius: of the circle (0: a point).
        down: +1 where it comes down counter-clockwise, −1 where clockwise.
    """

    pivot: tuple[float, float]
    arm: float
    radius: float
    down: float

    def centre(self, angle: float) -> tuple[float, float]:
        """Where the circle is when its arm has ``angle`` left to the line of the pivots [rad]."""
        back = np.arctan2(self.pivot[1], self.pivot[0]) + np.pi - self.down * angle
        return self.pivot[0] + self.arm * np.cos(back), self.pivot[1] + self.arm * np.sin(back)


def turned(cam: np.ndarray, angle: float) -> np.ndarray:
    """The cam (n, 2), turned as a whole, counter-clockwise."""
    cos, sin = np.cos(angle), np.sin(angle)
    return cam @ np.array([[cos, -sin], [sin, cos]]).T


def rest_height(cam: np.ndarray, roller: Roller) -> float:
    """Height of the roller's centre when it comes down from above and touches the polygon.

    It meets a vertex, or a side at one of the two lines parallel to it at the roller's radius.
    """
    a, b = cam, np.roll(cam, -1, axis=0)
    heights = [np.array([-np.inf])]
    beside = abs(a[:, 0] - roller.line)
    under = beside <= roller.radius
    heights.append(a[under, 1] + np.sqrt(roller.radius**2 - beside[under] ** 2))
    side = b - a
    side = side * np.where(side[:, :1] < 0.0, -1.0, 1.0)  # from left to right
    length = np.hypot(side[:, 0], side[:, 1])
    leans = side[:, 0] > 1e-12 * length
    side, length, start = side[leans], length[leans], np.where(a[:, :1] < b[:, :1], a, b)[leans]
    up = np.stack([-side[:, 1], side[:, 0]], axis=1) / length[:, None]
    part = (roller.line - start[:, 0] - roller.radius * up[:, 0]) / side[:, 0]
    met = (part >= 0.0) & (part <= 1.0)
    heights.append((start[:, 1] + roller.radius * up[:, 1] + part * side[:, 1])[met])
    return float(max(np.max(h, initial=-np.inf) for h in heights))


def rests(cam: np.ndarray, angles: np.ndarray, line: Line) -> np.ndarray:
    """Where the edge crosses the y axis when it comes down from above onto the turning polygon."""
    slope = np.tan(line.tilt)
    return np.array([np.max(p[:, 1] - slope * p[:, 0]) for p in (turned(cam, a) for a in angles)])


def rest_angle(cam: np.ndarray, swing: Swing) -> float:
    """Angle between arm and line of the pivots when the circle comes down on the polygon [rad].

    Its centre runs on a circle about the pivot. It is stopped where that meets the circle of the
    same size round a vertex, or a line parallel to a side at the roller's radius.
    """
    to = cam - np.array(swing.pivot)
    far = np.hypot(to[:, 0], to[:, 1])
    cosine = (swing.arm**2 + far**2 - swing.radius**2) / (2.0 * swing.arm * far)
    near = abs(cosine) <= 1.0
    heading, spread = np.arctan2(to[near, 1], to[near, 0]), np.arccos(cosine[near])
    found = [heading + spread, heading - spread]
    side = np.roll(to, -1, axis=0) - to
    length = np.hypot(side[:, 0], side[:, 1])
    # where a side is touched it lies no farther than the radius from the arm's circle
    real = (length > 0.0) & (abs(far - swing.arm) <= swing.radius + length)
    start, along = to[real], side[real] / length[real, None]
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    for offset in (swing.radius, -swing.radius):
        begin = start + offset * across
        middle, off = np.sum(begin * along, axis=1), np.sum(begin * across, axis=1)
        root = np.sqrt(np.maximum(swing.arm**2 - off**2, 0.0))
        for part in (root - middle, -root - middle):
            met = (abs(off) <= swing.arm) & (part >= 0.0) & (part <= length[real])
            at = begin[met] + part[met, None] * along[met]
            found.append(np.arctan2(at[:, 1], at[:, 0]))
    back = np.arctan2(-swing.pivot[1], -swing.pivot[0])
    angle = swing.down * (back - np.concatenate(found))
    angle = angle - 2.0 * np.pi * np.floor(angle / (2.0 * np.pi))
    return float(np.max(angle[angle <= np.pi], initial=-np.inf))


def clearance(cam: np.ndarray, centre: tuple[float, float]) -> float:
    """Distance from a point to the polygon's outline."""
    return float(_distances(cam, np.array([centre]))[0])


def _distances(cam: np.ndarray, centres: np.ndarray) -> np.ndarray:
    """The same of many points (m, 2)."""
    a = cam[:, 0] + 1j * cam[:, 1]
    side = np.roll(a, -1) - a
    squared = side.real**2 + side.imag**2
    along = np.conj(side) / np.where(squared > 0.0, squared, 1.0)
    found = []
    for centre in centres[:, 0] + 1j * centres[:, 1]:
        to = centre - a
        nearest = to - np.clip((to * along).real, 0.0, 1.0) * side
        found.append(np.sqrt(np.min(nearest.real**2 + nearest.imag**2)))
    return np.array(found)


def lifts(cam: np.ndarray, angles: np.ndarray, roller: Roller) -> np.ndarray:
    """Height of the roller's centre at each angle by which the cam has turned."""
    return np.array([rest_height(turned(cam, angle), roller) for angle in angles])


def swings(cam: np.ndarray, angles: np.ndarray, swing: Swing) -> np.ndarray:
    """Angle of the arm at each angle by which the cam has turned [rad]."""
    return np.array([rest_angle(turned(cam, angle), swing) for angle in angles])


def clearances(cam: np.ndarray, angles: np.ndarray, line: float, heights: np.ndarray) -> np.ndarray:
    """Distance of the roller's centre, held at given heights, from the turning cam.

    Seen from the cam, where the centre turns back.
    """
    centres = [
        turned(np.array([[line, h]]), -angle)[0] for angle, h in zip(angles, heights, strict=True)
    ]
    return _distances(cam, np.array(centres))


def cut(cam: np.ndarray, angles: np.ndarray, line: float, heights: np.ndarray, radius: float):
    """What a cutter of the roller's size leaves of the cam: the vertices that it never covers."""
    left = np.ones(len(cam), dtype=bool)
    for angle, height in zip(angles, heights, strict=True):
        centre = turned(np.array([[line, height]]), -angle)
        left &= np.hypot(*(cam - centre).T) >= radius * (1.0 - 1e-7)
    return cam[left]


def coarseness(cam: np.ndarray) -> float:
    """How far the curve through the vertices may lie from the polygon.

    Over a side of length h that turns by φ a smooth arc rises h φ / 8; both neighbours' turns
    count, and a factor of two is allowed for arcs that are not circles.
    """
    side = np.roll(cam, -1, axis=0) - cam
    length = np.hypot(side[:, 0], side[:, 1])
    heading = np.unwrap(np.arctan2(side[:, 1], side[:, 0]))
    turn = abs(
        np.diff(heading, append=heading[0] + 2.0 * np.pi * np.sign(heading[-1] - heading[0]))
    )
    return float(2.0 * np.max(length * np.maximum(turn, np.roll(turn, 1))) / 8.0)


@dataclass(frozen=True)
class Hinged:
    """A straight edge that swings about a pivot.

    Its line passes the pivot at ``gap``, measured towards the origin; ``sense`` is +1 where it
    swings clockwise away from the origin, −1 counter-clockwise. Angles are counted from where it
    would be parallel to the line from the pivot to the origin.
    """

    pivot: tuple[float, float]
    gap: float
    sense: float


def rest_angles(cam: np.ndarray, angles: np.ndarray, edge: Hinged) -> np.ndarray:
    """Where the edge comes to rest as it swings back onto the turning polygon [rad].

    A vertex at the distance r from the pivot, seen β off the line to the origin, is touched where
    the edge's angle exceeds β by that whose sine is gap/r.
    """
    pivot = np.array(edge.pivot)
    inward = -pivot / np.hypot(*pivot)
    found = []
    for angle in angles:
        to = turned(cam, angle) - pivot
        ahead, beside = to @ inward, edge.sense * (inward[0] * -to[:, 1] + inward[1] * to[:, 0])
        distance = np.hypot(ahead, beside)
        near = distance > abs(edge.gap)  # else the edge passes beyond the pivot, clear of them
        above = np.arcsin(edge.gap / distance[near])
        found.append(np.max(np.arctan2(beside, ahead)[near] + above))
    return np.array(found)


def ceiling(ring: np.ndarray, roller: Roller, start: float) -> float:
    """Height of the roller's centre when it rises from ``start`` in a polygon and touches it."""
    a, b = ring, np.roll(ring, -1, axis=0)
    beside = abs(a[:, 0] - roller.line)
    over = beside <= roller.radius
    heights = [a[over, 1] - np.sqrt(roller.radius**2 - beside[over] ** 2)]
    side = b - a
    side = side * np.where(side[:, :1] < 0.0, -1.0, 1.0)  # from left to right
    length = np.hypot(side[:, 0], side[:, 1])
    leans = side[:, 0] > 1e-12 * length
    side, length, first = side[leans], length[leans], np.where(a[:, :1] < b[:, :1], a, b)[leans]
    down = np.stack([side[:, 1], -side[:, 0]], axis=1) / length[:, None]
    part = (roller.line - first[:, 0] - roller.radius * down[:, 0]) / side[:, 0]
    met = (part >= 0.0) & (part <= 1.0)
    heights.append((first[:, 1] + roller.radius * down[:, 1] + part * side[:, 1])[met])
    found = np.concatenate(heights)
    return float(np.min(found[found > start], initial=np.inf))


def ceilings(ring: np.ndarray, angles: np.ndarray, roller: Roller, start: float) -> np.ndarray:
    """The same at each angle by which the ring has turned."""
    return np.array([ceiling(turned(ring, angle), roller, start) for angle in angles])
