"""Rows of a model as functionals of arbitrary laws: what a unit of their multipliers is worth.

A row's multiplier may sit at its point. Where the row reads the same all along a law or a window it
holds between its points too, and its multiplier may be a density there.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import comb, factorial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from synthesis.numerics.piecewise import Array
from synthesis.optimise.conic.linear_rows import LinearBlock
from synthesis.optimise.conic.program import ConicModel

Which = NDArray[Any] | slice
EVERY = slice(None)
DEGREE = 4  # of what a density of g itself adds to ψ where the third derivative is the control


@dataclass(frozen=True, eq=False)
class WeightedRows:
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
        result = np.where(self.x > tau[:, None], self.weights[:, -1], 0.0)
        for k in range(order - 1):
            result += self.weights[:, k] * ahead ** (order - 1 - k) / factorial(order - 1 - k)
        if self.spans is None or self.poly is None:
            return result
        low, high = self.spans.T
        inside = (low <= tau[:, None]) & (tau[:, None] < high)
        row, column = np.nonzero(inside)
        s = (tau[row] - low[column]) / (high - low)[column]
        result[row, column] += sum(self.poly[column, j] * s**j for j in range(self.poly.shape[1]))
        return result

    def select(self, which: NDArray[Any]) -> WeightedRows:
        """Some of them: a mask or numbers."""
        spans, poly = (None if a is None else a[which] for a in (self.spans, self.poly))
        return WeightedRows(
            self.position, self.x[which], self.weights[which], self.rhs[which], self.size[which],
            self.level, self.signed, spans, poly,
        )  # fmt: skip


@dataclass(frozen=True, eq=False)
class RowFunctional:
    """What a block says of arbitrary laws: at its points, and by densities between them.

    Attributes:
        first_row: number of its first row in the program. sizes: number of size variables.
        order: m, the order of the control.
        uniform: whether its rows read the same everywhere, at points that ascend, so that densities
            between neighbouring points are multipliers as well.
        jumps: whether a point multiplier makes ψ jump. windowed: whether it is about a part.
    """

    model: ConicModel
    block: LinearBlock
    first_row: int
    order: int
    uniform: bool
    jumps: bool
    windowed: bool

    @property
    def count(self) -> int:
        """Number of rows."""
        return len(self.block.rhs)

    def point_rows(self, which: Which = EVERY) -> WeightedRows:
        """All of its rows, or some: a mask or numbers."""
        block, order, rhs = self.block, self.order, self.block.rhs[which]
        sizes = np.zeros((len(rhs), len(self.model.problem.sizing.bounds)))
        if len(block.size):
            sizes[:] = _of_rows(block.size, which)
        if block.kind == "monotone":
            x, weights = sort_by_place(self.model, block, order, which)
            return WeightedRows(block.segment, x, weights, rhs, sizes)
        if block.highest_order == order:
            return _control_rows(block, order, sizes, which)
        weights = np.empty((len(rhs), order))
        weights[:] = _of_rows(block.alpha.T, which)[..., :order]
        x = block.x[which]
        return WeightedRows(block.segment, x, weights, rhs, sizes, block.level, block.exact)

    def hat_rows(self, which: NDArray[np.bool_]) -> WeightedRows:
        """Some of the densities: of falling ones between neighbours, then of rising ones."""
        interval = np.flatnonzero(which) % (self.count - 1)
        rising = np.flatnonzero(which) >= self.count - 1
        of = self.point_rows(interval)
        hats = Hats(of.x, self.block.x[interval + 1], rising, of.weights)
        spans = np.stack([hats.left, hats.right], axis=1)
        return replace(of, weights=hats.weights, spans=spans, poly=hats.poly)

    def distribute(self, z: Array) -> tuple[Array, Array | None]:
        """Multipliers z (r,) shared out to points and hats.

        A point multiplier on the derivative just below the steering one makes ψ jump; where that
        bound is met along an arc the true multiplier is a density, and ψ vanishes there. Where a
        window ends its bound may be met at that very point.
        """
        if not self.uniform or not self.jumps or (self.windowed and len(z) <= 3):
            return z, None
        kept = np.zeros_like(z)
        if self.windowed:
            kept[[0, -1]] = z[[0, -1]]
        return kept, np.concatenate(distribute_to_intervals(self.block.x, z - kept))


def _of_rows(each: Array, which: Which) -> Array:
    """What is said of some rows, where something is said row by row; else what is said of all."""
    return each if each.ndim == 1 else each[which]


def row_functionals(
    model: ConicModel, order: int, z: Array | None = None
) -> Iterator[RowFunctional]:
    """All rows that speak of arbitrary laws, or of the size alone; those of multipliers z ≠ 0."""
    for at, block in model.numbered_blocks if z is None else model.active_blocks(z):
        one = _row_functional(model, block, at, order)
        if one is not None:
            yield one


def _row_functional(
    model: ConicModel, block: LinearBlock, at: int, order: int
) -> RowFunctional | None:
    if block.kind == "monotone":
        return RowFunctional(model, block, at, order, uniform=False, jumps=False, windowed=False)
    windowed = block.spans is not None
    if windowed and block.highest_order == order:
        return RowFunctional(model, block, at, order, uniform=False, jumps=False, windowed=True)
    if not (windowed and block.highest_order < order) and (
        block.kind == "control" or block.highest_order >= order or block.exact
    ):
        return None  # says nothing more of arbitrary laws, or is the control itself
    alike = block.segment is not None and block.alpha.ndim == 1 and block.size.ndim == 1
    jumps = block.highest_order == order - 1
    return RowFunctional(model, block, at, order, alike and block.ascending, jumps, windowed)


def sort_by_place(
    model: ConicModel, block: LinearBlock, order: int, which: Which = EVERY
) -> tuple[Array, Array]:
    """Where coefficients in order stand for −g' ≤ 0, with what weights: (r,), (r, m)."""
    assert block.segment is not None
    first = len(model.boundary_states[block.segment].first) - 1
    x, factors = model.grids[block.segment].space.step_slopes
    here = slice(first, first + len(block.rhs))
    x, factors = x[here][which], factors[here][which]
    weights = np.zeros((len(x), order))
    weights[:, 1] = factors
    return x, weights


