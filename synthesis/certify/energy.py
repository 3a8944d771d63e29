"""Root mean squares over the turn by Gauss quadrature with a proven error."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Final

import numpy as np

from synthesis.numerics.enclosure import Enclosed
from synthesis.numerics.jets import Jets
from synthesis.numerics.piecewise import Array, Piecewise
from synthesis.units import FULL_TURN

WAVE_NODES: Final = 64
RHO: Final = 8.0  # Bernstein ellipse on which the integrand of a wave piece is bounded
ROUNDING: Final = 1e-13  # relative, of the quadrature's nodes, weights and sums


@lru_cache(maxsize=64)
def _gauss(count: int) -> tuple[Array, Array]:
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return nodes, weights


def rms(jets: Jets, order: int) -> Enclosed:
    """√(1/2π ∫ (f^(order))² dx) over the whole turn.

    Gauss quadrature is exact for polynomial pieces. On wave pieces its error is at most
    (64/15) M ρ^(−2n) / (1 − ρ^(−2)), M the largest |f^(order)|² on the Bernstein ellipse
    (Trefethen, Approximation Theory and Approximation Practice, theorem 19.3).
    """
    curve = jets.curve
    nodes, weights = _gauss(WAVE_NODES if curve.waves.shape[1] else curve.poly.shape[1])
    half = 0.5 * np.diff(curve.breaks)
    middle = 0.5 * (curve.breaks[:-1] + curve.breaks[1:])
    x = middle[:, None] + half[:, None] * nodes
    value, blur = jets.at(np.repeat(np.arange(curve.count), len(nodes)), x.ravel(), order)
    squares, blurs = value * value, blur * (2.0 * np.abs(value) + blur)
    total = float(half @ (squares.reshape(x.shape) @ weights))
    error = float(half @ (blurs.reshape(x.shape) @ weights)) + ROUNDING * total
    error += _truncation(curve, order, half, len(nodes))
    low, high = max(total - error, 0.0), total + error
    ends = [math.sqrt(part / FULL_TURN) for part in (total, low, high)]
    return Enclosed(ends[0], ends[1], ends[2], 0.0)


def _truncation(curve: Piecewise, order: int, half: Array, count: int) -> float:
    """What Gauss quadrature may miss on wave pieces."""
    if not curve.waves.shape[1]:
        return 0.0
    reach = 0.5 * (RHO + 1.0 / RHO) * half  # the ellipse lies in the disc of this radius
    away = np.abs(0.5 * (curve.breaks[:-1] + curve.breaks[1:]) - curve.origins) + reach
    poly = curve.poly
    for _ in range(order):
        poly = poly[:, 1:] * np.arange(1, poly.shape[1])
    largest = np.zeros(curve.count)
    for column in np.abs(poly).T[::-1]:
        largest = largest * away + column
    amplitude, frequency, _ = np.moveaxis(curve.waves, -1, 0)
    wave = np.abs(amplitude * frequency**order) * np.cosh(frequency * reach[:, None])
    largest = largest + np.sum(wave, axis=1)
    bound = half * largest**2 * (64.0 / 15.0) * RHO ** (-2.0 * count) / (1.0 - RHO**-2.0)
    return float(np.sum(bound))
