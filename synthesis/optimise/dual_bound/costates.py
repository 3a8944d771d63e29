"""Costates: the multipliers of g, g', …, g^(m−1) at the end of every law.

End conditions are equalities, so that any costates give a valid bound as long as what the
Lagrangian is left with of unknown values vanishes: the minimum over them would be −∞ otherwise
(``stationarity_conditions``). Three ways to choose them: those of the solver, read off the
stationarity of the last spline coefficients (``boundary_multipliers``); the nearest to these that
meet the conditions (``project_costates``); and, of a mean square, the best (``best_costates``).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import factorial

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag

from synthesis.numerics.piecewise import Array, gauss_points
from synthesis.numerics.solvers.clarabel import ConeSolution
from synthesis.optimise.conic.control import Control
from synthesis.optimise.conic.program import ConicModel
from synthesis.optimise.dual_bound.lagrangian import shared_derivatives
from synthesis.optimise.dual_bound.switching import NODES, Switching
from synthesis.optimise.problem.boundary import junction_rows

NOISE = 1e-10
"""Of the largest multiplier: an interior point gives rows that do not bind about as much."""
STEPS = 30
"""Of Newton's method: one without a cap, a few where the cap is active on a part of the law."""
GAIN = 1e-14  # relative gain of the bound below which a step is the last: rounding
REGULAR = 1e-14  # of the trace: where the cap is active all along a law its Hessian is singular
LEAST_STEP = 1e-6  # of a Newton step: below it, rounding hides whether the bound rises

Mask = NDArray[np.bool_]


def nonnegative_multipliers(model: ConicModel, solution: ConeSolution) -> Array:
    """The multipliers (m,) with those of inequalities projected on λ ≥ 0, and noise set to zero.

    An interior point gives every row a multiplier; most are of rows far from binding, and cost time
    only. Multipliers of cones are brought into the dual cone where they are used. Rows that speak
    of the size are left out where no bound may rest on it: then it holds for every size.
    """
    z, first = solution.multipliers.copy(), model.program.equalities
    last = first + model.program.inequalities
    own, conic = z[first:last], z[last:]
    noise = NOISE * float(own.max(initial=0.0))
    own[own <= noise] = 0.0
    conic[np.abs(conic) <= noise] = 0.0
    if model.problem.for_every_size:
        z[rows_of_size(model)] = 0.0
    return z


def rows_of_size(model: ConicModel) -> Mask:
    """Which rows of a program speak of the size: (m,)."""
    return np.asarray(np.diff(model.program.matrix[:, model.size].tocsr().indptr) > 0)


def boundary_multipliers(
    model: ConicModel, solution: ConeSolution, order: int, z: Array | None = None
) -> Array:
    """The solver's costates of g to g^(order − 1) at the end of every law: (1, laws, order)."""
    z = nonnegative_multipliers(model, solution) if z is None else z
    gradients = [np.zeros((1, len(boundary.end))) for boundary in model.boundary_states]
    if model.energy is not None:
        laws, _ = model.recover(solution.x)
        for k, (factor, law) in enumerate(zip(model.energy.factors, laws, strict=True)):
            root = factor @ law.coefficients
            last = end_coefficients(model, k)
            gradients[k] += 2.0 / model.energy.unit * root @ factor[:, last]
    return end_costates(model, z[None], gradients, order)


