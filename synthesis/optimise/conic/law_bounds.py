"""Bounds of a law that every better cam satisfies: of g and g' at nodes, and in between.

Between two nodes a, b they follow from the cap of |g^(m)|, or of ∫ (g^(m))² dx. For m = 2 g'
differs from its value at a node by cap · distance at most, or √(square · distance); for m = 3 it
lies within cap/2 · (x − a)(b − x) of its chord, or √(square / 3(b − a)) · (x − a)(b − x): Schwarz's
inequality with Green's function G(x, ·) of u'' = f, ∫ G² = (x − a)² (b − x)² / 3(b − a).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

import numpy as np

from synthesis.numerics.piecewise import Array


@dataclass(frozen=True, eq=False)
class LawBounds:
    """Bounds of a normalised law at nodes: low ≤ g ≤ high, slow ≤ g' ≤ fast, (n,) each.

    ``cap`` bounds |g^(order)| everywhere, order 2 or 3; ``square``, where it is finite and the cap
    is not, ∫ (g^(order))² dx.
    """

    nodes: Array
    low: Array
    high: Array
    low_speed: Array
    high_speed: Array
    order: int
    cap: float
    square: float = inf

    def speed_bounds(self, x: Array) -> tuple[Array, Array]:
        """Bounds of g' at any x."""
        left = np.clip(np.searchsorted(self.nodes, x, "right") - 1, 0, len(self.nodes) - 2)
        before, after = x - self.nodes[left], self.nodes[left + 1] - x
        if self.order == 2:
            reach = [change(each, self.cap, self.square) for each in (before, after)]
            slow = np.maximum(self.low_speed[left] - reach[0], self.low_speed[left + 1] - reach[1])
            fast = np.minimum(
                self.high_speed[left] + reach[0], self.high_speed[left + 1] + reach[1]
            )
            return slow, fast
        # g' leaves its chord by no more than this
        deviation = bend(np.diff(self.nodes), self.cap, self.square)[left] * before * after
        slow = np.interp(x, self.nodes, self.low_speed) - deviation
        return slow, np.interp(x, self.nodes, self.high_speed) + deviation

    def position_bounds(self, x: Array) -> tuple[Array, Array]:
        """Bounds of g at any x."""
        left = np.clip(np.searchsorted(self.nodes, x, "right") - 1, 0, len(self.nodes) - 2)
        before, after = x - self.nodes[left], self.nodes[left + 1] - x
        # g' over every interval
        width = np.diff(self.nodes)
        caps = self.cap, self.square
        over = change(0.5 * width, *caps)
        if self.order == 3:
            over = 0.25 * bend(width, *caps) * width**2
        slow = (np.minimum(self.low_speed[:-1], self.low_speed[1:]) - over)[left]
        fast = (np.maximum(self.high_speed[:-1], self.high_speed[1:]) + over)[left]
        high = np.minimum(self.high[left] + before * fast, self.high[left + 1] - after * slow)
        low = np.maximum(self.low[left] + before * slow, self.low[left + 1] - after * fast)
        return low, high


def change(distance: Array, cap: float, square: float) -> Array:
    """What a function changes by over distances, with |f'| ≤ cap or, of none, ∫ f'² ≤ square."""
    return np.asarray(cap * distance if cap < inf else np.sqrt(square * distance))


def bend(width: Array, cap: float, square: float) -> Array:
    """Times (x − a)(b − x) what a function leaves its chord by on intervals, with |f''| ≤ cap or,
    of none, ∫ f''² ≤ square.
    """
    return np.asarray(0.5 * cap + 0.0 * width if cap < inf else np.sqrt(square / (3.0 * width)))
