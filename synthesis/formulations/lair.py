"""Where every better cam lies: its sizes in a box, the points that draw its curves in hulls.

Bounded by duality over all laws under every row known: the linear ones, the best value, and those
that limits which are not convex imply inside what is known already.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf

import numpy as np

from synthesis.formulations import cuts
from synthesis.formulations.control import Control
from synthesis.formulations.convex import Plan, with_rows
from synthesis.formulations.floors import Wanted, floors, solved_prices
from synthesis.formulations.grid import Grid, SettledLaw
from synthesis.formulations.hull import Hull
from synthesis.formulations.matrix import Ball
from synthesis.formulations.problem import Problem
from synthesis.formulations.rows import Block, Drawn
from synthesis.formulations.spreading import Arcs, Spreading
from synthesis.motion import Stretch
from synthesis.numerics.piecewise import Array
from synthesis.solvers.highs import LinearRows, least
from synthesis.solvers.statuses import Stopped
from synthesis.terms import Seen, Traced, Vector

APART = 0.05  # of a law, between nodes of a hull
OPEN = 1e9  # strokes: nothing known
FAN, TURN = 24, 0.03  # tangents of a circle: most of them, and their step [rad]
SPREAD = 12  # points between two rows over which multipliers are spread
SPARE = 1e-9  # relative, by which bounds are loosened

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

    ``hulls``: by position of the free law and the point that is seen.
    """

    sizes: Sizes
    hulls: Mapping[tuple[int, Seen], Hull]
    guess: Guess | None = None

    @property
    def empty(self) -> bool:
        """Whether there is no such cam."""
        crossed = any(low > high for low, high in self.sizes)
        return crossed or any(hull.empty for hull in self.hulls.values())

    @property
    def width(self) -> float:
        """How far the hulls are open, on average [mm]."""
        return float(np.mean([hull.width for hull in self.hulls.values()]))

    def rows(self, plan: Plan, *, sparing: bool = False) -> list[Block]:
        """Rows that limits imply along the hulls: tight in the middle, and at the guess.

        ``sparing``: at the guess alone, where there is one: multipliers of two rows that say
        nearly the same at a knot alternate, and the bound pays for it.
        """
        return [
            block
            for (position, _), implied, hull in self._implying(plan.problem)
            for block in self._written(
                plan, position, implied, hull, _places(hull, plan, position), sparing
            )
        ]

    def spread(self, plan: Plan, each: int, *, sparing: bool = False) -> Spreading:
        """The same rows between the points where they are written, for a plan that ends in them.

        ``each``: points between two of these.
        """
        blocks, arcs = list[Block](), list[Arcs]()
        for (position, _), implied, hull in self._implying(plan.problem):
            arc = Arcs.of(_places(hull, plan, position), hull.parts, each)
            found = list(self._written(plan, position, implied, hull, arc.points, sparing))
            blocks += found
            arcs += [arc] * len(found)
        return Spreading.of(plan, blocks, arcs, each)

    def _implying(self, problem: Problem) -> Iterator[tuple[tuple[int, Seen], Traced, Hull]]:
        for position, stretch in enumerate(problem.free):
            for limit in problem.limits:
                for implied in limit.traced(stretch, problem.machine):
                    key = position, implied.seen
                    if key in self.hulls:
                        yield key, implied, self.hulls[key]

    def _written(
        self, plan: Plan, position: int, implied: Traced, hull: Hull, x: Array, sparing: bool
    ) -> Iterator[Block]:
        stretch, grid = plan.problem.free[position], Grid(plan.grids[position].space, x)
        low, high = hull.at(x)
        near = self._about(position, stretch, implied.seen, x)
        for about in near if sparing and near else (None, *near):
            found = implied.cuts(low, high, about)
            if found is not None:
                yield cuts.block(
                    found, implied.source, position, stretch, grid, plan.scales, Drawn()
                )

    def _about(self, position: int, stretch: Stretch, seen: Seen, x: Array) -> list[Array]:
        if self.guess is None:
            return []
        law = self.guess.laws[position].curve()
        s = stretch.s_start + stretch.lift * law(x)
        return [np.stack(seen.of((s, stretch.lift / stretch.angle * law(x, 1)), self.guess.size))]


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
        for limit in problem.limits:
            for implied in limit.traced(stretch, problem.machine):
                seen, wide = implied.seen, np.full((2, len(nodes)), OPEN * problem.length)
                sense = 0 if stretch.free.overshoot else int(np.sign(stretch.lift)) * seen.sign
                bend = abs(stretch.lift) / stretch.angle**3 * cap
                hulls[position, seen] = Hull(
                    nodes, ranges, stretch.angle, bend, sense, -wide, wide, seen.offsets(sizes)
                )
    return Lair(sizes, hulls)