def end_costates(model: ConicModel, z: Array, gradients: Sequence[Array], order: int) -> Array:
    """The costates (q, laws, order) that multipliers (q, m) imply.

    Those of known values make the eliminated last coefficients stationary; those of values that
    two laws share are the multipliers of their junction's rows. ``gradients``: of all but rows,
    vibrations, mean squares held and junctions in every law's last coefficients, (q, r) each.
    """
    costates = np.zeros((len(z), len(gradients), order))
    last = [end_coefficients(model, position) for position in range(len(gradients))]
    gradients = list(gradients)
    for vibration, y in model.vibration_multipliers(z):
        for share, of_law in zip(vibration.law_terms, vibration.rows, strict=True):
            law = share.position
            gradients[law] = gradients[law] + y @ of_law[:, last[law]]
    at = model.program.equalities + model.program.inequalities
    for cone in model.cone_blocks:
        own, at = z[:, at + 1 : at + 1 + len(cone.shift)], at + 1 + len(cone.shift)
        for law, factor in enumerate(cone.energy.factors if cone.energy is not None else ()):
            mine, own = own[:, : len(factor)], own[:, len(factor) :]
            gradients[law] = gradients[law] - mine @ factor[:, last[law]] / cone.room**0.5
    for at, block in model.numbered_blocks:
        own, k = z[:, at : at + len(block.rhs)], block.segment
        if block.law_matrix is not None and k is not None and np.count_nonzero(own):
            gradients[k] = gradients[k] + own @ block.law_matrix[:, last[k]]
    at = 0
    for junction in model.junctions:
        before, after = junction_rows(junction, model.problem.free, model.grids)
        mu = z[:, at : at + len(before.units)]
        at += len(before.units)
        for side in (before, after):
            k = side.position
            gradients[k] = gradients[k] + mu @ side.dense[:, last[k]]
        shared = (mu * before.units)[:, : max(order - junction.lowest, 0)]
        columns = slice(junction.lowest, junction.lowest + shared.shape[1])
        costates[:, junction.before, columns] = shared
    for k, (gradient, grid) in enumerate(zip(gradients, model.grids, strict=True)):
        known = grid.space.end_multipliers(gradient)[:, :order]
        costates[:, k, : known.shape[1]] = known
    return costates


def end_coefficients(model: ConicModel, position: int) -> slice:
    """The coefficients of a law that follow from its known end."""
    return slice(model.grids[position].space.size - len(model.boundary_states[position].end), None)


def stationarity_conditions(model: ConicModel, order: int) -> tuple[Array, Mask, Mask]:
    """What costates have to meet: matrix · costates + initial costates = 0.

    Returns:
        matrix: (r, laws·order), for every unknown initial value what the costates of its own law
            come to in it, and those of the law before that shares it.
        unknown: (laws, order), which initial values are unknown, row by row.
        priced: (laws, order), which costates there are: of end values that are known or shared.
    """
    laws, table = len(model.grids), np.zeros((len(model.grids), order, len(model.grids), order))
    unknown, priced = np.zeros((2, laws, order), dtype=bool)
    for position, boundary in enumerate(model.boundary_states):
        table[position, :, position] = _end_values(order)
        unknown[position, len(boundary.start) :] = True
        priced[position, : len(boundary.end)] = True
    for before, after, k, ratio in shared_derivatives(model, order):
        table[after, k, before, k] += ratio
        priced[before, k] = True
    return (table[unknown] * priced).reshape(unknown.sum(), laws * order), unknown, priced


def project_costates(model: ConicModel, initial_costates: Array, near: Array) -> Array:
    """The nearest costates (q, laws, m) at which the factors of unknown initial values vanish."""
    if all(len(boundary.start) >= near.shape[2] for boundary in model.boundary_states):
        return near  # all initial values are known
    matrix, unknown, priced = stationarity_conditions(model, near.shape[2])
    flat = near.reshape(len(near), -1)
    step = _minimum_norm_solution(matrix, -(initial_costates[:, unknown] + flat @ matrix.T).T)
    return near + step.T.reshape(near.shape) * priced


