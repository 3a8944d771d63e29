"""Multipliers that are densities: hats between two points, exactly as ψ sees them.

Where a limit is met all along an arc its true multiplier is a density, and ψ vanishes there. Point
multipliers make ψ jump or bend at every point instead, and the bound pays for that. A hat is a
density of mass 1 that rises or falls in proportion between a and b. To the left of a it acts like
its moments about a; between a and b ψ gets a polynomial.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import comb, factorial

import numpy as np
from numpy.typing import NDArray

from synthesis.numerics.piecewise import Array

DEGREE = 4  # of what a density of g itself adds to ψ where the third derivative steers


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
        found = self.alpha.copy()
        if order > 1:
            found[:, 1:] += (MEAN[self.rising * 1] * width)[:, None] * self.alpha[:, :-1]
        if order > 2:
            found[:, 2] += SQUARE[self.rising * 1] * width**2 * self.alpha[:, 0]
        return found

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


def _power(n: int) -> Array:
    """2 (1 − s)^n / n!: (DEGREE + 1,)."""
    found = np.zeros(DEGREE + 1)
    found[: n + 1] = [2.0 * comb(n, j) * (-1.0) ** j / factorial(n) for j in range(n + 1)]
    return found


MEAN, SQUARE = np.array([1.0, 2.0]) / 3.0, np.array([1.0, 3.0]) / 12.0  # falling, rising; over 2!
FALLING = np.stack([_power(p + 2) for p in (2, 1, 0)])  # for k = m − 1 − p
RISING = np.stack([_power(p + 1) for p in (2, 1, 0)]) - FALLING


def shared(x: Array, mass: Array) -> tuple[Array, Array]:
    """Point multipliers given to the intervals between their points, by their widths.

    Returns:
        masses of falling hats and of rising ones, (r − 1,) each.
    """
    gaps = np.diff(x)
    reach = np.concatenate([gaps, [0.0]]) + np.concatenate([[0.0], gaps])
    return mass[:-1] * gaps / reach[:-1], mass[1:] * gaps / reach[1:]
