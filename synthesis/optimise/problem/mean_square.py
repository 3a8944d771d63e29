"""Mean squares of a derivative over the turn, as exact quadratic forms of the coefficients."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import factorial

import numpy as np
from numpy.typing import NDArray

from synthesis.catalogue.motion import PlacedSegment
from synthesis.numerics.piecewise import Array, Piecewise, gauss_points
from synthesis.optimise.problem.grid import TYPICAL, Grid
from synthesis.units import FULL_TURN

ROUNDING = 1e-9  # relative, of a least mean square: the Gram matrix loses three digits of sixteen


@dataclass(frozen=True, eq=False)
class Energy:
    """1/2π ∫ (s^(k))² dθ = Σ ‖factors[i] c_i‖² + constant.

    Attributes:
        order: k. factors: one (r, n) matrix per free segment. constant: share of given laws.
        weights: (n_free,) factor W with which ∫ (g^(k))² dx enters.
        least: (n_free,) what each law has of it at least, by its ends alone; 0 while they are open.
    """

    order: int
    factors: tuple[Array, ...]
    constant: float
    weights: Array
    least: Array

    @property
    def rows(self) -> int:
        """Number of Gauss points of all free segments."""
        return sum(len(factor) for factor in self.factors)

    def of_laws(self, positions: Sequence[int]) -> tuple[Energy, NDArray[np.intp]]:
        """The same of some laws alone, and the numbers of their rows."""
        ends = np.cumsum([0, *(len(factor) for factor in self.factors)])
        rows = [np.arange(ends[k], ends[k + 1]) for k in positions]
        factors, chosen = tuple(self.factors[k] for k in positions), list(positions)
        part = replace(
            self, factors=factors, weights=self.weights[chosen], least=self.least[chosen]
        )
        return part, np.concatenate([np.zeros(0, dtype=np.intp), *rows])

    def between(self, ends: Sequence[tuple[Array, Array]]) -> Energy:
        """The same with what each law has at least between its known g, g', … at 0 and at 1."""
        each = (least_between(start, end, self.order) for start, end in ends)
        return replace(self, least=self.weights * np.array(list(each)))

    @property
    def unit(self) -> float:
        """Natural scale: what good laws on the free segments make of it."""
        return float(np.sum(self.weights) * TYPICAL[self.order] ** 2) or 1.0


def energy(segments: Sequence[PlacedSegment], grids: Sequence[Grid], order: int) -> Energy:
    """Gauss points on every knot interval integrate the squared polynomials exactly."""
    factors, weights = [], []
    free = [s for s in segments if s.law is None]
    for segment, grid in zip(free, grids, strict=True):
        weight = (segment.lift / segment.angle**order) ** 2 * segment.angle / FULL_TURN
        points = gauss_points(grid.space.breaks, grid.space.degree - order + 1)
        x, share = (each.ravel() for each in points)
        factors.append(np.sqrt(weight * share)[:, None] * grid.space.basis(x, order))
        weights.append(weight)
    given = sum(mean_square(s.placed(), order) for s in segments if s.law is not None)
    return Energy(order, tuple(factors), given, np.array(weights), np.zeros(len(weights)))


def least_between(start: Array, end: Array, order: int) -> float:
    """The least ∫ (g^(order))² dx over [0, 1] with g, g', … known at 0 and at 1, (p,) and (q,).

    By Taylor's formula the known g^(k)(1) are what the values at 0 make of them, and integrals of
    g^(order) with kernels (1 − τ)^n/n!, n = order − 1 − k. Of all functions with these integrals d
    the least one is a sum of the kernels: with their Gram matrix G it has dᵀ G⁻¹ d. Unknown values
    at 0 are those that make this least.
    """
    start, end, n = start[:order], end[:order], order - 1 - np.arange(len(end[:order]))
    taylor = np.array(
        [[1.0 / factorial(j - k) if j >= k else 0.0 for j in range(order)] for k in range(len(end))]
    )
    factorials = np.array([factorial(int(each)) for each in n], dtype=float)
    gram = 1.0 / ((n[:, None] + n + 1.0) * np.outer(factorials, factorials))
    missing = np.column_stack([end - taylor[:, : len(start)] @ start, taylor[:, len(start) :]])
    (rest, *free) = np.linalg.solve(np.linalg.cholesky(gram), missing).T
    if free:
        matrix = np.array(free).T
        rest = rest - matrix @ np.linalg.lstsq(matrix, rest, rcond=None)[0]
    return float(rest @ rest) * (1.0 - ROUNDING)


def mean_square(curve: Piecewise, order: int) -> float:
    """1/2π ∫ (f^(order))² over the pieces, by 24-point Gauss on every piece."""
    x, weights = gauss_points(curve.breaks, 24)
    value = curve.at(x.ravel(), np.repeat(np.arange(curve.count), 24), order)
    return float(weights.ravel() @ value**2 / FULL_TURN)
