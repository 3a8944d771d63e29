"""What a run may leave ringing, times its multipliers: what that says of arbitrary laws.

The two rows of a run are integrals of the law against a damped wave, so ψ gets a wave; in pieces of
a quarter of a radian that is a polynomial of the fourth degree, but for what is booked as missed.
"""

from __future__ import annotations

import numpy as np

from synthesis.formulations.bounds.ledger import Ledger
from synthesis.formulations.bounds.multiplied import Multiplied
from synthesis.formulations.cone.convex import Plan
from synthesis.formulations.question.ringing import swing
from synthesis.numerics.piecewise import Array


def resounding(plan: Plan, order: int, z: Array) -> list[tuple[Multiplied, Array, float]]:
    """Rows with their multipliers, and how far the law's true ψ may be from theirs.

    Args:
        order: m, the derivative that steers. z: (rows,) the program's multipliers.
    """
    found, sizes = [], len(plan.problem.sizing.bounds)
    for ring, y in plan.ring_multipliers(z):
        if not y.any():
            continue
        rhs = np.array([np.linalg.norm(y) * ring.radius - y @ ring.shift])
        nothing = np.zeros((1, order))
        constant = Multiplied(None, np.zeros(1), nothing, rhs, np.zeros((1, sizes)))
        found.append((constant, np.ones(1), 0.0))
        for share in ring.shares:
            part = swing(share, y, order)
            count = len(part.spans)
            weights = np.zeros((count, order))
            weights[0] = part.state
            rows = Multiplied(
                share.position, np.zeros(count), weights, np.zeros(count),
                np.zeros((count, sizes)), signed=True, spans=part.spans, poly=part.poly,
            )  # fmt: skip
            found.append((rows, np.ones(count), part.missed))
    return found


def resound(ledger: Ledger, z: Array, *, booked: bool = False) -> None:
    """Book them all; where they are booked already, what they miss alone."""
    for rows, mass, missed in resounding(ledger.plan, ledger.order, z):
        if not booked:
            ledger.book(rows, mass)
        if rows.position is not None:
            ledger.missed[rows.position] += missed
