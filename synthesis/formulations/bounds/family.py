"""A lower bound over the splines of a program's own knots: its dual objective, made sound."""

from __future__ import annotations

import numpy as np

from synthesis.formulations.cone.convex import Plan
from synthesis.numerics.piecewise import Array
from synthesis.solvers.clarabel import ConeSolution


def over_family(plan: Plan, solution: ConeSolution) -> float:
    """The dual objective, less what its residual could gain with coefficients in a box."""
    program, z = plan.program, solution.multipliers.copy()
    first, count = program.equalities, program.inequalities
    z[first : first + count] = np.maximum(z[first : first + count], 0.0)
    at = first + count
    for size in program.cones:
        z[at] = max(z[at], float(np.linalg.norm(z[at + 1 : at + size])))
        at += size
    x = solution.x
    full = program.quadratic + program.quadratic.T
    full.setdiag(program.quadratic.diagonal())
    curved = full @ x
    residual = curved + program.linear + program.matrix.T @ z
    box = np.maximum(10.0, 10.0 * np.abs(x))
    value = -0.5 * x @ curved - _asked(plan) @ z - np.abs(residual) @ box
    return float(value)


def _asked(plan: Plan) -> Array:
    """The right-hand sides as asked, before they were drawn in for the solver's sake."""
    rhs, at = plan.program.rhs.copy(), plan.program.equalities
    for block in plan.blocks:
        rhs[at : at + len(block.rhs)] += block.tighten
        at += len(block.rhs)
    for ball in plan.balls:
        rhs[at] += ball.radius * ball.tighten
        at += 1 + len(ball.shift)
    return rhs
