"""The control of every free law: its highest derivative that rows cap or the objective weighs.

The dual bound minimises the Lagrangian over it pointwise, so that without one there is no bound
over all laws. Rows that hold on a part of a law alone cap nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf

import numpy as np

from synthesis.numerics.piecewise import Array
from synthesis.optimise.conic.linear_rows import LinearBlock
from synthesis.optimise.conic.program import ConicModel

LEAST_MULTIPLIER = 1e-9  # of a mean square's cap, relative to the largest multiplier


@dataclass(frozen=True)
class Control:
    """|g^(order)| ≤ cap + rate π, and weight ∫ (g^(order))² dx in the objective.

    ``cap`` is infinite where only the weight holds the law, zero where only the level does.
    ``square``: of ∫ (g^(order))² dx, a cap; infinite where none is known.
    """

    order: int
    cap: float
    rate: float
    weight: float
    square: float = inf


@dataclass(frozen=True)
class MeanSquareCap:
    """Σ weights_i ∫ (g_i^(order))² dx ≤ room, over the free laws, and the multiplier of that.

    ``least``: what each law has of it in any case.
    """

    order: int
    weights: Array
    room: float
    multiplier: float
    least: Array

    @property
    def rooms(self) -> Array:
        """What each law may have of it: the room less what the others have in any case."""
        return np.maximum(self.room - np.sum(self.least) + self.least, self.least)


def mean_square_caps(model: ConicModel, z: Array) -> tuple[MeanSquareCap, ...]:
    """The caps of mean squares with the multipliers that those of their cones (m,) come to.

    ‖y‖ ≤ 1 with multiplier λ, where y is the derivative over √room, is ‖y‖² ≤ 1 with λ/2 where it
    binds; any that is not negative gives a valid bound. One of zero would leave nothing to hold a
    law's control against the rounding of ψ, so that each is at least a little.
    """
    found, at = list[MeanSquareCap](), model.program.equalities + model.program.inequalities
    least = LEAST_MULTIPLIER * float(np.max(np.abs(z), initial=0.0))
    for cone in model.cone_blocks:
        if cone.energy is not None:
            multiplier = 0.5 * max(float(z[at]), least) / cone.room
            found.append(MeanSquareCap(
                cone.energy.order, cone.energy.weights, cone.room, multiplier, cone.energy.least
            ))  # fmt: skip
        at += 1 + len(cone.shift)
    return tuple(found)


def weighed_controls(model: ConicModel, caps: Sequence[MeanSquareCap]) -> list[Control] | None:
    """The controls where one mean square is capped, and nothing else of its order; None elsewhere.

    In the Lagrangian the cap weighs the control as an objective that is a mean square does.
    """
    if len(caps) != 1 or caps[0].multiplier <= 0.0 or model.energy is not None:
        return None
    (cap,) = caps
    if any(b.law_matrix is not None and b.highest_order >= cap.order for b in model.blocks):
        return None
    return [
        Control(cap.order, inf, 0.0, cap.multiplier * float(weight), float(room / weight))
        for weight, room in zip(cap.weights, cap.rooms, strict=True)
    ]


def capped_controls(model: ConicModel) -> list[Control] | None:
    """The control of every free law with a cap of it, or of its mean square; None without one."""
    controls = law_controls(model)
    if controls is None:
        ones = np.ones(model.program.matrix.shape[0])
        controls = weighed_controls(model, mean_square_caps(model, ones))
    known = controls is not None and all(min(c.cap, c.square) < inf for c in controls)
    return controls if known else None


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
