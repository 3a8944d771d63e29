"""Where every better cam lies: its sizes in a box, the points that draw its curves in hulls.

Bounded by duality over all laws under every row known: the linear ones, the best value, and those
that limits which are not convex imply inside what is known already.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from synthesis.formulations.bounds.spreading import Arcs
from synthesis.formulations.cone import cuts
from synthesis.formulations.cone.control import Control
from synthesis.formulations.cone.convex import Plan
from synthesis.formulations.cone.matrix import Ball
from synthesis.formulations.cone.rows import Block, Drawn
from synthesis.formulations.curved.hull import Hull
from synthesis.formulations.curved.planes import Planes
from synthesis.formulations.question.grid import Grid, SettledLaw
from synthesis.formulations.question.problem import Problem
from synthesis.motion import Stretch
from synthesis.numerics.piecewise import Array
from synthesis.terms import Moving, Seen, Traced, Vector

APART = 0.05  # of a law, between nodes of a hull
OPEN = 1e9  # strokes: nothing known
SPARE = 1e-9  # relative: sizes known this well are known
FAN, TURN = 24, 0.03  # tangents of a circle: most of them, and their step [rad]

Sizes = tuple[tuple[float, float], ...]
Parts = tuple[tuple[float, float], ...]


@dataclass(frozen=True, eq=False)
class Guess:
    """A cam about which rows shall be tight."""

    laws: tuple[SettledLaw, ...]
    size: Vector


@dataclass(frozen=True, eq=False)
class Lair:
    """What every better cam of a box of sizes keeps to.

    Attributes:
        hulls: by position of the free law and the point that is seen.
        planes: what all laws together leave of the size.
    """

    sizes: Sizes
    hulls: Mapping[tuple[int, Seen], Hull]
    planes: Planes
    guess: Guess | None = None

    @property
    def empty(self) -> bool:
        """Whether there is no such cam."""
        crossed = any(low > high for low, high in self.sizes)
        return crossed or any(hull.empty for hull in self.hulls.values())

    @property
    def divisible(self) -> bool:
        """Whether it has a size that is still open."""
        return any(high - low > SPARE * max(abs(low), abs(high)) for low, high in self.sizes)

    @property
    def width(self) -> float:
        """How far the hulls are open, on average [mm]."""
        return float(np.mean([hull.width for hull in self.hulls.values()] or [0.0]))

    def inside(self, sizes: Sizes) -> Lair:
        """The part of it in a box of sizes."""
        hulls = {
            key: replace(hull, offsets=key[1].offsets(sizes)) for key, hull in self.hulls.items()
        }
        return replace(self, sizes=sizes, hulls=hulls)

    def of(self, positions: Sequence[int]) -> Lair:
        """What it says of some laws, numbered anew."""
        hulls = {
            (number, seen): hull
            for number, position in enumerate(positions)
            for seen, hull in self.hulls_of(position)
        }
        guess = self.guess
        if guess is not None:
            guess = Guess(tuple(guess.laws[position] for position in positions), guess.size)
        return replace(self, hulls=hulls, guess=guess)

    def hulls_of(self, position: int) -> list[tuple[Seen, Hull]]:
        """Of one law, by the point that is seen."""
        return [(seen, hull) for (law, seen), hull in self.hulls.items() if law == position]

    def rows(self, plan: Plan, *, sparing: bool = False) -> list[Block]:
        """Rows that limits imply along the hulls: tight in the middle, and at the guess.

        ``sparing``: at the guess alone, where there is one: multipliers of two rows that say
        nearly the same at a knot alternate, and the bound pays for it.
        """
        return [
            block
            for (position, _), implied, hull in self._implying(plan.problem)
            for block in self._written(
                plan, position, implied, hull, _places(hull, plan, position), sparing=sparing
            )
        ]

    def between(self, plan: Plan, each: int, *, sparing: bool = False) -> list[tuple[Block, Arcs]]:
        """The same rows between the points where they are written, too.

        ``each``: points between two of these.
        """
        found = list[tuple[Block, Arcs]]()
        for (position, _), implied, hull in self._implying(plan.problem):
            arc = Arcs.of(_places(hull, plan, position), hull.parts, each)
            written = self._written(
                plan, position, implied, hull, arc.points, bare=True, sparing=sparing
            )
            found += [(block, arc) for block in written]
        return found

    def _implying(self, problem: Problem) -> Iterator[tuple[tuple[int, Seen], Traced, Hull]]:
        for position, stretch in enumerate(problem.free):
            for limit in problem.limits:
                for implied in limit.traced(stretch, problem.machine):
                    key = position, implied.seen
                    if key in self.hulls:
                        yield key, implied, self.hulls[key]

    def _written(
        self,
        plan: Plan,
        position: int,
        implied: Traced,
        hull: Hull,
        x: Array,
        *,
        bare: bool = False,
        sparing: bool = False,
    ) -> Iterator[Block]:
        stretch, grid = plan.problem.free[position], Grid(plan.grids[position].space, x)
        low, high = hull.at(x)
        near = self._about(position, stretch, implied.seen, x)
        for about in near if sparing and near else (None, *near):
            moving = self._moving(stretch, implied, hull, x, None if about is None else about[3:])
            found = implied.cuts(low, high, None if about is None else about[:3], moving)
            if found is not None:
                yield cuts.block(
                    found, implied.source, position, stretch, grid, plan.scales, Drawn(), bare=bare
                )

    def _about(self, position: int, stretch: Stretch, seen: Seen, x: Array) -> list[Array]:
        """X, u and e, s, s' and s'' of the guess: (6, n); nothing where there is none."""
        if self.guess is None:
            return []
        law = self.guess.laws[position].curve()
        s = [stretch.lift / stretch.angle**k * law(x, k) for k in range(3)]
        s[0] = stretch.s_start + s[0]
        return [np.stack([*seen.of(s, self.guess.size), *s])]

    def _moving(
        self, stretch: Stretch, implied: Traced, hull: Hull, x: Array, about: Array | None
    ) -> Moving | None:
        """What hulls say of the motion itself, to rows that ask for it."""
        if not implied.weighed:
            return None
        low, high = (
            np.stack([*ends, bend])
            for ends, bend in zip(
                implied.seen.moved(*hull.at(x), self.sizes), hull.bends(x), strict=True
            )
        )
        assert stretch.free is not None
        if not stretch.free.overshoot:
            least, most = sorted((stretch.s_start, stretch.s_end))
            low[0], high[0] = np.clip(low[0], least, most), np.clip(high[0], least, most)
        return Moving(stretch.start + stretch.angle * x, low, high, about)


