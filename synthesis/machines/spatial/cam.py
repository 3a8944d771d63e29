"""SpatialCam: a spatial cam with its motion and all dimensions given, and its walls."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from synthesis.catalogue.motion import Motion
from synthesis.machines.spatial.machine import LEFT, Seat
from synthesis.machines.spatial.meshing import Span, intervals_between_faces, mesh_intervals
from synthesis.machines.spatial.spec import SpatialCamSpec
from synthesis.numerics.geometry.swept_roller import (
    Contacts,
    FollowerState,
    SweptRoller,
    dot,
    rotate,
)
from synthesis.numerics.piecewise import Array
from synthesis.units import FULL_TURN


@dataclass(frozen=True)
class Wall:
    """The surface of the cam that one side of one roller envelops in one turn.

    Attributes:
        seat: the roller.
        side: RIGHT for the wall ahead of the roller as q grows, LEFT for the other; so they appear
            from the cam, where a turret turns counter-clockwise seen from above.
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
        """Name of the flank: ``2R`` is on the side towards which roller 2 moves as q grows."""
        return f"{self.seat.number}{self.letter}"


@dataclass(frozen=True, eq=False)
class SpatialCam:
    """A spatial cam.

    Attributes:
        swept: kinematics of the roller against the cam. motion: q(θ) over one turn.
        walls: by roller, then by side.
        sizes: the machine's dimensions by the names of their fields [mm].
        faces: positions of the end faces along its axis, from ``swept.centre`` [mm].
        period: of q, after which a roller is back at its place [rad or mm].
    """

    swept: SweptRoller
    motion: Motion
    walls: tuple[Wall, ...]
    sizes: Mapping[str, float]
    faces: Span = (-math.inf, math.inf)
    period: float = math.inf

    def place(self, seat: Seat, theta: Array) -> FollowerState:
        """Position and derivatives of a roller at θ (n,) [rad], in any turn."""
        q, q1, q2 = self.motion.derivatives(theta, 2)
        turns = np.floor(theta / FULL_TURN)
        return FollowerState(seat.start + self.gain * turns + q, q1, q2)

    @property
    def gain(self) -> float:
        """Net displacement of the follower in one turn [rad or mm]."""
        return self.motion.segments[-1].s_end - self.motion.segments[0].s_start

    def contacts(self, wall: Wall, theta: Array, rho: Array) -> Contacts:
        """Contacts of a wall at θ (n,) [rad] and places on the roller's axis (m,) [mm]."""
        return self.swept.contacts(self.place(wall.seat, theta), rho, wall.side)

    def between_faces(self, point: Array) -> Array:
        """Which points (3, …) of the machine's frame lie between the end faces."""
        shape = (3,) + (1,) * (point.ndim - 1)
        along = dot(self.swept.axis.reshape(shape), point - self.swept.centre.reshape(shape))
        return np.asarray((along >= self.faces[0]) & (along <= self.faces[1]))

    def surface(self, wall: Wall, theta: Array, rho: Array) -> tuple[Array, Array]:
        """Points [mm] and unit normals out of the material, in the cam's frame: (3, n, m) each."""
        swept = self.swept
        point, normal = swept.contact_points(self.place(wall.seat, theta), rho, wall.side)
        outward = rotate(-normal, -swept.hand * theta, swept.axis)
        return swept.on_cam(theta, point), outward


def build_cam(spec: SpatialCamSpec, sizes: Mapping[str, float], motion: Motion) -> SpatialCam:
    """The cam with these dimensions [mm] and this motion."""
    machine = spec.machine
    swept, mesh, faces = (
        machine.swept_roller(sizes, spec.rotation_sign),
        machine.mesh_range(sizes),
        machine.end_faces(),
    )
    walls = []
    for seat in machine.seats():
        met = mesh_intervals(motion, seat, mesh, machine.period)
        for side in seat.sides if met else ():
            parts = (
                intervals_between_faces(swept, motion, seat, side, span, faces) for span in met
            )
            spans = tuple(part for each in parts for part in each)
            if spans:
                walls.append(Wall(seat, side, spans))
    return SpatialCam(swept, motion, tuple(walls), sizes, faces, machine.period)
