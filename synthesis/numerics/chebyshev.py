"""Functions on many intervals at once, by their values at Chebyshev's points.

The values at the points of one interval are those of a polynomial near to the function: they give
its integral (Clenshaw–Curtis) and tell where it is largest. Sources: Trefethen, *Approximation
Theory and Approximation Practice*, chapters 2, 5 and 19.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from numpy.polynomial.chebyshev import chebvander

from synthesis.numerics.piecewise import Array, Indices

POLYNOMIAL_DEGREE: Final = (
    14  # of the polynomial on an interval: even, so that its middle is a point
)
EQUAL: Final = 1e-13  # relative: tops of polynomials that differ by less are equally high
DENSE: Final = 257  # places between which a parabola has its vertex to about 1e-14 of the value

_ANGLES: Final = np.pi * np.arange(POLYNOMIAL_DEGREE + 1) / POLYNOMIAL_DEGREE
POINTS: Final = 0.5 - 0.5 * np.cos(_ANGLES)  # on [0, 1], both ends among them
_PLACES: Final = np.linspace(0.0, 1.0, DENSE)
_VALUES: Final = chebvander(2.0 * POINTS - 1.0, POLYNOMIAL_DEGREE)
_TO_DENSE: Final = np.linalg.solve(_VALUES.T, chebvander(2.0 * _PLACES - 1.0, POLYNOMIAL_DEGREE).T)
# weights of the integral over [0, 1]: exact for T_k, whose integral is 1/(1 − k²) for even k
_MOMENTS: Final = np.where(
    np.arange(POLYNOMIAL_DEGREE + 1) % 2 == 0,
    1.0 / (1.0 - np.arange(POLYNOMIAL_DEGREE + 1.0) ** 2 + 1e-300),
    0.0,
)
_WEIGHTS: Final = np.linalg.solve(_VALUES.T, _MOMENTS)


@dataclass(frozen=True, eq=False)
class Grid:
    """Chebyshev's points on intervals [low, high] (n,), each within one piece of a function.

    ``x``, ``weights``, ``piece``: (n · points,), interval by interval.
    """

    low: Array
    high: Array
    owner: Indices

    @classmethod
    def of(cls, breaks: Array, widest: float) -> Grid:
        """The pieces between breaks (m+1,), divided evenly until none is wider."""
        parts = np.maximum(np.ceil(np.diff(breaks) / widest - 1e-9), 1.0).astype(np.intp)
        owner = np.arange(len(parts)).repeat(parts)
        step = np.arange(len(owner)) - np.repeat(np.cumsum(parts) - parts, parts)
        width = (np.diff(breaks) / parts)[owner]
        low = breaks[owner] + step * width
        high = np.where(step == parts[owner] - 1, breaks[owner + 1], low + width)
        return cls(low, high, owner)

    @cached_property
    def x(self) -> Array:
        """The points."""
        x = self.low[:, None] + (self.high - self.low)[:, None] * POINTS
        x[:, -1] = self.high
        return np.asarray(x.ravel())

    @cached_property
    def weights(self) -> Array:
        """Weights of the integral over all intervals."""
        return np.asarray(((self.high - self.low)[:, None] * _WEIGHTS).ravel())

    @cached_property
    def piece(self) -> Indices:
        """Piece of every point."""
        return self.owner.repeat(POLYNOMIAL_DEGREE + 1)

    def highest(self, values: Array, signs: Sequence[tuple[int, float]]) -> tuple[Indices, Array]:
        """Where functions with these values (k, points) are largest: interval and x, (n,) each.

        ``signs``: of each question which function, and 1 for its largest, −1 for its smallest
        value. Of equals the first. All values are finite numbers.
        """
        seen = values.reshape(len(values), -1, len(POINTS))
        # intervals that may hold the extreme value: between two points a function leaves what it
        # is at both by no more than it changes from point to point
        spread = np.abs(seen[..., 1:] - seen[..., :-1]).max(axis=2)
        tops, lows = seen.max(axis=2), seen.min(axis=2)
        found = []
        for k, sign in signs:
            top = tops[k] if sign > 0.0 else -lows[k]
            near = (top + spread[k] >= top.max()).nonzero()[0]
            found.append(self._top_of(near, sign * seen[k]))
        return np.array([k for k, _ in found]), np.array([x for _, x in found])

    def _top_of(self, near: Indices, row: Array) -> tuple[int, float]:
        """Of these intervals the one with the highest polynomial, and where its top is."""
        curve = row[near] @ _TO_DENSE
        tops = curve.max(axis=1)
        best = int((tops >= tops.max() - EQUAL * abs(tops.max())).argmax())
        line, chosen = curve[best], int(near[best])
        k = int(line.argmax())
        middle = min(max(k, 1), DENSE - 2)
        before, here, after = line[middle - 1 : middle + 2].tolist()
        bend = 2.0 * here - before - after
        shift = 0.5 * (after - before) / bend if bend > 0.0 and k == middle else k - middle
        share = min(max((middle + shift) / (DENSE - 1), 0.0), 1.0)
        width = self.high[chosen] - self.low[chosen]
        return chosen, float(min(self.low[chosen] + width * share, self.high[chosen]))
