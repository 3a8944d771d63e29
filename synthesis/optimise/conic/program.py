"""One cone program over every free law's coefficients and the follower's size together.

Unknowns, all dimensionless:
    c   B-spline coefficients of g(x), 0 to 1 over x in [0, 1], for every free segment;
        s = s_start + h g, so s^(k) = h/β^k g^(k); those that a neighbour settles are left out
    ζ   size variables over the unit of size
    π   the objective's level P over its natural scale
    t   norm of the size over the unit of size
    y   the derivative whose mean square is the objective, at its Gauss points, over its unit;
        unknowns of their own, because the splines' matrices squared lose half of the digits
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import accumulate

import numpy as np
from scipy import sparse

from synthesis.numerics.double_double import round_mantissa
from synthesis.numerics.piecewise import Array
from synthesis.numerics.solvers.clarabel import ConeProgram
from synthesis.optimise.conic import linear_rows as rows
from synthesis.optimise.conic import tangent_cuts as cuts
from synthesis.optimise.conic.assembly import ConeBlock, MatrixBuilder
from synthesis.optimise.conic.linear_rows import LinearBlock, Scales, Tightening
from synthesis.optimise.conic.tangent_cuts import Region
from synthesis.optimise.problem.boundary import BoundaryState, Junction, boundary_states
from synthesis.optimise.problem.grid import TYPICAL, Grid, SplineLaw
from synthesis.optimise.problem.mean_square import Energy, energy
from synthesis.optimise.problem.problem import Problem
from synthesis.optimise.problem.residual_vibration import VibrationTerm, vibration_term

Vector = tuple[float, ...]
NO_TIGHTENING = Tightening()
HALF = 0.5  # of the slack between a cone and the nearest size that the bounds allow


@dataclass(frozen=True, eq=False)
class ConicModel:
    """The cone program, and what its unknowns and rows mean.

    Attributes:
        columns: unknown coefficients of every free law. size: size variables.
        epigraph: column of π or t, None where the objective is a mean square.
        energy_columns: columns of y, empty otherwise.
        equality_blocks: rows that are equalities, the last of the program's.
        blocks, cone_blocks: linear inequalities and cones, in the order of the program.
        vibration_equalities: runs after which no vibration may be left: two equalities each,
            right before ``equality_blocks``.
        energy: the objective where it is a mean square.
    """

    problem: Problem
    grids: tuple[Grid, ...]
    scales: Scales
    boundary_states: tuple[BoundaryState, ...]
    junctions: tuple[Junction, ...]
    columns: tuple[slice, ...]
    size: slice
    epigraph: int | None
    energy_columns: slice
    equality_blocks: tuple[LinearBlock, ...]
    blocks: tuple[LinearBlock, ...]
    cone_blocks: tuple[ConeBlock, ...]
    energy: Energy | None
    program: ConeProgram
    vibration_equalities: tuple[VibrationTerm, ...] = ()

    @cached_property
    def numbered_blocks(self) -> tuple[tuple[int, LinearBlock], ...]:
        """The blocks of equalities and of inequalities, each with the number of its first row."""
        blocks = (*self.equality_blocks, *self.blocks)
        first = self.program.equalities - sum(len(block.rhs) for block in self.equality_blocks)
        rows = accumulate((len(block.rhs) for block in blocks), initial=first)
        return tuple(zip(rows, blocks, strict=False))

    def recover(self, x: Array) -> tuple[list[SplineLaw], Vector]:
        """The laws and the size variables [length] at a point of the program."""
        laws = [
            SplineLaw(grid.space, boundary.expand(x[columns]))
            for grid, boundary, columns in zip(
                self.grids, self.boundary_states, self.columns, strict=True
            )
        ]
        return laws, tuple(float(v) for v in x[self.size] * self.scales.size)

    def point(self, laws: Sequence[SplineLaw], size: Vector) -> Array:
        """The point of the program that stands for these laws on its grids and this size."""
        x = np.zeros(self.program.matrix.shape[1])
        for law, grid, boundary, columns in zip(
            laws, self.grids, self.boundary_states, self.columns, strict=True
        ):
            coefficients = law.on(grid.space)
            x[columns] = coefficients[len(boundary.first) : grid.space.size - len(boundary.last)]
        x[self.size] = np.array(size) / self.scales.size
        if self.energy is not None:
            roots = [
                f @ law.on(g.space)
                for f, law, g in zip(self.energy.factors, laws, self.grids, strict=True)
            ]
            x[self.energy_columns] = np.concatenate([np.zeros(0), *roots]) / self.energy.unit**0.5
        norm = self.problem.objective.norm(self.problem.machine)
        if self.epigraph is not None and norm is not None:
            x[self.epigraph] = norm.value(size) / self.scales.size
        elif self.epigraph is not None:
            slack = self.program.rhs - self.program.matrix @ x
            column = self.program.matrix[:, [self.epigraph]].toarray().ravel()
            binding = column < 0.0
            x[self.epigraph] = max(np.max(-slack[binding] / -column[binding], initial=0.0), 0.0)
        return x

    def vibration_multipliers(self, z: Array) -> list[tuple[VibrationTerm, Array]]:
        """Of multipliers z (…, m) those of the two rows of every run with a limit: (…, 2)."""
        at = self.program.equalities - sum(len(block.rhs) for block in self.equality_blocks)
        at -= 2 * len(self.vibration_equalities)
        result = [
            (one, z[..., at + 2 * k : at + 2 * k + 2])
            for k, one in enumerate(self.vibration_equalities)
        ]
        at = self.program.equalities + self.program.inequalities
        for cone in self.cone_blocks:
            if cone.vibration is not None:
                result.append((cone.vibration, -z[..., at + 1 : at + 3]))
            at += 1 + len(cone.shift)
        return result


def formulate(
    problem: Problem,
    grids: Sequence[Grid],
    level: float = 0.0,
    tightening: Tightening = NO_TIGHTENING,
    region: Region | None = None,
    *,
    paired: bool = False,
) -> ConicModel:
    """State the problem on given grids.

    Args:
        level: trial level of a fractional objective [problem units], otherwise without effect.
        tightening: how far the rows are drawn in for the solver's sake.
        region: where curved limits are written as rows; None: all over what is allowed.
        paired: state rows that are equalities as two inequalities each, which may give way.
    """
    region = region or Region(problem.sizing.bounds)
    free = problem.free
    scales = natural_scales(problem)
    boundaries, junctions = boundary_states(problem.segments, grids)
    columns, at = [], 0
    for grid, boundary in zip(grids, boundaries, strict=True):
        columns.append(slice(at, at + grid.space.size - len(boundary.first) - len(boundary.last)))
        at = columns[-1].stop
    size = slice(at, at + len(problem.machine.follower.size_names))
    order = problem.objective.energy_order()
    extra = size.stop if order is None else None
    linear_blocks = list(
        _linear_blocks(problem, grids, boundaries, scales, level, tightening, region)
    )
    if paired:
        both = (block.inequalities() if block.exact else (block,) for block in linear_blocks)
        linear_blocks = [block for sides in both for block in sides]
    exact, blocks = (tuple(b for b in linear_blocks if b.exact is kind) for kind in (True, False))
    energetic = None if order is None else energy(problem.segments, grids, order)
    at = size.stop + (extra is not None)
    squares = slice(at, at + (0 if energetic is None else energetic.rows))
    writer = MatrixBuilder(squares.stop, columns, size, extra, boundaries)
    placed = (vibration_term(one, problem.segments, grids) for one in problem.vibration_limits)
    tighten = tightening.every_row
    vibrations = [writer.vibration_cone(one, tighten) for one in placed if one is not None]
    still = [] if paired else [cone for cone in vibrations if cone.radius == 0.0]
    sizes = _cone_blocks(problem, grids, writer, scales, tighten)
    cone_blocks = (*sizes, *(cone for cone in vibrations if cone not in still))
    for junction in junctions:
        writer.add_junction(junction, free, grids)
    writer.add_fixed_sizes(problem.sizing.bounds, scales)
    if energetic is not None:
        writer.add_energy(energetic, squares.start)
    for cone in still:
        writer.add_apex(cone)
    for block in exact:
        writer.add_block(block)
    equalities = writer.rows
    for block in blocks:
        writer.add_block(block)
    inequalities = writer.rows - equalities
    for cone in cone_blocks:
        writer.add_cone(cone)
    matrix, rhs = writer.build()
    # the extra unknown alone, or the sum of squares of y
    linear = np.zeros(squares.stop)
    if extra is not None:
        linear[extra] = 1.0
    program = ConeProgram(
        _sum_of_squares(squares.start, squares.stop), linear, matrix, rhs, equalities, inequalities,
        tuple(len(cone.shift) + 1 for cone in cone_blocks),
    )  # fmt: skip
    return ConicModel(
        problem, tuple(grids), scales, tuple(boundaries), tuple(junctions), tuple(columns), size,
        extra, squares, exact, blocks, cone_blocks, energetic, program,
        tuple(cone.vibration for cone in still if cone.vibration),
    )  # fmt: skip


def with_rows(model: ConicModel, more: Sequence[LinearBlock]) -> ConicModel:
    """The model with further inequalities, below those that it has."""
    if not more:
        return model
    program = model.program
    writer = MatrixBuilder(
        program.matrix.shape[1], model.columns, model.size, model.epigraph, model.boundary_states
    )
    for block in more:
        writer.add_block(block)
    result, bounds = writer.build()
    at = program.equalities + program.inequalities
    matrix = sparse.vstack([program.matrix[:at], result, program.matrix[at:]])
    longer = replace(
        program, matrix=sparse.csc_matrix(matrix),
        rhs=np.concatenate([program.rhs[:at], bounds, program.rhs[at:]]),
        inequalities=program.inequalities + writer.rows,
    )  # fmt: skip
    return replace(model, blocks=(*model.blocks, *more), program=longer)


def natural_scales(problem: Problem) -> Scales:
    """Natural units: of size the stroke or the least prime radius, of the level a good law's."""
    level = 0.0
    for segment in problem.segments:
        for row in problem.objective.rows(segment, problem.machine, 0.0):
            per_turn = abs(segment.lift) / segment.angle ** np.arange(4)
            level = max(level, float(np.max(np.abs(row.coefficients) * per_turn * TYPICAL)))
    return Scales(max(problem.length, problem.sizing.min_norm), level or 1.0)


