"""Piecewise functions and their derivatives as Taylor models on boxes."""

from __future__ import annotations

from typing import Final

import numpy as np

from synthesis.numerics.piecewise import Array, Indices, Piecewise, horner
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
        degree, waves = curve.poly.shape[1] - 1, curve.waves.shape[1] > 0
        self.rows = (max(degree, HIGHEST + 2) if waves else degree) + 1  # that do not vanish
        self._falling = np.stack([curve.descending, np.abs(curve.descending)], axis=1)
        self._horner_ulps = (4.0 * degree + 8.0) * UNIT
        amplitude, frequency, self._phase = curve.waves.transpose(2, 0, 1)
        self._frequency = frequency
        powers = np.arange(self.rows + 1)[:, None, None]
        self._amplitudes = amplitude * frequency**powers

    def derivatives(self, piece: Indices, x: Array) -> tuple[Array, Array]:
        """Values of f^(k)(x) by each piece's own formula, and bounds of their roundings.

        Args:
            piece: (n,) pieces. x: (n,) points.

        Returns:
            two arrays (k, n) of all rows that do not vanish, of f to f^(5) at the least.
        """
        t = x - self.curve.origins[piece]
        count = max(self.rows, HIGHEST + 3)
        both = horner(self._falling.take(piece, axis=-1), np.stack([t, np.abs(t)]), count - 1)
        exact, error = both[:, 0], self._horner_ulps * both[:, 1]
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

    def models(self, piece: Indices, lo: Array, hi: Array, highest: int) -> tuple[Taylor, ...]:
        """f, f', …, f^(highest) on the boxes [lo, hi], each inside its (closed) piece.

        Args:
            piece: (n,) pieces. lo, hi: (n,) ends of the boxes. highest: at most 3.
        """
        centre = 0.5 * (lo + hi)
        # so much wider that the roundings of the centre, and of its distance to the origin, fit in
        r = 0.5 * (hi - lo) + 8.0 * UNIT * (np.abs(centre) + np.abs(self.curve.origins[piece]))
        exact, error = self.derivatives(piece, centre)
        # 1. r^j/j!, by which the derivatives at the centre become coefficients
        power = [np.ones_like(r), r]
        for j in range(2, max(self.rows, 2) + 1):
            power.append(power[-1] * (r / j))
        # 2. quadratic part, and roundings of its coefficients; row k is that of f^(k)
        count = highest + 1
        head = (exact[:count], exact[1 : count + 1] * power[1], exact[2 : count + 2] * power[2])
        rem = error[:count] + error[1 : count + 1] * power[1] + error[2 : count + 2] * power[2]
        # 3. what the quadratic drops; polynomials end, a sinusoid is bounded by its amplitude
        for j in range(3, self.rows):
            rest = min(count, self.rows - j)
            rem[:rest] += (np.abs(exact[j : j + rest]) + error[j : j + rest]) * power[j]
        if self.curve.waves.shape[1]:
            amplitude = np.sum(np.abs(self._amplitudes[self.rows, piece]), axis=-1)
            for k in range(count):
                rem[k] += amplitude * power[self.rows - k]
        rem *= 1.0 + 64.0 * UNIT
        mag = np.abs(head[0]) + np.abs(head[1]) + np.abs(head[2]) + rem
        return tuple(map(Taylor, *head, rem, mag))
