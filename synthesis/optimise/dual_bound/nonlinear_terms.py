"""Terms of the Lagrangian that are no linear rows on a law, written as such.

Fixed sizes and cones: a cone ‖M ζ + m‖ ≤ r with dual vector (‖v‖, v) is the valid row
v · (M ζ + m) ≤ ‖v‖ r, by Cauchy and Schwarz, whatever v.

Mean square: (g^(k))² ≥ 2 y g^(k) − y² for any y, with equality where g^(k) = y. So where the
objective weighs a lower derivative than the one that is capped, this tangent takes its place: it
is linear in the law and never above the objective.

Residual vibration: the two rows of a run are integrals of the law against a damped wave, so that ψ
gets a wave. In pieces of a quarter of a radian it is a polynomial of degree 4 but for an error that
is bounded, and that the dual bound pays for.
"""

from __future__ import annotations

import numpy as np

from synthesis.numerics.piecewise import Array
from synthesis.numerics.solvers.clarabel import ConeSolution
from synthesis.optimise.conic.program import ConicModel
from synthesis.optimise.dual_bound.lagrangian import Lagrangian
from synthesis.optimise.dual_bound.row_functionals import Hats, WeightedRows
from synthesis.optimise.problem.residual_vibration import switching_contribution

PARTS = 4  # of a knot interval where y is not linear there


def nonlinear_row_functionals(
    model: ConicModel, order: int, z: Array
) -> list[tuple[WeightedRows, Array]]:
    """What is no row of a law, with its multipliers: sizes that leave no choice, cones of fixed
    radius; of a cone's in the direction that the solver found.
    """
    result, sizes = [], model.problem.sizing.bounds
    nowhere, nothing = np.zeros(1), np.zeros((1, order))
    at = sum(max(junction.highest - junction.lowest + 1, 0) for junction in model.junctions)
    for j, (low, high) in enumerate(sizes):
        if low == high:
            unit, rhs = np.eye(len(sizes))[j : j + 1], np.array([low / model.scales.size])
            rows = WeightedRows(None, nowhere, nothing, rhs, unit, signed=True)
            result.append((rows, z[at : at + 1]))
            at += 1
    at = model.program.equalities + model.program.inequalities
    for cone in model.cone_blocks:
        v = z[at + 1 : at + 1 + len(cone.shift)]
        at += 1 + len(cone.shift)
        if cone.bound_column is None and cone.vibration is None and np.count_nonzero(v):
            rhs = np.array([np.linalg.norm(v) * cone.radius + v @ cone.shift])
            size = -(cone.matrix.T @ v)[model.size][None, :]
            result.append((WeightedRows(None, nowhere, nothing, rhs, size), np.ones(1)))
    return result


def energy_tangents(
    model: ConicModel, solution: ConeSolution, order: int
) -> list[tuple[WeightedRows, Array]]:
    """What the objective is worth at least, as rows with their multipliers; none of other kinds.

    y is the solution's own derivative, linear between points.

    Args:
        order: m, the order of the control.
    """
    if model.energy is None or model.energy.order >= order:
        return []
    terms, k, sizes = [], model.energy.order, len(model.problem.sizing.bounds)
    laws, _ = model.recover(solution.x)
    for position, law in enumerate(laws):
        weight = float(model.energy.weights[position]) / model.energy.unit
        breaks = law.space.breaks
        if law.space.degree - k > 1:
            inner = breaks[:-1, None] + np.diff(breaks)[:, None] * (np.arange(PARTS) / PARTS)
            breaks = np.append(inner.ravel(), 1.0)
        y, width = law.curve().derivatives(breaks, k)[k], np.diff(breaks)
        rising, count = np.repeat([False, True], len(width)), 2 * len(width)
        alpha = np.tile(2.0 * weight * np.eye(order)[k], (count, 1))
        hats = Hats(np.tile(breaks[:-1], 2), np.tile(breaks[1:], 2), rising, alpha)
        linear = WeightedRows(
            position, hats.left, hats.weights, np.zeros(count), np.zeros((count, sizes)),
            signed=True, spans=np.stack([hats.left, hats.right], axis=1), poly=hats.poly,
        )  # fmt: skip
        square = np.sum(width * (y[:-1] ** 2 + y[:-1] * y[1:] + y[1:] ** 2)) / 3.0
        constant = WeightedRows(
            None, np.zeros(1), np.zeros((1, order)), np.array([weight * square]),
            np.zeros((1, sizes)),
        )  # fmt: skip
        terms.append((linear, 0.5 * np.concatenate([width * y[:-1], width * y[1:]])))
        terms.append((constant, np.ones(1)))
    return terms


def vibration_response(
    model: ConicModel, order: int, z: Array
) -> list[tuple[WeightedRows, Array, float]]:
    """Rows with their multipliers, and how far the law's true ψ may be from theirs.

    Args:
        order: m, the order of the control. z: (rows,) the program's multipliers.
    """
    result, sizes = [], len(model.problem.sizing.bounds)
    for vibration, y in model.vibration_multipliers(z):
        if not y.any():
            continue
        rhs = np.array([np.linalg.norm(y) * vibration.radius - y @ vibration.shift])
        nothing = np.zeros((1, order))
        constant = WeightedRows(None, np.zeros(1), nothing, rhs, np.zeros((1, sizes)))
        result.append((constant, np.ones(1), 0.0))
        for share in vibration.law_terms:
            part = switching_contribution(share, y, order)
            count = len(part.spans)
            weights = np.zeros((count, order))
            weights[0] = part.initial
            rows = WeightedRows(
                share.position, np.zeros(count), weights, np.zeros(count),
                np.zeros((count, sizes)), signed=True, spans=part.spans, poly=part.poly,
            )  # fmt: skip
            result.append((rows, np.ones(count), part.error))
    return result


def add_vibration_terms(lagrangian: Lagrangian, z: Array, *, error_only: bool = False) -> None:
    """Add all terms and the bound of their error; ``error_only``: that bound alone."""
    for rows, mass, missed in vibration_response(lagrangian.model, lagrangian.order, z):
        if not error_only:
            lagrangian.add_rows(rows, mass)
        if rows.position is not None:
            lagrangian.psi_error[rows.position] += missed
