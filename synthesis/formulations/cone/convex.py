"""One cone program over every free law's coefficients and the follower's size together.

Unknowns, all dimensionless:
    c   B-spline coefficients of g(x), 0 to 1 over x in [0, 1], for every free stretch;
        s = s_start + h g, so s^(k) = h/β^k g^(k); those that a neighbour settles are left out
    ζ   size variables over the unit of size
    π   the objective's level P over its natural scale
    t   norm of the size over the unit of size
    y   the derivative whose mean square is the objective, at its Gauss points, over its unit;
        unknowns of their own, because the splines' matrices squared lose half of the digits
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import accumulate, pairwise

import numpy as np
from scipy import sparse

from synthesis.formulations.cone import cuts, rows
from synthesis.formulations.cone.cuts import Region
from synthesis.formulations.cone.matrix import Ball, Writer
from synthesis.formulations.cone.rows import Block, Drawn, Scales
from synthesis.formulations.question.ends import Ends, Joint, meet
from synthesis.formulations.question.energy import Energy, energy
from synthesis.formulations.question.grid import TYPICAL, Grid, SettledLaw
from synthesis.formulations.question.problem import Problem
from synthesis.formulations.question.ringing import Ring, ring
from synthesis.numerics.digits import rounded
from synthesis.numerics.piecewise import Array
from synthesis.solvers.clarabel import ConeProgram

Vector = tuple[float, ...]
EXACT = Drawn()
HALF = 0.5  # of the room between a cone and the nearest size that the bounds allow


@dataclass(frozen=True, eq=False)
class Plan:
    """The cone program, and what its unknowns and rows mean.

    Attributes:
        columns: unknown coefficients of every free law. size: size variables.
        extra: column of π or t, None where the objective is a mean square.
        squares: columns of y, empty otherwise.
        exact: rows that are equalities, the last of the program's.
        equalities, blocks, balls: the rows, in the order of the program.
        silent: runs after which nothing may ring: two equalities each, right before ``exact``.
        energy: the objective where it is a mean square.
    """

    problem: Problem
    grids: tuple[Grid, ...]
    scales: Scales
    settled: tuple[Ends, ...]
    joints: tuple[Joint, ...]
    columns: tuple[slice, ...]
    size: slice
    extra: int | None
    squares: slice
    exact: tuple[Block, ...]
    blocks: tuple[Block, ...]
    balls: tuple[Ball, ...]
    energy: Energy | None
    program: ConeProgram
    silent: tuple[Ring, ...] = ()

    @cached_property
    def every_block(self) -> tuple[tuple[int, Block], ...]:
        """The blocks of equalities and of inequalities, each with the number of its first row."""
        blocks = (*self.exact, *self.blocks)
        first = self.program.equalities - sum(len(block.rhs) for block in self.exact)
        rows = accumulate((len(block.rhs) for block in blocks), initial=first)
        return tuple(zip(rows, blocks, strict=False))

    def heard_blocks(self, z: Array) -> list[tuple[int, Block]]:
        """Those of which a row has a multiplier."""
        each = ((at, block, z[at : at + len(block.rhs)]) for at, block in self.every_block)
        return [(at, block) for at, block, own in each if np.count_nonzero(own)]

    def recover(self, x: Array) -> tuple[list[SettledLaw], Vector]:
        """The laws and the size variables [mm] at a point of the program."""
        laws = [
            SettledLaw(grid.space, known.expand(x[columns]))
            for grid, known, columns in zip(self.grids, self.settled, self.columns, strict=True)
        ]
        return laws, tuple(float(v) for v in x[self.size] * self.scales.size)

    def point(self, laws: Sequence[SettledLaw], size: Vector) -> Array:
        """The point of the program that stands for these laws on its grids and this size."""
        x = np.zeros(self.program.matrix.shape[1])
        for law, grid, known, columns in zip(
            laws, self.grids, self.settled, self.columns, strict=True
        ):
            coefficients = law.on(grid.space)
            x[columns] = coefficients[len(known.first) : grid.space.size - len(known.last)]
        x[self.size] = np.array(size) / self.scales.size
        if self.energy is not None:
            roots = [
                f @ law.on(g.space)
                for f, law, g in zip(self.energy.factors, laws, self.grids, strict=True)
            ]
            x[self.squares] = np.concatenate([np.zeros(0), *roots]) / self.energy.unit**0.5
        norm = self.problem.objective.norm(self.problem.machine)
        if self.extra is not None and norm is not None:
            x[self.extra] = norm.value(size) / self.scales.size
        elif self.extra is not None:
            slack = self.program.rhs - self.program.matrix @ x
            column = self.program.matrix[:, [self.extra]].toarray().ravel()
            binding = column < 0.0
            x[self.extra] = max(np.max(-slack[binding] / -column[binding], initial=0.0), 0.0)
        return x

    def multipliers(self, z: Array) -> list[Array]:
        """The inequality multipliers, block by block, none negative."""
        z, found, at = np.maximum(z, 0.0), [], self.program.equalities
        for block in self.blocks:
            found.append(z[at : at + len(block.rhs)])
            at += len(block.rhs)
        return found

    def exact_multipliers(self, z: Array) -> list[Array]:
        """Those of the rows that are equalities, block by block, of either sign."""
        ends = np.cumsum([0, *(len(block.rhs) for block in self.exact)])
        first = self.program.equalities - ends[-1]
        return [z[first + a : first + b] for a, b in pairwise(ends)]

    def ring_multipliers(self, z: Array) -> list[tuple[Ring, Array]]:
        """Those of the two rows of every run that may leave little or nothing ringing."""
        at = self.program.equalities - sum(len(block.rhs) for block in self.exact)
        at -= 2 * len(self.silent)
        found = [(one, z[at + 2 * k : at + 2 * k + 2]) for k, one in enumerate(self.silent)]
        at = self.program.equalities + self.program.inequalities
        for ball in self.balls:
            if ball.ring is not None:
                found.append((ball.ring, -z[at + 1 : at + 3]))
            at += 1 + len(ball.shift)
        return found


def formulate(
    problem: Problem,
    grids: Sequence[Grid],
    level: float = 0.0,
    drawn: Drawn = EXACT,
    region: Region | None = None,
    *,
    paired: bool = False,
) -> Plan:
    """State the problem on given grids.

    Args:
        problem: the question. grids: one per free stretch.
        level: trial level of a fractional objective [core units], otherwise without effect.
        drawn: how far the rows are drawn in for the solver's sake.
        region: where curved limits are written as rows; None: all over what is allowed.
        paired: state rows that are equalities as two inequalities each, which may give way.
    """
    region = region or Region.whole(problem)
    free = problem.free
    scales = natural_scales(problem)
    settled, joints = meet(problem.stretches, grids)
    columns, at = [], 0
    for grid, known in zip(grids, settled, strict=True):
        columns.append(slice(at, at + grid.space.size - len(known.first) - len(known.last)))
        at = columns[-1].stop
    size = slice(at, at + len(problem.machine.follower.size_names))
    order = problem.objective.energy_order()
    extra = size.stop if order is None else None
    asked = _blocks(problem, grids, settled, scales, level, drawn, region)
    exact, blocks = _sorted(asked, paired)
    energetic = None if order is None else energy(problem.stretches, grids, order)
    at = size.stop + (extra is not None)
    squares = slice(at, at + (0 if energetic is None else energetic.rows))
    writer = Writer(squares.stop, columns, size, extra, settled)
    placed = (ring(one, problem.stretches, grids) for one in problem.ringing)
    rings = [one for one in placed if one is not None]
    silent = [one for one in rings if one.radius == 0.0 and not paired]
    balls = tuple(_balls(problem, grids, writer, scales, drawn.tighten)) + tuple(
        writer.ring_ball(one, drawn.tighten) for one in rings if one not in silent
    )
    for joint in joints:
        writer.joint(joint, free, grids)
    writer.fixed(problem.sizing.bounds, scales)
    if energetic is not None:
        writer.roots(energetic, squares.start)
    for one in silent:
        writer.silent(one)
    for block in exact:
        writer.block(block)
    equalities = writer.rows
    for block in blocks:
        writer.block(block)
    inequalities = writer.rows - equalities
    for ball in balls:
        writer.ball(ball)
    matrix, rhs = writer.finished()
    quadratic, linear = _objective(squares, extra)
    program = ConeProgram(
        quadratic, linear, matrix, rhs, equalities, inequalities,
        tuple(len(ball.shift) + 1 for ball in balls),
    )  # fmt: skip
    return Plan(
        problem, tuple(grids), scales, tuple(settled), tuple(joints), tuple(columns), size, extra,
        squares, exact, blocks, balls, energetic, program, tuple(silent),
    )  # fmt: skip


def with_rows(plan: Plan, more: Sequence[Block]) -> Plan:
    """The plan with further inequalities, below those that it has."""
    if not more:
        return plan
    program = plan.program
    writer = Writer(program.matrix.shape[1], plan.columns, plan.size, plan.extra, plan.settled)
    for block in more:
        writer.block(block)
    found, bounds = writer.finished()
    at = program.equalities + program.inequalities
    matrix = sparse.vstack([program.matrix[:at], found, program.matrix[at:]])
    longer = replace(
        program, matrix=sparse.csc_matrix(matrix),
        rhs=np.concatenate([program.rhs[:at], bounds, program.rhs[at:]]),
        inequalities=program.inequalities + writer.rows,
    )  # fmt: skip
    return replace(plan, blocks=(*plan.blocks, *more), program=longer)


def natural_scales(problem: Problem) -> Scales:
    """Natural units: of size the stroke or the least prime radius, of the level a good law's."""
    level = 0.0
    for stretch in problem.stretches:
        for row in problem.objective.rows(stretch, problem.machine, 0.0):
            per_turn = abs(stretch.lift) / stretch.angle ** np.arange(4)
            level = max(level, float(np.max(np.abs(row.coefficients) * per_turn * TYPICAL)))
    return Scales(max(problem.length, problem.sizing.least), level or 1.0)


