"""Walls cut at the joints of the motion: on each patch every quantity is smooth."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import groupby
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from synthesis.geometry.swept_roller import Contacts, Place
from synthesis.numerics.piecewise import Array
from synthesis.spatial.cam import SpatialCam, Wall


class Touching(ABC):
    """Contacts by one or several pieces of the motion, at their ends by their own formulas too."""

    cam: SpatialCam

    @abstractmethod
    def place(self, theta: Array) -> Place:
        """The roller at θ (n,)."""

    @property
    @abstractmethod
    def side(self) -> int | Array:
        """Of the wall: one, or (n, 1) one for every angle."""

    def points(self, theta: Array, rho: Array) -> Array:
        """Where the roller touches, (3, n, m), in the machine's frame [mm].

        Args:
            theta: (n,) [rad]. rho: (m,), or (n, m) for every angle others [mm].
        """
        return self.cam.swept.touched(self.place(theta), rho, self.side)[0]

    def contacts(self, theta: Array, rho: Array) -> Contacts:
        """Contacts there."""
        return self.cam.swept.contacts(self.place(theta), rho, self.side)

    def curvatures(self, theta: Array, rho: Array) -> Array:
        """Principal curvatures there, (2, n, m) [1/mm]."""
        return self.cam.swept.curvatures(self.place(theta), rho, self.side)


@dataclass(frozen=True, eq=False)
class Patch(Touching):
    """A part of a wall on one piece of the motion.

    Attributes:
        piece: which; of several at once one for every angle. low, high: ends [rad].
    """

    cam: SpatialCam
    wall: Wall
    piece: int | NDArray[np.intp]
    low: float
    high: float

    def place(self, theta: Array) -> Place:
        return _placed(self.cam, self.wall.seat.start, np.full(len(theta), self.piece), theta)

    @property
    def side(self) -> int:
        return self.wall.side

    @property
    def rests(self) -> bool:
        """Whether the follower stands still on the whole of it; False of several pieces at once."""
        curve, piece = self.cam.motion.curve, np.asarray(self.piece)
        return bool(piece.ndim == 0 and not curve.poly[piece, 1:].any()
                    and not curve.waves[piece, :, 0].any())  # fmt: skip


@dataclass(frozen=True, eq=False)
class Spots(Touching):
    """Some patches, whosever they are, each with ``each`` angles of its own."""

    cam: SpatialCam
    parts: Sequence[Patch]
    each: int

    def place(self, theta: Array) -> Place:
        start, piece = zip(
            *((part.wall.seat.start, part.piece) for part in self.parts), strict=True
        )
        return _placed(
            self.cam, np.repeat(start, self.each), np.repeat(piece, self.each), theta
        )  # fmt: skip

    @property
    def side(self) -> Array:
        return np.repeat([part.wall.side for part in self.parts], self.each)[:, None]


def _placed(cam: SpatialCam, start: float | Array, piece: NDArray[np.intp], theta: Array) -> Place:
    q, q1, q2 = (cam.motion.curve.at(theta, piece, order) for order in range(3))
    return Place(start + q, q1, q2)


@dataclass(frozen=True, eq=False)
class Together(Patch):
    """All patches of a wall at once, at angles of their own: laws may have a hundred pieces.

    What contacts do there is kept for the next quantity.
    """

    kept: dict[tuple[str, bytes], Any] = field(default_factory=dict)

    def points(self, theta: Array, rho: Array) -> Array:
        known = self.kept.get(("contacts", rho.tobytes()))
        return super().points(theta, rho) if known is None else cast(Contacts, known).point

    def contacts(self, theta: Array, rho: Array) -> Contacts:
        key = "contacts", rho.tobytes()
        if key not in self.kept:
            self.kept[key] = super().contacts(theta, rho)
        return cast(Contacts, self.kept[key])

    def curvatures(self, theta: Array, rho: Array) -> Array:
        key = "curvatures", rho.tobytes()
        if key not in self.kept:
            self.kept[key] = super().curvatures(theta, rho)
        return cast(Array, self.kept[key])


@dataclass(frozen=True, eq=False)
class Tried:
    """Patches of one wall and the angles at which they are tried.

    Attributes:
        first: number of the first of them. together: all of them. theta: (patches, angles) [rad].
    """

    first: int
    together: Together
    theta: Array

    def apart(self, values: Array) -> Iterator[Array]:
        """Values (…, n, m) at all angles patch by patch: (…, angles, m) each."""
        count, each = self.theta.shape
        shape = (*values.shape[:-2], count, each, values.shape[-1])
        yield from np.moveaxis(values.reshape(shape), -3, 0)


def tried(parts: Sequence[Patch], angles: int, whole: int) -> Iterator[Tried]:
    """Every wall's patches in their order.

    Args:
        angles: of a patch, the most. whole: of a wall that has many patches, about.
    """
    first = 0
    for wall, group in groupby(parts, key=lambda patch: patch.wall):
        own = list(group)
        each = int(np.clip(whole // len(own), 1, angles))
        low, high = np.array([(p.low, p.high) for p in own]).T[:, :, None]
        share = np.linspace(0.0, 1.0, each) if each > 1 else np.array([0.5])
        theta = low + (high - low) * share
        piece = np.repeat([p.piece for p in own], each)
        together = Together(own[0].cam, wall, piece, own[0].low, own[-1].high)
        yield Tried(first, together, theta)
        first += len(own)


def patches(cam: SpatialCam) -> Iterator[Patch]:
    """All of a cam, by wall."""
    breaks = cam.motion.curve.breaks
    for wall in cam.walls:
        for start, end in wall.spans:
            for piece in range(cam.motion.curve.count):
                low, high = max(start, breaks[piece]), min(end, breaks[piece + 1])
                if high > low:
                    yield Patch(cam, wall, piece, float(low), float(high))
