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

from synthesis.formulations.bounds.floors import Wanted, switchings
from synthesis.formulations.cone.convex import Plan
from synthesis.formulations.cone.rows import Block
from synthesis.numerics.piecewise import Array


@dataclass(frozen=True, eq=False)
class Arcs:
    """Points of rows in order, and points between them.

    Attributes:
        points: (r + each n,) those of the rows, then those between two of one part.
        left: (n,) number of the row before them. ahead, behind: (n,) shares of the rows before
            and after that belong there. each: points between two rows.
    """

    points: Array
    left: NDArray[np.intp]
    ahead: Array
    behind: Array
    each: int

    @classmethod
    def of(cls, x: Array, parts: Sequence[tuple[float, float]], each: int) -> Arcs:
        """For rows at x (r,), in order, on parts of a law."""
        part = np.searchsorted([low for low, _ in parts], x, "right")
        left = np.flatnonzero(part[1:] == part[:-1])
        gaps = np.zeros(len(x) + 1)
        gaps[left + 1] = x[left + 1] - x[left]
        reach = np.maximum(gaps[1:] + gaps[:-1], 1e-300)
        between = x[left, None] + gaps[left + 1, None] * (np.arange(each) + 0.5) / each
        ahead, behind = gaps[left + 1] / reach[left], gaps[left + 1] / reach[left + 1]
        return cls(np.concatenate([x, between.ravel()]), left, ahead, behind, each)

    def spread(self, z: Array, chosen: NDArray[Any]) -> Array:
        """Multipliers (…, r) of the rows as masses at all points; spread in the n ``chosen``."""
        own = z[..., self.left] * self.ahead * chosen
        following = z[..., self.left + 1] * self.behind * chosen
        kept = np.array(z)
        kept[..., self.left] -= own
        kept[..., self.left + 1] -= following
        rising = (np.arange(self.each) + 0.5) * 2.0 / self.each**2
        masses = own[..., None] * rising[::-1] + following[..., None] * rising
        return np.concatenate([kept, masses.reshape(*z.shape[:-1], -1)], axis=-1)

    def between(self, breaks: Array, amounts: Array) -> Array:
        """Sums of amounts (…, pieces) over what lies between the rows: (…, n)."""
        sums = np.concatenate([np.zeros((*amounts.shape[:-1], 1)), np.cumsum(amounts, axis=-1)], -1)
        ends = (self.points[k] for k in (self.left, self.left + 1))
        first, last = (np.searchsorted(breaks, end) for end in ends)
        return np.asarray(sums[..., last] - sums[..., first])


@dataclass(frozen=True, eq=False)
class Spreading:
    """A plan with rows between the points of another's, where they hold too.

    Attributes:
        plan: for bounds, not to be solved. arcs: of every block, None where it has no more points.
    """

    plan: Plan
    arcs: tuple[Arcs | None, ...]

    @classmethod
    def of(cls, plan: Plan, denser: Sequence[tuple[Block, Arcs]], each: int) -> Spreading:
        """For a plan whose last blocks are these with fewer points.

        Of the others those that hold all along a law, with the same factors everywhere, too.
        """
        found = list[tuple[Block, Arcs | None]]()
        for block in plan.blocks[: len(plan.blocks) - len(denser)]:
            arc = _all_along(block, each)
            found.append((block if arc is None else _alike(block, arc.points), arc))
        found += denser
        dense = tuple(block for block, _ in found)
        program = replace(plan.program, inequalities=sum(len(block.rhs) for block in dense))
        return cls(replace(plan, blocks=dense, program=program), tuple(arc for _, arc in found))

    def multipliers(self, wanted: Wanted, z: Array, ends: Array) -> Array:
        """The other plan's multipliers (q, m) as this one's.

        Args:
            wanted: the quantities that they are for. z: the multipliers.
            ends: prices of the laws' ends.
        """
        none, everywhere = (
            self._with(z, [None if a is None else np.full(len(a.left), c) for a in self.arcs])
            for c in (0, 1)
        )
        both = [switchings(self.plan, wanted, masses, ends) for masses in (none, everywhere)]
        chosen = list[NDArray[Any] | None]()
        for arc, block in zip(self.arcs, self.plan.blocks, strict=True):
            if arc is None or block.stretch is None:
                chosen.append(None)
                continue
            as_they_are, spread = (arc.between(*laws[block.stretch]) for laws in both)
            chosen.append(spread < as_they_are)
        return self._with(z, chosen)

    def masses(self, z: Array, ends: Sequence[Array]) -> Array:
        """The same for one set of multipliers (m,) that is for the plan's own objective."""
        none = np.zeros((1, len(self.plan.problem.sizing.bounds)))
        nothing = Wanted(np.zeros(1, dtype=int), np.zeros(1), np.zeros((1, 3)), none)
        return np.asarray(self.multipliers(nothing, z[None], np.stack(ends)[None])[0])

    def _with(self, z: Array, chosen: Sequence[NDArray[Any] | None]) -> Array:
        at = self.plan.program.equalities
        parts = [z[..., :at]]
        for arc, block, here in zip(self.arcs, self.plan.blocks, chosen, strict=True):
            rows = len(block.rhs)
            if arc is not None and here is not None:
                rows -= arc.each * len(arc.left)
                parts.append(arc.spread(np.maximum(z[..., at : at + rows], 0.0), here))
            else:
                parts.append(z[..., at : at + rows])
            at += rows
        return np.concatenate([*parts, z[..., at:]], axis=-1)


def _all_along(block: Block, each: int) -> Arcs | None:
    """The points of a limit that holds all along a law and reads the same everywhere."""
    everywhere = block.kind == "point" and block.alpha.ndim == 1 and block.spans is None
    if not everywhere or block.alpha[3] or not block.alpha[2] or block.exact or len(block.x) < 2:
        return None
    return Arcs.of(block.x, ((0.0, 1.0),), each)


def _alike(block: Block, x: Array) -> Block:
    """The same rows at other points; the splines' matrix left out, which bounds do not read."""
    return replace(block, laws=None, x=x, rhs=np.full(len(x), block.rhs[0]))
