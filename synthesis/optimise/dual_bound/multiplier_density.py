"""Multipliers of rows at points, spread along the arcs where a limit is met all along.

A multiplier of the second derivative at a point makes ψ jump. Where such a row is met along an arc
the true multiplier is a density, and ψ vanishes there: a point's share between it and a neighbour
that has a multiplier too is spread over what lies between them. Where an arc begins or ends the
true one has masses too; so each share is spread only where that makes ψ smaller. Any masses of any
shape give valid bounds, where the rows hold in between too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from synthesis.numerics.piecewise import Array
from synthesis.optimise.conic.linear_rows import LinearBlock
from synthesis.optimise.conic.program import ConicModel
from synthesis.optimise.dual_bound.batch import Quantities, absolute_pieces, batches, lagrangian_of
from synthesis.optimise.dual_bound.lagrangian import sums_at_start
from synthesis.optimise.dual_bound.row_functionals import RowFunctional


@dataclass(frozen=True, eq=False)
class PointRuns:
    """Points of rows, and points between neighbouring rows, all in ascending order.

    Blocks are made at these points, and the points of a block ascend (``Block.x``).

    Attributes:
        points: (r + each n,) strictly ascending.
        rows: (r,) indices of the rows' own points in ``points``.
        inner: (n, each) indices of the points between two rows in ``points``.
        left: (n,) number of the row before them. right_share, left_share: (n,) shares of the
            multipliers of the rows before and after that belong there.
    """

    points: Array
    rows: NDArray[np.intp]
    inner: NDArray[np.intp]
    left: NDArray[np.intp]
    right_share: Array
    left_share: Array

    @classmethod
    def of(cls, x: Array, parts: Sequence[tuple[float, float]], each: int) -> PointRuns:
        """For rows at x (r,), strictly ascending, on parts of a law.

        ``each``: points between two neighbouring rows of one part.
        """
        part = np.searchsorted([low for low, _ in parts], x, "right")
        together = part[1:] == part[:-1]
        left = np.flatnonzero(together)
        gaps = np.zeros(len(x) + 1)
        gaps[left + 1] = x[left + 1] - x[left]
        reach = np.maximum(gaps[1:] + gaps[:-1], 1e-300)
        ahead, behind = gaps[left + 1] / reach[left], gaps[left + 1] / reach[left + 1]
        # every interval between two rows of one part moves the rows behind it up by ``each``
        rows = np.arange(len(x))
        rows[1:] += each * np.cumsum(together)
        inner = rows[left, None] + 1 + np.arange(each)
        points = np.empty(len(x) + inner.size)
        points[rows] = x
        points[inner] = x[left, None] + gaps[left + 1, None] * (np.arange(each) + 0.5) / each
        return cls(points, rows, inner, left, ahead, behind)

    def distribute(self, z: Array, chosen: NDArray[Any] | float) -> Array:
        """Multipliers (…, r) of the rows as masses at all points; spread where ``chosen`` (n,)."""
        own = z[..., self.left] * self.right_share * chosen
        following = z[..., self.left + 1] * self.left_share * chosen
        kept = np.array(z)
        kept[..., self.left] -= own
        kept[..., self.left + 1] -= following
        each = self.inner.shape[1]
        rising = (np.arange(each) + 0.5) * 2.0 / each**2
        masses = np.empty((*z.shape[:-1], len(self.points)))
        masses[..., self.rows] = kept
        masses[..., self.inner] = own[..., None] * rising[::-1] + following[..., None] * rising
        return masses

    def ends(self, intervals: NDArray[np.intp]) -> Array:
        """The points of the rows before and after some intervals: (2, k)."""
        return np.stack([self.points[self.rows[self.left[intervals] + k]] for k in (0, 1)])

    def multiplied(self, z: Array) -> NDArray[np.intp]:
        """The intervals that a multiplier of any of the rows z (q, r) beside them belongs to."""
        any_of = np.any(z > 0.0, axis=0)
        return np.flatnonzero(any_of[self.left] | any_of[self.left + 1])


def _sum_between(breaks: Array, amounts: Array, ends: Array) -> Array:
    """Sums of amounts (…, pieces) over what lies between ends (2, n), which are breaks: (…, n)."""
    sums = np.concatenate([np.zeros((*amounts.shape[:-1], 1)), np.cumsum(amounts, axis=-1)], -1)
    first, last = (np.searchsorted(breaks, end) for end in ends)
    return np.asarray(sums[..., last] - sums[..., first])


@dataclass(frozen=True, eq=False)
class MultiplierDensity:
    """A model with rows between the points of another's, where they hold too.

    Attributes:
        model: for bounds, not to be solved. solved: the other one, whose multipliers are known.
        point_runs: of every block, None where it has no more points.
    """

    model: ConicModel
    solved: ConicModel
    point_runs: tuple[PointRuns | None, ...]

    @classmethod
    def of(
        cls,
        model: ConicModel,
        denser: Sequence[tuple[LinearBlock, PointRuns | None]],
        each: int,
        order: int,
    ) -> MultiplierDensity:
        """For a model whose last blocks are these with fewer points.

        Of the others those that hold all along a law, with the same factors everywhere, too.
        ``order``: of the control; rows of the derivative just below it make ψ jump.
        """
        result = list[tuple[LinearBlock, PointRuns | None]]()
        for block in model.blocks[: len(model.blocks) - len(denser)]:
            runs = None
            uniform = block.alpha.ndim == 1 and block.spans is None
            jumps = uniform and block.highest_order == order - 1 and not block.exact
            if jumps and block.ascending:
                runs = PointRuns.of(block.x, ((0.0, 1.0),), each)
                # the splines' matrix is left out, which bounds do not read
                rhs = np.full(len(runs.points), block.rhs[0])
                block = replace(block, law_matrix=None, x=runs.points, rhs=rhs)
            result.append((block, runs))
        result += denser
        dense = tuple(block for block, _ in result)
        program = replace(model.program, inequalities=sum(len(block.rhs) for block in dense))
        both = replace(model, blocks=dense, program=program), model
        return cls(*both, tuple(runs for _, runs in result))

    def distribute(self, quantities: Quantities, z: Array, costates: Array) -> Array:
        """The other model's multipliers z (q, m) of some quantities as this one's."""
        every = self._masses(z, [1.0] * len(self.point_runs))
        counts = (0 if runs is None else len(runs.left) for runs in self.point_runs)
        chosen = [np.zeros((len(z), count), dtype=bool) for count in counts]
        for some in batches(len(z)):
            part, ends = quantities.select(some), costates[some]
            points = lagrangian_of(self.solved, part, z[some], ends)
            spread = lagrangian_of(self.model, part, every[some], ends)
            # ∫ |ψ| between two rows, with their multipliers at points, and spread between them
            arcs = self._arcs(z[some])
            for position, _, _, between in arcs:
                points.add_breaks(position, between.ravel())
                spread.add_breaks(position, between.ravel())
            for position in {arc[0] for arc in arcs}:
                both = [absolute_pieces(one, position) for one in (spread, points)]
                for _, number, intervals, between in (a for a in arcs if a[0] == position):
                    less, more = (_sum_between(*pieces, between) for pieces in both)
                    chosen[number][some, intervals] = less < more
        return self._masses(z, chosen)

    def _arcs(self, z: Array) -> list[tuple[int, int, NDArray[np.intp], Array]]:
        """Where multipliers z (q, m) of rows of a law may be spread: its position, the number of
        the block, the intervals beside rows that have any, and their ends (2, n).
        """
        result, of_equalities = [], len(self.solved.equality_blocks)
        inequalities = self.solved.numbered_blocks[of_equalities:]
        for number, (runs, (at, block)) in enumerate(
            zip(self.point_runs, inequalities, strict=True)
        ):
            if runs is None or block.segment is None:
                continue
            intervals = runs.multiplied(z[:, at : at + len(block.rhs)])
            if len(intervals):
                result.append((block.segment, number, intervals, runs.ends(intervals)))
        return result

    def balance(self, masses: Array, z: Array, order: int) -> Array:
        """Distributed masses (q, m), in total worth as much as the multipliers z (q, m') were.

        Rows between two points differ from those at the points, and the centre of what is spread
        is not where it came from. So ψ gets a polynomial on all that lies before an arc, by far the
        larger part of a law, and the size another factor. Of every block the masses are changed by
        the least, relative to each of them, that makes both what the points made of them. On fine
        knots that is a better bound; on coarse ones it may be a worse one.
        """
        points = self._masses(z, [0.0] * len(self.point_runs))
        result, at = masses.copy(), self.model.program.equalities
        for runs, block in zip(self.point_runs, self.model.blocks, strict=True):
            here, at = slice(at, at + len(block.rhs)), at + len(block.rhs)
            if runs is None or not len(block.rhs):  # no arc: cuts may leave nothing of it
                continue
            # 1. What a unit of each row comes to: the powers of ψ before it, and in the size.
            rows = RowFunctional(self.model, block, here.start, order).point_rows()
            about = 0.5 * (rows.x[0] + rows.x[-1])
            effect = sums_at_start((rows.x - about)[:, None], rows.weights[:, None])
            effect = np.hstack([effect, rows.size])
            effect = effect[:, np.any(effect, axis=0)]
            effect = effect / np.max(np.abs(effect), axis=0)
            # 2. The least squares of relative changes: each is linear in these effects.
            own = masses[:, here]
            missing = (points[:, here] - own) @ effect
            squares = (effect[:, :, None] * effect[:, None]).reshape(len(effect), -1)
            gram = (own @ squares).reshape(len(own), *2 * (effect.shape[1],))
            change = np.einsum("qcd,qd->qc", np.linalg.pinv(gram, hermitian=True), missing)
            result[:, here] = own * np.maximum(1.0 + change @ effect.T, 0.0)
        return result

    def distribute_single(self, z: Array, costates: Array) -> tuple[Array, Array]:
        """The same for one set of multipliers (m,) for the model's own objective; and balanced."""
        none = np.zeros((1, len(self.model.problem.sizing.bounds)))
        nothing = Quantities(np.zeros(1, dtype=int), np.zeros(1), np.zeros((1, 3)), none)
        masses = self.distribute(nothing, z[None], costates)
        return masses[0], self.balance(masses, z[None], costates.shape[2])[0]

    def _masses(self, z: Array, chosen: Sequence[NDArray[Any] | float]) -> Array:
        """Multipliers of all rows, spread where chosen, block by block."""
        at = self.model.program.equalities
        parts = [z[..., :at]]
        for runs, block, here in zip(self.point_runs, self.model.blocks, chosen, strict=True):
            count = len(block.rhs) - (0 if runs is None else runs.inner.size)
            own = z[..., at : at + count]
            parts.append(own if runs is None else runs.distribute(np.maximum(own, 0.0), here))
            at += count
        return np.concatenate([*parts, z[..., at:]], axis=-1)
