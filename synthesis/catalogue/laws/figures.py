"""Figures of a normalised law g(x): peaks of its derivatives, their mean squares, C_va."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np

from synthesis.numerics.maxima import maximise, maximise_formula
from synthesis.numerics.piecewise import Array, Piecewise, gauss_points
from synthesis.numerics.polynomial_extrema import Extremum, extreme_values, product

WAVE_NODES: Final = 32  # of Gauss's rule on a piece with sinusoids of at most two periods
ORDERS: Final = (1, 2, 3)  # velocity, acceleration, jerk


@dataclass(frozen=True)
class LawFigures:
    """Of g over its closed pieces, one-sided at breaks.

    Attributes:
        extremes: for g', g'', g''' the largest and the smallest value, each with its x.
        product: the same of g' g''. mean_squares: ∫ (g^(k))² dx over [0, 1], k = 1 to 3.
    """

    extremes: tuple[tuple[Extremum, Extremum], ...]
    product: tuple[Extremum, Extremum]
    mean_squares: tuple[float, ...]

    def peak(self, order: int) -> float:
        """Largest |g^(order)|."""
        return max(abs(value) for value, _ in self.extremes[order - 1])

    @property
    def product_peak(self) -> float:
        """C_va: largest |g' g''|."""
        return max(abs(value) for value, _ in self.product)


@lru_cache(maxsize=256)
def figures(law: Piecewise) -> LawFigures:
    """The figures of a law.

    Polynomials have their extremes at ends of pieces and roots of the derivative, and Gauss's rule
    is exact for their squares. Of pieces with sinusoids every extreme is closed in on from samples
    until rounding.
    """
    if law.waves.shape[1]:
        extremes = tuple(_wave_extremes(law, order) for order in ORDERS)
        up = maximise_formula(law, lambda g: g[1] * g[2], 2)
        down = maximise_formula(law, lambda g: -g[1] * g[2], 2)
        both = up, (-down[0], down[1])
    else:
        extremes = tuple(extreme_values(law, order) for order in ORDERS)
        both = extreme_values(product(law, 1, 2))
    return LawFigures(extremes, both, tuple(_mean_squares(law).tolist()))


def _wave_extremes(law: Piecewise, order: int) -> tuple[Extremum, Extremum]:
    up, down = (maximise(law, [*[0.0] * order, sign]) for sign in (1.0, -1.0))
    return up, (-down[0], down[1])


def _mean_squares(law: Piecewise) -> Array:
    count = WAVE_NODES if law.waves.shape[1] else max(law.poly.shape[1] - 1, 1)
    x, weights = gauss_points(law.breaks, count)
    rates = law.jet(x.ravel(), np.arange(law.count).repeat(count), 3)[1:]
    return np.asarray((rates * rates) @ weights.ravel())
