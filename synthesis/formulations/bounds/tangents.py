"""A mean square from below: its tangent at a law at hand, which is linear in every other law.

(g^(k))² ≥ 2 y g^(k) − y² for any y, with equality where g^(k) = y; so where the objective weighs a
lower derivative than the one that is capped, its tangent takes its place in the bound.
"""

from __future__ import annotations

import numpy as np

from synthesis.formulations.bounds.densities import Hats
from synthesis.formulations.bounds.multiplied import Multiplied
from synthesis.formulations.cone.convex import Plan
from synthesis.numerics.piecewise import Array
from synthesis.solvers.clarabel import ConeSolution

PARTS = 4  # of a knot interval where y is not linear there


def tangents(plan: Plan, solution: ConeSolution, order: int) -> list[tuple[Multiplied, Array]]:
    """What the objective is worth at least, as rows with their multipliers; none of other kinds.

    y is the solution's own derivative, linear between points.

    Args:
        order: m, the derivative that steers.
    """
    if plan.energy is None or plan.energy.order >= order:
        return []
    found, k, sizes = [], plan.energy.order, len(plan.problem.sizing.bounds)
    laws, _ = plan.recover(solution.x)
    for position, law in enumerate(laws):
        weight = float(plan.energy.weights[position]) / plan.energy.unit
        breaks = law.space.breaks
        if law.space.degree - k > 1:
            inner = breaks[:-1, None] + np.diff(breaks)[:, None] * (np.arange(PARTS) / PARTS)
            breaks = np.append(inner.ravel(), 1.0)
        y, width = law.curve().derivatives(breaks, k)[k], np.diff(breaks)
        rising, count = np.repeat([False, True], len(width)), 2 * len(width)
        alpha = np.tile(2.0 * weight * np.eye(order)[k], (count, 1))
        hats = Hats(np.tile(breaks[:-1], 2), np.tile(breaks[1:], 2), rising, alpha)
        linear = Multiplied(
            position, hats.left, hats.weights, np.zeros(count), np.zeros((count, sizes)),
            signed=True, spans=np.stack([hats.left, hats.right], axis=1), poly=hats.poly,
        )  # fmt: skip
        square = np.sum(width * (y[:-1] ** 2 + y[:-1] * y[1:] + y[1:] ** 2)) / 3.0
        constant = Multiplied(
            None, np.zeros(1), np.zeros((1, order)), np.array([weight * square]),
            np.zeros((1, sizes)),
        )  # fmt: skip
        found.append((linear, 0.5 * np.concatenate([width * y[:-1], width * y[1:]])))
        found.append((constant, np.ones(1)))
    return found
