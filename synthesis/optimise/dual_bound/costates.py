"""Costates of the end values, for a mean square: those that make the bound largest.

The bound is concave in the costates of g^(k)(1), k < m, law by law, and its gradient is by how much
the ideal law's end misses what it has to be; so Newton's method finds them, in one step where
nothing caps the law. The solver's own costates come from the last few coefficients of the spline,
and what is uncertain there grows with the third power of the knots.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import factorial

import numpy as np

from synthesis.numerics.piecewise import Array
from synthesis.optimise.conic.control import Control
from synthesis.optimise.conic.program import ConicModel
from synthesis.optimise.dual_bound.switching import NODES, SHARES, Switching
from synthesis.optimise.problem.boundary import junction_rows

STEPS = 30
SETTLED = 1e-14


@dataclass(frozen=True, eq=False)
class _Law:
    """One free law as a function of its end costates.

    Attributes:
        weights: (n,) weights of the integral over [0, 1] at Gauss points.
        psi: (n,) ψ there, from the rows alone.
        costate_effect: (m, n) what the costate of g^(k)(1) adds to ψ.
        constant: (m,) what that costate adds to the bound besides the integral.
    """

    control: Control
    weights: Array
    psi: Array
    costate_effect: Array
    constant: Array

    def value(self, costates: Array) -> tuple[float, Array, Array]:
        """The bound's share, its gradient and its Hessian."""
        weight, cap = self.control.weight, self.control.cap
        psi = self.psi + costates @ self.costate_effect
        w = np.clip(-psi / (2.0 * weight), -cap, cap)
        free = self.weights * (np.abs(w) < cap) / (2.0 * weight)
        value = self.constant @ costates + np.sum(self.weights * (weight * w**2 + psi * w))
        gradient = self.constant + self.costate_effect @ (self.weights * w)
        return float(value), gradient, -(self.costate_effect * free) @ self.costate_effect.T


def boundary_costates(
    model: ConicModel,
    controls: Sequence[Control],
    psi: Sequence[Switching],
    state: Sequence[Array],
    initial_costates: Sequence[Array],
) -> list[Array]:
    """Prices (m,) of g^(k)(1) for every free law, at which unknown initial values are worthless.

    Args:
        model: the model.
        controls: of every law, each with a weight.
        psi: of every law, from its rows alone; not needed where no mean square is weighed.
        state: per law, (m,) factors of unknown initial values that its rows leave.
        initial_costates: the solver's costates, good enough where no mean square is weighed.
    """
    if not model.grids:
        return []
    # 1. Costates are free but for the junctions: unknown values that two laws share must leave the
    #    Lagrangian, or its minimum over them would be −∞. Start at the nearest that comply.
    matrix, rhs = _junction_conditions(model, controls[0].order, state)
    initial = np.concatenate(initial_costates)
    costates = (
        initial + _minimum_norm_solution(matrix, rhs - matrix @ initial) if len(rhs) else initial
    )
    if not all(control.weight for control in controls):
        return list(costates.reshape(len(controls), -1))
    # 2. Newton's method on a concave function, its steps in the null space of these conditions. A
    #    step that does not raise the bound is halved: any costates give a valid bound, so that it
    #    can stop at any time.
    laws = [_law(model, k, *both) for k, both in enumerate(zip(controls, psi, strict=True))]
    costates = _minimum_norm_solution(matrix, rhs)
    value, gradient, hessian = _total(laws, costates)
    for _ in range(STEPS):
        step = _newton(gradient, hessian, matrix)
        share, before = 1.0, value
        while share > 1e-6 and (result := _total(laws, costates + share * step))[0] <= before:
            share *= 0.5
        if share <= 1e-6:
            break
        costates = costates + share * step
        value, gradient, hessian = result
        if value - before <= SETTLED * abs(value):
            break
    return list(costates.reshape(len(laws), -1))


def _law(model: ConicModel, position: int, control: Control, psi: Switching) -> _Law:
    order, boundary = control.order, model.boundary_states[position]
    cuts = np.union1d(psi.breaks, np.linspace(0.0, 1.0, 65))
    width = np.diff(cuts)[:, None]
    tau = (cuts[:-1, None] + width * (NODES + 1.0) / 2.0).ravel()
    powers = [(1.0 - tau) ** (order - 1 - k) / factorial(order - 1 - k) for k in range(order)]
    constant = np.zeros(order)
    for k in range(order):
        for j in range(k, min(len(boundary.start), order)):
            constant[k] += boundary.start[j] / factorial(j - k)
    count = min(len(boundary.end), order)
    constant[:count] -= boundary.end[:count]
    return _Law(control, (width * SHARES / 2.0).ravel(), psi(tau), np.stack(powers), constant)


def _junction_conditions(
    model: ConicModel, order: int, state: Sequence[Array]
) -> tuple[Array, Array]:
    """matrix · costates = rhs: unknown initial values leave the Lagrangian at every junction."""
    rows, rhs = [np.zeros((0, len(model.grids) * order))], []
    for junction in model.junctions:
        before, after = junction_rows(junction, model.problem.free, model.grids)
        for k in range(junction.lowest, min(junction.highest + 1, order)):
            row = np.zeros((len(model.grids), order))
            for j in range(k + 1):
                row[junction.after, j] = 1.0 / factorial(k - j)
            at = k - junction.lowest
            row[junction.before, k] += after.units[at] / before.units[at]
            rows.append(row.reshape(1, -1))
            rhs.append(-float(state[junction.after][k]))
    return np.vstack(rows), np.array(rhs)


def _total(laws: Sequence[_Law], costates: Array) -> tuple[float, Array, Array]:
    """Value, gradient and Hessian of all laws together."""
    table = costates.reshape(len(laws), -1)
    parts = [law.value(row) for law, row in zip(laws, table, strict=True)]
    order = table.shape[1]
    hessian = np.zeros((len(costates), len(costates)))
    for k, (_, _, block) in enumerate(parts):
        hessian[k * order : (k + 1) * order, k * order : (k + 1) * order] = block
    return sum(p[0] for p in parts), np.concatenate([p[1] for p in parts]), hessian


def _newton(gradient: Array, hessian: Array, matrix: Array) -> Array:
    """The step to the top of the quadratic model that keeps matrix · costates."""
    n, rows = len(gradient), len(matrix)
    system = np.zeros((n + rows, n + rows))
    system[:n, :n] = hessian - 1e-14 * np.trace(np.abs(hessian)) * np.eye(n)
    system[:n, n:], system[n:, :n] = matrix.T, matrix
    return _minimum_norm_solution(system, np.concatenate([-gradient, np.zeros(rows)]))[:n]


def _minimum_norm_solution(matrix: Array, rhs: Array) -> Array:
    """The shortest of the solutions."""
    return np.asarray(np.linalg.lstsq(matrix, rhs, rcond=None)[0], dtype=float)
