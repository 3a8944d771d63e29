"""The derivative by which a free law is steered: the highest one that something caps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf

import numpy as np

from synthesis.formulations.cone.convex import Plan
from synthesis.formulations.cone.rows import Block


@dataclass(frozen=True)
class Control:
    """|g^(order)| ≤ cap + rate π, and weight ∫ (g^(order))² dx in the objective.

    ``cap`` is infinite where only the weight holds the law, zero where only the level does.
    """

    order: int
    cap: float
    rate: float
    weight: float


def controls(plan: Plan) -> list[Control] | None:
    """The steering derivative of every free law, of one order; None where there is none."""
    if any(ball.norm is None and ball.ring is None for ball in plan.balls):
        return None
    capping = [block for block in plan.blocks if block.laws is not None and block.highest >= 2]
    for order in (3, 2):
        if any(b.highest >= order and np.count_nonzero(b.size) for b in capping):
            return None  # the size caps it too: a bound over all laws would lose that row
        found = [_control(plan, capping, position, order) for position in range(len(plan.grids))]
        if any(control is not None for control in found):
            usable = [control for control in found if control is not None]
            weighs_more = plan.energy is not None and plan.energy.order > order
            return usable if len(usable) == len(found) and not weighs_more else None
    return None if plan.grids else []


def _control(plan: Plan, capping: Sequence[Block], position: int, order: int) -> Control | None:
    caps, rates = {1: inf, -1: inf}, {1: inf, -1: inf}
    for block in capping:
        # one that holds on a part of the law caps nothing
        if block.stretch != position or block.alpha.ndim > 1 or block.spans is not None:
            continue
        if block.orders != (order,):
            continue
        factor = float(block.alpha[order])
        sign, scale = (1 if factor > 0.0 else -1), abs(factor)
        if block.level == 0.0:
            caps[sign] = min(caps[sign], float(block.rhs[0]) / scale)
        else:
            rates[sign] = min(rates[sign], -block.level / scale)
    cap, rate = max(caps.values()), max(rates.values())
    weight = 0.0
    if plan.energy is not None and plan.energy.order == order:
        weight = float(plan.energy.weights[position]) / plan.energy.unit
    if rate < inf:  # the level caps the derivative; a fixed cap beside it only helps: left out
        return Control(order, 0.0, rate, weight)
    return None if cap == inf and weight == 0.0 else Control(order, cap, 0.0, weight)
