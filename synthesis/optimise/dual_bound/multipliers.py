"""From the multipliers of a cone program to those of the bound over all laws.

Three changes. Any λ ≥ 0, any multipliers of equalities and any costates give a valid bound, so that
each is allowed: noise is set to zero (``nonnegative_multipliers``); costates of the end values that
the program has eliminated are read off its stationarity (``boundary_multipliers``); multipliers of
a value that is held along a window are spread so that ψ is small there (``window_multipliers``).
"""

from __future__ import annotations

from math import factorial

import numpy as np

from synthesis.numerics.piecewise import Array
from synthesis.numerics.solvers.clarabel import ConeSolution
from synthesis.optimise.conic.program import ConicModel
from synthesis.optimise.dual_bound.switching import Switching
from synthesis.optimise.problem.boundary import junction_rows

NOISE = 1e-10
"""Of the largest multiplier: an interior point gives rows that do not bind about as much."""
NODES = 33
"""Chebyshev points of a window on which its multipliers are spread."""
SAMPLES = 3
"""Between two nodes, at which ψ is made small."""


def nonnegative_multipliers(model: ConicModel, solution: ConeSolution) -> Array:
    """The multipliers (m,) with those of inequalities projected on λ ≥ 0, and noise set to zero.

    An interior point gives every row a multiplier; most are of rows far from binding, and cost time
    only. Multipliers of cones are brought into the dual cone where they are used.
    """
    z, first = solution.multipliers.copy(), model.program.equalities
    last = first + model.program.inequalities
    own, conic = z[first:last], z[last:]
    noise = NOISE * float(own.max(initial=0.0))
    own[own <= noise] = 0.0
    conic[np.abs(conic) <= noise] = 0.0
    return z


def boundary_multipliers(
    model: ConicModel, solution: ConeSolution, z: Array, order: int
) -> list[Array]:
    """The solver's costates of g to g^(order − 1) at the end of every law: (order,) each.

    Those of known values make the eliminated last coefficients stationary; those of values that
    two laws share are the multipliers of their junction's rows.

    Args:
        z: the multipliers, as ``nonnegative_multipliers``.
    """
    gradients = _gradients(model, solution, z)
    costates = [np.zeros(max(order, len(each))) for each in gradients]
    at = 0
    for junction in model.junctions:
        before, after = junction_rows(junction, model.problem.free, model.grids)
        mu = z[at : at + len(before.units)]
        at += len(mu)
        for side in (before, after):
            gradients[side.position] += mu @ side.dense[:, _last(model, side.position)]
        shared = (mu * before.units)[: max(order - junction.lowest, 0)]
        costates[junction.before][junction.lowest : junction.lowest + len(shared)] = shared
    for nu, gradient, grid in zip(costates, gradients, model.grids, strict=True):
        nu[: len(gradient)] = grid.space.end_multipliers(gradient)
    return [nu[:order] for nu in costates]


def _gradients(model: ConicModel, solution: ConeSolution, z: Array) -> list[Array]:
    """The gradient of the Lagrangian in every law's last coefficients, junctions left out."""
    result = [np.zeros(len(boundary.end)) for boundary in model.boundary_states]
    last = [_last(model, position) for position in range(len(result))]
    for at, block in model.active_blocks(z):
        if block.law_matrix is not None and block.segment is not None:
            own = z[at : at + len(block.rhs)]
            result[block.segment] += own @ block.law_matrix[:, last[block.segment]]
    for vibration, y in model.vibration_multipliers(z):
        for share, rows in zip(vibration.law_terms, vibration.rows, strict=True):
            result[share.position] += y @ rows[:, last[share.position]]
    if model.energy is not None:
        laws, _ = model.recover(solution.x)
        for k, (factor, law) in enumerate(zip(model.energy.factors, laws, strict=True)):
            root = factor @ law.coefficients
            result[k] += 2.0 / model.energy.unit * root @ factor[:, last[k]]
    return result


def _last(model: ConicModel, position: int) -> slice:
    """The coefficients of a law that follow from its known end."""
    return slice(model.grids[position].space.size - len(model.boundary_states[position].end), None)


def window_multipliers(
    psi: Switching, x: Array, part: tuple[float, float], factor: float, degree: int
) -> tuple[Array, Array]:
    """Masses to add to a held derivative's multipliers that make ψ small on its window.

    Where a derivative is held, the control is determined and ψ should vanish. The multipliers of a
    spline's rows make it small only on average over the splines; between them it oscillates, and
    the bound pays for the area. Masses without moments up to ``degree`` leave ψ as it is elsewhere.

    Args:
        psi: ψ as it stands. x: (r,) points of the present multipliers. part: the window.
        factor: of the derivative in its rows.
        degree: a mass at x contributes factor (x − τ)^degree / degree! to ψ, for τ < x.

    Returns:
        (n,) points and (n,) masses, whose moments up to that degree vanish.
    """
    low, high = part
    chebyshev = 0.5 - 0.5 * np.cos(np.pi * np.arange(NODES) / (NODES - 1))
    nodes = np.unique(np.clip(np.append(x, low + (high - low) * chebyshev), low, high))
    width = np.diff(nodes)
    shares = (np.arange(SAMPLES) + 0.5) / SAMPLES
    tau = (nodes[:-1, None] + width[:, None] * shares).ravel()
    weight = np.sqrt(np.repeat(width / (high - low), SAMPLES))
    unit = (high - low) ** degree / factorial(degree)
    reach = np.maximum(nodes - tau[:, None], 0.0) / (high - low)
    effect = weight[:, None] * (reach**degree if degree else (nodes > tau[:, None]))
    scaled = (nodes - low) / (high - low)
    moments = np.vander(scaled, degree + 1, increasing=True).T
    *_, directions = np.linalg.svd(moments)
    free = directions[degree + 1 :].T  # masses without moments
    result, *_ = np.linalg.lstsq(effect @ free, -weight * psi(tau), rcond=1e-10)
    return nodes, (free @ result) / (factor * unit)
