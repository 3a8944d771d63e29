"""The solver's multipliers as the bound takes them: noise left out, and what they say of ends."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from synthesis.formulations.convex import Plan
from synthesis.formulations.ends import joint_rows
from synthesis.numerics.piecewise import Array
from synthesis.solvers.clarabel import ConeSolution

SILENT = 1e-10  # of the largest: multipliers of rows that do not bind, all but noise


def heard(plan: Plan, solution: ConeSolution) -> list[Array]:
    """The inequality multipliers, block by block, those that are noise left out.

    An interior point gives every row one; most are of rows far from binding, and cost time only.
    """
    z, first = solution.multipliers, plan.program.equalities
    loudest = np.max(z[first : first + plan.program.inequalities], initial=0.0)
    return plan.multipliers(np.where(z > SILENT * loudest, z, 0.0))


def ends_priced(
    plan: Plan, solution: ConeSolution, prices: Sequence[Array], order: int
) -> list[Array]:
    """The solver's prices of g to g^(order − 1) at the end of every law: (order,) each.

    ``prices``: the inequality multipliers, as ``heard``.
    """
    return [_end_price(plan, solution, prices, k, order) for k in range(len(plan.grids))]


def _end_price(
    plan: Plan, solution: ConeSolution, prices: Sequence[Array], position: int, order: int
) -> Array:
    """The solver's prices of g^(k)(1), k < order: of shared values those of the joints' rows.

    Those of known values are what makes the eliminated last coefficients stationary.
    """
    end, space = plan.settled[position].end, plan.grids[position].space
    nu, gradient = np.zeros(max(order, len(end))), np.zeros(len(end))
    last = slice(space.size - len(end), space.size)
    for block, z in (
        *zip(plan.blocks, prices, strict=True),
        *zip(plan.exact, plan.exact_multipliers(solution.multipliers), strict=True),
    ):
        if block.stretch == position and block.laws is not None:
            gradient += z @ block.laws[:, last]
    at = 0
    for joint in plan.joints:
        before, after = joint_rows(joint, plan.problem.free, plan.grids)
        mu = solution.multipliers[at : at + len(before.units)]
        at += len(mu)
        for side in (before, after):
            if side.position == position:
                gradient += mu @ side.dense[:, last]
        if before.position == position:
            shared = (mu * before.units)[: max(order - joint.lowest, 0)]
            nu[joint.lowest : joint.lowest + len(shared)] = shared
    rows = space.boundary(1.0, len(end))[:, last]
    nu[: len(end)] = np.linalg.solve(rows.T, -gradient)
    return nu[:order]
