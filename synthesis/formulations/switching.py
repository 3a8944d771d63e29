"""The switching function ψ of a free law: what its highest bounded derivative is worth.

By weak duality every law pays ∫ ψ w dx with w = g^(m); a row with multiplier λ at x_i that reads
alpha · (g, g', …) contributes λ alpha_k (x_i − τ)^(m−1−k) / (m−1−k)! for τ < x_i. So ψ is a
polynomial of degree m − 1 between the points, and where it changes sign the ideal law switches.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import comb, factorial

import numpy as np

from synthesis.numerics.peaks import quadratic_roots
from synthesis.numerics.piecewise import Array

SPREAD = 8  # parts of an interval over which a point multiplier is spread
NODES, SHARES = np.polynomial.legendre.leggauss(3)  # exact to degree 5 between the cuts


@dataclass(frozen=True, eq=False)
class Switching:
    """ψ(τ) = Σ_j poly[i, j] τ^j on [breaks[i], breaks[i+1]], breaks from 0 to 1."""

    breaks: Array
    poly: Array

    def __call__(self, tau: Array) -> Array:
        """ψ at τ, of the piece on the right."""
        piece = np.clip(np.searchsorted(self.breaks, tau, "right") - 1, 0, len(self.poly) - 1)
        return np.asarray(sum(self.poly[piece, j] * tau**j for j in range(self.poly.shape[1])))

    def crossings(self, value: float = 0.0) -> Array:
        """Points inside (0, 1) where ψ − value changes sign, at jumps as well."""
        cuts = self._cut((value,))
        middle = self(0.5 * (cuts[:-1] + cuts[1:])) - value
        changes = np.sign(middle[:-1]) != np.sign(middle[1:])
        return np.asarray(cuts[1:-1][changes], dtype=float)

    def raised(self, spans: Array, heights: Array) -> Switching:
        """ψ raised by a height all along each span: (r, 2) and (r,)."""
        if not len(spans):
            return self
        breaks = np.unique(np.concatenate([self.breaks, spans.ravel()]))
        middle = 0.5 * (breaks[:-1] + breaks[1:])
        poly = self.poly[np.searchsorted(self.breaks, middle, "right") - 1]
        over = (spans[:, :1] < middle) & (middle < spans[:, 1:])
        poly[:, 0] += heights @ over
        return Switching(breaks, poly)

    def least(self, cap: float, weight: float) -> float:
        """∫ min over |w| ≤ cap of (weight w² + ψ w), exact: never positive.

        Args:
            cap: bound of |w|, may be infinite if weight is positive.
            weight: ≥ 0.
        """
        edge = 2.0 * weight * cap
        values = (0.0,) if weight == 0.0 or not np.isfinite(edge) else (0.0, edge, -edge)
        cuts = self._cut(values)
        width = np.diff(cuts)
        tau = cuts[:-1, None] + width[:, None] * (NODES + 1.0) / 2.0
        psi = np.abs(self(tau))
        if weight == 0.0:
            value = -cap * psi
        else:
            inner = -(psi**2) / (4.0 * weight)
            outer = -cap * psi + weight * cap**2 if np.isfinite(cap) else inner
            value = np.where(psi <= edge, inner, outer)
        return float(np.sum(value * SHARES * width[:, None]) / 2.0)

    def losses(
        self, knots: Array, law: Callable[[Array], Array], cap: float, weight: float
    ) -> Array:
        """What a law pays more than the ideal one, knot interval by knot interval: (n,) ≥ 0.

        Args:
            knots: (n+1,) from 0 to 1.
            law: its steering derivative at given x, right-hand values.
            cap, weight: as in ``least``.
        """
        cuts = np.union1d(self._cut((0.0,)), knots)
        width = np.diff(cuts)
        tau = cuts[:-1, None] + width[:, None] * (NODES + 1.0) / 2.0
        psi, w = self(tau), law(tau)
        paid = weight * w**2 + psi * w
        ideal = -cap * np.abs(psi) if weight == 0.0 else -(psi**2) / (4.0 * weight)
        loss = np.sum((paid - ideal) * SHARES, axis=1) * width / 2.0
        interval = np.searchsorted(knots, 0.5 * (cuts[:-1] + cuts[1:]), "right") - 1
        sums = np.bincount(interval, np.maximum(loss, 0.0), minlength=len(knots) - 1)
        return np.asarray(sums, dtype=float)

    def _cut(self, values: tuple[float, ...]) -> Array:
        """The breaks and every root of ψ − value, sorted."""
        found = [self.breaks]
        padded = np.zeros((len(self.poly), 3))
        padded[:, : self.poly.shape[1]] = self.poly
        c, b, a = padded.T
        for value in values:
            for root in quadratic_roots(a, b, c - value):
                inside = (root > self.breaks[:-1]) & (root < self.breaks[1:])
                found.append(root[inside])
        return np.unique(np.concatenate(found))


def switching(points: Array, weights: Array, order: int) -> Switching:
    """ψ from point rows.

    Args:
        points: (r,) x_i in [0, 1].
        weights: (r, order) λ_i alpha_k for k < order.
        order: m.
    """
    sorting = np.argsort(points)
    x, w = points[sorting], weights[sorting]
    coefficients = np.zeros((len(x), order))
    for k in range(order):
        n = order - 1 - k
        for j in range(n + 1):
            # (x − τ)^n / n!, coefficient of τ^j
            coefficients[:, j] += w[:, k] * comb(n, j) * (-1.0) ** j * x ** (n - j) / factorial(n)
    suffix = np.cumsum(coefficients[::-1], axis=0)[::-1]
    inner = (x > 0.0) & (x < 1.0)
    breaks, first = np.unique(np.concatenate([[0.0], x[inner], [1.0]]), return_index=True)
    del first
    # on [breaks[i], breaks[i+1]] every row with x ≥ breaks[i+1] counts
    at = np.searchsorted(x, breaks[1:], side="left")
    table = np.vstack([suffix, np.zeros((1, order))])[at]
    return Switching(breaks, table)


def spread(x: Array, mass: Array) -> tuple[Array, Array]:
    """Point multipliers of a bound that holds everywhere, spread as hats between their points.

    A point multiplier on the derivative just below the steering one makes ψ jump; where that
    bound is met along an arc the true multiplier is a density, and ψ vanishes there. Any
    non-negative measure of any shape is valid, this one is closer to the truth.
    """
    if len(x) < 2:
        return x, mass  # nothing to spread over
    sorting = np.argsort(x)
    x, mass = x[sorting], mass[sorting]
    gaps = np.diff(x)
    reach = np.concatenate([gaps, [0.0]]) + np.concatenate([[0.0], gaps])
    share = (np.arange(SPREAD) + 0.5) / SPREAD
    left = mass[:-1] * gaps / reach[:-1]  # of each point to its right-hand interval
    right = mass[1:] * gaps / reach[1:]  # of the next point to the same interval
    falling, rising = 1.0 - share, share
    spread = left[:, None] * falling / falling.sum() + right[:, None] * rising / rising.sum()
    return (x[:-1, None] + gaps[:, None] * share).ravel(), spread.ravel()
