"""Walls cut at the joints of the motion: on each patch every quantity is smooth."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from synthesis.geometry.swept_roller import Contacts, Place
from synthesis.numerics.piecewise import Array
from synthesis.spatial.cam import SpatialCam, Wall


@dataclass(frozen=True, eq=False)
class Patch:
    """A part of a wall on one piece of the motion.

    Attributes:
        piece: which. low, high: where it begins and ends [rad].
    """

    cam: SpatialCam
    wall: Wall
    piece: int
    low: float
    high: float

    def place(self, theta: Array) -> Place:
        """The roller at θ (n,), by the piece's own formula also at its ends."""
        piece = np.full(len(theta), self.piece)
        q, q1, q2 = (self.cam.motion.curve.at(theta, piece, order) for order in range(3))
        return Place(self.wall.seat.start + q, q1, q2)

    def contacts(self, theta: Array, rho: Array) -> Contacts:
        """Contacts at θ (n,) and ρ (m,)."""
        return self.cam.swept.contacts(self.place(theta), rho, self.wall.side)

    def curvatures(self, theta: Array, rho: Array) -> Array:
        """Principal curvatures there, (2, n, m) [1/mm]."""
        return self.cam.swept.curvatures(self.place(theta), rho, self.wall.side)


def patches(cam: SpatialCam) -> Iterator[Patch]:
    """All of a cam, by wall."""
    breaks = cam.motion.curve.breaks
    for wall in cam.walls:
        for start, end in wall.spans:
            for piece in range(cam.motion.curve.count):
                low, high = max(start, breaks[piece]), min(end, breaks[piece + 1])
                if high > low:
                    yield Patch(cam, wall, piece, float(low), float(high))
