"""Lower bounds of many quantities over all laws and sizes that keep a model's rows.

1. The multipliers: a linear program for every quantity over the model's splines, by the simplex
   method; where laws share a mean square, a cone program.
2. The bounds: those of these multipliers over all laws (``dual_bound``), whatever they are.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import inf

import numpy as np
from scipy import sparse

from synthesis.numerics import clock
from synthesis.numerics.piecewise import Array, Mask
from synthesis.numerics.solvers import clarabel, highs
from synthesis.numerics.solvers.clarabel import ConeProgram
from synthesis.numerics.solvers.highs import LinearRows
from synthesis.numerics.solvers.statuses import USABLE, StopReason
from synthesis.optimise.conic.control import Control
from synthesis.optimise.conic.linear_rows import LinearBlock
from synthesis.optimise.conic.program import ConicModel, with_rows
from synthesis.optimise.dual_bound.batch import Quantities, dual_bounds, solve_boundary_costates
from synthesis.optimise.dual_bound.costates import rows_of_size
from synthesis.optimise.dual_bound.multiplier_density import MultiplierDensity, PointRuns
from synthesis.optimise.propagation.half_spaces import LOOSENING, cone_tangents
from synthesis.optimise.propagation.improving_region import Sizes

NO_MINIMUM = frozenset({StopReason.INFEASIBLE, StopReason.UNBOUNDED})
SPREAD = 12  # points between two rows over which multipliers are distributed


def bound_quantities(
    model: ConicModel,
    controls: Sequence[Control],
    sizes: Sizes,
    quantities: Quantities,
    until: float = inf,
) -> Array | None:
    """Lower bounds (q,) of quantities over all laws and sizes that keep a model's rows.

    Args:
        model: rows without an objective. controls: caps of the free laws' controls, of one order.
        sizes: ranges of the size, besides. until: ``clock.now()`` at which to stop.

    Returns:
        the bounds; None where the mesh has no spline under the rows.
    """
    sizes = box_within_cones(model, sizes)
    tangents = [each for cone in model.cone_blocks for each in cone_tangents(model, cone, sizes)]
    return lower_bounds(model, tangents, [], controls, sizes, quantities, until)


def lower_bounds(
    model: ConicModel, rows: Sequence[LinearBlock],
    denser: Sequence[tuple[LinearBlock, PointRuns | None]], controls: Sequence[Control],
    sizes: Sizes, quantities: Quantities, until: float, last_program: float = inf,
    enough: Array | None = None,
) -> Array | None:  # fmt: skip
    """Lower bounds of quantities (q,) under a model's rows and more of them.

    ``denser``: the last of these rows at more points. ``enough``: (q,) values that bounds need not
    exceed; −∞ where a quantity comes down to its own.
    """
    wanted, units = quantities.scaled()
    # 1. A program for each: its multipliers, at the points where rows are written.
    enough = None if enough is None else enough / units
    solved = _solve_each(model, rows, wanted, sizes, until, last_program, enough)
    if solved is None:
        return None
    full, z, sought = solved
    wanted, z = wanted.select(sought), z[sought]
    # 2. The same, distributed along arcs where rows bind: true multipliers are densities there.
    order = controls[0].order
    between = MultiplierDensity.of(full, denser, SPREAD, order)
    ends = solve_boundary_costates(full, wanted, z, order)
    masses = between.distribute(wanted, z, ends)
    # 3. Their bound over all laws, whatever the multipliers are: the better one. It is loosened by
    #    what is done with it may lose by rounding.
    values, result = np.maximum(*(
        dual_bounds(between.model, controls, sizes, wanted, each, ends)
        for each in (masses, between.balance(masses, z, order))
    )), np.full(len(units), -inf)  # fmt: skip
    result[sought] = values - LOOSENING * np.maximum(np.abs(values), 1.0)
    return np.asarray(result * units)


def caps_mean_square(model: ConicModel) -> bool:
    """Whether a cone couples the laws, so that programs are no linear ones."""
    return any(cone.energy is not None for cone in model.cone_blocks)


def _solve_each(
    model: ConicModel, rows: Sequence[LinearBlock], wanted: Quantities, sizes: Sizes, until: float,
    last_program: float, enough: Array | None,
) -> tuple[ConicModel, Array, Mask] | None:  # fmt: skip
    """The model with more rows, their multipliers (q, m) at the least of every quantity, and which
    of these were sought.

    None where a program has no minimum. Where bounds are to hold for every size, rows that speak of
    it have none.
    """
    sought = np.ones(len(wanted.x), dtype=bool)
    if caps_mean_square(model):
        full = with_rows(model, [*_box_rows(sizes, model.scales.size), *rows])
        objectives, _ = wanted.objectives(full)
        z = _cone_multipliers(full.program, list(objectives), until, last_program)
    else:
        full = with_rows(model, rows)
        objectives, constants = wanted.objectives(full)
        least = None if enough is None else enough - constants
        found = _linear_multipliers(full, objectives, sizes, until, least)
        z, sought = (None, sought) if found is None else found
    if z is None:
        return None
    if full.problem.for_every_size:
        z[:, rows_of_size(full)] = 0.0
    return full, z, sought


def _box_rows(sizes: Sizes, unit: float) -> list[LinearBlock]:
    """Ranges of the size, far ends over their own size; of those that leave no choice none."""
    return [
        LinearBlock.of_size(sign * axis / far, np.array([sign * end / unit / far]), "box")
        for axis, ends in zip(np.eye(len(sizes)), sizes, strict=True)
        for sign, end in ((1.0, ends[1]), (-1.0, ends[0]))
        if ends[0] < ends[1]
        for far in (max(abs(end) / unit, 1.0),)
    ]


def _cone_multipliers(
    program: ConeProgram, objectives: Sequence[Array], until: float, last_program: float
) -> Array | None:
    """Multipliers (q, m) of a program's rows for each objective; None where one has no minimum.

    Where the budget ends, 0 for the rest: they are valid too, and what is known stays.
    """
    result = clarabel.minimise_each(program, objectives, until - clock.now(), last_program)
    if result[-1].stopped is StopReason.OUT_OF_TIME:
        result.pop()
    if not result or result[-1].stopped not in USABLE:
        return None
    known = np.stack([each.multipliers for each in result])
    return np.pad(known, ((0, len(objectives) - len(known)), (0, 0)))


def _linear_multipliers(
    model: ConicModel, objectives: Array, sizes: Sizes, until: float, enough: Array | None
) -> tuple[Array, Mask] | None:  # fmt: skip
    """The same of linear programs, with a box in place of every cone and the size in its own.

    Where the simplex method fails, 0 for the rest too. And which objectives were sought: not those
    that a point brings down to ``enough`` (q,), so that they have no larger bound.
    """
    program = model.program
    infinite = np.full(program.matrix.shape[1], inf)
    low, high = -infinite, infinite.copy()
    low[model.size], high[model.size] = (np.array(sizes) / model.scales.size).T
    rows = _linear_rows(program, low, high)
    result = highs.minimise_each(rows, objectives, until - clock.now(), enough=enough)
    if result[-1].stopped in NO_MINIMUM:
        return None
    if result[-1].stopped not in (StopReason.SOLVED, StopReason.NOT_NEEDED):
        result.pop()
    known, sought = np.zeros((len(objectives), len(rows.rhs))), np.ones(len(objectives), dtype=bool)
    for k, each in enumerate(result):
        known[k], sought[k] = each.multipliers, each.stopped is StopReason.SOLVED
    return _of_cones(program, known), sought


def _linear_rows(program: ConeProgram, low: Array, high: Array) -> LinearRows:
    """A program's rows, low ≤ x ≤ high, and in place of every cone ‖w‖ ≤ r the box |w_k| ≤ r."""
    count = program.equalities + program.inequalities
    parts, rhs, at = [program.matrix[:count]], [program.rhs[:count]], count
    for length in program.cones:
        # w = rhs − matrix · x in the rows below the first, whose right-hand side is r
        matrix, known = program.matrix[at + 1 : at + length], program.rhs[at + 1 : at + length]
        parts += [-matrix, matrix]
        rhs += [program.rhs[at] - known, program.rhs[at] + known]
        at += length
    matrix = sparse.csc_matrix(sparse.vstack(parts)) if program.cones else parts[0]
    return LinearRows(matrix, np.concatenate(rhs), program.equalities, low, high)


