"""A lower bound over all motion laws, from the multipliers of a cone program over splines.

Symbols: g is a law on [0, 1], w = g^(m) its control (the derivative that is capped or weighed,
m = 2 or 3), ζ the size over its unit, π the objective's level over its unit, λ the multipliers,
ν the costates at the end of a law, ψ the switching function.

Why the bound is valid over all laws (weak duality):

1. Every row Σ_k alpha_k g^(k)(x_i) + a_i · ζ + b_i π ≤ c_i is a limit written at a point, so that
   every admissible law satisfies it, not only a spline; or it follows from limits in a region
   outside of which no cam is better than the incumbent (``conic.tangent_cuts``). With any λ ≥ 0
   the Lagrangian

       L = objective + Σ λ_i (Σ_k alpha_k g^(k)(x_i) + a_i · ζ + b_i π − c_i)

   is therefore at most the objective, at every admissible law, size and level. Multipliers of
   equalities, the costates ν among them, may have either sign.
2. By Taylor's formula with integral remainder g^(k)(x) = Σ_j g^(k+j)(0) x^j/j! + ∫ (x − τ)^(m−1−k)
   / (m−1−k)! w(τ) dτ over τ < x. So L = constant + initial costates · (g, g', …)(0) + ∫ ψ w dτ
   + r · ζ + …, linear in all unknowns (``lagrangian``).
3. The minimum over all laws with |w| ≤ cap is taken pointwise: −cap ∫ |ψ|; with a weighed control
   ∫ min (weight w² + ψ w): the objective weighs it, or the multiplier of a capped mean square. Over
   the size it lies at the ends of its ranges, or is taken up by the dual norm of the objective.
   Known initial values are constants; unknown ones have their costates made to vanish, and what is
   left of them is paid for.

The solver's multipliers are used as numbers and not trusted: its errors cost tightness, never
validity. Rounding of the sums is paid for too: ``ROUNDING`` times the sum of the absolute values of
all terms.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import inf, sqrt

import numpy as np

from synthesis.numerics.piecewise import Array
from synthesis.numerics.solvers.clarabel import ConeSolution
from synthesis.optimise.conic.control import (
    Control,
    law_controls,
    mean_square_caps,
    weighed_controls,
)
from synthesis.optimise.conic.program import ConicModel
from synthesis.optimise.dual_bound import row_functionals as terms
from synthesis.optimise.dual_bound.arcs import (
    density_terms,
    redistribute_window_multipliers,
    with_densities_of_control,
)
from synthesis.optimise.dual_bound.costates import (
    best_costates,
    boundary_multipliers,
    nonnegative_multipliers,
    project_costates,
)
from synthesis.optimise.dual_bound.lagrangian import Lagrangian
from synthesis.optimise.dual_bound.sensitivity import neighbour
from synthesis.optimise.dual_bound.spline_family import WORSE, family_name, spline_family_bound
from synthesis.optimise.dual_bound.switching import Switching, absolute_integrals
from synthesis.optimise.dual_bound.vibration_terms import vibration_terms
from synthesis.optimise.problem.problem import Problem
from synthesis.optimise.recovery.closed_form import inverse_matrix

ROUNDING = 1e-12
"""Relative to the sum of absolute values: sums of 1e3 terms are in error by 1e3 · 1.1e-16."""
INITIAL_VALUE_BOUND = 12.0
"""|g'(0)| and |g''(0)| of a law from 0 to 1 are at most this times 1 + R: see where it is used."""
RAYS = (1e2, 1e4, 1e6)
"""Factors on an infeasibility certificate: any multiple of it is dual feasible."""
NAMES = {2: "acceleration", 3: "jerk"}


@dataclass(frozen=True, eq=False)
class Bound:
    """A lower bound of the objective [problem units], and what it covers.

    Attributes:
        valid_for: the cams that it covers, in words.
        switching: ψ of every free law; empty where all laws are given, and where the bound covers a
            spline family only.
        order: m, the highest derivative that is capped or weighed: the control of every law.
        controls: the caps and weights of every free law, caps at the level found.
        of_neighbour: the bound of another problem by the same multipliers (``sensitivity``), None
            where its rows are others; None where that is not to be had.
    """

    value: float
    valid_for: str
    switching: tuple[Switching, ...] = ()
    controls: tuple[Control, ...] = ()
    of_neighbour: Callable[[Problem], Bound | None] | None = None

    @property
    def order(self) -> int:
        """m, the derivative that is the control."""
        return self.controls[0].order if self.controls else 3