def narrowed(
    plan: Plan, steering: Sequence[Control], lair: Lair, time_limit: float = inf
) -> Lair | None:
    """The lair, narrowed under the plan's rows and those that it implies itself.

    Args:
        plan: rows that every better cam keeps, and nothing asked for.
        steering: caps of the free laws' third derivatives.
        time_limit: seconds after which nothing more is bounded.

    Returns:
        None where the rows leave no spline of the plan's, which says nothing of other laws, and
        where time ended.
    """
    fans = [fan for ball in plan.balls for fan in _fan(plan, ball, lair.sizes)]
    full = with_rows(plan, [*fans, *lair.rows(plan)])
    wanted, constants, units = _wanted(full, lair)
    count = full.program.equalities + full.program.inequalities
    low, high = np.full((2, full.program.matrix.shape[1]), np.inf)
    low = -low
    low[full.size], high[full.size] = (np.array(lair.sizes) / full.scales.size).T
    rows = LinearRows(
        full.program.matrix[:count], full.program.rhs[:count], full.program.equalities, low, high
    )
    found = least(rows, wanted.costs(full), time_limit)
    if found[-1].stopped is not Stopped.SOLVED:
        return None
    z = np.stack([each.multipliers for each in found])
    between, ends = lair.spread(full, SPREAD), solved_prices(full, wanted, z)
    masses = between.multipliers(wanted, z, ends)
    values = floors(between.plan, steering, lair.sizes, wanted, masses, ends)
    values = (values - SPARE * np.maximum(np.abs(values), 1.0)) * units + constants
    return _taken(lair, values)


def _fan(plan: Plan, ball: Ball, sizes: Sizes) -> Iterator[Block]:
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
        yield Block(
            "size", None, None, np.zeros(1), np.zeros(4), y @ matrix, 0.0,
            np.array([ball.radius - y @ ball.shift]), ball.source,
        )  # fmt: skip


def _wanted(plan: Plan, lair: Lair) -> tuple[Wanted, Array, Array]:
    """Every size, X and u from below and from above, with what is constant in them, and units."""
    count, scale = len(lair.sizes), plan.scales.size
    law, x, alpha, size, constants = [], [], [], [], []
    for sign in (1.0, -1.0):
        for axis in range(count):
            law.append(0)
            x.append(0.0)
            alpha.append(np.zeros(3))
            size.append(sign * scale * np.eye(count)[axis])
            constants.append(0.0)
        for (position, seen), hull in lair.hulls.items():
            stretch = plan.problem.free[position]
            for order in (0, 1):
                factor = sign * seen.sign * stretch.lift / stretch.angle**order
                known = seen.constants[order] + (seen.sign * stretch.s_start if order == 0 else 0.0)
                for node in hull.nodes:
                    law.append(position)
                    x.append(float(node))
                    alpha.append(factor * np.eye(3)[order])
                    size.append(sign * scale * np.array(seen.by[order]))
                    constants.append(sign * known)
    units = np.maximum(np.abs(np.array(alpha)).max(axis=1), np.abs(np.array(size)).max(axis=1))
    wanted = Wanted(
        np.array(law),
        np.array(x),
        np.array(alpha) / units[:, None],
        np.array(size) / units[:, None],
    )
    return wanted, np.array(constants), units


def _taken(lair: Lair, values: Array) -> Lair:
    """The lair with bounds in the order of ``_wanted``, where they are narrower."""
    below, above = values.reshape(2, -1)
    above, count = -above, len(lair.sizes)
    sizes = tuple(
        (max(low, float(a)), min(high, float(b)))
        for (low, high), a, b in zip(lair.sizes, below[:count], above[:count], strict=True)
    )
    hulls, at = {}, count
    for key, hull in lair.hulls.items():
        shape, stop = hull.low.shape, at + hull.low.size
        low = np.maximum(hull.low, below[at:stop].reshape(shape))
        high = np.minimum(hull.high, above[at:stop].reshape(shape))
        hulls[key] = replace(hull, low=low, high=high, offsets=key[1].offsets(sizes))
        at = stop
    return replace(lair, sizes=sizes, hulls=hulls)


def _places(hull: Hull, plan: Plan, position: int) -> Array:
    """Where rows are written along a hull: at every knot, so that each has a say of its own."""
    breaks = plan.grids[position].space.breaks
    inside = [(low <= breaks) & (breaks <= high) for low, high in hull.parts]
    return np.asarray(breaks[np.any(inside, axis=0)])
