"""Optimality-based bound tightening of laws and sizes.

Rows of a nonconvex limit are as tight as the region is narrow over which they have to hold. Each
bound here (of g or g' at a node, of a size variable) is the dual bound of a cone program with that
quantity as its objective, so that it holds over all laws that satisfy the rows: a better cam does.
"""

from __future__ import annotations

from dataclasses import replace
from math import inf, sqrt

import numpy as np

from synthesis.numerics import clock
from synthesis.numerics.piecewise import Array
from synthesis.numerics.solvers.clarabel import solve
from synthesis.numerics.solvers.statuses import USABLE
from synthesis.optimise.conic.control import Control
from synthesis.optimise.conic.law_bounds import LawBounds
from synthesis.optimise.conic.linear_rows import LinearBlock
from synthesis.optimise.conic.program import ConicModel, with_rows
from synthesis.optimise.dual_bound.bound import dual_bound
from synthesis.optimise.problem.problem import NoObjective, ObjectiveCap, Problem
from synthesis.optimise.propagation.half_spaces import LOOSENING

INTERVALS = 12
"""Of a law between the knots at which it is bounded; each end costs four cone programs."""
FASTEST = 20.0
"""Times 1 + cap: more than |g'| of any law from 0 to 1 (7 + 7/2 cap, by Taylor's formula; by
Schwarz's inequality with the root of the square's cap in its place)."""


def with_value_cap(problem: Problem, value: float) -> Problem:
    """The problem without an objective, its objective's value capped: what better cams satisfy.

    The cap on a mean square is left out: it is a cone over all laws at once, of which the bounds
    over all laws know no row. Better cams satisfy what is left as well.
    """
    if problem.objective.energy_order() is not None:
        return replace(problem, objective=NoObjective())
    caps = (*problem.objective_caps, ObjectiveCap(problem.objective, value))
    return replace(problem, objective=NoObjective(), objective_caps=caps)


def initial_law_bounds(
    model: ConicModel, position: int, control: Control, nodes: Array | None = None
) -> LawBounds:
    """What follows for a law from its ends and cap alone; at some knots, if not at given nodes."""
    if nodes is None:
        breaks = model.grids[position].space.breaks
        chosen = np.linspace(0, len(breaks) - 1, INTERVALS + 1).round().astype(int)
        nodes = breaks[np.unique(chosen)]
    free, zero = model.problem.free[position].free, np.zeros_like(nodes)
    caps = control.order, control.cap, control.square
    fast = zero + FASTEST * (1.0 + min(control.cap, sqrt(control.square)))
    if free is None or free.overshoot:
        return LawBounds(nodes, -fast, fast, -fast, fast, *caps)
    return LawBounds(nodes, zero, zero + 1.0, zero, fast, *caps)


def tighten_law(
    model: ConicModel, position: int, bounds: LawBounds, deadline: float = inf
) -> LawBounds:
    """Tighten the bounds of one free law: a dual bound from either side at every node.

    Args:
        model: rows that every better cam satisfies, with a level that no row has yet.
        deadline: ``clock.now()`` after which no more nodes are tightened.
    """
    value = bounds.low.copy(), bounds.high.copy()
    speed = bounds.low_speed.copy(), bounds.high_speed.copy()
    space, level = model.grids[position].space, -1.0
    for at, x in enumerate(bounds.nodes):
        if clock.now() >= deadline:
            break
        for order, (low, high) in ((1, speed), (0, value)):
            if order == 0 and x in (0.0, 1.0):
                low[at] = high[at] = x
                continue
            # the rows g^(k)(x) ≤ P and −g^(k)(x) ≤ P: the least P bounds it from either side
            row, ends = space.basis(np.array([x]), order), []
            for sign in (1.0, -1.0):
                block = LinearBlock(
                    "point", position, sign * row, np.array([x]), sign * np.eye(4)[order],
                    np.zeros(0), level, np.zeros(1), "law bounds",
                )  # fmt: skip
                ends.append(sign * _level_lower_bound(model, block))
            low[at], high[at] = max(low[at], ends[0]), min(high[at], ends[1])
    return replace(bounds, low=value[0], high=value[1], low_speed=speed[0], high_speed=speed[1])


def size_bounds(model: ConicModel, axis: int, known: tuple[float, float]) -> tuple[float, float]:
    """Bounds of one size variable over every law and size that keep the model's rows [length].

    ``known``: those known before.
    """
    unit = np.zeros(len(model.problem.sizing.bounds))
    unit[axis] = model.scales.size
    low, high = (
        sign * _level_lower_bound(
            model, LinearBlock.of_size(sign * unit, np.zeros(1), "size bounds", level=-1.0)
        )
        for sign in (1.0, -1.0)
    )  # fmt: skip
    return max(low, known[0]), min(high, known[1])


def _level_lower_bound(model: ConicModel, block: LinearBlock) -> float:
    """A lower bound, over all laws, of the level that one more row asks for."""
    extended = with_rows(model, [block])
    solution = solve(extended.program)
    if solution.stopped not in USABLE:
        return -inf
    result = dual_bound(extended, solution)
    return result.value - LOOSENING * max(abs(result.value), 1.0) if result.switching else -inf
