"""The solver's multipliers as the bound takes them: noise left out, and what they say of ends."""

from __future__ import annotations

import numpy as np

from synthesis.formulations.cone.convex import Plan
from synthesis.formulations.question.ends import joint_rows
from synthesis.numerics.piecewise import Array
from synthesis.solvers.clarabel import ConeSolution

SILENT = 1e-10  # of the largest: multipliers of rows that do not bind, all but noise


def heard(plan: Plan, solution: ConeSolution) -> Array:
    """The multipliers (m,), those of inequalities and cones without what is noise.

    An interior point gives every row one; most are of rows far from binding, and cost time only.
    """
    z, first = solution.multipliers.copy(), plan.program.equalities
    last = first + plan.program.inequalities
    own, conic = z[first:last], z[last:]
    noise = SILENT * float(own.max(initial=0.0))
    own[own <= noise] = 0.0
    conic[np.abs(conic) <= noise] = 0.0
    return z


def ends_priced(plan: Plan, solution: ConeSolution, z: Array, order: int) -> list[Array]:
    """The solver's prices of g to g^(order − 1) at the end of every law: (order,) each.

    Those of known values are what makes the eliminated last coefficients stationary; of values that
    laws share, those of the joints' rows.

    Args:
        z: the multipliers, as ``heard``.
    """
    gradients = _gradients(plan, solution, z)
    prices = [np.zeros(max(order, len(each))) for each in gradients]
    at = 0
    for joint in plan.joints:
        before, after = joint_rows(joint, plan.problem.free, plan.grids)
        mu = z[at : at + len(before.units)]
        at += len(mu)
        for side in (before, after):
            gradients[side.position] += mu @ side.dense[:, _last(plan, side.position)]
        shared = (mu * before.units)[: max(order - joint.lowest, 0)]
        prices[joint.before][joint.lowest : joint.lowest + len(shared)] = shared
    for nu, gradient, grid in zip(prices, gradients, plan.grids, strict=True):
        nu[: len(gradient)] = grid.space.end_prices(gradient)
    return [nu[:order] for nu in prices]


def _gradients(plan: Plan, solution: ConeSolution, z: Array) -> list[Array]:
    """What rows and objective ask of every law's last coefficients, joints apart."""
    found = [np.zeros(len(known.end)) for known in plan.settled]
    last = [_last(plan, position) for position in range(len(found))]
    for at, block in plan.heard_blocks(z):
        if block.laws is not None and block.stretch is not None:
            own = z[at : at + len(block.rhs)]
            found[block.stretch] += own @ block.laws[:, last[block.stretch]]
    for ring, y in plan.ring_multipliers(z):
        for share, rows in zip(ring.shares, ring.rows, strict=True):
            found[share.position] += y @ rows[:, last[share.position]]
    if plan.energy is not None:
        laws, _ = plan.recover(solution.x)
        for k, (factor, law) in enumerate(zip(plan.energy.factors, laws, strict=True)):
            root = factor @ law.coefficients
            found[k] += 2.0 / plan.energy.unit * root @ factor[:, last[k]]
    return found


def _last(plan: Plan, position: int) -> slice:
    """The coefficients of a law that its known end settles."""
    return slice(plan.grids[position].space.size - len(plan.settled[position].end), None)