def _sorted(blocks: Iterable[Block], paired: bool) -> tuple[tuple[Block, ...], tuple[Block, ...]]:
    """Equalities, and inequalities: to these belong both sides of an equality that is paired."""
    exact, others = list[Block](), list[Block]()
    for block in blocks:
        if not block.exact:
            others.append(block)
        elif paired:
            others += [replace(block, exact=False), block.opposite()]
        else:
            exact.append(block)
    return tuple(exact), tuple(others)


def _blocks(
    problem: Problem,
    grids: Sequence[Grid],
    settled: Sequence[Ends],
    scales: Scales,
    level: float,
    drawn: Drawn,
    region: Region,
) -> Iterator[Block]:
    yield from _size_bounds(problem, scales)
    position = 0
    for stretch in problem.stretches:
        for row in problem.rows_on(stretch, level):
            if stretch.law is not None:
                block = rows.on_given(row, stretch, scales, drawn.tighten)
                if block is not None:
                    yield block
            else:
                grid, known = grids[position], settled[position]
                yield rows.on_law(row, position, stretch, grid, known, scales, drawn)
        for curve in problem.curves_on(stretch):
            if stretch.law is not None:
                yield from cuts.on_given(curve, stretch, scales, drawn.tighten)
            else:
                grid = grids[position]
                yield from cuts.on_law(curve, position, stretch, grid, scales, drawn, region)
        if stretch.law is None:
            assert stretch.free is not None
            if not stretch.free.overshoot:
                yield rows.monotone(position, grids[position], settled[position], drawn)
            position += 1


