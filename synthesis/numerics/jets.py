"""Piecewise functions and their derivatives as Taylor models on boxes."""

from __future__ import annotations

from math import factorial
from typing import Final

import numpy as np
from numpy.typing import NDArray

from synthesis.numerics.piecewise import Array, Piecewise
from synthesis.numerics.taylor import Taylor

UNIT: Final = 2.0**-53
HIGHEST: Final = 3  # models of f to f''' are on offer


class Jets:
    """Models of f, f', f'', f''' of one piecewise function; tables are made once.

    The Taylor series about a box's centre is exact for a polynomial: what a quadratic model drops
    is bounded by the higher coefficients there; of a sinusoid, by its amplitude.
    """

    def __init__(self, curve: Piecewise) -> None:
        self.curve = curve
        degree = curve.poly.shape[1] - 1
        self.rows = (max(degree, HIGHEST + 2) if curve.waves.shape[1] else degree) + 1
        table = np.zeros((degree + 1, self.rows, curve.count))
        for order in range(degree + 1):
            for j in range(degree + 1 - order):
                ratio = factorial(j + order) // factorial(j)
                table[j, order] = ratio * curve.poly[:, j + order]
        self._table = np.stack([table, np.abs(table)], axis=1)
        self._horner_ulps = (4.0 * degree + 8.0) * UNIT
        amplitude, frequency, self._phase = np.moveaxis(curve.waves, -1, 0)
        self._frequency = frequency
        powers = np.arange(self.rows + 1)[:, None, None]
        self._amplitudes = amplitude * frequency**powers

    def derivatives(self, piece: NDArray[np.intp], x: Array) -> tuple[Array, Array]:
        """Values of f^(k)(x), k < rows, by each piece's own formula, and bounds of their roundings.

        Args:
            piece: (n,) pieces. x: (n,) points.

        Returns:
            two arrays (rows, n).
        """
        t = x - self.curve.origins[piece]
        table = self._table[..., piece]
        both = np.stack([t, np.abs(t)])[:, None, :]
        value = table[-1]
        for row in table[-2::-1]:
            value = value * both + row
        exact, error = value[0], self._horner_ulps * value[1]
        if self.curve.waves.shape[1]:
            turn, phase = self._frequency[piece] * t[:, None], self._phase[piece]
            angle = turn + phase
            sine, cosine = np.sin(angle), np.cos(angle)
            amplitude = self._amplitudes[: self.rows, piece]
            turns = np.stack([(sine, cosine, -sine, -cosine)[k % 4] for k in range(self.rows)])
            exact = exact + np.sum(amplitude * turns, axis=-1)
            spread = 16.0 * UNIT * (1.0 + np.abs(turn) + np.abs(phase))
            error = error + np.sum(np.abs(amplitude) * spread, axis=-1)
        return exact, error

    def at(self, piece: NDArray[np.intp], x: Array, order: int) -> tuple[Array, Array]:
        """f^(order)(x) and a bound of its rounding, (n,) each."""
        value, error = self.derivatives(piece, x)
        if order >= self.rows:
            return np.zeros_like(x), np.zeros_like(x)
        return value[order], error[order]

    def models(
        self, piece: NDArray[np.intp], lo: Array, hi: Array, highest: int
    ) -> tuple[Taylor, ...]:
        """f, f', …, f^(highest) on the boxes [lo, hi], each inside its (closed) piece.

        Args:
            piece: (n,) pieces. lo, hi: (n,) ends of the boxes. highest: at most 3.
        """
        centre = 0.5 * (lo + hi)
        # so much wider that the roundings of the centre, and of its distance to the origin, fit in
        r = 0.5 * (hi - lo) + 8.0 * UNIT * (np.abs(centre) + np.abs(self.curve.origins[piece]))
        exact, error = self.derivatives(piece, centre)
        power = [np.ones_like(r)]
        for j in range(1, self.rows + 1):
            power.append(power[-1] * r / j)
        size = np.abs(exact) + error
        return tuple(self._model(piece, k, exact, error, size, power) for k in range(highest + 1))

    def _model(
        self,
        piece: NDArray[np.intp],
        k: int,
        exact: Array,
        error: Array,
        size: Array,
        power: list[Array],
    ) -> Taylor:
        """The model of f^(k); ``power[j]`` is r^j / j!."""
        zero = np.zeros_like(power[0])
        head = [exact[k + j] * power[j] if k + j < self.rows else zero for j in range(3)]
        rem = zero
        for m in range(k, self.rows):
            rem = rem + (error if m < k + 3 else size)[m] * power[m - k]
        if self.curve.waves.shape[1]:
            amplitude = np.sum(np.abs(self._amplitudes[self.rows, piece]), axis=-1)
            rem = rem + amplitude * power[self.rows - k]
        return Taylor.of(head[0], head[1], head[2], rem * (1.0 + 64.0 * UNIT))
