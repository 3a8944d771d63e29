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
from synthesis.optimise.dual_bound.row_functionals import Hats, WeightedRows
from synthesis.optimise.problem.residual_vibration import switching_contribution

PARTS = 4  # of a knot interval where y is not linear there


Terms = list[tuple[WeightedRows, Array]]
"""Rows with their multipliers, (n,) or (q, n)."""


def fixed_size_rows(model: ConicModel, z: Array) -> Terms:
    """Sizes that leave no choice, equalities with their multipliers; z: (m,) or (q, m)."""
    sizes, unit = model.problem.sizing.bounds, model.scales.size
    # their rows come after those of the junctions
    at = sum(max(junction.highest - junction.lowest + 1, 0) for junction in model.junctions)
    fixed = [(j, low / unit) for j, (low, high) in enumerate(sizes) if low == high]
    return [
        (
            WeightedRows.of_size(np.array([value]), np.eye(len(sizes))[[j]], signed=True),
            z[..., at + k : at + k + 1],
        )
        for k, (j, value) in enumerate(fixed)
    ]


def cone_rows(model: ConicModel, z: Array) -> Terms:
    """Cones of fixed radius, each as its row in the direction of the solver's multipliers (m,)."""
    result, at = Terms(), model.program.equalities + model.program.inequalities
    for cone in model.cone_blocks:
        v = z[at + 1 : at + 1 + len(cone.shift)]
        at += 1 + len(cone.shift)
        if cone.bound_column is None and cone.vibration is None and np.count_nonzero(v):
            rhs = np.array([np.linalg.norm(v) * cone.radius + v @ cone.shift])
            size = -(cone.matrix.T @ v)[model.size]
            result.append((WeightedRows.of_size(rhs, size[None]), np.ones(1)))
    return result


def energy_tangents(model: ConicModel, solution: ConeSolution, order: int) -> Terms:
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
            signed=True, spans=hats.spans, poly=hats.poly,
        )  # fmt: skip
        square = np.sum(width * (y[:-1] ** 2 + y[:-1] * y[1:] + y[1:] ** 2)) / 3.0
        constant = WeightedRows.of_size(np.array([weight * square]), np.zeros((1, sizes)))
        terms.append((linear, 0.5 * np.concatenate([width * y[:-1], width * y[1:]])))
        terms.append((constant, np.ones(1)))
    return terms


def vibration_terms(model: ConicModel, order: int, z: Array) -> tuple[Terms, Array]:
    """Limits on residual vibration, and how far the laws' true ψ may be from theirs: (laws,).

    Args:
        order: m, the order of the control. z: (rows,) the program's multipliers.
    """
    terms, error, sizes = Terms(), np.zeros(len(model.grids)), len(model.problem.sizing.bounds)
    for vibration, y in model.vibration_multipliers(z):
        if not y.any():
            continue
        rhs = np.array([np.linalg.norm(y) * vibration.radius - y @ vibration.shift])
        terms.append((WeightedRows.of_size(rhs, np.zeros((1, sizes))), np.ones(1)))
        for share in vibration.law_terms:
            part = switching_contribution(share, y, order)
            count = len(part.spans)
            weights = np.zeros((count, order))
            weights[0] = part.initial
            rows = WeightedRows(
                share.position, np.zeros(count), weights, np.zeros(count),
                np.zeros((count, sizes)), signed=True, spans=part.spans, poly=part.poly,
            )  # fmt: skip
            terms.append((rows, np.ones(count)))
            error[share.position] += part.error
    return terms, error
