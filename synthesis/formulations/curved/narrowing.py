"""A lair made narrower, law by law.

A law's hull follows from its own rows, its neighbours' at joints, and from what all laws together
leave of the size. So each law first says how far the size may lie in directions all round; the
half-spaces that follow are shared, and with them each law bounds its own hull. Time and memory grow
with the number of laws, not with its square.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from math import inf

import numpy as np

from synthesis import clock
from synthesis.formulations.bounds.floors import Wanted, floors, solved_prices
from synthesis.formulations.bounds.spreading import Arcs, Spreading
from synthesis.formulations.cone.control import Control
from synthesis.formulations.cone.convex import Plan, with_rows
from synthesis.formulations.cone.pieces import Whole
from synthesis.formulations.cone.rows import Block
from synthesis.formulations.curved.lair import Lair, Sizes, fan
from synthesis.formulations.curved.planes import Planes, all_round
from synthesis.numerics.piecewise import Array
from synthesis.solvers.highs import LinearRows, least
from synthesis.solvers.statuses import Stopped

SPREAD = 12  # points between two rows over which multipliers are spread
SPARE = 1e-9  # relative, by which bounds are loosened


def narrowed(
    plan: Plan,
    steering: Sequence[Control],
    lair: Lair,
    among: Collection[int],
    time_limit: float = inf,
) -> tuple[Lair, frozenset[int]]:
    """The lair, narrowed under the plan's rows and those that it implies itself.

    Args:
        plan: rows that every better cam keeps, and nothing asked for.
        steering: caps of the free laws' third derivatives.
        among: positions of the laws that are asked.
        time_limit: seconds after which nothing more is bounded.

    Returns:
        the lair, and the laws whose rows leave no spline of the plan's, which says nothing of
        other laws; all that are left where time ended.
    """
    until = clock.now() + time_limit
    lair = replace(lair, sizes=_inside(plan, lair.sizes))
    fans = [block for ball in plan.balls for block in fan(plan, ball, lair.sizes)]
    whole, stuck, said = Whole(plan), set[int](), list[Planes]()
    pieces = {k: _Piece.of(whole, k, steering, fans, lair) for k in among}
    directions = all_round(lair.sizes)
    for k, piece in pieces.items() if len(directions) else ():
        values = piece.floors(_sizes(directions, plan.scales.size), lair, until)
        if values is None:
            stuck.add(k)
        else:
            said.append(Planes(directions, values))
    lair = _shared(lair, directions, said) if said else lair
    for k in sorted({position for position, _ in lair.hulls} & set(among) - stuck):
        if lair.empty:
            break
        piece = pieces[k]
        asked, constants = _motion(lair, k, piece.law, piece.plan)
        values = piece.floors(asked, lair, until)
        if values is None:
            stuck.add(k)
        else:
            lair = _taken(lair, k, values + constants)
    return lair, frozenset(stuck)


@dataclass(frozen=True, eq=False)
class _Asked:
    """Quantities, each over its unit, and these units."""

    wanted: Wanted
    units: Array

    @classmethod
    def of(cls, law: int, x: Array, alpha: Array, size: Array) -> _Asked:
        """alpha · (g, g', g'') (x) + size · ζ of one law: (q,), (q, 3) and (q, n_size)."""
        units = np.maximum(np.abs(alpha).max(axis=1), np.abs(size).max(axis=1))
        laws = np.full(len(x), law)
        return cls(Wanted(laws, x, alpha / units[:, None], size / units[:, None]), units)


@dataclass(frozen=True, eq=False)
class _Piece:
    """A law and what it meets at joints.

    Attributes:
        plan: their rows, and those of the size alone. positions: in the whole plan.
        law: number of the one that is asked. steering: of all of them.
        implied, denser: rows of curvature at their points, and between these.
    """

    plan: Plan
    positions: tuple[int, ...]
    law: int
    steering: tuple[Control, ...]
    implied: list[Block]
    denser: list[tuple[Block, Arcs]]

    @classmethod
    def of(
        cls,
        whole: Whole,
        position: int,
        steering: Sequence[Control],
        more: Sequence[Block],
        lair: Lair,
    ) -> _Piece:
        """Of a plan, with more rows of the size, and those that a lair implies."""
        positions = whole.beside(position)
        part, own = with_rows(whole.part(positions), more), lair.of(positions)
        caps = tuple(steering[k] for k in positions)
        law = positions.index(position)
        return cls(part, positions, law, caps, own.rows(part), own.between(part, SPREAD))

    def floors(self, asked: _Asked, lair: Lair, until: float) -> Array | None:
        """Lower bounds of quantities (q,) where better cams lie; None where there is no spline."""
        unit = self.plan.scales.size
        full = with_rows(self.plan, [*lair.planes.blocks(unit), *self.implied])
        count = full.program.equalities + full.program.inequalities
        low, high = np.full((2, full.program.matrix.shape[1]), inf)
        low = -low
        low[full.size], high[full.size] = (np.array(lair.sizes) / unit).T
        program = full.program
        rows = LinearRows(
            program.matrix[:count], program.rhs[:count], program.equalities, low, high
        )
        found = least(rows, asked.wanted.costs(full), until - clock.now())
        if found[-1].stopped is not Stopped.SOLVED:
            return None
        z = np.stack([each.multipliers for each in found])
        between = Spreading.of(full, self.denser, SPREAD)
        ends = solved_prices(full, asked.wanted, z)
        masses = between.multipliers(asked.wanted, z, ends)
        values = floors(between.plan, self.steering, lair.sizes, asked.wanted, masses, ends)
        return np.asarray((values - SPARE * np.maximum(np.abs(values), 1.0)) * asked.units)


def _inside(plan: Plan, sizes: Sizes) -> Sizes:
    """The box within the cones on the size."""
    found = np.array(sizes, dtype=float)
    for ball in plan.balls:
        if ball.head is not None or ball.norm is None or len(ball.shift) != len(sizes):
            continue
        matrix = ball.matrix[:, plan.size]
        if abs(np.linalg.det(matrix)) < SPARE:
            continue
        inverse = np.linalg.inv(matrix)
        centre = -inverse @ ball.shift
        reach = (1.0 + SPARE) * ball.radius * np.linalg.norm(inverse, axis=1)
        ends = plan.scales.size * np.stack([centre - reach, centre + reach], axis=1)
        found = np.stack(
            [np.maximum(found[:, 0], ends[:, 0]), np.minimum(found[:, 1], ends[:, 1])], axis=1
        )
    return tuple((float(low), float(high)) for low, high in found)


def _sizes(directions: Array, unit: float) -> _Asked:
    """How far the size lies in directions."""
    count = len(directions)
    return _Asked.of(0, np.zeros(count), np.zeros((count, 3)), unit * directions)


def _shared(lair: Lair, directions: Array, said: Sequence[Planes]) -> Lair:
    """The lair with what its laws say of the size together."""
    every, axes = lair.planes.joined(said), np.eye(len(lair.sizes))
    low, high = every.least(np.concatenate([axes, -axes]), lair.sizes).reshape(2, -1)
    sizes = tuple(
        (max(ends[0], float(a)), min(ends[1], -float(b)))
        for ends, a, b in zip(lair.sizes, low, high, strict=True)
    )
    planes = Planes(directions, every.least(directions, lair.sizes))
    return replace(lair.inside(sizes), planes=planes)


def _motion(lair: Lair, position: int, law: int, plan: Plan) -> tuple[_Asked, Array]:
    """X, u and perhaps s'' of a law's hulls from below, then from above, and their constants.

    ``law``: its number in the plan.
    """
    stretch, scale = plan.problem.free[law], plan.scales.size
    x, alpha, size, constants = list[Array](), list[Array](), list[Array](), list[Array]()
    for sign in (1.0, -1.0):
        for seen, hull in lair.hulls_of(position):
            one = np.ones((len(hull.nodes), 1))
            for order in (0, 1):
                factor = sign * seen.sign * stretch.lift / stretch.angle**order
                known = seen.constants[order] + (seen.sign * stretch.s_start if order == 0 else 0.0)
                x.append(hull.nodes)
                alpha.append(one * (factor * np.eye(3)[order]))
                size.append(one * (sign * scale * np.array(seen.by[order])))
                constants.append(one[:, 0] * sign * known)
            for order in range(2, len(hull.low)):
                x.append(hull.nodes)
                alpha.append(one * (sign * stretch.lift / stretch.angle**order * np.eye(3)[order]))
                size.append(np.zeros((len(one), len(lair.sizes))))
                constants.append(np.zeros(len(one)))
    asked = _Asked.of(law, np.concatenate(x), np.concatenate(alpha), np.concatenate(size))
    return asked, np.concatenate(constants)


def _taken(lair: Lair, position: int, values: Array) -> Lair:
    """The lair with bounds in the order of ``_motion``, where they are narrower."""
    below, above = values.reshape(2, -1)
    hulls, at = dict(lair.hulls), 0
    for seen, hull in lair.hulls_of(position):
        shape, stop = hull.low.shape, at + hull.low.size
        low = np.maximum(hull.low, below[at:stop].reshape(shape))
        high = np.minimum(hull.high, -above[at:stop].reshape(shape))
        hulls[position, seen] = replace(hull, low=low, high=high)
        at = stop
    return replace(lair, hulls=hulls)
