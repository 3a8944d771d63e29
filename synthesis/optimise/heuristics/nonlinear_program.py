"""The cone program's rows with smooth limits at spots of the turn, as IPOPT takes them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from math import inf
from typing import Any

import casadi
import numpy as np
from scipy import sparse

from synthesis.numerics.piecewise import Array
from synthesis.numerics.solvers.ipopt import SmoothProgram
from synthesis.optimise.conic.assembly import ConeBlock
from synthesis.optimise.conic.linear_rows import LinearBlock
from synthesis.optimise.conic.program import ConicModel
from synthesis.optimise.recovery.constraint_samples import ConstraintSamples

NOWHERE = 1e-24  # added to a norm's square, in the model's units


@dataclass(eq=False)
class NonlinearModel:
    """The program while it is written.

    Attributes:
        at: the point whose values set the scales.
        eased: how many of the last limits give way by the level that is made small.
    """

    model: ConicModel
    at: Array
    eased: int = 0
    x: Any = field(init=False)
    own: Any = field(init=False)
    _rows: list[Any] = field(default_factory=list)
    _lower: list[Array] = field(default_factory=list)
    _upper: list[Array] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.at = whole(self.model, self.at)
        self.x = casadi.MX.sym("x", len(self.at))
        self.own = self.x[: self.model.program.matrix.shape[1]]

    def stated(self, spots: Sequence[ConstraintSamples], tighten: float) -> SmoothProgram:
        """All rows and the objective."""
        self._linear()
        for ball, least in self._fixed_balls():
            self._ball(ball, least)
        for spot in spots:
            self._smooth(spot, tighten)
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
        found, at = list[int](), self.model.program.equalities
        for block in self.model.blocks:
            for cone in self.model.problem.sizing.norm_bounds if block.source == "bounds" else ():
                matrix = np.array(cone.norm.matrix)
                centre = np.linalg.solve(matrix, -np.array(cone.norm.shift))
                across = np.linalg.norm(np.linalg.solve(matrix.T, block.size.T), axis=0)
                room = block.rhs * self.model.scales.size - block.size @ centre
                idle = room - cone.upper * across >= -1e-9 * cone.upper
                found += (at + np.flatnonzero(idle)).tolist()
            at += len(block.rhs)
        return found

    def _fixed_balls(self) -> Iterator[tuple[ConeBlock, float]]:
        """Balls of fixed radius, and which share of it is the least allowed.

        The cones of the sizing stand first among the balls. The one that bounds the prime radius
        above bounds it below too; without such a cone the size's own bounds say both.
        """
        sizing, prime = self.model.problem.sizing, self.model.problem.machine.follower.radius_norm()
        shares = [
            max(cone.lower, sizing.min_norm * (cone.norm == prime)) / cone.upper
            for cone in sizing.norm_bounds
        ]
        for position, ball in enumerate(self.model.cone_blocks):
            if ball.bound_column is None:
                yield ball, shares[position] if position < len(shares) else 0.0

    def _ball(self, ball: ConeBlock, share: float) -> None:
        """Least ≤ ‖image‖² ≤ radius² over a scale; an equality where they leave no room."""
        image, here = self._image(ball)
        least = (share * ball.radius) ** 2
        most = max((ball.radius * (1.0 - ball.tightening)) ** 2, least)
        scale = max(float(np.sum(np.square(here))), least) or most
        lower = least / scale if least else -inf
        self._put(casadi.sumsqr(image) / scale, np.array([lower]), np.array([most / scale]))

    def _image(self, ball: ConeBlock) -> tuple[Any, Array]:
        """What a ball bounds, and its value at hand; of what rings, unknowns of its own.

        It depends on every coefficient: squared it would fill the Hessian.
        """
        matrix, first = _constant(ball.matrix), self.own.numel()
        image = casadi.mtimes(matrix, self.own) + casadi.DM(ball.shift)
        if ball.vibration is None:
            return image, ball.matrix @ self.at[:first] + ball.shift
        rings = [one for one in self.model.cone_blocks if one.vibration is not None]
        first += 2 * next(k for k, one in enumerate(rings) if one is ball)
        self._put(image - self.x[first : first + 2], np.zeros(2), np.zeros(2))
        return self.x[first : first + 2], np.zeros(2)

    def _smooth(self, spot: ConstraintSamples, tighten: float) -> None:
        """One limit at its spots, drawn in."""
        problem, model = self.model.problem, self.model
        segment = problem.segments[spot.position]
        z = casadi.vertsplit(self.x[model.size] * model.scales.size)
        s = self._motion(spot)
        yields = spot.limit >= len(problem.limits) - self.eased
        theta: Any = casadi.DM(segment.start + segment.angle * spot.x)  # a column, as s is
        for value in problem.limits[spot.limit].smooth_constraints(
            segment, problem.machine, theta, s, z
        ):
            none = np.full(len(spot.x), -inf)
            given = value - self.x[model.epigraph] if yields else value
            self._put(given, none, np.full(len(spot.x), -tighten))

    def _motion(self, spot: ConstraintSamples) -> list[Any]:
        """s to s''' at the spots [mm, per rad]: columns of numbers, or of the unknowns."""
        problem = self.model.problem
        segment = problem.segments[spot.position]
        if segment.law is not None:
            return [casadi.DM(row) for row in spot.s]
        position = problem.free.index(segment)
        space, known = self.model.grids[position].space, self.model.boundary_states[position]
        coefficients = self.x[self.model.columns[position]]
        columns = []
        for order in range(4):
            inner, fixed = known.split(space.basis(spot.x, order))
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
                # its slope is finite at 0 too, where IPOPT may pass
                return casadi.sqrt(casadi.sumsqr(image) + NOWHERE)
        value = casadi.dot(casadi.DM(program.linear), self.own)
        if program.quadratic.nnz:
            upper = program.quadratic
            full = upper + upper.T - sparse.diags(upper.diagonal())
            value += 0.5 * casadi.bilin(_constant(full), self.own, self.own)
        return value


def whole(model: ConicModel, x: Array) -> Array:
    """A point of the model, and what IPOPT has as unknowns besides: what runs leave ringing."""
    x = x[: model.program.matrix.shape[1]]
    rings = [
        ball.matrix @ x + ball.shift for ball in model.cone_blocks if ball.vibration is not None
    ]
    return np.concatenate([x, *rings])


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
