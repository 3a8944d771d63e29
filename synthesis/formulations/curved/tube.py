"""How narrow a tube every better cam's laws keep to.

Rows of a curved limit that is not convex are as tight as the range is narrow over which they have
to hold. Each bound is a cone program's optimum under all rows known, taken from its multipliers as
any bound over all laws is; a better cam keeps it, because it keeps the rows.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace
from math import inf

import numpy as np

from synthesis import clock
from synthesis.formulations.bounds.bound import bound
from synthesis.formulations.cone.control import Control
from synthesis.formulations.cone.convex import Plan, with_rows
from synthesis.formulations.cone.rows import Block
from synthesis.formulations.cone.tubing import Tube
from synthesis.numerics.piecewise import Array
from synthesis.solvers.clarabel import solve
from synthesis.solvers.statuses import USABLE

SPARE = 1e-9
NODES = 12  # intervals of a law between the knots at which its tube is known


def tubes(
    plan: Plan,
    steering: Sequence[Control],
    former: Sequence[Tube],
    wanted: Collection[int],
    deadline: float = inf,
) -> tuple[Tube, ...]:
    """The tube of every free law, at knots of the plan.

    Args:
        plan: rows that every better cam keeps, with a level that nothing asks for yet.
        steering: what caps the laws.
        former: tubes known so far, () at first.
        wanted: positions of the laws whose tube shall be narrowed.
        deadline: ``clock.now()`` after which what is known already has to do.
    """
    found = []
    for position, control in enumerate(steering):
        known = former[position] if former else _widest(plan, position, control)
        found.append(_narrowed(plan, position, known, deadline) if position in wanted else known)
    return tuple(found)


def tube_of(
    plan: Plan,
    position: int,
    control: Control,
    nodes: Array,
    former: Tube | None = None,
    deadline: float = inf,
) -> Tube:
    """The tube of one free law between chosen nodes; a former one has the same."""
    known = former or _unknown(plan, position, control, nodes)
    return _narrowed(plan, position, known, deadline)


def size_ends(plan: Plan, axis: int, known: tuple[float, float]) -> tuple[float, float]:
    """Bounds of one size variable over every law and size that keep the plan's rows [mm].

    ``known``: those known before.
    """
    unit = np.zeros(len(plan.problem.sizing.bounds))
    unit[axis] = plan.scales.size
    low, high = (
        _floor(plan, Block.of_size(sign * unit, np.zeros(1), "tube", level=-1.0))
        for sign in (1.0, -1.0)
    )
    return max(low, known[0]), min(-high, known[1])


def _widest(plan: Plan, position: int, control: Control) -> Tube:
    """What follows from the ends and the cap alone, at some of the plan's knots."""
    breaks = plan.grids[position].space.breaks
    nodes = breaks[np.unique(np.linspace(0, len(breaks) - 1, NODES + 1).round().astype(int))]
    return _unknown(plan, position, control, nodes)


def _unknown(plan: Plan, position: int, control: Control, nodes: Array) -> Tube:
    free = plan.problem.free[position].free
    zero = np.zeros_like(nodes)
    # with g from 0 to 1 and its steering derivative capped: far more than any speed that occurs
    fast = zero + 20.0 * (1.0 + control.cap)
    if free is None or free.overshoot:
        return Tube(nodes, zero - fast, zero + fast, -fast, fast, control.order, control.cap)
    return Tube(nodes, zero, zero + 1.0, zero, fast, control.order, control.cap)


def _narrowed(plan: Plan, position: int, known: Tube, deadline: float) -> Tube:
    low, high, slow, fast = (a.copy() for a in (known.low, known.high, known.slow, known.fast))
    for at, x in enumerate(known.nodes):
        if clock.now() >= deadline:
            break
        slow[at] = max(slow[at], _least(plan, position, float(x), 1, 1.0))
        fast[at] = min(fast[at], -_least(plan, position, float(x), 1, -1.0))
        if x in (0.0, 1.0):
            low[at] = high[at] = x
        else:
            low[at] = max(low[at], _least(plan, position, float(x), 0, 1.0))
            high[at] = min(high[at], -_least(plan, position, float(x), 0, -1.0))
    return replace(known, low=low, high=high, slow=slow, fast=fast)


def _least(plan: Plan, position: int, x: float, order: int, sign: float) -> float:
    """A lower bound of sign · g^(order)(x) over all laws that keep the plan's rows."""
    basis = plan.grids[position].space.basis(np.array([x]), order)
    alpha = np.zeros(4)
    alpha[order] = sign
    return _floor(
        plan,
        Block(
            "point", position, sign * basis, np.array([x]), alpha, np.zeros(0), -1.0, np.zeros(1),
            "tube",
        ),
    )  # fmt: skip


def _floor(plan: Plan, block: Block) -> float:
    """A lower bound of the level that one more row asks for."""
    asked = with_rows(plan, [block])
    solution = solve(asked.program)
    if solution.stopped not in USABLE:
        return -inf
    found = bound(asked, solution)
    return found.value - SPARE * max(abs(found.value), 1.0) if found.switching else -inf