def dual_bound(model: ConicModel, solution: ConeSolution, costates: Array | None = None) -> Bound:
    """The lower bound that the multipliers of a solution give, of its problem and of neighbours.

    Any multipliers give a valid one: over all laws; over the splines of the model's mesh alone
    where nothing caps or weighs a derivative of every law. ``costates``: (1, laws, m), needed where
    the rows at hand are those that were solved at many more points (``MultiplierDensity``); None:
    those of ``boundary_multipliers``.
    """
    bound = _bound_of_multipliers(model, solution, costates)
    again = None if costates is not None else partial(_bound_of_neighbour, model, solution)
    return replace(bound, of_neighbour=again)


def _bound_of_neighbour(
    model: ConicModel, solution: ConeSolution, problem: Problem
) -> Bound | None:
    """The bound of another problem by the same multipliers; None where its rows are others."""
    other = neighbour(model, problem)
    return None if other is None else dual_bound(other, solution)


def _bound_of_multipliers(
    model: ConicModel, solution: ConeSolution, costates: Array | None
) -> Bound:
    """``dual_bound`` of the model's own problem."""
    controls, dense = law_controls(model), costates is not None
    # Dual feasibility: λ ≥ 0 of inequalities. Noise is left out, which is valid and saves time.
    z = nonnegative_multipliers(model, solution)
    if controls is None:
        controls = weighed_controls(model, mean_square_caps(model, z))
    densities = with_densities_of_control(model, z) if controls is None and not dense else None
    controls = law_controls(densities[0]) if densities is not None else controls
    if densities is not None and controls is not None:
        costates, dense = boundary_multipliers(model, solution, controls[0].order, z), True
        model, z = densities
    if controls is None and dense:
        return Bound(-inf, family_name(model))  # rows that are not solved bound no splines
    if controls is None:
        value = spline_family_bound(model, solution)
        return Bound(in_problem_units(model, value), family_name(model))
    order = controls[0].order if controls else 3
    if costates is None:
        costates = boundary_multipliers(model, solution, order, z)
    rows = list(terms.row_functionals(model, order, z))
    bound = _bound_of_rows(model, solution, controls, costates, z, rows, dense=dense)
    if dense or not any(one.may_be_density for one in rows):
        return bound
    # Where a limit binds along an arc, once more with multipliers for which ψ is small there.
    flat = _bound_of_rows(
        model, solution, controls, costates, z, rows, dense=False, psi=bound.switching
    )
    # Knots go on the switches of the multipliers as they were: along such an arc the other ψ is
    # nearly zero, and where it changes sign means nothing.
    return replace(bound, value=max(bound.value, flat.value))


def _bound_of_rows(
    model: ConicModel,
    solution: ConeSolution,
    controls: Sequence[Control],
    costates: Array,
    z: Array,
    rows: Sequence[terms.RowFunctional],
    *,
    dense: bool,
    psi: Sequence[Switching] = (),
) -> Bound:
    """The bound of multipliers z (m,); ``psi``: what they come to, for them to be moved by."""
    # The Lagrangian: every term that is multiplied, as a functional of arbitrary laws.
    order = controls[0].order if controls else 3
    lagrangian = Lagrangian(model, order)
    multipliers = model.vibration_multipliers(z[None])
    vibrations, lagrangian.psi_error = vibration_terms(model, order, multipliers)
    for other, mass in (*terms.energy_tangents(model, solution, order), *vibrations):
        lagrangian.add_rows(other, mass)
    # Rows act at their points, or as densities between these.
    for one in rows:
        own = z[one.first_row : one.first_row + one.count]
        points, nodes, masses = one.distribute(own, dense=dense)
        nonzero = points != 0.0
        lagrangian.add_rows(one.point_rows(nonzero), points[nonzero])
        for density, mass in density_terms(one, nodes, masses, psi):
            lagrangian.add_rows(density, mass)
    rooms = terms.mean_square_rooms(model, mean_square_caps(model, z))
    for other, mass in (*terms.fixed_size_rows(model, z), *terms.cone_rows(model, z), *rooms):
        lagrangian.add_rows(other, mass)
    # End conditions are equalities, so that costates are free: those that make the bound largest.
    add_costates(lagrangian, controls, costates)
    redistribute_window_multipliers(lagrangian)
    return bound_from_lagrangian(solution, lagrangian, controls)


