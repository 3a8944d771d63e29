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
        left: (n,) number of the row before them. ahead, left_share: (n,) shares of the rows before
            and after that belong there.
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

    def distribute(self, z: Array, chosen: NDArray[Any]) -> Array:
        """Multipliers (…, r) of the rows as masses at all points; spread in the n ``chosen``."""
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
        costates = (self.points[self.rows[k]] for k in (self.left, self.left + 1))
        first, last = (np.searchsorted(breaks, end) for end in costates)
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
            arc = _uniform_runs(block, each)
            result.append((block if arc is None else _rows_at(block, arc.points), arc))
        result += denser
        dense = tuple(block for block, _ in result)
        program = replace(model.program, inequalities=sum(len(block.rhs) for block in dense))
        return cls(replace(model, blocks=dense, program=program), tuple(arc for _, arc in result))

    def distribute(self, quantities: Quantities, z: Array, costates: Array) -> Array:
        """The other model's multipliers (q, m) as this one's.

        Args:
            quantities: the quantities that they are for. z: the multipliers.
            costates: costates of the laws' ends.
        """
        none, everywhere = (
            self._masses(
                z, [None if a is None else np.full(len(a.left), c) for a in self.point_runs]
            )
            for c in (0, 1)
        )
        both = [
            switching_functions(self.model, quantities, masses, costates)
            for masses in (none, everywhere)
        ]
        chosen = list[NDArray[Any] | None]()
        for arc, block in zip(self.point_runs, self.model.blocks, strict=True):
            if arc is None or block.segment is None:
                chosen.append(None)
                continue
            as_they_are, spread = (arc.sum_between(*laws[block.segment]) for laws in both)
            chosen.append(spread < as_they_are)
        return self._masses(z, chosen)

    def distribute_single(self, z: Array, costates: Array) -> Array:
        """The same for one set of multipliers (m,) that is for the model's own objective."""
        none = np.zeros((1, len(self.model.problem.sizing.bounds)))
        nothing = Quantities(np.zeros(1, dtype=int), np.zeros(1), np.zeros((1, 3)), none)
        return np.asarray(self.distribute(nothing, z[None], costates)[0])

    def _masses(self, z: Array, chosen: Sequence[NDArray[Any] | None]) -> Array:
        at = self.model.program.equalities
        parts = [z[..., :at]]
        for arc, block, here in zip(self.point_runs, self.model.blocks, chosen, strict=True):
            rows = len(block.rhs)
            if arc is not None and here is not None:
                rows -= arc.inner.size
                parts.append(arc.distribute(np.maximum(z[..., at : at + rows], 0.0), here))
            else:
                parts.append(z[..., at : at + rows])
            at += rows
        return np.concatenate([*parts, z[..., at:]], axis=-1)


def _uniform_runs(block: LinearBlock, each: int) -> PointRuns | None:
    """The points of a limit that holds all along a law and reads the same everywhere."""
    everywhere = block.kind == "point" and block.alpha.ndim == 1 and block.spans is None
    if not everywhere or block.alpha[3] or not block.alpha[2] or block.exact or not block.ascending:
        return None
    return PointRuns.of(block.x, ((0.0, 1.0),), each)


def _rows_at(block: LinearBlock, x: Array) -> LinearBlock:
    """The same rows at other points; the splines' matrix left out, which bounds do not read."""
    return replace(block, law_matrix=None, x=x, rhs=np.full(len(x), block.rhs[0]))
