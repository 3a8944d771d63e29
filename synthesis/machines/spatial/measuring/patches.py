"""Quantities and extrema; patches of walls, their contacts, and the search for an extremum on them.

A patch is a part of a wall on one piece of the motion, where every quantity is smooth. All patches
of a wall are sampled in one call. Around the best samples ever finer grids follow. What the last of
them gained, doubled, is the width of the result: measured, not proven.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import groupby
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from synthesis.machines.spatial.cam import SpatialCam, Wall
from synthesis.numerics.geometry.swept_roller import Contacts, FollowerState
from synthesis.numerics.piecewise import Array


class Bound(NamedTuple):
    """An allowed value in the unit on the wire, and the field of the spec that sets it."""

    value: float
    field: str = ""


Bounds = Mapping[str, Bound]


@dataclass(frozen=True)
class Quantity:
    """A quantity and which of its extremes is measured.

    Attributes:
        name, unit: on the wire. largest: whether its maximum is measured, otherwise its minimum.
        to_wire: from the core's value to the wire's. from_wire: the inverse.
        required: bound that every cam must keep, whatever the spec says.
    """

    name: str
    unit: str
    largest: bool
    to_wire: Callable[[float], float] = float
    from_wire: Callable[[float], float] = float
    required: Bound | None = None


@dataclass(frozen=True)
class Extremum:
    """An extreme value [core units].

    Attributes:
        value: infinite where there is none.
        limit: the true extreme does not lie beyond it, as far as the evidence goes.
        evidence: how that is known.
        theta, wall, rho: where: cam angle [rad], wall, and place on the roller's axis [mm].
    """

    value: float
    limit: float
    evidence: str
    theta: float | None = None
    wall: Wall | None = None
    rho: float | None = None


def rounded(value: float) -> float:
    """A value to twelve digits: of two that differ by rounding only, the first one is chosen."""
    return float(f"{value:.11e}")


@dataclass(frozen=True, eq=False)
class Patch:
    """A part of a wall, from ``low`` to ``high`` [rad], on one piece of the motion, a number."""

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
    """Contacts of k patches at cam angles (k, n), each by the formulas of its piece of the motion.

    ``rho`` are places (m,) on the roller's axis, or (k n, m) others at every angle [mm].
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
        piece = self.repeat([patch.piece for patch in self.patches])
        q, q1, q2 = (curve.at(theta, piece, order) for order in range(3))
        return FollowerState(self.repeat([p.wall.seat.start for p in self.patches]) + q, q1, q2)

    @property
    def side(self) -> NDArray[Any]:
        """(k n, 1) sides of the rollers."""
        return self.repeat([patch.wall.side for patch in self.patches])[:, None]

    def repeat(self, values: Sequence[float]) -> NDArray[Any]:
        """Values of the patches (k,) at all angles, (k n,)."""
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


@dataclass(frozen=True)
class Sampling:
    """How an extremum is sought.

    Attributes:
        angles: samples of a patch in cam angle at most. whole: about, of a wall with many patches.
        kept: patches whose best samples are refined. points: of a grid around such a sample, in
            each direction. iterations: of ever finer grids. shrink: of the steps in each.
        evidence: how the extremum is known.
    """

    angles: int
    whole: int
    kept: int
    points: int
    iterations: int
    shrink: float
    evidence: str

    def walls(self, parts: Sequence[Patch], rho: Array) -> Iterator[WallPoints]:
        """Sample points of every wall at places (m,), all its patches together, in their order."""
        for _, group in groupby(parts, key=lambda patch: patch.wall):
            own = list(group)
            each = int(np.clip(self.whole // len(own), 1, self.angles))
            low, high = np.array([(patch.low, patch.high) for patch in own]).T[:, :, None]
            share = np.linspace(0.0, 1.0, each) if each > 1 else np.array([0.5])
            yield WallPoints(own, low + (high - low) * share, rho)


def find_extremum(
    values: Callable[..., Array],
    walls: Iterable[WallPoints],
    how: Sampling,
    sign: float,
    *others: Array,
) -> Extremum:
    """Maximise a function over walls by samples, then on ever finer grids around the best of them.

    Args:
        values: of points and other coordinates, (j, 1) or (j, k n) each, to (…, k n, m).
        walls: sample points, at places (m,) on the roller's axis, whose ends bound ρ.
        sign: of the measured quantity in the function.
        others: evenly spaced values (j,) of the coordinates besides θ and ρ, which are not bounded.
    """

    def best(points: WallPoints, *others: Array) -> tuple[Array, NDArray[np.intp]]:
        """The largest value on each patch (k,), and its place on the axes (k, d)."""
        (count, each), every = points.theta.shape, values(points, *others)
        every = np.moveaxis(every.reshape(*every.shape[:-2], count, each, every.shape[-1]), -3, 0)
        top = every.reshape(count, -1).argmax(axis=1)
        where = np.unravel_index(top, every.shape[1:])
        return every[(np.arange(count), *where)], np.stack(where, axis=1)

    # 1. The best sample of every patch: value, coordinates (…, θ, ρ), and steps between samples.
    parts, rows = list[Patch](), list[Array]()
    for points in walls:
        count, each = points.theta.shape
        value, where = best(points, *(axis[:, None] for axis in others))
        axes = [np.broadcast_to(axis, (count, axis.shape[-1]))
                for axis in (*others, points.theta, points.rho)]  # fmt: skip
        coordinates = [axis[np.arange(count), i] for axis, i in zip(axes, where.T, strict=True)]
        steps = [(axis[:, -1] - axis[:, 0]) / max(axis.shape[1] - 1, 1) for axis in axes]
        if each == 1:  # one sample stands for the whole patch
            steps[-2] = np.array([patch.high - patch.low for patch in points.patches])
        parts += points.patches
        rows.append(np.column_stack([value, *coordinates, *steps]))
        ends = points.rho[0], points.rho[-1]
    table = np.concatenate(rows)
    kept = sorted(range(len(parts)), key=lambda i: -rounded(table[i, 0]))[: how.kept]
    parts, table = [parts[i] for i in kept], table[kept]
    value, (at, step) = table[:, 0], np.split(table[:, 1:], 2, axis=1)
    # 2. Around each of the best a grid, of steps that shrink with each iteration.
    low, high = np.full_like(at, -np.inf), np.full_like(at, np.inf)
    low[:, -2:] = [(part.low, ends[0]) for part in parts]
    high[:, -2:] = [(part.high, ends[1]) for part in parts]
    share = np.linspace(-1.0, 1.0, how.points)
    for _ in range(how.iterations):
        around = np.clip(at[..., None] + step[..., None] * share, low[..., None], high[..., None])
        *more, theta, rho = np.moveaxis(around, 1, 0)
        points = WallPoints(parts, theta, np.repeat(rho, how.points, axis=0))
        top, where = best(points, *(np.repeat(axis.T, how.points, axis=1) for axis in more))
        before, better = value, top > value
        value = np.where(better, top, value)
        moved = np.take_along_axis(around, where[..., None], axis=2)[..., 0]
        at, step = np.where(better[:, None], moved, at), how.shrink * step
    # 3. The first of those equal but for rounding, and twice what its last iteration gained.
    first = max(range(len(parts)), key=lambda i: rounded(float(value[i])))
    most, (*_, angle, place) = float(value[first]), at[first].tolist()
    limit = most + 2.0 * (most - float(before[first]))
    return Extremum(sign * most, sign * limit, how.evidence, angle, parts[first].wall, place)