def infeasibility_bound(model: ConicModel, solution: ConeSolution, ends: Array) -> Bound:
    """The best bound from an infeasibility certificate: it grows with any multiple of it."""
    rays = (replace(solution, multipliers=scale * solution.multipliers) for scale in RAYS)
    bounds = (dual_bound(model, ray, k * ends) for ray, k in zip(rays, RAYS, strict=True))
    return max(bounds, key=lambda bound: bound.value)


def add_costates(lagrangian: Lagrangian, controls: Sequence[Control], near: Array) -> Array:
    """Add the end conditions, with the nearest valid costates; of a mean square with the best.

    Returns the costates: (q, laws, m).
    """
    lagrangian.reduce()
    model, given = lagrangian.model, lagrangian.initial_costates
    if controls and all(control.weight for control in controls):
        costates = best_costates(model, controls, lagrangian.psi(), given)
    else:
        costates = project_costates(model, given, near)
    lagrangian.add_boundary_costates(costates)
    return costates


def bound_from_lagrangian(
    solution: ConeSolution, lagrangian: Lagrangian, controls: Sequence[Control]
) -> Bound:
    """The bound that a Lagrangian gives, minimised over all laws, sizes and levels."""
    lagrangian.reduce()
    model, psi = lagrangian.model, lagrangian.psi()
    total = _minimum(solution, lagrangian, controls, psi)
    valid_for = all_laws(lagrangian.order) if controls else family_name(model)
    level = 0.0 if model.epigraph is None else abs(float(solution.x[model.epigraph]))
    result = tuple(replace(c, cap=c.rate * level) if c.rate else c for c in controls)
    return Bound(in_problem_units(model, total), valid_for, psi, result)


def all_laws(order: int) -> str:
    """What a bound with a control of some order covers."""
    return f"all motion laws with a bounded {NAMES[order]}"


def in_problem_units(model: ConicModel, value: float) -> float:
    """The program's objective as a value of the quantity that is minimised."""
    if model.energy is not None:
        return sqrt(max(value * model.energy.unit + model.energy.constant, 0.0))
    if model.problem.objective.norm(model.problem.machine) is not None:
        return value * model.scales.size
    return value * model.scales.level


def _minimum(
    solution: ConeSolution,
    lagrangian: Lagrangian,
    controls: Sequence[Control],
    psi: Sequence[Switching],
) -> float:
    """The minimum of the Lagrangian, after scaling the multipliers to be dual feasible."""
    model, objective = lagrangian.model, lagrangian.model.problem.objective
    # 1. Over the laws: −cap ∫ |ψ|, or the integral of min (weight w² + ψ w).
    if all(control.weight for control in controls):
        area = [0.0 for _ in psi]  # the level caps no control
        capped = sum(p.least_integral(c.cap, c.weight) for p, c in zip(psi, controls, strict=True))
    else:
        area = absolute_integrals(psi)
        capped = -sum(c.cap * a for a, c in zip(area, controls, strict=True))
    total: float = float(lagrangian.constant[0]) + capped
    total -= ROUNDING * (float(lagrangian.magnitude[0]) + abs(capped))
    # 2. Unknown initial values, and what rounding and vibration may add to ψ.
    if np.count_nonzero(lagrangian.initial_costates):
        integrals = _control_integrals(model, solution, controls)
        total -= float(unknown_initial_values(lagrangian, integrals)[0])
    blur = ROUNDING * lagrangian.psi_magnitude[0] + lagrangian.psi_error[0]
    total -= sum(
        each * (c.cap if c.cap < inf else (p.magnitude_bound + each) / (2.0 * c.weight))
        for each, p, c in zip(blur, psi, controls, strict=True)
    )
    # 3. Over the size and the level.
    total = minimum_over_sizes(solution, lagrangian, total)
    norm = objective.norm(model.problem.machine)
    if norm is not None or model.energy is not None:
        return total
    price = level_price(lagrangian)
    for a, c, each in zip(area, controls, blur, strict=True):
        price += c.rate * (each + a)
    return total / price if price > 0.0 else 0.0


