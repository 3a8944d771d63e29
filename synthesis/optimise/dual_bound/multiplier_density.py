"""Multipliers of rows at points, spread along the arcs where a limit is met all along.

A multiplier of the second derivative at a point makes ψ jump. Where such a row is met along an arc
the true multiplier is a density, and ψ vanishes there: a point's share between it and a neighbour
that has a multiplier too is spread over what lies between them. Where an arc begins or ends the
true one has masses too; so each share is spread only where that makes ψ smaller. Any masses of
any shape give valid bounds, where the rows hold in between too.
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
from synthesis.optimise.dual_bound.batch import Quantities, switching_functions


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

    def sum_between(self, breaks: Array, amounts: Array) -> Array:
        """Sums of amounts (…, pieces) over what lies between the rows: (…, n)."""
        sums = np.concatenate([np.zeros((*amounts.shape[:-1], 1)), np.cumsum(amounts, axis=-1)], -1)
        ends = (self.points[self.rows[k]] for k in (self.left, self.left + 1))
        first, last = (np.searchsorted(breaks, end) for end in ends)
        return np.asarray(sums[..., last] - sums[..., first])


@dataclass(frozen=True, eq=False)
class MultiplierDensity:
    """A model with rows between the points of another's, where they hold too.

    Attributes:
        model: for bounds, not to be solved.
        point_runs: of every block, None where it has no more points.
    """

    model: ConicModel
    point_runs: tuple[PointRuns | None, ...]

    @classmethod
    def of(
        cls, model: ConicModel, denser: Sequence[tuple[LinearBlock, PointRuns]], each: int
    ) -> MultiplierDensity:
        """For a model whose last blocks are these with fewer points.

        Of the others those that hold all along a law, with the same factors everywhere, too.
        """
        result = list[tuple[LinearBlock, PointRuns | None]]()
        for block in model.blocks[: len(model.blocks) - len(denser)]:
            runs = None
            uniform = block.kind == "point" and block.alpha.ndim == 1 and block.spans is None
            jumps = uniform and block.alpha[2] and not block.alpha[3] and not block.exact
            if jumps and block.ascending:
                runs = PointRuns.of(block.x, ((0.0, 1.0),), each)
                # the splines' matrix is left out, which bounds do not read
                rhs = np.full(len(runs.points), block.rhs[0])
                block = replace(block, law_matrix=None, x=runs.points, rhs=rhs)
            result.append((block, runs))
        result += denser
        dense = tuple(block for block, _ in result)
        program = replace(model.program, inequalities=sum(len(block.rhs) for block in dense))
        return cls(replace(model, blocks=dense, program=program), tuple(runs for _, runs in result))

    def distribute(self, quantities: Quantities, z: Array, costates: Array) -> Array:
        """The other model's multipliers (q, m) as this one's.

        Args:
            quantities: the quantities that they are for. z: the multipliers.
            costates: costates of the laws' ends.
        """
        # ∫ |ψ| between every two rows, with their multipliers at points, and spread between them.
        points, spread = (
            switching_functions(
                self.model, quantities, self._masses(z, [share] * len(self.point_runs)), costates
            )
            for share in (0.0, 1.0)
        )
        chosen: list[NDArray[Any] | float] = []
        for runs, block in zip(self.point_runs, self.model.blocks, strict=True):
            if runs is None or block.segment is None:
                chosen.append(0.0)
            else:
                k = block.segment
                chosen.append(runs.sum_between(*spread[k]) < runs.sum_between(*points[k]))
        return self._masses(z, chosen)

    def distribute_single(self, z: Array, costates: Array) -> Array:
        """The same for one set of multipliers (m,) that is for the model's own objective."""
        none = np.zeros((1, len(self.model.problem.sizing.bounds)))
        nothing = Quantities(np.zeros(1, dtype=int), np.zeros(1), np.zeros((1, 3)), none)
        return np.asarray(self.distribute(nothing, z[None], costates)[0])

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