def _size_bounds(problem: Problem, scales: Scales) -> Iterator[Block]:
    """Upper and lower bounds of the size variables that are not fixed, one after the other."""
    count = len(problem.sizing.bounds)
    sides = [
        (j, sign, sign * bound / scales.size)
        for j, (low, high) in enumerate(problem.sizing.bounds)
        if low != high
        for sign, bound in ((1.0, high), (-1.0, low))
    ]
    table = np.zeros((len(sides), count + 1))
    for own, (j, sign, bound) in zip(table, sides, strict=True):
        # a far bound is divided by its size: the solver's tolerance is relative to the largest
        far = max(abs(bound), 1.0)
        own[j], own[count] = sign / far, bound / far
    table = rounded(table)
    if sides:
        yield Block.of_size(table[:, :count], table[:, count], "bounds")


def _balls(
    problem: Problem, grids: Sequence[Grid], writer: Writer, scales: Scales, tighten: float
) -> Iterator[Ball]:
    """Cones of the sizing, of limits, of the objective's norm, of objectives held."""
    machine = problem.machine
    for cone in problem.cones:
        # a ring no wider than the draw-in, a base radius that is given, must keep an inside
        room = cone.radius - cone.norm.floor(problem.sizing.bounds)
        drawn = min(tighten, HALF * max(room, 0.0) / max(cone.radius, 1e-300))
        yield writer.norm_ball(cone.norm, scales.size, cone.radius, drawn, cone.source)
    norm = problem.objective.norm(machine)
    if norm is not None:
        yield writer.norm_ball(norm, scales.size, None)
    for earlier in problem.held:
        norm, order = earlier.objective.norm(machine), earlier.objective.energy_order()
        if norm is not None:
            yield writer.norm_ball(norm, scales.size, earlier.value)
        if order is not None:
            yield writer.energy_ball(energy(problem.stretches, grids, order), earlier.value)


def _objective(squares: slice, extra: int | None) -> tuple[sparse.csc_matrix, Array]:
    """P and q: the extra unknown alone, or the sum of squares of y."""
    linear = np.zeros(squares.stop)
    if extra is not None:
        linear[extra] = 1.0
    return _sum_of_squares(squares.start, squares.stop), linear


@lru_cache(maxsize=64)
def _sum_of_squares(start: int, width: int) -> sparse.csc_matrix:
    """P of the unknowns from a first one to the last: made once, and never written to."""
    count = width - start
    ends = np.append(np.zeros(start, dtype=int), np.arange(count + 1))
    packed = np.full(count, 2.0), np.arange(start, width), ends
    return sparse.csc_matrix(packed, shape=(width, width))
