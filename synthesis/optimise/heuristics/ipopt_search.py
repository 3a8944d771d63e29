"""IPOPT as a local search: nonconvex limits join the cone program's rows.

The unknowns are the model's own, and its linear rows and balls stay what they are; where a norm of
the size is the objective, it is minimised itself. Smooth limits are written at samples of the turn.
At the solution they are measured densely, the peaks that violate a limit are written too, and the
program is solved again from there, until there is no such peak: an exchange method.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from math import inf
from typing import Any

import casadi
import numpy as np
from scipy import sparse

from synthesis.catalogue.constraints import enlarged
from synthesis.numerics import clock
from synthesis.numerics.piecewise import Array
from synthesis.numerics.solvers.ipopt import SmoothProgram, StartingPoint, solve
from synthesis.numerics.solvers.statuses import USABLE, StopReason
from synthesis.optimise.conic.assembly import ConeBlock
from synthesis.optimise.conic.linear_rows import LinearBlock
from synthesis.optimise.conic.program import ConicModel
from synthesis.optimise.problem.problem import Problem
from synthesis.optimise.recovery.smooth_limits import (
    ConstraintSamples,
    add_violated,
    constraint_samples,
    peaks,
    sample,
    violation,
)

MAX_PROGRAMS = (
    6  # programs at most, each with the peaks that violated a limit at the solution before
)
NOWHERE = 1e-24  # added to a norm's square: so its slope is finite at 0 too, where IPOPT may pass


@dataclass(frozen=True, eq=False)
class NonlinearSolution:
    """A point in the model's unknowns, and why the solver stopped there.

    Attributes:
        x: the last point that IPOPT called a solution; the start where it called none so.
        rows: of the last program. iterations: of all.
        samples: where smooth limits were written. end: the point with its multipliers, for IPOPT.
    """

    x: Array
    stopped: StopReason
    word: str
    iterations: int
    rows: int
    samples: tuple[ConstraintSamples, ...]
    end: StartingPoint


def solver_tolerances(tolerance: float) -> tuple[float, float]:
    """What a relative gap asks of rows at points, and of the optimum: see ``solve_ipopt``.

    Rows tightened by a little of what the caller allows save programs: peaks may lie between them.
    """
    spare = float(np.clip(0.04 * tolerance, 1e-7, 1e-3))
    return spare, float(np.clip(1e-5 * tolerance, 1e-9, 1e-7))


def solve_ipopt(
    model: ConicModel,
    start: Array,
    deadline: float | None = None,
    tighten: float = 1e-6,
    accuracy: float = 1e-9,
    *,
    relaxed_count: int = 0,
    growth: float = 0.0,
) -> NonlinearSolution:
    """A local optimum under all limits, those that are not convex included.

    Args:
        model: the relaxation.
        start: a point of its unknowns, best one at which the smooth limits hold.
        deadline: ``time.monotonic()`` at which to stop.
        tighten: relative amount by which smooth limits are tightened at the points where they are
            written; peaks between these may rise by as much, so a larger one saves programs.
        accuracy: of the optimum, relative.
        relaxed_count: how many of the last limits may be exceeded by the level that is minimised.
        growth: relative increase of the value for which limits may hold at last: where a cam that
            much larger satisfies those that are exceeded between points, they get no rows there.
    """
    samples = constraint_samples(*recover_problem(model, start), -np.inf, np.inf)
    begin = StartingPoint(start)
    return solve_with_exchange(
        model, samples, begin, deadline, tighten, accuracy, relaxed_count, growth=growth
    )


def solve_with_exchange(
    model: ConicModel,
    samples: Sequence[ConstraintSamples],
    start: StartingPoint,
    deadline: float | None,
    tighten: float,
    accuracy: float,
    relaxed_count: int = 0,
    *,
    growth: float = 0.0,
) -> NonlinearSolution:
    """The same from given samples, and multipliers where they are known."""
    end, iterations, rows = start, 0, 0
    end = StartingPoint(with_vibrations(model, start.x), start.rows, start.bounds)
    for _ in range(MAX_PROGRAMS):
        stopped, word = StopReason.OUT_OF_TIME, "deadline"
        left = inf if deadline is None else deadline - clock.now()
        if left <= 0.0:
            break
        program = NonlinearModel(model, end.x, relaxed_count).program(samples, tighten)
        result = solve(program, end, left, accuracy)
        stopped, word, rows = result.stopped, result.word, len(program.lower)
        iterations += result.iterations
        if stopped not in USABLE:
            break
        end = StartingPoint(result.x, result.rows, result.bounds)
        level = float(result.x[model.epigraph]) if relaxed_count else 0.0
        here = recover_problem(model, result.x)
        violated = add_violated(*here, relaxed_count, level)
        samples = [*samples, *violated]
        if not violated or (growth > 0.0 and _holds_enlarged(*here, growth)):
            break
    x = _with_norm(model, end.x)
    return NonlinearSolution(x, stopped, word, iterations, rows, tuple(samples), end)


def _holds_enlarged(problem: Problem, size: tuple[float, ...], growth: float) -> bool:
    """Whether limits that are exceeded a little hold on a cam larger by no more than that."""
    if problem.objective.norm(problem.machine) is None:
        return False  # what growing costs is not known
    follower = problem.machine.follower
    step = growth * follower.radius_norm().value(size)
    larger = enlarged(size, min(step, problem.max_enlargement(size)))
    samples = sample(problem)
    return violation(problem, samples + peaks(problem, samples, larger), larger) < 0.0


def recover_problem(model: ConicModel, x: Array) -> tuple[Problem, tuple[float, ...]]:
    """The problem with the laws of this point, and its size."""
    laws, size = model.recover(x)
    free = model.problem.free
    placed = [s.with_law(law.curve()) for s, law in zip(free, laws, strict=True)]
    return model.problem.with_laws(placed), size


def _with_norm(model: ConicModel, x: Array) -> Array:
    """The point with the objective's norm, which IPOPT does not know as an unknown."""
    x = x[: model.program.matrix.shape[1]].copy()
    for cone in model.cone_blocks:
        if cone.bound_column is not None:
            x[cone.bound_column] = float(np.linalg.norm(cone.matrix @ x + cone.shift)) - cone.radius
    return x


