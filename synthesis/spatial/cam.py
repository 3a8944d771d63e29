"""A spatial cam with everything settled, and its walls."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np
from scipy.optimize import brentq

from synthesis.geometry.swept_roller import Contacts, Place, SweptRoller
from synthesis.motion import Motion
from synthesis.numerics.piecewise import Array
from synthesis.spatial.machine import LEFT, Seat
from synthesis.spatial.spec import SpatialCamSpec
from synthesis.units import FULL_TURN

Span = tuple[float, float]
TRIED = 33  # places on every piece of the motion between which it is followed


@dataclass(frozen=True)
class Wall:
    """What one side of one roller leaves of the cam in one turn.

    Attributes:
        seat: the roller. side: RIGHT for the one ahead of it as q grows, LEFT for the other; so
            they appear from the cam, where a turret turns counter-clockwise seen from above.
        spans: cam angles between which the roller meets the blank [rad].
    """

    seat: Seat
    side: int
    spans: tuple[Span, ...]

    @property
    def letter(self) -> Literal["L", "R"]:
        """L or R."""
        return "L" if self.side == LEFT else "R"

    @property
    def name(self) -> str:
        """As flanks are named: ``2R`` is the one on the side to which roller 2 moves as q grows."""
        return f"{self.seat.number}{self.letter}"


@dataclass(frozen=True, eq=False)
class SpatialCam:
    """A spatial cam.

    Attributes:
        swept: its geometry. motion: q(θ) over one turn. walls: by roller, then by side.
        sizes: the machine's dimensions by the names of their fields [mm].
    """

    swept: SweptRoller
    motion: Motion
    walls: tuple[Wall, ...]
    sizes: Mapping[str, float]

    def place(self, seat: Seat, theta: Array) -> Place:
        """Where a roller is at θ (n,) [rad], of any turn."""
        q, q1, q2 = self.motion.derivatives(theta, 2)
        turns = np.floor(theta / FULL_TURN)
        return Place(seat.start + self.gain * turns + q, q1, q2)

    @property
    def gain(self) -> float:
        """What the follower has moved on after a turn [rad or mm]."""
        return self.motion.stretches[-1].s_end - self.motion.stretches[0].s_start

    def contacts(self, wall: Wall, theta: Array, rho: Array) -> Contacts:
        """Contacts of a wall at θ (n,) [rad] by places on the roller's axis (m,) [mm]."""
        return self.swept.contacts(self.place(wall.seat, theta), rho, wall.side)

    def surface(self, wall: Wall, theta: Array, rho: Array) -> tuple[Array, Array]:
        """Points [mm] and unit normals out of the cam, as the cam has them: (3, n, m) each."""
        found = self.contacts(wall, theta, rho)
        swept = self.swept
        outward = swept.on_cam(theta, swept.centre.reshape(3, 1, 1) - found.normal)
        return swept.on_cam(theta, found.point), outward


def in_mesh(motion: Motion, seat: Seat, mesh: Span, period: float) -> tuple[Span, ...]:
    """Cam angles within one turn between which a roller meets the blank [rad].

    Args:
        mesh: q between which it does [rad or mm]. period: what brings it back to where it was;
            infinite where nothing does.
    """
    joints = [0.0, *(stretch.end for stretch in motion.stretches)]
    places = seat.start + motion.curve(np.linspace(0.0, FULL_TURN, TRIED * motion.curve.count))
    around = _rounds(float(places.min()), float(places.max()), mesh, period)
    levels = [q - seat.start + shift for q in mesh for shift in around]
    marks = sorted({*joints, *(t for level in levels for t in _reaches(motion, level))})
    middles = [0.5 * (a + b) for a, b in pairwise(marks)]
    q = seat.start + motion.derivatives(np.array(middles), 0)[0]
    inside = np.any([(q > mesh[0] + s) & (q < mesh[1] + s) for s in around], axis=0)
    spans: list[Span] = []
    for (a, b), within in zip(pairwise(marks), inside, strict=True):
        if not within:
            continue
        if spans and spans[-1][1] == a:
            spans[-1] = (spans[-1][0], b)
        else:
            spans.append((a, b))
    return tuple(spans)


def _rounds(low: float, high: float, mesh: Span, period: float) -> list[float]:
    """Multiples of the period by which the mesh may be met between two places q."""
    if math.isinf(period):
        return [0.0]
    first, last = math.floor((low - mesh[1]) / period), math.ceil((high - mesh[0]) / period)
    return [period * k for k in range(first, last + 1)]


def walls_of(
    motion: Motion, seats: Sequence[Seat], mesh: Span, period: float = math.inf
) -> tuple[Wall, ...]:
    """The walls that all rollers leave; those that never meet the blank leave none."""
    found = [(seat, in_mesh(motion, seat, mesh, period)) for seat in seats]
    return tuple(Wall(seat, side, spans) for seat, spans in found if spans for side in seat.sides)


def _reaches(motion: Motion, level: float) -> list[float]:
    """Cam angles where the motion passes a level; one that it only touches may be left out."""
    breaks = motion.curve.breaks
    tried = np.unique(np.concatenate([np.linspace(a, b, TRIED) for a, b in pairwise(breaks)]))

    def above(theta: float) -> float:
        return float(motion.curve(theta)) - level

    high = motion.curve(tried) > level
    changes = np.flatnonzero(high[1:] != high[:-1])
    return [brentq(above, tried[i], tried[i + 1], xtol=1e-14) for i in changes]


def settled(spec: SpatialCamSpec, sizes: Mapping[str, float], motion: Motion) -> SpatialCam:
    """The cam with these dimensions [mm] and this motion."""
    machine = spec.machine
    walls = walls_of(motion, machine.seats(), machine.mesh(sizes), machine.period)
    return SpatialCam(machine.swept(sizes, spec.turns), motion, walls, sizes)
