"""Lower bounds of many quantities at once, over every motion law and size that keep a model's rows.

Each quantity is linear in one law, at a point, and in the size. Multipliers of the rows, one set
for each quantity, add the rows to it; what is left is least for a law that switches with the sign
of ψ and for a size at the ends of its ranges. It is the duality of ``bound``, for capped laws and
without an objective, in a few operations on tables: hundreds of bounds cost what one costs there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from synthesis.numerics.piecewise import Array
from synthesis.optimise.conic.control import Control
from synthesis.optimise.conic.program import ConicModel
from synthesis.optimise.dual_bound.bound import ROUNDING, unknown_initial_values
from synthesis.optimise.dual_bound.costates import end_coefficients, end_costates, project_costates
from synthesis.optimise.dual_bound.lagrangian import Lagrangian
from synthesis.optimise.dual_bound.nonlinear_terms import fixed_size_rows
from synthesis.optimise.dual_bound.row_functionals import row_functionals
from synthesis.optimise.dual_bound.switching import mean_absolute

ORDER = 3  # of the control: only capped jerks are handled here


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

    def objectives(self, model: ConicModel) -> list[Array]:
        """The same as objectives of the model's program, but for constants: one (n,) each."""
        result = np.zeros((len(self.x), model.program.matrix.shape[1]))
        result[:, model.size] = self.size
        for position in np.unique(self.law):
            mine, rows = self.rows_of_law(model, position)
            result[mine, model.columns[position]] = model.boundary_states[position].split(rows)[0]
        return list(result)

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


def solve_boundary_costates(model: ConicModel, quantities: Quantities, multipliers: Array) -> Array:
    """The solver's costates of g, g' and g'' at the end of every law: (q, laws, 3)."""
    gradients = []
    for position in range(len(model.grids)):
        last = end_coefficients(model, position)
        mine, rows = quantities.rows_of_law(model, position)
        gradients.append(np.zeros((len(multipliers), rows[:, last].shape[1])))
        gradients[-1][mine] = rows[:, last]
    return end_costates(model, multipliers, gradients, ORDER)


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
        model: rows that hold. controls: caps of every free law's third derivative.
        sizes: ranges of the size variables [length].
        quantities: the quantities.
        multipliers: (q, m) of the model's rows without its cones; any, good ones bound well.
        costates: (q, laws, 3) costates of the laws' ends (``solve_boundary_costates``); any.
    """
    # 1. The quantities and the rows times their multipliers: linear in all unknowns.
    lagrangian = _lagrangian(model, quantities, multipliers, costates)
    total, magnitude = lagrangian.constant, lagrangian.magnitude
    # 2. Least over every law: ∫ ψ w with |w| ≤ cap where w switches with the sign of ψ.
    for k, control in enumerate(controls):
        integral = control.cap * np.sum(_absolute_pieces(lagrangian, k)[1], axis=1)
        total = total - integral
        magnitude = magnitude + integral + control.cap * lagrangian.psi_magnitude[:, k]
    total = total - unknown_initial_values(lagrangian, [0.5 * c.cap for c in controls])
    # 3. What is left of the size: linear, so least at an end of each range.
    low, high = np.array(sizes).T / model.scales.size
    total = total + np.sum(np.minimum(lagrangian.size * low, lagrangian.size * high), axis=1)
    magnitude = magnitude + lagrangian.size_magnitude @ np.maximum(np.abs(low), np.abs(high))
    # 4. Less an allowance for rounding, in proportion to all that was added up.
    return np.where(np.isfinite(total), total - ROUNDING * magnitude, -np.inf)


def switching_functions(
    model: ConicModel, quantities: Quantities, multipliers: Array, costates: Array
) -> list[tuple[Array, Array]]:
    """∫ |ψ| of every law, piece by piece: breaks (n+1,) and integrals (q, n)."""
    lagrangian = _lagrangian(model, quantities, multipliers, costates)
    return [_absolute_pieces(lagrangian, k) for k in range(len(model.grids))]


def _lagrangian(
    model: ConicModel, quantities: Quantities, multipliers: Array, costates: Array
) -> Lagrangian:
    """The quantities, and the rows times their multipliers projected on λ ≥ 0."""
    z = np.array(multipliers[:, : model.program.equalities + model.program.inequalities])
    z[:, model.program.equalities :] = np.maximum(z[:, model.program.equalities :], 0.0)
    lagrangian = Lagrangian(model, ORDER, len(z))
    lagrangian.size += quantities.size
    lagrangian.size_magnitude += np.abs(quantities.size)
    for k in range(len(model.grids)):
        mine = np.flatnonzero(quantities.law == k)
        weights = np.zeros((len(z), len(mine), ORDER))
        weights[mine, np.arange(len(mine))] = quantities.alpha[mine]
        lagrangian.add_functionals(k, quantities.x[mine], weights)
    for one in row_functionals(model, ORDER):
        if one.block.highest_order < ORDER:
            own = z[:, one.first_row : one.first_row + one.count]
            lagrangian.add_rows(one.point_rows(), own)
    for rows, mass in fixed_size_rows(model, z):
        lagrangian.add_rows(rows, mass)
    lagrangian.reduce()
    lagrangian.add_boundary_costates(project_costates(model, lagrangian.initial_costates, costates))
    return lagrangian


def _absolute_pieces(lagrangian: Lagrangian, position: int) -> tuple[Array, Array]:
    """∫ |ψ| of one law, piece by piece: breaks (n+1,) and integrals (q, n)."""
    breaks, poly = lagrangian.psi_pieces(position)
    shares = mean_absolute(poly.reshape(-1, ORDER), exact=True).reshape(poly.shape[:2])
    return breaks, shares * np.diff(breaks)
