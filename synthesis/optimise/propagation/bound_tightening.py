"""Optimality-based bound tightening of an improving region, law by law.

1. For every law: bounds of the size in directions all round, each the dual bound of a linear
   program over that law, the laws coupled to it, and the size (a relaxation of the whole problem).
2. The half-spaces so found hold for the size of every better cam: they are intersected and shared.
3. For every law: bounds of the traced point and of s'' at nodes, from below and from above, by the
   same dual bounds with the shared half-spaces.

A dual bound holds over all laws, so that no better cam is removed. Time and memory grow with the
number of laws, not with its square.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from math import inf

import numpy as np

from synthesis.numerics import clock
from synthesis.numerics.piecewise import Array
from synthesis.optimise.conic.control import Control
from synthesis.optimise.conic.linear_rows import LinearBlock
from synthesis.optimise.conic.program import ConicModel, with_rows
from synthesis.optimise.conic.subprogram import coupled_laws, submodel, without_size_rows
from synthesis.optimise.dual_bound.batch import Quantities
from synthesis.optimise.dual_bound.multiplier_density import PointRuns
from synthesis.optimise.propagation.half_spaces import HalfSpaces, cone_tangents, directions_around
from synthesis.optimise.propagation.improving_region import ImprovingRegion
from synthesis.optimise.propagation.quantity_bounds import (
    SPREAD,
    box_within_cones,
    caps_mean_square,
    lower_bounds,
)

SLIGHT = 0.05  # of the width of known bounds: what one of them must gain to be sought again


def tighten_bounds(
    model: ConicModel,
    controls: Sequence[Control],
    region: ImprovingRegion,
    positions: Collection[int],
    time_limit: float = inf,
    last_program: float = inf,
    *,
    laws: bool = True,
) -> tuple[ImprovingRegion, frozenset[int]]:
    """The region, tightened under the model's rows and those that the region implies.

    Args:
        model: rows that every better cam satisfies, without an objective.
        controls: caps of the free laws' controls, of one order.
        positions: positions of the laws to be bounded.
        time_limit: seconds after which nothing more is bounded.
        last_program: ``clock.programs_solved()`` at which the same holds of cone programs.

    Returns:
        the region, and the laws for which the mesh has no spline under the rows, so that nothing
        was bounded; where time ended, all laws that were left.
    """
    until = clock.now() + time_limit
    region = replace(region, sizes=box_within_cones(model, region.sizes))
    tangents = [
        block for cone in model.cone_blocks for block in cone_tangents(model, cone, region.sizes)
    ]
    infeasible, half_spaces = set[int](), list[HalfSpaces]()
    parts = {
        k: _LawSubproblem.of(model, k, controls, tangents, region, last_program) for k in positions
    }
    # 1. How far the size of a better cam lies in directions all round, by every law.
    directions = directions_around(region.sizes)
    count = len(directions)
    sizes = Quantities(
        np.zeros(count, dtype=int), np.zeros(count), np.zeros((count, 3)),
        model.scales.size * directions,
    )  # fmt: skip
    for k, part in parts.items() if count else ():
        values = part.lower_bounds(sizes, region, until)
        if values is None:
            infeasible.add(k)
        else:
            half_spaces.append(HalfSpaces(directions, values))
    # 2. The half-spaces of all laws hold together.
    if half_spaces:
        region = _intersect_half_spaces(region, directions, half_spaces)
    # 3. The traced point at the nodes of every law.
    for k in sorted({k for k, _ in region.point_bounds} & set(positions) - infeasible):
        if region.is_empty or not laws:
            break
        quantities, constants = _point_quantities(region, k, parts[k].law, parts[k].model)
        enough = _not_worth_raising(region, k) - constants
        values = parts[k].lower_bounds(quantities, region, until, enough, size_is_bounded=True)
        if values is None:
            infeasible.add(k)
        else:
            region = _tighten_point_bounds(region, k, values + constants)
    return region, frozenset(infeasible)


@dataclass(frozen=True, eq=False)
class _LawSubproblem:
    """A law and those that share derivatives with it.

    Attributes:
        model: their rows, and those of the size alone.
        law: number of the law to be bounded. controls: of all of them.
        implied, denser: rows of curvature at their points, and between these.
        last_program: ``clock.programs_solved()`` at which no more cone programs are begun.
    """

    model: ConicModel
    law: int
    controls: tuple[Control, ...]
    implied: list[LinearBlock]
    denser: list[tuple[LinearBlock, PointRuns | None]]
    last_program: float

    @classmethod
    def of(
        cls,
        whole: ConicModel,
        position: int,
        controls: Sequence[Control],
        more: Sequence[LinearBlock],
        region: ImprovingRegion,
        last_program: float,
    ) -> _LawSubproblem:
        """Of a model, with more rows of the size, and those that a region implies."""
        positions = coupled_laws(whole, position)
        part, own = with_rows(submodel(whole, positions), more), region.for_laws(positions)
        caps = tuple(controls[k] for k in positions)
        law = positions.index(position)
        rows = own.rows(part, SPREAD)
        implied, denser = [x for x, _, _ in rows], [(y, runs) for _, y, runs in rows]
        return cls(part, law, caps, implied, denser, last_program)

    def lower_bounds(
        self, quantities: Quantities, region: ImprovingRegion, until: float,
        enough: Array | None = None, *, size_is_bounded: bool = False,
    ) -> Array | None:  # fmt: skip
        """Lower bounds of quantities (q,) where better cams lie; None where there is no spline.

        ``enough``: (q,) values that bounds need not exceed. ``size_is_bounded``: whether the
        region's half-spaces tell what the rows of the size do.
        """
        rows = [*region.half_spaces.blocks(self.model.scales.size), *self.implied]
        # every row costs a cone program as much, whether it binds or not
        spared = size_is_bounded and caps_mean_square(self.model)
        model = without_size_rows(self.model) if spared else self.model
        return lower_bounds(
            model, rows, self.denser, self.controls, region.sizes, quantities, until,
            self.last_program, enough,
        )  # fmt: skip


def _intersect_half_spaces(
    region: ImprovingRegion, directions: Array, half_spaces: Sequence[HalfSpaces]
) -> ImprovingRegion:
    """The region with the half-spaces of all its laws intersected."""
    every, axes = region.half_spaces.intersect(half_spaces), np.eye(len(region.sizes))
    low, high = every.minimise(np.concatenate([axes, -axes]), region.sizes).reshape(2, -1)
    sizes = tuple(
        (max(ends[0], float(a)), min(ends[1], -float(b)))
        for ends, a, b in zip(region.sizes, low, high, strict=True)
    )
    planes = HalfSpaces(directions, every.minimise(directions, region.sizes))
    return replace(region.restrict(sizes), half_spaces=planes)


def _point_quantities(
    region: ImprovingRegion, position: int, law: int, model: ConicModel
) -> tuple[Quantities, Array]:
    """X, u and perhaps s'' of a law at its nodes from below, then from above, and their constants.

    ``law``: its number in the model.
    """
    segment, scale = model.problem.free[law], model.scales.size
    x, alpha, size, constants = list[Array](), list[Array](), list[Array](), list[Array]()
    for sign in (1.0, -1.0):
        for coordinates, bounds in region.bounds_of_law(position):
            one = np.ones((len(bounds.nodes), 1))
            for order in range(len(bounds.low)):
                # X and u are sums of motion and size; s'' is the motion's alone.
                seen, known, share = 1.0, 0.0, np.zeros(len(region.sizes))
                if order < 2:
                    seen, known = coordinates.sign, coordinates.constants[order]
                    share = scale * np.array(coordinates.size_factors[order])
                if order == 0:
                    known += seen * segment.s_start
                factor = seen * segment.lift / segment.angle**order
                x.append(bounds.nodes)
                alpha.append(one * (sign * factor * np.eye(3)[order]))
                size.append(one * (sign * share))
                constants.append(one[:, 0] * sign * known)
    places = np.concatenate(x)
    laws = np.full(len(places), law)
    quantities = Quantities(laws, places, np.concatenate(alpha), np.concatenate(size))
    return quantities, np.concatenate(constants)


def _not_worth_raising(region: ImprovingRegion, position: int) -> Array:
    """Values of ``_point_quantities`` and constants that are next to the bounds known: (q,)."""
    every = [bounds for _, bounds in region.bounds_of_law(position)]
    slack = [SLIGHT * (bounds.high - bounds.low) for bounds in every]
    below = (bounds.low + more for bounds, more in zip(every, slack, strict=True))
    above = (more - bounds.high for bounds, more in zip(every, slack, strict=True))
    return np.concatenate([each.ravel() for each in (*below, *above)])


def _tighten_point_bounds(region: ImprovingRegion, position: int, values: Array) -> ImprovingRegion:
    """The region with bounds in the order of ``_point_quantities``, where they are tighter."""
    below, above = values.reshape(2, -1)
    point_bounds, at = dict(region.point_bounds), 0
    for coordinates, bounds in region.bounds_of_law(position):
        shape, stop = bounds.low.shape, at + bounds.low.size
        low = np.maximum(bounds.low, below[at:stop].reshape(shape))
        high = np.minimum(bounds.high, -above[at:stop].reshape(shape))
        point_bounds[position, coordinates] = replace(bounds, low=low, high=high)
        at = stop
    return replace(region, point_bounds=point_bounds)
