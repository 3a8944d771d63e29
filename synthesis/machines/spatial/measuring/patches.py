"""Patches of walls, their contacts, and the search for an extremum over them by samples.

A patch is a part of a wall on one piece of the motion, where every quantity is smooth. All patches
of a wall are sampled in one vectorised call, as laws may have a hundred pieces. Around the best
samples ever finer grids follow. What the last of them gained, doubled, is the width of the result:
a measurement of how far the true extremum may be away, not a proof.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import groupby
from typing import Any

import numpy as np
from numpy.typing import NDArray

from synthesis.machines.spatial.cam import SpatialCam, Wall
from synthesis.machines.spatial.measuring.quantities import Extremum, rounded
from synthesis.numerics.geometry.swept_roller import Contacts, FollowerState
from synthesis.numerics.piecewise import Array


@dataclass(frozen=True, eq=False)
class Patch:
    """A part of a wall on one piece of the motion.

    Attributes:
        piece: number of the piece. low, high: ends [rad].
    """

    cam: SpatialCam
    wall: Wall
    piece: int
    low: float
    high: float

    @property
    def rests(self) -> bool:
        """Whether the follower dwells on the patch."""
        curve = self.cam.motion.curve
        return not (curve.poly[self.piece, 1:].any() or curve.waves[self.piece, :, 0].any())

    def at(self, theta: Array, rho: Array) -> WallPoints:
        """Contacts of the patch alone; arguments as in ``WallPoints``, with θ (n,)."""
        return WallPoints((self,), theta[None], rho)


@dataclass(frozen=True, eq=False)
class WallPoints:
    """Contacts of patches at sample angles, each by the formulas of its own piece of the motion.

    Attributes:
        patches: k of them, of any walls. theta: (k, n) cam angles of each [rad].
        rho: (m,) places on the roller's axis, or (k n, m) others at every angle [mm].
    """

    patches: Sequence[Patch]
    theta: Array
    rho: Array

    @property
    def cam(self) -> SpatialCam:
        """The cam."""
        return self.patches[0].cam

    @cached_property
    def state(self) -> FollowerState:
        """Position and derivatives of the rollers, (k n,) each."""
        theta, curve = self.theta.ravel(), self.cam.motion.curve
        piece = self._repeat([patch.piece for patch in self.patches])
        q, q1, q2 = (curve.at(theta, piece, order) for order in range(3))
        return FollowerState(self._repeat([p.wall.seat.start for p in self.patches]) + q, q1, q2)

    @property
    def side(self) -> NDArray[Any]:
        """(k n, 1) sides of the rollers."""
        return self._repeat([patch.wall.side for patch in self.patches])[:, None]

    def _repeat(self, values: Sequence[float]) -> NDArray[Any]:
        return np.repeat(values, self.theta.shape[1])

    @cached_property
    def contacts(self) -> Contacts:
        """The contacts, by (k n, m)."""
        return self.cam.swept.contacts(self.state, self.rho, self.side)

    @cached_property
    def curvatures(self) -> Array:
        """Principal curvatures of the walls there, (2, k n, m) [1/mm]."""
        return self.cam.swept.curvatures(self.state, self.rho, self.side)

    @cached_property
    def points(self) -> Array:
        """Contact points (3, k n, m) in the machine's frame [mm]."""
        if "contacts" in vars(self):
            return self.contacts.point
        return self.cam.swept.contact_points(self.state, self.rho, self.side)[0]

    def between_faces(self, values: Array, otherwise: float) -> Array:
        """Values (…, k n, m), replaced where the contact is beyond the end faces."""
        if np.all(np.isinf(self.cam.faces)):
            return values
        return np.where(self.cam.between_faces(self.points), values, otherwise)


def patches(cam: SpatialCam) -> Iterator[Patch]:
    """All patches of a cam, by wall."""
    breaks = cam.motion.curve.breaks
    for wall in cam.walls:
        for start, end in wall.spans:
            for piece in range(cam.motion.curve.count):
                low, high = max(start, breaks[piece]), min(end, breaks[piece + 1])
                if high > low:
                    yield Patch(cam, wall, piece, float(low), float(high))


