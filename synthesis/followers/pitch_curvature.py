"""Rows implied by a bound on the curvature that a point on a slide draws on the turning cam.

With the point's height X, its offset e and u = X' − e (of a roller X = s0 + s) the bound σκ ≤ k,
κ = [X² + u(2u + e) − X X''] / (X² + u²)^{3/2}, reads for X > 0

    σ X'' ≥ σ [X + 2(u + e/4)²/X] − σ e²/(8X) − k (X² + u²)^{3/2}/X

Each of the four terms is convex or concave in (X, u, e) as a whole: squares over X, and
(X² + u²)^{3/2}/X, are convex. So the right side is a difference A − B of convex functions, and over
a box it is nowhere below the tangent of A anywhere, less the lowest plane of a given slope that is
above B at every corner: linear in X, X', X'' and e. The narrower the box, the less is lost.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from synthesis.numerics.piecewise import Array
from synthesis.terms import Cuts, Traced

ROUNDING = 1e-13  # of the terms' size, by which a row is loosened
CORNERS = np.array(list(product((False, True), repeat=3))).T  # which ends: (3, 8)
Convex = tuple[Array, Array]  # a function's values (n,) and its slopes by X, u and e (3, n)


@dataclass(frozen=True)
class PitchCurvature(Traced):
    """side · κ ≤ most [1/mm], most > 0, of the curve that a point draws."""

    side: int
    most: float

    def cuts(self, low: Array, high: Array, about: Array | None) -> Cuts | None:
        if not (np.all(low[0] > 0.0) and np.all(np.isfinite(low)) and np.all(np.isfinite(high))):
            return None
        middle = 0.5 * (low + high)
        at = middle if about is None else np.clip(about, low, high)
        value, slopes = self._convex(at)
        _, other = self._subtracted(middle)
        corners = np.where(CORNERS[:, :, None], high[:, None], low[:, None])  # (3, 8, n)
        above = self._height(corners) - np.sum(other[:, None] * corners, axis=0)
        most = np.max(above, axis=0)
        # side X'' ≥ least + by · (X, u, e) all over the box
        by = slopes - other
        least = value - np.sum(slopes * at, axis=0) - most
        least -= ROUNDING * (np.abs(value) + np.abs(most) + np.sum(np.abs(slopes * at), axis=0))
        one, sign = np.ones_like(least), self.seen.sign
        coefficients = np.stack([sign * by[0], sign * by[1], -self.side * sign * one, 0.0 * one])
        known = np.array(self.seen.constants) @ by
        return Cuts(coefficients, np.array(self.seen.by).T @ by, -least - known)

    def _convex(self, at: Array) -> Convex:
        """A."""
        return _spread(at) if self.side > 0 else _leaning(at)

    def _height(self, at: Array) -> Array:
        """B alone, at points (3, …)."""
        x, u, e = at
        w = np.hypot(x, u)
        q = (u + 0.25 * e) / x
        rest = 0.125 * (e / x) * e if self.side > 0 else x + 2.0 * q * q * x
        return np.asarray(rest + self.most * (w**3 / x))

    def _subtracted(self, at: Array) -> Convex:
        """B."""
        bend, bends = _bend(at)
        rest, rests = _leaning(at) if self.side > 0 else _spread(at)
        return rest + self.most * bend, rests + self.most * bends


def _spread(at: Array) -> Convex:
    """X + 2 (u + e/4)²/X."""
    x, u, e = at
    q = (u + 0.25 * e) / x
    return x + 2.0 * q * q * x, np.stack([1.0 - 2.0 * q * q, 4.0 * q, q])


def _leaning(at: Array) -> Convex:
    """e²/(8X)."""
    x, u, e = at
    q = e / x
    return 0.125 * q * e, np.stack([-0.125 * q * q, 0.0 * u, 0.25 * q])


def _bend(at: Array) -> Convex:
    """(X² + u²)^{3/2}/X."""
    x, u, e = at
    w = np.hypot(x, u)
    return w**3 / x, np.stack([3.0 * w - w**3 / x**2, 3.0 * w * u / x, 0.0 * e])
