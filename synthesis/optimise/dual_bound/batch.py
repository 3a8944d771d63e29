"""Lower bounds of many quantities at once, over every motion law and size that keep a model's rows.

Each quantity is linear in one law, at a point, and in the size. Multipliers of the rows, one set
for each quantity, add the rows to it; what is left is least for a law that switches with the sign
of ψ and for a size at the ends of its ranges. It is the duality of ``bound``, for capped laws and
without an objective, in a few operations on tables: hundreds of bounds cost what one costs there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from synthesis.numerics.piecewise import Array, gauss_points
from synthesis.optimise.conic.control import Control
from synthesis.optimise.conic.program import ConicModel
from synthesis.optimise.dual_bound.bound import ROUNDING, unknown_initial_values
from synthesis.optimise.dual_bound.costates import end_coefficients, end_costates, project_costates
from synthesis.optimise.dual_bound.lagrangian import Lagrangian
from synthesis.optimise.dual_bound.row_functionals import fixed_size_rows, row_functionals
from synthesis.optimise.dual_bound.switching import NODES, mean_absolute
from synthesis.optimise.dual_bound.vibration_terms import vibration_terms

BATCH = 16
"""Quantities whose Lagrangians are worked out together."""


@dataclass(frozen=True, eq=False)
class Quantities:
    """Quantities alpha · (g, g', g'') (x) + size · ζ, in the model's units.

    Attributes:
        law: (q,) positions of the free laws. x: (q,). alpha: (q, 3). size: (q, n_size).
    """

    law: Array
    x: Array
    alpha: Array
    size: Array

    def scaled(self) -> tuple[Quantities, Array]:
        """Every quantity over its largest factor, and these units (q,)."""
        units = np.maximum(np.abs(self.alpha).max(axis=1), np.abs(self.size).max(axis=1))
        alpha, size = self.alpha / units[:, None], self.size / units[:, None]
        return replace(self, alpha=alpha, size=size), units

    def objectives(self, model: ConicModel) -> tuple[Array, Array]:
        """The same as objectives of the model's program, (q, n), and their constants, (q,)."""
        result = np.zeros((len(self.x), model.program.matrix.shape[1]))
        constants = np.zeros(len(self.x))
        result[:, model.size] = self.size
        for position in np.unique(self.law):
            mine, rows = self.rows_of_law(model, position)
            unknown, constants[mine] = model.boundary_states[position].split(rows)
            result[mine, model.columns[position]] = unknown
        return result, constants

    def select(self, which: slice | NDArray[Any]) -> Quantities:
        """Some of them."""
        parts = self.law[which], self.x[which], self.alpha[which], self.size[which]
        return Quantities(*parts)

    def rows_of_law(self, model: ConicModel, position: int) -> tuple[NDArray[np.intp], Array]:
        """Which of them speak of one law, and their factors (k, n) of its coefficients."""
        mine = np.flatnonzero(self.law == position)
        space, alpha = model.grids[position].space, self.alpha[mine]
        rows = np.zeros((len(mine), space.size))
        for order in np.flatnonzero(np.any(alpha, axis=0)):
            acting = alpha[:, order] != 0.0
            table = space.basis(self.x[mine[acting]], int(order))
            rows[acting] += alpha[acting, order][:, None] * table
        return mine, rows


def solve_boundary_costates(
    model: ConicModel, quantities: Quantities, multipliers: Array, order: int
) -> Array:
    """The solver's costates of g to g^(m−1) at the end of every law, m the order: (q, laws, m)."""
    gradients = []
    for position in range(len(model.grids)):
        last = end_coefficients(model, position)
        mine, rows = quantities.rows_of_law(model, position)
        gradients.append(np.zeros((len(multipliers), rows[:, last].shape[1])))
        gradients[-1][mine] = rows[:, last]
    return end_costates(model, multipliers, gradients, order)


def dual_bounds(
    model: ConicModel,
    controls: Sequence[Control],
    sizes: Sequence[tuple[float, float]],
    quantities: Quantities,
    multipliers: Array,
    costates: Array,
) -> Array:
    """A lower bound of every quantity: (q,), −inf where none follows.

    Args:
        controls: caps of every free law's control, of one order m, or of one mean square of all.
            sizes: ranges of the size [length].
        multipliers: (q, m) of the model's rows, of its cones those on residual vibration alone;
            any, good ones bound well. Of a mean square the best one is known, and taken.
        costates: (q, laws, m) costates of the laws' ends (``solve_boundary_costates``); any.
    """
    lagrangians = (
        lagrangian_of(model, quantities.select(some), multipliers[some], costates[some])
        for some in batches(len(multipliers))
    )
    every = (_least_values(lagrangian, controls, sizes) for lagrangian in lagrangians)
    return np.concatenate([np.zeros(0), *every])


def batches(count: int) -> list[slice]:
    """Of quantities. Each has few multipliers, neighbours the same: in a small batch few points."""
    return [slice(at, at + BATCH) for at in range(0, count, BATCH)]


def _least_values(
    lagrangian: Lagrangian, controls: Sequence[Control], sizes: Sequence[tuple[float, float]]
) -> Array:
    """The least of every Lagrangian over all laws and sizes, or less: (q,)."""
    # 1. Quantities and rows times their multipliers are linear in all unknowns.
    total, magnitude = lagrangian.constant, lagrangian.magnitude
    # 2. Least over every law: ∫ ψ w with |w| ≤ cap where w switches with the sign of ψ.
    for k, control in enumerate(controls):
        if control.cap == inf:
            continue
        integral = control.cap * np.sum(absolute_pieces(lagrangian, k)[1], axis=1)
        total = total - integral - control.cap * lagrangian.psi_error[:, k]
        magnitude = magnitude + integral + control.cap * lagrangian.psi_magnitude[:, k]
    #    Where a mean square of all laws is capped, less what they can make of it together.
    if any(control.cap == inf for control in controls):
        together = _least_under_mean_square(lagrangian)
        total, magnitude = total + together, magnitude - together
    total = total - unknown_initial_values(lagrangian, [largest_integral(c) for c in controls])
    # 3. What is left of the size: linear, so least at an end of each range.
    low, high = np.array(sizes).T / lagrangian.model.scales.size
    total = total + np.sum(np.minimum(lagrangian.size * low, lagrangian.size * high), axis=1)
    magnitude = magnitude + lagrangian.size_magnitude @ np.maximum(np.abs(low), np.abs(high))
    # 4. Less an allowance for rounding, in proportion to all that was added up.
    return np.where(np.isfinite(total), total - ROUNDING * magnitude, -np.inf)


def lagrangian_of(
    model: ConicModel, quantities: Quantities, multipliers: Array, costates: Array
) -> Lagrangian:
    """The quantities, and the rows times their multipliers projected on λ ≥ 0."""
    z, first = np.array(multipliers), model.program.equalities
    last = first + model.program.inequalities
    z[:, first:last] = np.maximum(z[:, first:last], 0.0)
    order = costates.shape[2]
    lagrangian = Lagrangian(model, order, len(z))
    lagrangian.size += quantities.size
    lagrangian.size_magnitude += np.abs(quantities.size)
    for k in range(len(model.grids)):
        mine = np.flatnonzero(quantities.law == k)
        weights = np.zeros((len(z), len(mine), order))
        weights[mine, np.arange(len(mine))] = quantities.alpha[mine, :order]
        lagrangian.add_functionals(k, quantities.x[mine], weights)
    multiplied = np.any(z, axis=0)
    for one in row_functionals(model, order):
        used = np.flatnonzero(multiplied[one.first_row : one.first_row + one.count])
        if len(used):
            lagrangian.add_rows(one.point_rows(used), z[:, one.first_row + used])
    vibrations, lagrangian.psi_error = vibration_terms(
        model, order, model.vibration_multipliers(z), len(z)
    )
    for rows, mass in (*fixed_size_rows(model, z), *vibrations):
        lagrangian.add_rows(rows, mass)
    lagrangian.reduce()
    lagrangian.add_boundary_costates(project_costates(model, lagrangian.initial_costates, costates))
    return lagrangian


def _least_under_mean_square(lagrangian: Lagrangian) -> Array:
    """The least of Σ ∫ ψ w over all controls with Σ W ∫ w² ≤ room: −√(room Σ ∫ ψ²/W), (q,).

    By Cauchy and Schwarz, with equality where every w is −ψ/W times one number. The multiplier of
    the cap is the best one, whatever the solver's is. What rounding or a vibration adds to ψ adds
    no more than its largest value to √∫ ψ², which is a norm.
    """
    held = ((cone.energy, cone.room) for cone in lagrangian.model.cone_blocks)
    ((weights, room),) = ((energy.weights, room) for energy, room in held if energy is not None)
    squares = np.zeros(lagrangian.count)
    for k, weight in enumerate(weights):
        blur = lagrangian.psi_error[:, k] + ROUNDING * lagrangian.psi_magnitude[:, k]
        squares += (root_mean_squares(lagrangian, k) + blur) ** 2 / weight
    return np.asarray(-np.sqrt(room * squares))


def root_mean_squares(lagrangian: Lagrangian, position: int) -> Array:
    """√∫ ψ² of one law, (q,): Gauss's rule is exact, and a sum of squares loses no digits."""
    breaks, poly = lagrangian.psi_pieces(position)
    s, shares = (each[0] for each in gauss_points(np.array([0.0, 1.0]), NODES))
    value = poly @ s ** np.arange(poly.shape[2])[:, None]
    return np.asarray(np.sqrt(np.einsum("qns,s,n->q", value**2, shares, np.diff(breaks))))


def largest_integral(control: Control) -> float:
    """What |∫ (x − τ)²/2 w dτ| is at most: by the cap, or by Schwarz's inequality."""
    return 0.5 * control.cap if control.cap < inf else sqrt(control.square)


def absolute_pieces(lagrangian: Lagrangian, position: int) -> tuple[Array, Array]:
    """∫ |ψ| of one law, piece by piece: breaks (n+1,) and integrals (q, n)."""
    breaks, poly = lagrangian.psi_pieces(position)
    flat = poly.reshape(-1, poly.shape[2])
    if poly.shape[2] > 3:
        shares = mean_absolute(flat).reshape(poly.shape[:2])
        return breaks, shares * np.diff(breaks)
    parabolas = np.zeros((len(flat), 3))
    parabolas[:, : flat.shape[1]] = flat
    shares = mean_absolute(parabolas, exact=True).reshape(poly.shape[:2])
    return breaks, shares * np.diff(breaks)