def sample_walls(
    parts: Sequence[Patch], rho: Array, angles: int, whole: int
) -> Iterator[WallPoints]:
    """Sample points of every wall, all its patches together, in the order of the patches.

    Args:
        parts: the patches, by wall. rho: (m,) places on the roller's axis [mm].
        angles: at most on a patch. whole: about, on a wall with many patches.
    """
    for _, group in groupby(parts, key=lambda patch: patch.wall):
        own = list(group)
        each = int(np.clip(whole // len(own), 1, angles))
        low, high = np.array([(patch.low, patch.high) for patch in own]).T[:, :, None]
        share = np.linspace(0.0, 1.0, each) if each > 1 else np.array([0.5])
        yield WallPoints(own, low + (high - low) * share, rho)


@dataclass(frozen=True)
class Refinement:
    """How the best samples are refined.

    Attributes:
        kept: patches. points: in each direction around a sample. rounds: of ever finer grids.
        shrink: of the steps from round to round. evidence: how the extremum is known.
    """

    kept: int
    points: int
    rounds: int
    shrink: float
    evidence: str


@dataclass(frozen=True, eq=False)
class Sample:
    """The largest sampled value on a patch.

    Attributes:
        value: of the maximised function. patch: where.
        at: (d,) coordinates, the last two of them θ [rad] and ρ [mm]. step: (d,) between samples.
    """

    value: float
    patch: Patch
    at: Array
    step: Array


def best_samples(points: WallPoints, values: Array, *others: Array) -> Iterator[Sample]:
    """The best sample of every patch.

    Args:
        values: (…, k n, m) of the function that is maximised, at ``points``.
        others: evenly spaced coordinates of the axes of ``values`` before those of the points.
    """
    count, each = points.theta.shape
    split = values.reshape(*values.shape[:-2], count, each, values.shape[-1])
    for patch, theta, own in zip(
        points.patches, points.theta, np.moveaxis(split, -3, 0), strict=True
    ):
        where = np.unravel_index(int(np.argmax(own)), own.shape)
        axes = (*others, theta, points.rho)
        # One sample stands for the whole patch.
        steps = [(axis[-1] - axis[0]) / (len(axis) - 1) for axis in (*others, points.rho)]
        steps.insert(-1, (patch.high - patch.low) / max(each - 1, 1))
        at = [axis[i] for axis, i in zip(axes, where, strict=True)]
        yield Sample(float(own[where]), patch, np.array(at), np.array(steps))


def refine(
    values: Callable[[Sequence[Patch], Array], Array],
    samples: Iterable[Sample],
    rho: Array,
    how: Refinement,
    sign: float,
) -> Extremum:
    """Maximise a function around the best samples, all of them in one vectorised call a round.

    Args:
        values: from b patches and coordinates (b, d, g) to the function on their grids,
            (b, g, …, g).
        samples: of all patches. rho: (m,) sampled places, whose ends bound ρ [mm].
        sign: of the measured quantity in the function.
    """
    # The best patches; coordinates other than θ and ρ are not bounded.
    best = sorted(samples, key=lambda each: -rounded(each.value))[: how.kept]
    parts = [sample.patch for sample in best]
    at, step = (np.stack([getattr(each, name) for each in best]) for name in ("at", "step"))
    value = np.array([sample.value for sample in best])
    low, high = np.full_like(at, -np.inf), np.full_like(at, np.inf)
    low[:, -2:] = [(part.low, rho[0]) for part in parts]
    high[:, -2:] = [(part.high, rho[-1]) for part in parts]
    spots, share = np.arange(len(best)), np.linspace(-1.0, 1.0, how.points)
    for _ in range(how.rounds):
        # A grid around each best place yet, of steps that shrink from round to round.
        around = np.clip(at[..., None] + step[..., None] * share, low[..., None], high[..., None])
        grids = values(parts, around).reshape(len(best), -1)
        top = np.argmax(grids, axis=1)
        where = np.stack(np.unravel_index(top, (how.points,) * at.shape[1]), axis=1)
        before, better = value, grids[spots, top] > value
        value = np.where(better, grids[spots, top], value)
        moved = np.take_along_axis(around, where[..., None], axis=2)[..., 0]
        at, step = np.where(better[:, None], moved, at), how.shrink * step
    # The first of those that are equal but for rounding, and twice what its last round gained.
    first = max(range(len(best)), key=lambda i: rounded(float(value[i])))
    *_, theta, place = at[first].tolist()
    most = float(value[first])
    limit = most + 2.0 * (most - float(before[first]))
    return Extremum(sign * most, sign * limit, how.evidence, theta, parts[first].wall, place)
