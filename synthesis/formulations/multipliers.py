"""The solver's multipliers as the bound takes them: noise left out, and what they say of ends."""

from __future__ import annotations

import numpy as np

from synthesis.formulations.convex import Plan
from synthesis.formulations.ends import joint_rows
from synthesis.formulations.grid import SettledLaw
from synthesis.numerics.piecewise import Array
from synthesis.solvers.clarabel import ConeSolution

SILENT = 1e-10  # of the largest: multipliers of rows that do not bind, all but noise


def heard(plan: Plan, solution: ConeSolution) -> Array:
    """The multipliers (m,), those of inequalities without what is noise.

    An interior point gives every row one; most are of rows far from binding, and cost time only.
    """
    z, first = solution.multipliers.copy(), plan.program.equalities
    own = z[first : first + plan.program.inequalities]
    own[own <= SILENT * max(float(np.max(own, initial=0.0)), 0.0)] = 0.0
    return z


def ends_priced(plan: Plan, solution: ConeSolution, z: Array, order: int) -> list[Array]:
    """The solver's prices of g to g^(order − 1) at the end of every law: (order,) each.

    ``z``: the multipliers, as ``heard``.
    """
    laws, _ = plan.recover(solution.x)
    return [_end_price(plan, law, z, k, order) for k, law in enumerate(laws)]


def _end_price(plan: Plan, law: SettledLaw, z: Array, position: int, order: int) -> Array:
    """The solver's prices of g^(k)(1), k < order: of shared values those of the joints' rows.

    Those of known values are what makes the eliminated last coefficients stationary.
    """
    end, space = plan.settled[position].end, plan.grids[position].space
    nu, gradient = np.zeros(max(order, len(end))), np.zeros(len(end))
    last = slice(space.size - len(end), space.size)
    at = plan.program.equalities - sum(len(block.rhs) for block in plan.exact)
    for block in (*plan.exact, *plan.blocks):
        own = z[at : at + len(block.rhs)]
        if block.stretch == position and block.laws is not None and own.any():
            gradient += own @ block.laws[:, last]
        at += len(block.rhs)
    for ring, y in plan.ring_multipliers(z):
        for share, rows in zip(ring.shares, ring.rows, strict=True):
            if share.position == position:
                gradient += y @ rows[:, last]
    if plan.energy is not None:
        factor = plan.energy.factors[position]
        gradient += 2.0 / plan.energy.unit * (factor @ law.coefficients) @ factor[:, last]
    at = 0
    for joint in plan.joints:
        before, after = joint_rows(joint, plan.problem.free, plan.grids)
        mu = z[at : at + len(before.units)]
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