def unknown(problem: Problem, steering: Sequence[Control], parts: Mapping[int, Parts]) -> Lair:
    """All that the problem allows; hulls with nodes all over the parts of the free laws."""
    sizes = problem.sizing.bounds
    hulls = {}
    for position, ranges in parts.items():
        stretch, cap = problem.free[position], steering[position].cap
        assert stretch.free is not None
        nodes = np.concatenate(
            [np.linspace(a, b, 1 + max(2, int(np.ceil((b - a) / APART)))) for a, b in ranges]
        )
        known = dict[Seen, int]()  # how many of X, u and s'' are asked for
        for limit in problem.limits:
            for implied in limit.traced(stretch, problem.machine):
                asked = 3 if implied.weighed else 2
                known[implied.seen] = max(asked, known.get(implied.seen, 0))
        for seen, rows in known.items():
            wide = np.full((rows, len(nodes)), OPEN * problem.length)
            sense = 0 if stretch.free.overshoot else int(np.sign(stretch.lift)) * seen.sign
            bend = abs(stretch.lift) / stretch.angle**3 * cap
            hulls[position, seen] = Hull(
                nodes, ranges, stretch.angle, bend, sense, -wide, wide, seen.offsets(sizes)
            )
    return Lair(sizes, hulls, Planes.none(len(sizes)))


def fan(plan: Plan, ball: Ball, sizes: Sizes) -> Iterator[Block]:
    """Tangents of a cone on the size, all round where sizes of the box may lie on it."""
    if ball.head is not None or ball.norm is None:
        return
    matrix = ball.matrix[:, plan.size]
    corners = np.stack(np.meshgrid(*(np.array(ends) for ends in sizes)), axis=-1)
    images = corners.reshape(-1, len(sizes)) / plan.scales.size @ matrix.T + ball.shift
    if images.shape[1] == 2:
        middle = np.mean(images, axis=0)
        main = np.arctan2(*middle)
        off = np.arctan2(*images.T) - main
        off = (off + np.pi) % (2.0 * np.pi) - np.pi
        steps = min(int(np.ceil(np.ptp(off) / TURN)) + 1, FAN)
        angles = main + np.linspace(np.min(off), np.max(off), steps)
        directions = np.stack([np.sin(angles), np.cos(angles)], axis=1)
    else:
        norms = np.linalg.norm(images, axis=1)
        directions = images[norms > 0.0] / norms[norms > 0.0, None]
    for y in directions:
        yield Block.of_size(y @ matrix, np.array([ball.radius - y @ ball.shift]), ball.source)


def _places(hull: Hull, plan: Plan, position: int) -> Array:
    """Where rows are written along a hull: at every knot, so that each has a say of its own."""
    breaks = plan.grids[position].space.breaks
    inside = [(low <= breaks) & (breaks <= high) for low, high in hull.parts]
    return np.asarray(breaks[np.any(inside, axis=0)])
