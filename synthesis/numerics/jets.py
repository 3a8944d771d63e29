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
        amplitude, frequency, self._phase = curve.waves.transpose(2, 0, 1)
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
        both = np.empty((2, 1, len(t)))
        both[0], both[1] = t, np.abs(t)
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
        power = np.ones((max(self.rows, 2) + 1, len(r)))  # r^j / j!
        for j in range(1, len(power)):
            power[j] = power[j - 1] * (r / j)
        return self._models(piece, exact, error, power, highest + 1)

    def _models(
        self, piece: NDArray[np.intp], exact: Array, error: Array, power: Array, count: int
    ) -> tuple[Taylor, ...]:
        """The models of f to f^(count−1), all in one go: row k is that of f^(k)."""
        missing = max(count + 2 - self.rows, 0)
        if missing:  # derivatives that vanish
            nothing = np.zeros((missing, power.shape[1]))
            exact, error = np.concatenate([exact, nothing]), np.concatenate([error, nothing])
        size = np.abs(exact) + error
        head = [exact[j : j + count] * power[j] for j in range(3)]
        rem = error[:count] + error[1 : count + 1] * power[1] + error[2 : count + 2] * power[2]
        for j in range(3, self.rows):
            rest = min(count, self.rows - j)
            rem[:rest] += size[j : j + rest] * power[j]
        if self.curve.waves.shape[1]:
            amplitude = np.sum(np.abs(self._amplitudes[self.rows, piece]), axis=-1)
            for k in range(count):
                rem[k] += amplitude * power[self.rows - k]
        rem *= 1.0 + 64.0 * UNIT
        mag = np.abs(head[0]) + np.abs(head[1]) + np.abs(head[2]) + rem
        return tuple(Taylor(*model) for model in zip(*head, rem, mag, strict=True))
