"""The bound over the splines of a mesh, where nothing caps or weighs a derivative of all laws."""

from __future__ import annotations

from math import sqrt

import numpy as np

from synthesis.numerics.piecewise import Array
from synthesis.numerics.solvers.clarabel import ConeSolution
from synthesis.optimise.conic.program import ConicModel
from synthesis.optimise.dual_bound.costates import nonnegative_multipliers
from synthesis.optimise.recovery.closed_form import inverse_matrix

FAMILY_BOX = 10.0
"""Coefficients of a law that may overshoot lie within this, so the family of splines is said."""
WORSE = 2.0
"""Factor on the solution's objective: no cam whose energy or norm is larger has to be covered."""


def family_name(model: ConicModel) -> str:
    """What a bound covers that holds over splines alone, or of given laws."""
    parts = {f"degree {g.space.degree} on {len(g.space.breaks) - 1} intervals" for g in model.grids}
    wild = any(law.free is not None and law.free.overshoot for law in model.problem.free)
    far = f", overshooting by {FAMILY_BOX - 1.0:g} lifts at most" if wild else ""
    return "splines of " + " and ".join(sorted(parts)) + far if parts else "the given laws"


def spline_family_bound(model: ConicModel, solution: ConeSolution) -> float:
    """A bound over the splines of the model's mesh, where no control is known.

    The dual objective, less what its residual r could gain: |r| · box (``_family_box``). Dual
    cones: the head of a cone's multiplier is raised to the norm of its tail.
    """
    program, z, x = model.program, nonnegative_multipliers(model, solution), solution.x
    rhs, at = program.rhs.copy(), program.equalities
    # the right-hand sides of the limits themselves, without the tightening for the solver
    for block in model.blocks:
        own = slice(at, at + len(block.rhs))
        rhs[own] += block.tightening
        z[own], at = np.maximum(z[own], 0.0), own.stop
    for cone in model.cone_blocks:
        rhs[at] += cone.radius * cone.tightening
        z[at] = max(z[at], float(np.linalg.norm(z[at + 1 : at + 1 + len(cone.shift)])))
        at += 1 + len(cone.shift)
    curved = program.quadratic @ x  # its matrix is diagonal
    residual = curved + program.linear + program.matrix.T @ z
    box, worst = _family_box(model, solution)
    value = -0.5 * x @ curved - rhs @ z - np.abs(residual) @ box
    return min(float(value), worst)


def _family_box(model: ConicModel, solution: ConeSolution) -> tuple[Array, float]:
    """What the unknowns of cams are at most that have a value of the program up to ``worst``.

    Cams above that value need no bound. Coefficients of laws that never move backwards rise from 0
    to 1; the size is in its ranges, or out of what a bound may rest on; the epigraph and the terms
    of a mean square are no larger than the value allows.
    """
    x, problem = solution.x, model.problem
    worst = WORSE * max(model.program.value(x), 0.0)
    box = np.full(len(x), max(worst, 0.0))
    for columns, segment in zip(model.columns, problem.free, strict=True):
        wild = segment.free is not None and segment.free.overshoot
        box[columns] = FAMILY_BOX if wild else 1.0
    sizes = np.abs(np.array(problem.sizing.bounds)).max(axis=1) / model.scales.size
    norm = problem.objective.norm(problem.machine)
    if norm is not None and len(norm.matrix) == np.shape(norm.matrix)[1]:
        shift = float(np.linalg.norm(norm.shift)) / model.scales.size
        sizes = np.minimum(sizes, np.linalg.norm(inverse_matrix(norm.matrix), 2) * (worst + shift))
    box[model.size] = 0.0 if problem.for_every_size else sizes
    box[model.energy_columns] = sqrt(worst)
    return box, worst
