"""Optimality-based bound tightening of laws and sizes.

Rows of a nonconvex limit are as tight as the region is narrow over which they have to hold. Each
bound here (of g or g' at a node, of a size variable) is the dual bound of a cone program with that
quantity as its objective, so that it holds over all laws that satisfy the rows: a better cam does.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace
from math import inf

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
from synthesis.optimise.propagation.tolerances import LOOSENING

NODES = 12  # intervals of a law between the knots at which it is bounded


def tighten_laws(
    model: ConicModel,
    controls: Sequence[Control],
    previous: Sequence[LawBounds],
    wanted: Collection[int],
    deadline: float = inf,
) -> tuple[LawBounds, ...]:
    """The tube of every free law, at knots of the model.

    Args:
        model: rows that every better cam keeps, with a level that nothing asks for yet.
        controls: what caps the laws.
        previous: bounds known so far, () at first.
        wanted: positions of the laws whose bounds are tightened.
        deadline: ``clock.now()`` after which what is known already has to do.
    """
    result = []
    for position, control in enumerate(controls):
        bounds = (
            previous[position] if previous else _initial_bounds_at_knots(model, position, control)
        )
        result.append(
            _tighten_at_nodes(model, position, bounds, deadline) if position in wanted else bounds
        )
    return tuple(result)


def tighten_law(
    model: ConicModel,
    position: int,
    control: Control,
    nodes: Array,
    previous: LawBounds | None = None,
    deadline: float = inf,
) -> LawBounds:
    """The tube of one free law between chosen nodes; a former one has the same."""
    bounds = previous or _initial_bounds(model, position, control, nodes)
    return _tighten_at_nodes(model, position, bounds, deadline)


def size_bounds(model: ConicModel, axis: int, known: tuple[float, float]) -> tuple[float, float]:
    """Bounds of one size variable over every law and size that keep the model's rows [length].

    ``known``: those known before.
    """
    unit = np.zeros(len(model.problem.sizing.bounds))
    unit[axis] = model.scales.size
    low, high = (
        _level_lower_bound(model, LinearBlock.of_size(sign * unit, np.zeros(1), "tube", level=-1.0))
        for sign in (1.0, -1.0)
    )
    return max(low, known[0]), min(-high, known[1])


def _initial_bounds_at_knots(model: ConicModel, position: int, control: Control) -> LawBounds:
    """What follows from the ends and the cap alone, at some of the model's knots."""
    breaks = model.grids[position].space.breaks
    nodes = breaks[np.unique(np.linspace(0, len(breaks) - 1, NODES + 1).round().astype(int))]
    return _initial_bounds(model, position, control, nodes)


def _initial_bounds(model: ConicModel, position: int, control: Control, nodes: Array) -> LawBounds:
    free = model.problem.free[position].free
    zero = np.zeros_like(nodes)
    # with g from 0 to 1 and its control capped: far more than any speed that occurs
    fast = zero + 20.0 * (1.0 + control.cap)
    if free is None or free.overshoot:
        return LawBounds(nodes, zero - fast, zero + fast, -fast, fast, control.order, control.cap)
    return LawBounds(nodes, zero, zero + 1.0, zero, fast, control.order, control.cap)


def _tighten_at_nodes(
    model: ConicModel, position: int, bounds: LawBounds, deadline: float
) -> LawBounds:
    low, high, slow, fast = (
        a.copy() for a in (bounds.low, bounds.high, bounds.low_speed, bounds.high_speed)
    )
    for at, x in enumerate(bounds.nodes):
        if clock.now() >= deadline:
            break
        slow[at] = max(slow[at], _law_lower_bound(model, position, float(x), 1, 1.0))
        fast[at] = min(fast[at], -_law_lower_bound(model, position, float(x), 1, -1.0))
        if x in (0.0, 1.0):
            low[at] = high[at] = x
        else:
            low[at] = max(low[at], _law_lower_bound(model, position, float(x), 0, 1.0))
            high[at] = min(high[at], -_law_lower_bound(model, position, float(x), 0, -1.0))
    return replace(bounds, low=low, high=high, low_speed=slow, high_speed=fast)


def _law_lower_bound(model: ConicModel, position: int, x: float, order: int, sign: float) -> float:
    """A lower bound of sign · g^(order)(x) over all laws that keep the model's rows."""
    basis = model.grids[position].space.basis(np.array([x]), order)
    alpha = np.zeros(4)
    alpha[order] = sign
    return _level_lower_bound(
        model,
        LinearBlock(
            "point", position, sign * basis, np.array([x]), alpha, np.zeros(0), -1.0, np.zeros(1),
            "tube",
        ),
    )  # fmt: skip


def _level_lower_bound(model: ConicModel, block: LinearBlock) -> float:
    """A lower bound of the level that one more row asks for."""
    extended = with_rows(model, [block])
    solution = solve(extended.program)
    if solution.stopped not in USABLE:
        return -inf
    result = dual_bound(extended, solution)
    return result.value - LOOSENING * max(abs(result.value), 1.0) if result.switching else -inf