def minimum_over_sizes(solution: ConeSolution, lagrangian: Lagrangian, total: float) -> float:
    """The minimum over all sizes of a Lagrangian that comes to ``total`` over laws.

    Of a norm it is the bound; else the level is still to be taken care of (``level_price``).
    """
    model = lagrangian.model
    norm = model.problem.objective.norm(model.problem.machine)
    bounds = np.array(model.problem.sizing.bounds) / model.scales.size
    size, magnitude = lagrangian.size[0], lagrangian.size_magnitude[0]
    reach = np.max(np.abs(bounds), axis=1)
    if norm is not None:
        # ‖Mζ + m‖ ≥ y·(Mζ + m) for ‖y‖ ≤ 1: y takes up what the rows leave of ζ
        matrix, shift = np.array(norm.matrix), np.array(norm.shift) / model.scales.size
        if len(matrix) == matrix.shape[1]:
            inverse = inverse_matrix(norm.matrix)
            y = -size @ inverse
            # of sizes with a norm larger than this nothing is to be shown
            largest = abs(float(solution.x[model.epigraph])) + float(np.linalg.norm(shift))
            reach = np.minimum(reach, WORSE * np.linalg.norm(inverse, 2) * largest)
        else:  # all but what the norm does not speak of: that is least at one end of its range
            y = np.linalg.lstsq(matrix.T, -size, rcond=None)[0]
            rest = size + matrix.T @ y
            total += float(np.sum(np.min(rest[:, None] * bounds, axis=1)))
        shrink = 1.0 / max(1.0, float(np.linalg.norm(y)))
        return float(shrink * (total + y @ shift - ROUNDING * (magnitude @ reach)))
    if not model.problem.for_every_size:
        total += float(np.sum(np.min(size[:, None] * bounds, axis=1)))
        return total - ROUNDING * float(magnitude @ reach)
    # of sizes beyond those that are searched nothing is known
    return -inf if size.any() else total


def level_price(lagrangian: Lagrangian) -> float:
    """What the rows charge for a unit of the level, but for what it caps on the laws."""
    level = float(lagrangian.level[0])
    return abs(level) * ROUNDING - level


def _control_integrals(
    model: ConicModel, solution: ConeSolution, controls: Sequence[Control]
) -> list[float]:
    """What |∫ (x−τ)²/2 w dτ| of every law is at most, up to twice the solution's energy."""
    energy = 0.0
    if model.energy is not None:
        laws, _ = model.recover(solution.x)
        for factor, law in zip(model.energy.factors, laws, strict=True):
            energy += float(np.sum((factor @ law.coefficients) ** 2))
    result = []
    held = mean_square_caps(model, solution.multipliers)
    for position, control in enumerate(controls):
        reach = control.cap / 2.0 if control.cap < inf else 0.0
        if control.weight and model.energy is None:
            reach += sqrt(held[0].room / held[0].weights[position])
        if control.rate and model.epigraph is not None:
            reach += control.rate * abs(float(solution.x[model.epigraph]))
        if control.weight and model.energy is not None:
            reach += sqrt(WORSE * energy / model.energy.weights[position])
        result.append(reach)
    return result


def unknown_initial_values(lagrangian: Lagrangian, integrals: Sequence[float]) -> Array:
    """What unknown initial values could gain from a residual that is not exactly zero: (q,).

    For g in [0, 1] with R (``integrals``) at least |∫ (x−τ)²/2 w dτ|: |g'(0)| ≤ 7 + 7R and
    |g''(0)| ≤ 12 + 12R (from Taylor's formula at 1/2 and 1).
    """
    lost = np.zeros(lagrangian.count)
    for position, (segment, r) in enumerate(
        zip(lagrangian.model.problem.free, integrals, strict=True)
    ):
        rest = np.abs(lagrangian.initial_costates[:, position]).sum(axis=1)
        assert segment.free is not None
        if segment.free.overshoot:
            lost[rest > 0.0] = inf
        else:
            lost += rest * INITIAL_VALUE_BOUND * (1.0 + r)
    return lost