@dataclass(eq=False)
class NonlinearModel:
    """The program while it is written.

    Attributes:
        at: the point whose values set the scales.
        relaxed_count: how many of the last limits may be exceeded by the level.
    """

    model: ConicModel
    at: Array
    relaxed_count: int = 0
    x: Any = field(init=False)
    own: Any = field(init=False)
    _rows: list[Any] = field(default_factory=list)
    _lower: list[Array] = field(default_factory=list)
    _upper: list[Array] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.at = with_vibrations(self.model, self.at)
        self.x = casadi.MX.sym("x", len(self.at))
        self.own = self.x[: self.model.program.matrix.shape[1]]

    def program(self, samples: Sequence[ConstraintSamples], tighten: float) -> SmoothProgram:
        """All rows and the objective."""
        self._linear()
        for ball, least in self._fixed_balls():
            self._ball(ball, least)
        for one in samples:
            self._smooth(one, tighten)
        low, high = np.full(len(self.at), -inf), np.full(len(self.at), inf)
        for ball in self.model.cone_blocks:
            if ball.bound_column is not None:
                low[ball.bound_column] = high[ball.bound_column] = self.at[ball.bound_column]
        rows = casadi.densify(casadi.vertcat(*self._rows))  # a row of zeros would be left out
        lower, upper = np.concatenate(self._lower), np.concatenate(self._upper)
        return SmoothProgram(self.x, self._objective(), rows, lower, upper, low, high)

    def _put(self, rows: Any, lower: Array, upper: Array) -> None:
        self._rows.append(rows)
        self._lower.append(lower)
        self._upper.append(upper)

    def _linear(self) -> None:
        """Equalities and inequalities as the cone program has them."""
        program = self.model.program
        last = program.equalities + program.inequalities
        upper = program.rhs[:last].copy()
        lower = np.where(np.arange(last) < program.equalities, upper, -inf)
        upper[self._implied()] = inf
        kept = np.full(last, True)
        for one, other in self._opposites():
            lower[one], kept[other] = -upper[other], False
        matrix = sparse.csr_matrix(program.matrix)[:last][kept]
        self._put(casadi.mtimes(_constant(matrix), self.own), lower[kept], upper[kept])

    def _opposites(self) -> Iterator[tuple[slice, slice]]:
        """Rows of two blocks that bound the same from above and from below: one row for IPOPT."""
        there, paired = self.model.program.equalities, False
        for before, block in pairwise(self.model.blocks):
            here, there = there, there + len(before.rhs)
            paired = not paired and _opposite(before, block)
            if paired:
                yield slice(here, there), slice(there, there + len(block.rhs))

    def _implied(self) -> list[int]:
        """Bounds of the size that a ball implies: where it touches them, they leave no interior."""
        implied, at = list[int](), self.model.program.equalities
        for block in self.model.blocks:
            for cone in self.model.problem.sizing.norm_bounds if block.source == "bounds" else ():
                matrix = np.array(cone.norm.matrix)
                centre = np.linalg.solve(matrix, -np.array(cone.norm.shift))
                across = np.linalg.norm(np.linalg.solve(matrix.T, block.size.T), axis=0)
                slack = block.rhs * self.model.scales.size - block.size @ centre
                idle = slack - cone.upper * across >= -1e-9 * cone.upper
                implied += (at + np.flatnonzero(idle)).tolist()
            at += len(block.rhs)
        return implied

    def _fixed_balls(self) -> Iterator[tuple[ConeBlock, float]]:
        """Balls of fixed radius, and which share of it is the least allowed.

        The cones of the sizing stand first among the balls. The one that bounds the prime radius
        above bounds it below too; without such a cone the size's own bounds say both.
        """
        problem, prime = self.model.problem, self.model.problem.machine.follower.radius_norm()
        shares = [
            max(cone.lower, problem.searched_norm * (cone.norm == prime)) / cone.upper
            for cone in problem.sizing.norm_bounds
        ]
        for position, ball in enumerate(self.model.cone_blocks):
            if ball.bound_column is None:
                yield ball, shares[position] if position < len(shares) else 0.0

    def _ball(self, ball: ConeBlock, share: float) -> None:
        """Least ≤ ‖image‖² ≤ radius² over a scale; an equality where they coincide."""
        image, here = self._image(ball)
        least = (share * ball.radius) ** 2
        most = max((ball.radius * (1.0 - ball.tightening)) ** 2, least)
        scale = max(float(np.sum(np.square(here))), least) or most
        lower = least / scale if least else -inf
        self._put(casadi.sumsqr(image) / scale, np.array([lower]), np.array([most / scale]))

    def _image(self, ball: ConeBlock) -> tuple[Any, Array]:
        """What a ball bounds, and its value at hand; of vibrations, unknowns of their own.

        It depends on every coefficient: squared it would fill the Hessian.
        """
        matrix, first = _constant(ball.matrix), self.own.numel()
        image = casadi.mtimes(matrix, self.own) + casadi.DM(ball.shift)
        if ball.vibration is None:
            return image, ball.matrix @ self.at[:first] + ball.shift
        vibrations = [one for one in self.model.cone_blocks if one.vibration is not None]
        first += 2 * next(k for k, one in enumerate(vibrations) if one is ball)
        self._put(image - self.x[first : first + 2], np.zeros(2), np.zeros(2))
        return self.x[first : first + 2], np.zeros(2)

    def _smooth(self, samples: ConstraintSamples, tighten: float) -> None:
        """One limit at its samples, tightened."""
        problem, model = self.model.problem, self.model
        segment = problem.segments[samples.position]
        z = casadi.vertsplit(self.x[model.size] * model.scales.size)
        s = self._motion(samples)
        yields = samples.limit >= len(problem.limits) - self.relaxed_count
        theta: Any = casadi.DM(segment.start + segment.angle * samples.x)  # a column, as s is
        for value in problem.limits[samples.limit].smooth_constraints(
            segment, problem.machine, theta, s, z
        ):
            none = np.full(len(samples.x), -inf)
            given = value - self.x[model.epigraph] if yields else value
            self._put(given, none, np.full(len(samples.x), -tighten))

    def _motion(self, samples: ConstraintSamples) -> list[Any]:
        """s to s''' at the samples [mm, per rad]: columns of numbers, or of the unknowns."""
        problem = self.model.problem
        segment = problem.segments[samples.position]
        if segment.law is not None:
            return [casadi.DM(row) for row in samples.s]
        position = problem.free.index(segment)
        space, known = self.model.grids[position].space, self.model.boundary_states[position]
        coefficients = self.x[self.model.columns[position]]
        columns = []
        for order in range(4):
            inner, fixed = known.split(space.basis(samples.x, order))
            unit = segment.lift / segment.angle**order
            start = segment.s_start if order == 0 else 0.0
            moving = casadi.mtimes(_constant(unit * inner), coefficients)
            columns.append(moving + casadi.DM(unit * fixed + start))
        return columns

    def _objective(self) -> Any:
        """The norm of the size, the level, or the mean square."""
        program = self.model.program
        for ball in self.model.cone_blocks:
            if ball.bound_column is not None:
                image = casadi.mtimes(_constant(ball.matrix), self.own) + casadi.DM(ball.shift)
                return casadi.sqrt(casadi.sumsqr(image) + NOWHERE)
        value = casadi.dot(casadi.DM(program.linear), self.own)
        if program.quadratic.nnz:
            upper = program.quadratic
            full = upper + upper.T - sparse.diags(upper.diagonal())
            value += 0.5 * casadi.bilin(_constant(full), self.own, self.own)
        return value


def with_vibrations(model: ConicModel, x: Array) -> Array:
    """A point of the model, and IPOPT's further unknowns: the vibrations that runs leave."""
    x = x[: model.program.matrix.shape[1]]
    vibrations = [
        ball.matrix @ x + ball.shift for ball in model.cone_blocks if ball.vibration is not None
    ]
    return np.concatenate([x, *vibrations])


def _opposite(one: LinearBlock, other: LinearBlock) -> bool:
    """Whether two blocks bound the same derivatives of one law from above and from below."""
    if one.segment != other.segment or one.law_matrix is None or other.law_matrix is None:
        return False
    alone = not any(block.level or block.size.any() for block in (one, other))
    return alone and np.array_equal(one.law_matrix, -other.law_matrix)


def _constant(matrix: Any) -> Any:
    """A sparse matrix of CasADi; the way over lists is five times quicker than the direct one."""
    packed = sparse.csc_matrix(matrix)
    packed.sort_indices()
    pattern = casadi.Sparsity(*packed.shape, packed.indptr.tolist(), packed.indices.tolist())
    return casadi.DM(pattern, packed.data.tolist())