def _linear_blocks(
    problem: Problem,
    grids: Sequence[Grid],
    boundaries: Sequence[BoundaryState],
    scales: Scales,
    level: float,
    tightening: Tightening,
    region: Region,
) -> Iterator[LinearBlock]:
    yield from _size_bounds(problem, scales)
    position = 0
    for segment in problem.segments:
        for row in problem.rows_on(segment, level):
            if segment.law is not None:
                block = rows.row_on_given_law(row, segment, scales, tightening.every_row)
                if block is not None:
                    yield block
            else:
                grid, boundary = grids[position], boundaries[position]
                yield rows.rows_on_law(row, position, segment, grid, boundary, scales, tightening)
        for curve in problem.curved_limits_on(segment):
            if segment.law is not None:
                yield from cuts.cuts_on_given_law(curve, segment, scales, tightening.every_row)
            else:
                grid = grids[position]
                yield from cuts.cuts_on_law(
                    curve, position, segment, grid, scales, tightening, region
                )
        if segment.law is None:
            assert segment.free is not None
            if not segment.free.overshoot:
                yield rows.monotonicity_rows(
                    position, grids[position], boundaries[position], tightening
                )
            position += 1


def _size_bounds(problem: Problem, scales: Scales) -> Iterator[LinearBlock]:
    """Upper and lower bounds of the size variables that are not fixed, one after the other."""
    rows, axes = [], np.eye(len(problem.sizing.bounds))
    for axis, (low, high) in zip(axes, problem.sizing.bounds, strict=True):
        for sign, end in ((1.0, high), (-1.0, low)) if low != high else ():
            # a far bound is divided by its size: the solver's tolerance is relative to the largest
            bound = sign * end / scales.size
            far = max(abs(bound), 1.0)
            rows.append([*(axis * (sign / far)), bound / far])
    if rows:
        table = round_mantissa(np.array(rows))
        yield LinearBlock.of_size(table[:, :-1], table[:, -1], "bounds")


