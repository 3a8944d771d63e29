"""Mean squares of a derivative over the turn, as exact quadratic forms of the coefficients."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from synthesis.catalogue.motion import PlacedSegment
from synthesis.numerics.piecewise import Array, Piecewise, gauss_points
from synthesis.optimise.problem.grid import TYPICAL, Grid
from synthesis.units import FULL_TURN


@dataclass(frozen=True, eq=False)
class Energy:
    """1/2π ∫ (s^(k))² dθ = Σ ‖factors[i] c_i‖² + constant.

    Attributes:
        order: k. factors: one (r, n) matrix per free segment. constant: share of given laws.
        weights: (n_free,) factor W with which ∫ (g^(k))² dx enters.
    """

    order: int
    factors: tuple[Array, ...]
    constant: float
    weights: Array

    @property
    def rows(self) -> int:
        """Number of Gauss points of all free segments."""
        return sum(len(factor) for factor in self.factors)

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
    return Energy(order, tuple(factors), given, np.array(weights))


def mean_square(curve: Piecewise, order: int) -> float:
    """1/2π ∫ (f^(order))² over the pieces, by 24-point Gauss on every piece."""
    x, weights = gauss_points(curve.breaks, 24)
    value = curve.at(x.ravel(), np.repeat(np.arange(curve.count), 24), order)
    return float(weights.ravel() @ value**2 / FULL_TURN)
