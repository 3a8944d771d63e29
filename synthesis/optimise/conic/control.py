"""The control of every free law: its highest derivative that rows cap or the objective weighs.

The dual bound minimises the Lagrangian over it pointwise, so that without one there is no bound
over all laws. Rows that hold on a part of a law alone cap nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf

import numpy as np

from synthesis.optimise.conic.linear_rows import LinearBlock
from synthesis.optimise.conic.program import ConicModel


@dataclass(frozen=True)
class Control:
    """|g^(order)| ≤ cap + rate π, and weight ∫ (g^(order))² dx in the objective.

    ``cap`` is infinite where only the weight holds the law, zero where only the level does.
    """

    order: int
    cap: float
    rate: float
    weight: float


def law_controls(model: ConicModel) -> list[Control] | None:
    """The control of every free law, of one order for all; None where one of them has none."""
    if any(cone.norm is None and cone.vibration is None for cone in model.cone_blocks):
        return None
    capping = [
        block for block in model.blocks if block.law_matrix is not None and block.highest_order >= 2
    ]
    for order in (3, 2):
        if any(
            b.highest_order >= order and np.count_nonzero(b.size) and b.kind != "mean"
            for b in capping
        ):
            return None  # the size caps it too: a bound over all laws would lose that row
        result = [_control(model, capping, position, order) for position in range(len(model.grids))]
        if any(control is not None for control in result):
            usable = [control for control in result if control is not None]
            weighs_more = model.energy is not None and model.energy.order > order
            return usable if len(usable) == len(result) and not weighs_more else None
    return None if model.grids else []


def _control(
    model: ConicModel, capping: Sequence[LinearBlock], position: int, order: int
) -> Control | None:
    caps, rates = np.full((2, 2), inf)  # of negative factors, and of positive ones
    for block in capping:
        # one that holds on a part of the law caps nothing
        whole = block.alpha.ndim == 1 and block.spans is None
        if block.segment == position and whole and block.orders == (order,):
            factor = float(block.alpha[order])
            side, scale = int(factor > 0.0), abs(factor)
            if block.level == 0.0:
                caps[side] = min(caps[side], block.rhs[0] / scale)
            else:
                rates[side] = min(rates[side], -block.level / scale)
    cap, rate = float(max(caps)), float(max(rates))
    weight = 0.0
    if model.energy is not None and model.energy.order == order:
        weight = float(model.energy.weights[position]) / model.energy.unit
    if rate < inf:  # the level caps the derivative; a fixed cap beside it only helps: left out
        return Control(order, 0.0, rate, weight)
    return None if cap == inf and weight == 0.0 else Control(order, cap, 0.0, weight)
