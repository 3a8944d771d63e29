"""Optimality-based bound tightening of laws and sizes.

Rows of a nonconvex limit are as tight as the region is narrow over which they have to hold. Each
bound here (of g or g' at a node, of a size variable) is the dual bound of a program with that
quantity as its objective, so that it holds over all laws that satisfy the rows: a better cam does.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import inf, sqrt

import numpy as np

from synthesis.numerics.piecewise import Array
from synthesis.optimise.conic.control import Control
from synthesis.optimise.conic.law_bounds import LawBounds
from synthesis.optimise.conic.program import ConicModel
from synthesis.optimise.dual_bound.batch import Quantities
from synthesis.optimise.problem.problem import NoObjective, ObjectiveCap, Problem
from synthesis.optimise.propagation.improving_region import Sizes
from synthesis.optimise.propagation.quantity_bounds import bound_quantities

INTERVALS = 12  # of a law between the knots at which it is bounded
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
    model: ConicModel,
    controls: Sequence[Control],
    sizes: Sizes,
    position: int,
    bounds: LawBounds,
    deadline: float = inf,
) -> LawBounds:
    """Tighten the bounds of one free law: a dual bound from either side at every node.

    Args:
        model: rows that every better cam satisfies, without an objective.
        controls: caps of all free laws' controls (``capped_controls``).
        sizes: ranges of the size of better cams.
        deadline: ``clock.now()`` after which nothing is tightened.
    """
    # 1. g' at every node, and g at those in between: it is known at the ends.
    nodes, inner = bounds.nodes, (bounds.nodes > 0.0) & (bounds.nodes < 1.0)
    x = np.concatenate([nodes, nodes[inner]])
    orders = np.concatenate([np.full(len(nodes), 1), np.zeros(len(x) - len(nodes), dtype=int)])
    known = np.where(inner, bounds.low, nodes), np.where(inner, bounds.high, nodes)
    bounds = replace(bounds, low=known[0], high=known[1])
    # 2. Each from below and from above.
    alpha = np.eye(3)[orders]
    both = Quantities(
        np.full(2 * len(x), position), np.tile(x, 2), np.concatenate([alpha, -alpha]),
        np.zeros((2 * len(x), len(sizes))),
    )  # fmt: skip
    values = bound_quantities(model, controls, sizes, both, deadline)
    if values is None:
        return bounds
    below, above = values.reshape(2, -1)
    (slow, low), (fast, high) = np.split(below, [len(nodes)]), np.split(-above, [len(nodes)])
    tight = bounds.low.copy(), bounds.high.copy()
    tight[0][inner] = np.maximum(tight[0][inner], low)
    tight[1][inner] = np.minimum(tight[1][inner], high)
    return replace(
        bounds, low=tight[0], high=tight[1],
        low_speed=np.maximum(bounds.low_speed, slow),
        high_speed=np.minimum(bounds.high_speed, fast),
    )  # fmt: skip


def size_bounds(model: ConicModel, controls: Sequence[Control], known: Sizes) -> Sizes:
    """Bounds of the size over every law and size that keep the model's rows [length].

    Args:
        model, controls: as of ``tighten_law``.
        known: bounds known before.
    """
    axes = model.scales.size * np.eye(len(known))
    count = 2 * len(axes)
    both = Quantities(
        np.zeros(count, dtype=int), np.zeros(count), np.zeros((count, 3)),
        np.concatenate([axes, -axes]),
    )  # fmt: skip
    values = bound_quantities(model, controls, known, both)
    if values is None:
        return known
    low, high = values.reshape(2, -1)
    return tuple(
        (max(ends[0], float(a)), min(ends[1], -float(b)))
        for ends, a, b in zip(known, low, high, strict=True)
    )
