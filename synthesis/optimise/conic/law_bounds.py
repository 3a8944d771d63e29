"""Bounds of a law that every better cam satisfies: of g and g' at nodes, and in between.

Between two nodes they follow from the cap of |g^(m)|: for m = 2 g' differs from its value at a node
by cap · distance at most; for m = 3 g' lies within cap/2 · (x − a)(b − x) of its chord.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from synthesis.numerics.piecewise import Array


@dataclass(frozen=True, eq=False)
class LawBounds:
    """Bounds of a normalised law at nodes: low ≤ g ≤ high, slow ≤ g' ≤ fast, (n,) each.

    ``cap`` bounds |g^(order)| everywhere, order 2 or 3.
    """

    nodes: Array
    low: Array
    high: Array
    low_speed: Array
    high_speed: Array
    order: int
    cap: float

    def speed_bounds(self, x: Array) -> tuple[Array, Array]:
        """Bounds of g' at any x."""
        left = np.clip(np.searchsorted(self.nodes, x, "right") - 1, 0, len(self.nodes) - 2)
        before, after = x - self.nodes[left], self.nodes[left + 1] - x
        if self.order == 2:
            reach = (self.cap * before, self.cap * after)
            slow = np.maximum(self.low_speed[left] - reach[0], self.low_speed[left + 1] - reach[1])
            fast = np.minimum(
                self.high_speed[left] + reach[0], self.high_speed[left + 1] + reach[1]
            )
            return slow, fast
        # |g'''| ≤ cap: g' leaves its chord by no more than this
        deviation = 0.5 * self.cap * before * after
        slow = np.interp(x, self.nodes, self.low_speed) - deviation
        return slow, np.interp(x, self.nodes, self.high_speed) + deviation

    def position_bounds(self, x: Array) -> tuple[Array, Array]:
        """Bounds of g at any x."""
        left = np.clip(np.searchsorted(self.nodes, x, "right") - 1, 0, len(self.nodes) - 2)
        before, after = x - self.nodes[left], self.nodes[left + 1] - x
        # g' over every interval
        width = np.diff(self.nodes)
        over = self.cap * width * (0.5 if self.order == 2 else 0.125 * width)
        slow = (np.minimum(self.low_speed[:-1], self.low_speed[1:]) - over)[left]
        fast = (np.maximum(self.high_speed[:-1], self.high_speed[1:]) + over)[left]
        high = np.minimum(self.high[left] + before * fast, self.high[left + 1] - after * slow)
        low = np.maximum(self.low[left] + before * slow, self.low[left + 1] - after * fast)
        return low, high