def _cone_blocks(
    problem: Problem, grids: Sequence[Grid], writer: MatrixBuilder, scales: Scales, tighten: float
) -> Iterator[ConeBlock]:
    """Cones of the sizing, of limits, of the objective's norm, of objectives held."""
    machine = problem.machine
    for cone in problem.norm_bounds:
        # a ring no wider than the draw-in, a base radius that is given, must keep an inside
        slack = cone.upper - cone.norm.lower_bound(problem.sizing.bounds)
        drawn = min(tighten, HALF * max(slack, 0.0) / max(cone.upper, 1e-300))
        yield writer.norm_cone(cone.norm, scales.size, cone.upper, drawn, cone.source)
    norm = problem.objective.norm(machine)
    if norm is not None:
        yield writer.norm_cone(norm, scales.size, None)
    for earlier in problem.objective_caps:
        norm, order = earlier.objective.norm(machine), earlier.objective.energy_order()
        if norm is not None:
            yield writer.norm_cone(norm, scales.size, earlier.value)
        if order is not None:
            yield writer.energy_cone(energy(problem.segments, grids, order), earlier.value)


@lru_cache(maxsize=64)
def _sum_of_squares(start: int, width: int) -> sparse.csc_matrix:
    """P of the unknowns from a first one to the last: made once, and never written to."""
    count = width - start
    ends = np.append(np.zeros(start, dtype=int), np.arange(count + 1))
    packed = np.full(count, 2.0), np.arange(start, width), ends
    return sparse.csc_matrix(packed, shape=(width, width))