def best_costates(
    model: ConicModel,
    controls: Sequence[Control],
    psi: Sequence[Switching],
    given: Array,
    start: Array | None = None,
) -> Array:
    """The costates (1, laws, m) that make the bound of a mean square largest.

    The bound is concave in them, and its gradient is by how much the ideal law's end misses what it
    has to be. The solver's own come from the last few coefficients of the spline, and what is
    uncertain there grows with the third power of the knots. ``psi``: of the rows alone; ``given``:
    (1, laws, m) factors of initial values that they leave. ``start``: (1, laws, m), None for the
    smallest that meet the conditions.
    """
    # Newton's method on a concave function, its steps in the null space of the conditions. A step
    # that does not raise the bound is halved: any costates give a valid bound, so that it can stop
    # at any time.
    matrix, unknown, priced = stationarity_conditions(model, controls[0].order)
    bound = _CostateFunction.of(model, controls, psi)
    costates = _minimum_norm_solution(matrix, -given[0, unknown])
    costates = costates if start is None else start.ravel()
    value, gradient, hessian = bound(costates)
    for _ in range(STEPS):
        # to the top of the quadratic model, with matrix · costates kept
        size = len(gradient)
        regular = hessian - REGULAR * np.trace(np.abs(hessian)) * np.eye(size)
        system = np.block([[regular, matrix.T], [matrix, np.zeros((len(matrix),) * 2)]])
        rhs = np.concatenate([-gradient, np.zeros(len(matrix))])
        step = _minimum_norm_solution(system, rhs)[:size] * priced.ravel()
        share, before = 1.0, value
        while share > LEAST_STEP and (new := bound(costates + share * step))[0] <= before:
            share *= 0.5
        if share <= LEAST_STEP:
            break
        costates = costates + share * step
        value, gradient, hessian = new
        if value - before <= GAIN * abs(value):
            break
    return np.asarray(costates.reshape(given.shape))


@dataclass(frozen=True, eq=False)
class _CostateFunction:
    """The bound of a mean square as a function of the end costates of all laws (laws·m,).

    Attributes:
        shares, psi, weight, cap: (n,) at the Gauss points of all laws: weights of the integrals,
            ψ from the rows alone, weight and cap of the control.
        effect: (laws·m, n) what each costate adds to ψ.
        constant: (laws·m,) what it adds to the bound besides the integrals.
    """

    shares: Array
    psi: Array
    weight: Array
    cap: Array
    effect: Array
    constant: Array

    @classmethod
    def of(
        cls, model: ConicModel, controls: Sequence[Control], psi: Sequence[Switching]
    ) -> _CostateFunction:
        order = controls[0].order
        columns, effects, constant = [], [], np.zeros((len(controls), order))
        for control, own, boundary, added in zip(
            controls, psi, model.boundary_states, constant, strict=True
        ):
            cuts = np.union1d(own.breaks, np.linspace(0.0, 1.0, 65))
            tau, shares = (each.ravel() for each in gauss_points(cuts, NODES))
            one = np.ones(len(tau))
            columns.append(np.stack([shares, own(tau), control.weight * one, control.cap * one]))
            powers = [(1.0 - tau) ** n / factorial(n) for n in range(order - 1, -1, -1)]
            effects.append(np.stack(powers))
            start, end = boundary.start[:order], boundary.end[:order]
            added += start @ _end_values(order)[: len(start)]
            added[: len(end)] -= end
        shares, values, weight, cap = np.concatenate(columns, axis=1)
        return cls(shares, values, weight, cap, block_diag(*effects), constant.ravel())

    def __call__(self, costates: Array) -> tuple[float, Array, Array]:
        """The bound, its gradient and its Hessian."""
        psi = self.psi + costates @ self.effect
        w = np.clip(-psi / (2.0 * self.weight), -self.cap, self.cap)
        free = self.shares * (np.abs(w) < self.cap) / (2.0 * self.weight)
        value = self.constant @ costates + np.sum(self.shares * (self.weight * w**2 + psi * w))
        gradient = self.constant + self.effect @ (self.shares * w)
        return float(value), gradient, -(self.effect * free) @ self.effect.T


def _end_values(order: int) -> Array:
    """What a polynomial's j-th derivative at 0 comes to in its k-th one at 1: (m, m) of j and k."""
    return np.array(
        [[1.0 / factorial(j - k) if k <= j else 0.0 for k in range(order)] for j in range(order)]
    )


def _minimum_norm_solution(matrix: Array, rhs: Array) -> Array:
    """The shortest of the solutions."""
    return np.asarray(np.linalg.lstsq(matrix, rhs, rcond=None)[0], dtype=float)
