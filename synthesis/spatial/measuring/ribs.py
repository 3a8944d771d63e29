"""Ribs: how far it is from one of their walls to what the next roller takes away.

A rib stands between two rollers that follow each other. From a point of the wall that one of them
leaves, the rib is as thick as the other one stays away, at whatever cam angle it comes nearest
within half a turn either way. Where the two rollers' ways cross, that is negative: the rib is cut
through there. The rollers know only their axes; no formula of contacts is in that.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from synthesis.geometry.swept_roller import dot, norm, turned
from synthesis.numerics.piecewise import Array
from synthesis.spatial.cam import SpatialCam
from synthesis.spatial.machine import LEFT, Seat
from synthesis.spatial.measuring.found import Bound, Found, Kind, leading
from synthesis.spatial.measuring.patches import Patch, tried
from synthesis.units import FULL_TURN

RIB = Kind("rib_thickness", "mm", largest=False, must=Bound(0.0))
ANGLES, PLACES, TURNS = 25, 3, 73  # tried: of the wall, along it, and of the other roller
CLOSER, ROUNDS, SHRINK = 7, 13, 0.4
WHOLE = 72  # angles of a wall that has many patches, about
KEPT = 3  # places looked at more closely
EVIDENCE = "measured from points of each wall to the next roller, at every cam angle, then closer"


@dataclass(frozen=True, eq=False)
class _Rib:
    """A patch of a wall and the roller on the other side of the rib."""

    patch: Patch
    other: Seat
    lag: float  # what the other roller's place is ahead of its seat's by now [rad or mm]

    def thickness(self, theta: Array, rho: Array, offset: Array) -> Array:
        """From the wall at θ (n,), ρ (m,) to the roller at θ + offset (k,): (k, n, m) [mm].

        Infinite where the wall is beyond the end faces.
        """
        cam = self.patch.cam
        points = self.patch.points(theta, rho)
        found = self._away(points.reshape(3, 1, -1), np.repeat(theta, len(rho)), offset)
        return np.where(cam.between_faces(points), found.reshape(-1, *points.shape[1:]), np.inf)

    def _away(self, points: Array, theta: Array, steps: Array) -> Array:
        """How far points (3, 1, j) of θ (j,) are from the other roller after steps (k,): (k j, 1).

        [mm]; negative inside of the roller.
        """
        swept = self.patch.cam.swept
        centre = swept.centre.reshape(3, 1, 1)
        moved = turned(points - centre, swept.hand * steps, swept.axis) + centre
        at = (theta + steps[:, None]).ravel()
        q = self.other.start + self.lag + carried(self.patch.cam, at)
        u = swept.joint.turned(swept.along.reshape(3, 1, 1), q)
        foot = moved.reshape(3, -1, 1) - swept.joint.moved(swept.origin.reshape(3, 1, 1), q)
        roller, along = swept.roller, dot(u, foot)
        within = np.clip(along, roller.inner, roller.outer)
        beyond = np.abs(along - within)
        over = norm(foot - along * u) - roller.profile(within)[0]
        return np.where(beyond > 0.0, np.hypot(beyond, np.maximum(over, 0.0)), over)


def carried(cam: SpatialCam, theta: Array) -> Array:
    """q at cam angles of any turn [rad or mm]: from turn to turn the follower goes on."""
    turns = np.floor(theta / FULL_TURN)
    return np.asarray(cam.motion.derivatives(theta, 0)[0] + cam.gain * turns)


def _behind(patch: Patch, seats: Sequence[Seat]) -> _Rib | None:
    """A patch of a wall with the rib behind it."""
    ordered = sorted(seats, key=lambda seat: seat.start)
    step = -1 if patch.wall.side == LEFT else 1
    round_trip, at = divmod(ordered.index(patch.wall.seat) + step, len(ordered))
    period = patch.cam.period
    if len(ordered) < 2 or (round_trip and np.isinf(period)):
        return None
    return _Rib(patch, ordered[at], round_trip * period if round_trip else 0.0)


def thinnest(cam: SpatialCam, parts: Sequence[Patch], seats: Sequence[Seat]) -> Found | None:
    """Where a rib is thinnest; None where the cam has none."""
    rho = np.linspace(cam.swept.roller.inner, cam.swept.roller.outer, PLACES)
    offset = np.linspace(-0.5 * FULL_TURN, 0.5 * FULL_TURN, TURNS)
    seen = []
    for wall in tried(parts, ANGLES, WHOLE):
        rib = _behind(wall.together, seats)
        if rib is None:
            continue
        whole = rib.thickness(wall.theta.ravel(), rho, offset)
        for patch, theta, values in zip(parts[wall.first :], wall.theta, wall.apart(whole),
                                        strict=False):  # fmt: skip
            k, n, m = np.unravel_index(int(np.argmin(values)), values.shape)
            at = (float(theta[n]), float(rho[m]), float(offset[k]))
            wide = (patch.high - patch.low) / max(len(theta) - 1, 1)
            seen.append((float(values[k, n, m]), replace(rib, patch=patch), at, wide))
    best = sorted(seen, key=lambda each: leading(each[0]))[:KEPT]
    found = [_closer(*each, rho) for each in best]
    return min(found, key=lambda each: leading(each.value)) if found else None


def _closer(
    value: float, rib: _Rib, at: tuple[float, float, float], wide: float, rho: Array
) -> Found:
    theta, place, offset = at
    patch, long = rib.patch, (rho[-1] - rho[0]) / (PLACES - 1)
    swing, before, grid = FULL_TURN / (TURNS - 1), value, np.linspace(-1.0, 1.0, CLOSER)
    for _ in range(ROUNDS):
        around = np.clip(theta + wide * grid, patch.low, patch.high)
        along = np.clip(place + long * grid, rho[0], rho[-1])
        turns = offset + swing * grid
        values = rib.thickness(around, along, turns)
        k, n, m = np.unravel_index(int(np.argmin(values)), values.shape)
        before = value
        if values[k, n, m] < value:
            value, theta, place = float(values[k, n, m]), float(around[n]), float(along[m])
            offset = float(turns[k])
        wide, long, swing = SHRINK * wide, SHRINK * long, SHRINK * swing
    return Found(value, value - 2.0 * (before - value), EVIDENCE, theta, patch.wall, place)
