"""Optimality-based bound tightening of an improving region, law by law.

1. For every law: bounds of the size in directions all round, each the dual bound of a linear
   program over that law, the laws coupled to it, and the size (a relaxation of the whole problem).
2. The half-spaces so found hold for the size of every better cam: they are intersected and shared.
3. For every law: bounds of the traced point and of s'' at nodes, from below and from above, by the
   same dual bounds with the shared half-spaces.

``bound_quantities`` gives such bounds of any quantities over all laws at once.

A dual bound holds over all laws, so that no better cam is removed. Time and memory grow with the
number of laws, not with its square.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from math import inf

import numpy as np
from scipy import sparse

from synthesis.numerics import clock
from synthesis.numerics.piecewise import Array
from synthesis.numerics.solvers import clarabel, highs
from synthesis.numerics.solvers.clarabel import ConeProgram
from synthesis.numerics.solvers.highs import LinearRows
from synthesis.numerics.solvers.statuses import USABLE, StopReason
from synthesis.optimise.conic.control import Control
from synthesis.optimise.conic.linear_rows import LinearBlock
from synthesis.optimise.conic.program import ConicModel, with_rows
from synthesis.optimise.conic.subprogram import coupled_laws, submodel, without_size_rows
from synthesis.optimise.dual_bound.batch import (
    MultiplierDensity,
    PointRuns,
    Quantities,
    dual_bounds,
    solve_boundary_costates,
)
from synthesis.optimise.dual_bound.costates import rows_of_size
from synthesis.optimise.propagation.half_spaces import (
    LOOSENING,
    HalfSpaces,
    cone_tangents,
    directions_around,
)
from synthesis.optimise.propagation.improving_region import ImprovingRegion, Sizes

NO_MINIMUM = frozenset({StopReason.INFEASIBLE, StopReason.UNBOUNDED})
SPREAD = 12  # points between two rows over which multipliers are distributed


def tighten_bounds(
    model: ConicModel,
    controls: Sequence[Control],
    region: ImprovingRegion,
    positions: Collection[int],
    time_limit: float = inf,
    last_program: float = inf,
    *,
    laws: bool = True,
) -> tuple[ImprovingRegion, frozenset[int]]:
    """The region, tightened under the model's rows and those that the region implies.

    Args:
        model: rows that every better cam satisfies, without an objective.
        controls: caps of the free laws' controls, of one order.
        positions: positions of the laws to be bounded.
        time_limit: seconds after which nothing more is bounded.
        last_program: ``clock.programs_solved()`` at which the same holds of cone programs.

    Returns:
        the region, and the laws for which the mesh has no spline under the rows, so that nothing
        was bounded; where time ended, all laws that were left.
    """
    until = clock.now() + time_limit
    region = replace(region, sizes=_box_within_cones(model, region.sizes))
    tangents = [
        block for cone in model.cone_blocks for block in cone_tangents(model, cone, region.sizes)
    ]
    infeasible, half_spaces = set[int](), list[HalfSpaces]()
    parts = {
        k: _LawSubproblem.of(model, k, controls, tangents, region, last_program) for k in positions
    }
    # 1. How far the size of a better cam lies in directions all round, by every law.
    directions = directions_around(region.sizes)
    count = len(directions)
    sizes = Quantities(
        np.zeros(count, dtype=int), np.zeros(count), np.zeros((count, 3)),
        model.scales.size * directions,
    )  # fmt: skip
    for k, part in parts.items() if count else ():
        values = part.lower_bounds(sizes, region, until)
        if values is None:
            infeasible.add(k)
        else:
            half_spaces.append(HalfSpaces(directions, values))
    # 2. The half-spaces of all laws hold together.
    if half_spaces:
        region = _intersect_half_spaces(region, directions, half_spaces)
    # 3. The traced point at the nodes of every law.
    for k in sorted({k for k, _ in region.point_bounds} & set(positions) - infeasible):
        if region.is_empty or not laws:
            break
        quantities, constants = _point_quantities(region, k, parts[k].law, parts[k].model)
        values = parts[k].lower_bounds(quantities, region, until, size_is_bounded=True)
        if values is None:
            infeasible.add(k)
        else:
            region = _tighten_point_bounds(region, k, values + constants)
    return region, frozenset(infeasible)


@dataclass(frozen=True, eq=False)
class _LawSubproblem:
    """A law and those that share derivatives with it.

    Attributes:
        model: their rows, and those of the size alone.
        law: number of the law to be bounded. controls: of all of them.
        implied, denser: rows of curvature at their points, and between these.
        last_program: ``clock.programs_solved()`` at which no more cone programs are begun.
    """

    model: ConicModel
    law: int
    controls: tuple[Control, ...]
    implied: list[LinearBlock]
    denser: list[tuple[LinearBlock, PointRuns | None]]
    last_program: float

    @classmethod
    def of(
        cls,
        whole: ConicModel,
        position: int,
        controls: Sequence[Control],
        more: Sequence[LinearBlock],
        region: ImprovingRegion,
        last_program: float,
    ) -> _LawSubproblem:
        """Of a model, with more rows of the size, and those that a region implies."""
        positions = coupled_laws(whole, position)
        part, own = with_rows(submodel(whole, positions), more), region.for_laws(positions)
        caps = tuple(controls[k] for k in positions)
        law = positions.index(position)
        rows = own.rows(part, SPREAD)
        implied, denser = [x for x, _, _ in rows], [(y, runs) for _, y, runs in rows]
        return cls(part, law, caps, implied, denser, last_program)

    def lower_bounds(
        self, quantities: Quantities, region: ImprovingRegion, until: float,
        *, size_is_bounded: bool = False,
    ) -> Array | None:  # fmt: skip
        """Lower bounds of quantities (q,) where better cams lie; None where there is no spline.

        ``size_is_bounded``: whether the region's half-spaces tell what the rows of the size do.
        """
        rows = [*region.half_spaces.blocks(self.model.scales.size), *self.implied]
        # every row costs a cone program as much, whether it binds or not
        spared = size_is_bounded and _caps_mean_square(self.model)
        model = without_size_rows(self.model) if spared else self.model
        return _lower_bounds(
            model, rows, self.denser, self.controls, region.sizes, quantities, until,
            self.last_program,
        )  # fmt: skip


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
    sizes = _box_within_cones(model, sizes)
    tangents = [each for cone in model.cone_blocks for each in cone_tangents(model, cone, sizes)]
    return _lower_bounds(model, tangents, [], controls, sizes, quantities, until)


def _lower_bounds(
    model: ConicModel, rows: Sequence[LinearBlock],
    denser: Sequence[tuple[LinearBlock, PointRuns | None]], controls: Sequence[Control],
    sizes: Sizes, quantities: Quantities, until: float, last_program: float = inf,
) -> Array | None:  # fmt: skip
    """Lower bounds of quantities (q,) under a model's rows and more of them.

    ``denser``: the last of these rows at more points.
    """
    wanted, units = quantities.scaled()
    # 1. A program for each: its multipliers, at the points where rows are written.
    solved = _solve_each(model, rows, wanted, sizes, until, last_program)
    if solved is None:
        return None
    full, z = solved
    # 2. The same, distributed along arcs where rows bind: true multipliers are densities there.
    order = controls[0].order
    between = MultiplierDensity.of(full, denser, SPREAD, order)
    ends = solve_boundary_costates(full, wanted, z, order)
    masses = between.distribute(wanted, z, ends)
    # 3. Their bound over all laws, whatever the multipliers are: the better one. It is loosened by
    #    what is done with it may lose by rounding.
    values = np.maximum(*(
        dual_bounds(between.model, controls, sizes, wanted, each, ends)
        for each in (masses, between.balance(masses, z, order))
    ))  # fmt: skip
    return np.asarray((values - LOOSENING * np.maximum(np.abs(values), 1.0)) * units)


def _caps_mean_square(model: ConicModel) -> bool:
    """Whether a cone couples the laws, so that programs are no linear ones."""
    return any(cone.energy is not None for cone in model.cone_blocks)


def _solve_each(
    model: ConicModel, rows: Sequence[LinearBlock], wanted: Quantities, sizes: Sizes, until: float,
    last_program: float,
) -> tuple[ConicModel, Array] | None:  # fmt: skip
    """The model with more rows, and their multipliers (q, m) at the least of every quantity.

    None where a program has no minimum. Where bounds are to hold for every size, rows that speak of
    it have none.
    """
    if _caps_mean_square(model):
        full = with_rows(model, [*_box_rows(sizes, model.scales.size), *rows])
        z = _cone_multipliers(full.program, wanted.objectives(full), until, last_program)
    else:
        full = with_rows(model, rows)
        z = _linear_multipliers(full, wanted.objectives(full), sizes, until)
    if z is not None and full.problem.for_every_size:
        z[:, rows_of_size(full)] = 0.0
    return None if z is None else (full, z)


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
    model: ConicModel, objectives: Sequence[Array], sizes: Sizes, until: float
) -> Array | None:
    """The same of linear programs, with a box in place of every cone and the size in its own.

    Where the simplex method fails, 0 for the rest too.
    """
    program = model.program
    infinite = np.full(program.matrix.shape[1], inf)
    low, high = -infinite, infinite.copy()
    low[model.size], high[model.size] = (np.array(sizes) / model.scales.size).T
    rows = _linear_rows(program, low, high)
    result = highs.minimise_each(rows, objectives, until - clock.now())
    if result[-1].stopped in NO_MINIMUM:
        return None
    if result[-1].stopped is not StopReason.SOLVED:
        result.pop()
    known = np.zeros((len(objectives), len(rows.rhs)))
    for each, own in zip(result, known, strict=False):
        own[:] = each.multipliers
    return _of_cones(program, known)


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


def _box_within_cones(model: ConicModel, sizes: Sizes) -> Sizes:
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


def _intersect_half_spaces(
    region: ImprovingRegion, directions: Array, half_spaces: Sequence[HalfSpaces]
) -> ImprovingRegion:
    """The region with the half-spaces of all its laws intersected."""
    every, axes = region.half_spaces.intersect(half_spaces), np.eye(len(region.sizes))
    low, high = every.minimise(np.concatenate([axes, -axes]), region.sizes).reshape(2, -1)
    sizes = tuple(
        (max(ends[0], float(a)), min(ends[1], -float(b)))
        for ends, a, b in zip(region.sizes, low, high, strict=True)
    )
    planes = HalfSpaces(directions, every.minimise(directions, region.sizes))
    return replace(region.restrict(sizes), half_spaces=planes)


def _point_quantities(
    region: ImprovingRegion, position: int, law: int, model: ConicModel
) -> tuple[Quantities, Array]:
    """X, u and perhaps s'' of a law at its nodes from below, then from above, and their constants.

    ``law``: its number in the model.
    """
    segment, scale = model.problem.free[law], model.scales.size
    x, alpha, size, constants = list[Array](), list[Array](), list[Array](), list[Array]()
    for sign in (1.0, -1.0):
        for coordinates, bounds in region.bounds_of_law(position):
            one = np.ones((len(bounds.nodes), 1))
            for order in range(len(bounds.low)):
                # X and u are sums of motion and size; s'' is the motion's alone.
                seen, known, share = 1.0, 0.0, np.zeros(len(region.sizes))
                if order < 2:
                    seen, known = coordinates.sign, coordinates.constants[order]
                    share = scale * np.array(coordinates.size_factors[order])
                if order == 0:
                    known += seen * segment.s_start
                factor = seen * segment.lift / segment.angle**order
                x.append(bounds.nodes)
                alpha.append(one * (sign * factor * np.eye(3)[order]))
                size.append(one * (sign * share))
                constants.append(one[:, 0] * sign * known)
    places = np.concatenate(x)
    laws = np.full(len(places), law)
    quantities = Quantities(laws, places, np.concatenate(alpha), np.concatenate(size))
    return quantities, np.concatenate(constants)


def _tighten_point_bounds(region: ImprovingRegion, position: int, values: Array) -> ImprovingRegion:
    """The region with bounds in the order of ``_point_quantities``, where they are tighter."""
    below, above = values.reshape(2, -1)
    point_bounds, at = dict(region.point_bounds), 0
    for coordinates, bounds in region.bounds_of_law(position):
        shape, stop = bounds.low.shape, at + bounds.low.size
        low = np.maximum(bounds.low, below[at:stop].reshape(shape))
        high = np.minimum(bounds.high, -above[at:stop].reshape(shape))
        point_bounds[position, coordinates] = replace(bounds, low=low, high=high)
        at = stop
    return replace(region, point_bounds=point_bounds)
