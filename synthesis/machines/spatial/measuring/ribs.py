"""Rib thickness: least distance from a wall of the rib to the next roller.

A rib stands between two consecutive rollers. At a point of the wall that one of them envelops, the
rib is as thick as the least distance to the other roller over half a turn either way. Where the
rollers' swept volumes overlap it is negative: the rib is cut through. The distance is to the roller
as a solid of revolution about its axis; it uses no formula of contacts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from synthesis.machines.spatial.cam import SpatialCam
from synthesis.machines.spatial.machine import LEFT, Seat
from synthesis.machines.spatial.measuring.extremum import Bound, Extremum, Quantity, rounded
from synthesis.machines.spatial.measuring.patches import Patch, sample_walls
from synthesis.numerics.geometry.swept_roller import dot, norm, rotate
from synthesis.numerics.piecewise import Array
from synthesis.units import FULL_TURN

RIB = Quantity("rib_thickness", "mm", largest=False, required=Bound(0.0))
ANGLES, PLACES, TURNS = 25, 3, 73  # samples: cam angles, places, angles of the other roller
GRID, ROUNDS, SHRINK = 7, 13, 0.4  # refinement: points a direction, rounds, shrinkage a round
WHOLE = 72  # about so many angles on a wall with many patches
REFINED = 3  # samples that are refined
EVIDENCE = "measured from points of each wall to the next roller, at every cam angle, then closer"


@dataclass(frozen=True, eq=False)
class _Rib:
    """A patch of a wall and the roller on the other side of its rib."""

    patch: Patch
    other: Seat
    lag: float  # of the other roller's position, where it is one period further [rad or mm]

    def thickness(self, theta: Array, rho: Array, offset: Array) -> Array:
        """Distance of the wall at θ (n,), ρ (m,) to the roller at θ + offset (k,): (k, n, m) [mm].

        Infinite where the wall is beyond the end faces.
        """
        cam = self.patch.cam
        points = self.patch.points(theta, rho)
        found = self._distance(points.reshape(3, 1, -1), np.repeat(theta, len(rho)), offset)
        return np.where(cam.between_faces(points), found.reshape(-1, *points.shape[1:]), np.inf)

    def _distance(self, points: Array, theta: Array, steps: Array) -> Array:
        """Distance of points (3, 1, j) at θ (j,) from the other roller steps (k,) later: (k j, 1).

        [mm]; negative inside the roller.
        """
        swept = self.patch.cam.swept
        centre = swept.centre.reshape(3, 1, 1)
        moved = rotate(points - centre, swept.hand * steps, swept.axis) + centre
        at = (theta + steps[:, None]).ravel()
        q = self.other.start + self.lag + position_at(self.patch.cam, at)
        u = swept.joint.turn_direction(swept.along.reshape(3, 1, 1), q)
        foot = moved.reshape(3, -1, 1) - swept.joint.move_points(swept.origin.reshape(3, 1, 1), q)
        roller, along = swept.roller, dot(u, foot)
        within = np.clip(along, roller.inner, roller.outer)
        beyond = np.abs(along - within)
        over = norm(foot - along * u) - roller.profile(within)[0]
        return np.where(beyond > 0.0, np.hypot(beyond, np.maximum(over, 0.0)), over)


def position_at(cam: SpatialCam, theta: Array) -> Array:
    """q at cam angles of any turn, with the net displacement of the turns before [rad or mm]."""
    turns = np.floor(theta / FULL_TURN)
    return np.asarray(cam.motion.derivatives(theta, 0)[0] + cam.gain * turns)


def _rib_behind(patch: Patch, seats: Sequence[Seat]) -> _Rib | None:
    """The rib behind a patch of a wall; None where no other roller bounds it."""
    ordered = sorted(seats, key=lambda seat: seat.start)
    step = -1 if patch.wall.side == LEFT else 1
    round_trip, at = divmod(ordered.index(patch.wall.seat) + step, len(ordered))
    period = patch.cam.period
    if len(ordered) < 2 or (round_trip and np.isinf(period)):
        return None
    return _Rib(patch, ordered[at], round_trip * period if round_trip else 0.0)


def thinnest(cam: SpatialCam, parts: Sequence[Patch], seats: Sequence[Seat]) -> Extremum | None:
    """The least rib thickness, by samples and refinement; None where the cam has no ribs."""
    rho = np.linspace(cam.swept.roller.inner, cam.swept.roller.outer, PLACES)
    offset = np.linspace(-0.5 * FULL_TURN, 0.5 * FULL_TURN, TURNS)
    seen = []
    for wall in sample_walls(parts, ANGLES, WHOLE):
        rib = _rib_behind(wall.together, seats)
        if rib is None:
            continue
        whole = rib.thickness(wall.theta.ravel(), rho, offset)
        for patch, theta, values in zip(parts[wall.first :], wall.theta, wall.by_patch(whole),
                                        strict=False):  # fmt: skip
            k, n, m = np.unravel_index(int(np.argmin(values)), values.shape)
            at = (float(theta[n]), float(rho[m]), float(offset[k]))
            wide = (patch.high - patch.low) / max(len(theta) - 1, 1)
            seen.append((float(values[k, n, m]), replace(rib, patch=patch), at, wide))
    best = sorted(seen, key=lambda each: rounded(each[0]))[:REFINED]
    found = [_refine(*each, rho) for each in best]
    return min(found, key=lambda each: rounded(each.value)) if found else None


def _refine(
    value: float, rib: _Rib, at: tuple[float, float, float], wide: float, rho: Array
) -> Extremum:
    theta, place, offset = at
    patch, long = rib.patch, (rho[-1] - rho[0]) / (PLACES - 1)
    swing, before, grid = FULL_TURN / (TURNS - 1), value, np.linspace(-1.0, 1.0, GRID)
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
    return Extremum(value, value - 2.0 * (before - value), EVIDENCE, theta, patch.wall, place)
