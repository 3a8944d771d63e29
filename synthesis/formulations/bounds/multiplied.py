"""Rows of a plan as functionals of arbitrary laws: what a unit of their multipliers is worth.

A row's multiplier may sit at its point. Where the row reads the same all along a law or a window it
holds between its points too, and its multiplier may be a density there.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import factorial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from synthesis.formulations.bounds.densities import DEGREE, Hats, shared
from synthesis.formulations.cone.convex import Plan
from synthesis.formulations.cone.rows import Block
from synthesis.numerics.piecewise import Array

Which = NDArray[Any] | slice
EVERY = slice(None)


@dataclass(frozen=True, eq=False)
class Multiplied:
    """n multipliers of one kind on one law: Σ weights · (g, g', …) (x) and a share of ∫ g^(m).

    Attributes:
        position: of the law, None where there is no motion in the rows.
        x: (n,) and weights: (n, m), which come to ψ before x.
        spans, poly: (n, 2) and (n, DEGREE + 1), what ψ gets on these spans as well, in s from 0 to
            1 along them; None: nothing.
        rhs: (n,) right-hand sides. size: (n, n_size) factors of ζ. level: factor of π.
        signed: of either sign, as the rows are equalities.
    """

    position: int | None
    x: Array
    weights: Array
    rhs: Array
    size: Array
    level: float = 0.0
    signed: bool = False
    spans: Array | None = None
    poly: Array | None = None

    def psi(self, tau: Array) -> Array:
        """What a unit of each adds to ψ at τ (q,): (q, n)."""
        order = self.weights.shape[1]
        ahead = np.maximum(self.x - tau[:, None], 0.0)
        found = np.where(self.x > tau[:, None], self.weights[:, -1], 0.0)
        for k in range(order - 1):
            found += self.weights[:, k] * ahead ** (order - 1 - k) / factorial(order - 1 - k)
        if self.spans is None or self.poly is None:
            return found
        low, high = self.spans.T
        inside = (low <= tau[:, None]) & (tau[:, None] < high)
        row, column = np.nonzero(inside)
        s = (tau[row] - low[column]) / (high - low)[column]
        found[row, column] += sum(self.poly[column, j] * s**j for j in range(self.poly.shape[1]))
        return found

    def chosen(self, which: NDArray[Any]) -> Multiplied:
        """Some of them: a mask or numbers."""
        spans, poly = (None if a is None else a[which] for a in (self.spans, self.poly))
        return Multiplied(
            self.position, self.x[which], self.weights[which], self.rhs[which], self.size[which],
            self.level, self.signed, spans, poly,
        )  # fmt: skip


@dataclass(frozen=True, eq=False)
class Said:
    """What a block says of arbitrary laws: at its points, and by densities between them.

    Attributes:
        rows: number of its first row in the program. sizes: number of size variables.
        order: m, the derivative that steers.
        alike: whether its rows read the same everywhere, so that densities between neighbouring
            points are multipliers as well.
        jumps: whether a point multiplier makes ψ jump. windowed: whether it is about a part.
    """

    plan: Plan
    block: Block
    rows: int
    order: int
    alike: bool
    jumps: bool
    windowed: bool

    @property
    def count(self) -> int:
        """Number of rows."""
        return len(self.block.rhs)

    def points(self, which: Which = EVERY) -> Multiplied:
        """All of its rows, or some: a mask or numbers."""
        block, order, rhs = self.block, self.order, self.block.rhs[which]
        sizes = np.zeros((len(rhs), len(self.plan.problem.sizing.bounds)))
        if len(block.size):
            sizes[:] = _of(block.size, which)
        if block.kind == "monotone":
            x, weights = in_order(self.plan, block, order, which)
            return Multiplied(block.stretch, x, weights, rhs, sizes)
        if block.highest == order:
            return _steered(block, order, sizes, which)
        weights = np.empty((len(rhs), order))
        weights[:] = _of(block.alpha.T, which)[..., :order]
        x = block.x[which]
        return Multiplied(block.stretch, x, weights, rhs, sizes, block.level, block.exact)

    def hats(self, which: NDArray[np.bool_]) -> Multiplied:
        """Some of the densities: of falling ones between neighbours, then of rising ones."""
        interval = np.flatnonzero(which) % (self.count - 1)
        rising = np.flatnonzero(which) >= self.count - 1
        of = self.points(interval)
        hats = Hats(of.x, self.block.x[interval + 1], rising, of.weights)
        spans = np.stack([hats.left, hats.right], axis=1)
        return replace(of, weights=hats.weights, spans=spans, poly=hats.poly)

    def masses(self, z: Array) -> tuple[Array, Array | None]:
        """Multipliers z (r,) shared out to points and hats.

        A point multiplier on the derivative just below the steering one makes ψ jump; where that
        bound is met along an arc the true multiplier is a density, and ψ vanishes there. Where a
        window ends its bound may be met at that very point.
        """
        if not self.alike or not self.jumps or (self.windowed and len(z) <= 3):
            return z, None
        kept = np.zeros_like(z)
        if self.windowed:
            kept[[0, -1]] = z[[0, -1]]
        return kept, np.concatenate(shared(self.block.x, z - kept))


def _of(each: Array, which: Which) -> Array:
    """What is said of some rows, where something is said row by row; else what is said of all."""
    return each if each.ndim == 1 else each[which]


def said(plan: Plan, order: int, z: Array | None = None) -> Iterator[Said]:
    """All rows that speak of arbitrary laws, or of the size alone; those of multipliers z ≠ 0."""
    for at, block in plan.every_block if z is None else plan.heard_blocks(z):
        one = _said(plan, block, at, order)
        if one is not None:
            yield one


def _said(plan: Plan, block: Block, at: int, order: int) -> Said | None:
    if block.kind == "monotone":
        return Said(plan, block, at, order, alike=False, jumps=False, windowed=False)
    windowed = block.spans is not None
    if windowed and block.highest == order:
        return Said(plan, block, at, order, alike=False, jumps=False, windowed=True)
    if not (windowed and block.highest < order) and (
        block.kind == "control" or block.highest >= order or block.exact
    ):
        return None  # says nothing more of arbitrary laws, or is the steering itself
    alike = block.stretch is not None and block.alpha.ndim == 1 and block.size.ndim == 1
    jumps = block.highest == order - 1
    return Said(plan, block, at, order, alike and len(block.rhs) > 1, jumps, windowed)


def in_order(plan: Plan, block: Block, order: int, which: Which = EVERY) -> tuple[Array, Array]:
    """Where coefficients in order stand for −g' ≤ 0, with what weights: (r,), (r, m)."""
    assert block.stretch is not None
    first = len(plan.settled[block.stretch].first) - 1
    x, factors = plan.grids[block.stretch].space.slopes
    here = slice(first, first + len(block.rhs))
    x, factors = x[here][which], factors[here][which]
    weights = np.zeros((len(x), order))
    weights[:, 1] = factors
    return x, weights


def _steered(block: Block, order: int, size: Array, which: Which) -> Multiplied:
    """Rows of the steering derivative itself on a part of a law: they add to ψ all along it."""
    assert block.spans is not None
    spans = block.spans[which]
    poly = np.zeros((len(spans), DEGREE + 1))
    poly[:, 0] = block.alpha[order] / np.ptp(spans, axis=1)
    nothing = np.zeros(len(spans)), np.zeros((len(spans), order))
    return Multiplied(
        block.stretch, *nothing, block.rhs[which], size, block.level, block.exact, spans, poly,
    )  # fmt: skip


def further(plan: Plan, order: int, z: Array) -> list[tuple[Multiplied, Array]]:
    """What is no row of a law, with its multipliers: sizes that leave no choice, cones of fixed
    radius; of a cone's in the direction that the solver found.
    """
    found, sizes = [], plan.problem.sizing.bounds
    nowhere, nothing = np.zeros(1), np.zeros((1, order))
    at = sum(max(joint.highest - joint.lowest + 1, 0) for joint in plan.joints)
    for j, (low, high) in enumerate(sizes):
        if low == high:
            unit, rhs = np.eye(len(sizes))[j : j + 1], np.array([low / plan.scales.size])
            rows = Multiplied(None, nowhere, nothing, rhs, unit, signed=True)
            found.append((rows, z[at : at + 1]))
            at += 1
    at = plan.program.equalities + plan.program.inequalities
    for ball in plan.balls:
        v = z[at + 1 : at + 1 + len(ball.shift)]
        at += 1 + len(ball.shift)
        if ball.head is None and ball.ring is None and np.count_nonzero(v):
            rhs = np.array([np.linalg.norm(v) * ball.radius + v @ ball.shift])
            size = -(ball.matrix.T @ v)[plan.size][None, :]
            found.append((Multiplied(None, nowhere, nothing, rhs, size), np.ones(1)))
    return found