def _control_rows(block: LinearBlock, order: int, size: Array, which: Which) -> WeightedRows:
    """Rows of the control itself on a part of a law: they add to ψ all along it."""
    assert block.spans is not None
    spans = block.spans[which]
    poly = np.zeros((len(spans), DEGREE + 1))
    poly[:, 0] = block.alpha[order] / np.ptp(spans, axis=1)
    nothing = np.zeros(len(spans)), np.zeros((len(spans), order))
    return WeightedRows(
        block.segment, *nothing, block.rhs[which], size, block.level, block.exact, spans, poly,
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class Hats:
    """Hats on intervals of a law, all of one row alpha · (g, g', …) or of one row each.

    Attributes:
        left, right: (n,) a < b. rising: (n,) bool, whether all the weight is at b, else at a.
        alpha: (n, m) factors of g to g^(m−1).
    """

    left: Array
    right: Array
    rising: NDArray[np.bool_]
    alpha: Array

    @property
    def weights(self) -> Array:
        """Weights (n, m) on g, g', … at a that act like the hats on all that lies before a."""
        width = self.right - self.left
        order = self.alpha.shape[1]
        result = self.alpha.copy()
        if order > 1:
            result[:, 1:] += (MEAN[self.rising * 1] * width)[:, None] * self.alpha[:, :-1]
        if order > 2:
            result[:, 2] += SQUARE[self.rising * 1] * width**2 * self.alpha[:, 0]
        return result

    @property
    def poly(self) -> Array:
        """What they add to ψ between a and b: (n, DEGREE + 1) in s, from 0 to 1 along it.

        ∫ ρ(x) (x − τ)^p/p! dx over x > τ; with v = 1 − s it is 2 h^p v^(p+2)/(p+2)! of a falling
        one, and 2 h^p [v^(p+1)/(p+1)! − v^(p+2)/(p+2)!] of a rising one.
        """
        width, order = self.right - self.left, self.alpha.shape[1]
        powers = width[:, None] ** np.arange(order - 1, -1, -1)
        shapes = np.where(self.rising[:, None, None], RISING[-order:], FALLING[-order:])
        return np.asarray(np.einsum("nk,nkj->nj", self.alpha * powers, shapes))


def _shifted_power(n: int) -> Array:
    """2 (1 − s)^n / n!: (DEGREE + 1,)."""
    result = np.zeros(DEGREE + 1)
    result[: n + 1] = [2.0 * comb(n, j) * (-1.0) ** j / factorial(n) for j in range(n + 1)]
    return result


MEAN, SQUARE = np.array([1.0, 2.0]) / 3.0, np.array([1.0, 3.0]) / 12.0  # falling, rising; over 2!
FALLING = np.stack([_shifted_power(p + 2) for p in (2, 1, 0)])  # for k = m − 1 − p
RISING = np.stack([_shifted_power(p + 1) for p in (2, 1, 0)]) - FALLING


def distribute_to_intervals(x: Array, mass: Array) -> tuple[Array, Array]:
    """Point multipliers given to the intervals between their points, by their widths.

    Returns:
        masses of falling hats and of rising ones, (r − 1,) each.
    """
    gaps = np.diff(x)
    reach = np.concatenate([gaps, [0.0]]) + np.concatenate([[0.0], gaps])
    return mass[:-1] * gaps / reach[:-1], mass[1:] * gaps / reach[1:]