def _of_cones(program: ConeProgram, z: Array) -> Array:
    """Multipliers (q, …) of these rows as those of the program: of a cone (‖y‖, −y) each."""
    count = program.equalities + program.inequalities
    parts, at = [z[:, :count]], count
    for length in program.cones:
        above, below = z[:, at : at + length - 1], z[:, at + length - 1 : at + 2 * length - 2]
        y, at = above - below, at + 2 * length - 2
        parts += [np.linalg.norm(y, axis=1, keepdims=True), -y]
    return np.hstack(parts)


def box_within_cones(model: ConicModel, sizes: Sizes) -> Sizes:
    """The box within the cones on the size."""
    result = np.array(sizes, dtype=float)
    for cone in model.cone_blocks:
        if cone.bound_column is not None or cone.norm is None or len(cone.shift) != len(sizes):
            continue
        matrix = cone.matrix[:, model.size]
        if abs(np.linalg.det(matrix)) < LOOSENING:
            continue
        inverse = np.linalg.inv(matrix)
        centre = -inverse @ cone.shift
        reach = (1.0 + LOOSENING) * cone.radius * np.linalg.norm(inverse, axis=1)
        ends = model.scales.size * np.stack([centre - reach, centre + reach], axis=1)
        result = np.stack(
            [np.maximum(result[:, 0], ends[:, 0]), np.minimum(result[:, 1], ends[:, 1])], axis=1
        )
    return tuple((float(low), float(high)) for low, high in result)
