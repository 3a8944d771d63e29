"""Patches: parts of walls on one piece of the motion each, where every quantity is smooth."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import groupby
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from synthesis.machines.spatial.cam import SpatialCam, Wall
from synthesis.numerics.geometry.swept_roller import Contacts, FollowerState
from synthesis.numerics.piecewise import Array


class ContactPlaces(ABC):
    """Contacts of one or several patches, at their ends by the formulas of their own pieces."""

    cam: SpatialCam

    @abstractmethod
    def place(self, theta: Array) -> FollowerState:
        """Position of the roller at θ (n,)."""

    @property
    @abstractmethod
    def side(self) -> int | Array:
        """Side of the roller: one, or (n, 1), one for every angle."""

    def points(self, theta: Array, rho: Array) -> Array:
        """Contact points (3, n, m) in the machine's frame [mm].

        Args:
            theta: (n,) [rad]. rho: (m,), or (n, m) with other places at every angle [mm].
        """
        return self.cam.swept.contact_points(self.place(theta), rho, self.side)[0]

    def contacts(self, theta: Array, rho: Array) -> Contacts:
        """Contacts at the same places."""
        return self.cam.swept.contacts(self.place(theta), rho, self.side)

    def curvatures(self, theta: Array, rho: Array) -> Array:
        """Principal curvatures at the same places, (2, n, m) [1/mm]."""
        return self.cam.swept.curvatures(self.place(theta), rho, self.side)


@dataclass(frozen=True, eq=False)
class Patch(ContactPlaces):
    """A part of a wall on one piece of the motion.

    Attributes:
        piece: number of the piece, or one for every angle. low, high: ends [rad].
    """

    cam: SpatialCam
    wall: Wall
    piece: int | NDArray[np.intp]
    low: float
    high: float

    def place(self, theta: Array) -> FollowerState:
        return _placed(self.cam, self.wall.seat.start, np.full(len(theta), self.piece), theta)

    @property
    def side(self) -> int:
        return self.wall.side

    @property
    def rests(self) -> bool:
        """Whether the follower dwells on the whole patch; False for several pieces at once."""
        curve, piece = self.cam.motion.curve, np.asarray(self.piece)
        return bool(piece.ndim == 0 and not curve.poly[piece, 1:].any()
                    and not curve.waves[piece, :, 0].any())  # fmt: skip


@dataclass(frozen=True, eq=False)
class PatchSet(ContactPlaces):
    """Patches of any walls, each with ``each`` angles of its own."""

    cam: SpatialCam
    parts: Sequence[Patch]
    each: int

    def place(self, theta: Array) -> FollowerState:
        start, piece = zip(
            *((part.wall.seat.start, part.piece) for part in self.parts), strict=True
        )
        return _placed(
            self.cam, np.repeat(start, self.each), np.repeat(piece, self.each), theta
        )  # fmt: skip

    @property
    def side(self) -> Array:
        return np.repeat([part.wall.side for part in self.parts], self.each)[:, None]


def _placed(
    cam: SpatialCam, start: float | Array, piece: NDArray[np.intp], theta: Array
) -> FollowerState:
    q, q1, q2 = (cam.motion.curve.at(theta, piece, order) for order in range(3))
    return FollowerState(start + q, q1, q2)


@dataclass(frozen=True, eq=False)
class WholeWall(Patch):
    """All patches of a wall at once, vectorised: laws may have a hundred pieces.

    Contacts and curvatures are cached, as several quantities are sampled at the same places.
    """

    cache: dict[tuple[str, bytes], Any] = field(default_factory=dict)

    def points(self, theta: Array, rho: Array) -> Array:
        known = self.cache.get(("contacts", rho.tobytes()))
        return super().points(theta, rho) if known is None else cast(Contacts, known).point

    def contacts(self, theta: Array, rho: Array) -> Contacts:
        key = "contacts", rho.tobytes()
        if key not in self.cache:
            self.cache[key] = super().contacts(theta, rho)
        return cast(Contacts, self.cache[key])

    def curvatures(self, theta: Array, rho: Array) -> Array:
        key = "curvatures", rho.tobytes()
        if key not in self.cache:
            self.cache[key] = super().curvatures(theta, rho)
        return cast(Array, self.cache[key])


@dataclass(frozen=True, eq=False)
class WallSamples:
    """Sample angles on the patches of one wall.

    Attributes:
        first: number of the first patch. together: all patches. theta: (patches, angles) [rad].
    """

    first: int
    together: WholeWall
    theta: Array

    def by_patch(self, values: Array) -> Iterator[Array]:
        """Values (…, n, m) at all angles, split by patch: (…, angles, m) each."""
        count, each = self.theta.shape
        shape = (*values.shape[:-2], count, each, values.shape[-1])
        yield from np.moveaxis(values.reshape(shape), -3, 0)


def sample_walls(parts: Sequence[Patch], angles: int, whole: int) -> Iterator[WallSamples]:
    """Sample angles, wall by wall, in the order of the patches.

    Args:
        parts: the patches, by wall. angles: at most on a patch.
        whole: about, on a wall with many patches.
    """
    first = 0
    for wall, group in groupby(parts, key=lambda patch: patch.wall):
        own = list(group)
        each = int(np.clip(whole // len(own), 1, angles))
        low, high = np.array([(p.low, p.high) for p in own]).T[:, :, None]
        share = np.linspace(0.0, 1.0, each) if each > 1 else np.array([0.5])
        theta = low + (high - low) * share
        piece = np.repeat([p.piece for p in own], each)
        together = WholeWall(own[0].cam, wall, piece, own[0].low, own[-1].high)
        yield WallSamples(first, together, theta)
        first += len(own)


def patches(cam: SpatialCam) -> Iterator[Patch]:
    """All patches of a cam, by wall."""
    breaks = cam.motion.curve.breaks
    for wall in cam.walls:
        for start, end in wall.spans:
            for piece in range(cam.motion.curve.count):
                low, high = max(start, breaks[piece]), min(end, breaks[piece + 1])
                if high > low:
                    yield Patch(cam, wall, piece, float(low), float(high))
