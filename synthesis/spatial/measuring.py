"""What a finished spatial cam does: extremes over all walls, cam angles and places on the rollers.

Every quantity is a function of θ and ρ on each wall. It is tried on a grid of every smooth piece of
the motion, and from the best places on between neighbours, ever closer.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import pi

import numpy as np

from synthesis.geometry.swept_roller import Contacts, Place
from synthesis.numerics.piecewise import Array
from synthesis.spatial.cam import SpatialCam, Wall
from synthesis.spatial.design import SpatialExtreme
from synthesis.units import DEGREE

ANGLES, PLACES = 65, 9  # tried on each piece of a wall
CLOSER, ROUNDS, KEPT = 7, 24, 3  # a grid around each of the best, a third as wide every time
EVIDENCE = "tried on a grid of each wall, then between its points"


@dataclass(frozen=True)
class Measured:
    """A quantity that every contact has.

    Attributes:
        name, unit: on the wire. per_unit: the core's in one of them.
        of: its values (n, m) from contacts. largest: whether its largest is looked for.
        least: what it may not fall to; None: it is told and no more.
    """

    name: str
    unit: str
    per_unit: float
    of: Callable[[Contacts], Array]
    largest: bool
    least: float | None = None


QUANTITIES = (
    Measured("pressure_angle", "deg", DEGREE, lambda c: c.pressure_angle, largest=True),
    Measured("undercut", "1", 1.0, lambda c: c.regular, largest=False, least=0.0),
)


@dataclass(frozen=True, eq=False)
class _Patch:
    """A smooth piece of a wall."""

    cam: SpatialCam
    wall: Wall
    piece: int
    low: float
    high: float

    def contacts(self, theta: Array, rho: Array) -> Contacts:
        """At θ (n,) of the piece, by its own formula also at its ends, and ρ (m,)."""
        piece = np.full(len(theta), self.piece)
        q, q1, q2 = (self.cam.motion.curve.at(theta, piece, order) for order in range(3))
        place = Place(self.wall.seat.start + q, q1, q2)
        return self.cam.swept.contacts(place, rho, self.wall.side)


def _patches(cam: SpatialCam) -> Iterator[_Patch]:
    breaks = cam.motion.curve.breaks
    for wall in cam.walls:
        for start, end in wall.spans:
            for piece in range(cam.motion.curve.count):
                low, high = max(start, breaks[piece]), min(end, breaks[piece + 1])
                if high > low:
                    yield _Patch(cam, wall, piece, low, high)


def measured(cam: SpatialCam) -> list[SpatialExtreme]:
    """Every quantity's extreme."""
    patches = list(_patches(cam))
    roller = cam.swept.roller
    rho = np.linspace(roller.inner, roller.outer, PLACES)
    grids = [np.linspace(patch.low, patch.high, ANGLES) for patch in patches]
    tried = [p.contacts(theta, rho) for p, theta in zip(patches, grids, strict=True)]
    return [_extreme(each, patches, grids, rho, [each.of(found) for found in tried])
            for each in QUANTITIES]  # fmt: skip


def _extreme(
    quantity: Measured, patches: list[_Patch], grids: list[Array], rho: Array, values: list[Array]
) -> SpatialExtreme:
    sign = 1.0 if quantity.largest else -1.0
    best = sorted(range(len(patches)), key=lambda i: -float((sign * values[i]).max()))[:KEPT]
    found = []
    for i in best:
        n, m = np.unravel_index(int(np.argmax(sign * values[i])), values[i].shape)
        found.append((_closer(quantity, sign, patches[i], grids[i][n], rho[m], rho), i))
    (value, theta, place, step), i = max(found, key=lambda each: each[0][0])
    wall = patches[i].wall
    told = sign * value / quantity.per_unit
    bound = quantity.least
    margin = None if bound is None else told - bound
    width = step / quantity.per_unit
    return SpatialExtreme(
        quantity=quantity.name, value=told, unit=quantity.unit, angle_deg=theta * 180.0 / pi,
        roller=wall.seat.number, side=wall.letter, rho_mm=place, bound=bound, margin=margin,
        width=width, holds=margin is None or margin > width, evidence=EVIDENCE, field="",
    )  # fmt: skip


def _closer(
    quantity: Measured, sign: float, patch: _Patch, theta: float, place: float, rho: Array
) -> tuple[float, float, float, float]:
    """The best value near a place, where it is, and by how much the last round bettered it."""
    half = (patch.high - patch.low) / (ANGLES - 1), (rho[-1] - rho[0]) / (PLACES - 1)
    value, gained = -np.inf, np.inf
    for _ in range(ROUNDS):
        around = np.linspace(max(theta - half[0], patch.low), min(theta + half[0], patch.high),
                             CLOSER)  # fmt: skip
        along = np.linspace(max(place - half[1], rho[0]), min(place + half[1], rho[-1]), CLOSER)
        values = sign * quantity.of(patch.contacts(around, along))
        n, m = np.unravel_index(int(np.argmax(values)), values.shape)
        gained, value = float(values[n, m]) - value, float(values[n, m])
        theta, place = float(around[n]), float(along[m])
        half = half[0] / 3.0 * 1.5, half[1] / 3.0 * 1.5
    return value, theta, place, abs(gained)
