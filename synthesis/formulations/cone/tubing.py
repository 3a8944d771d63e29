"""What every better cam's law keeps to: bounds of g and g' at nodes, and from them in between."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from synthesis.numerics.piecewise import Array


@dataclass(frozen=True, eq=False)
class Tube:
    """Bounds of a normalised law at nodes: low ≤ g ≤ high, slow ≤ g' ≤ fast, (n,) each.

    ``cap`` bounds |g^(order)| everywhere, order 2 or 3.
    """

    nodes: Array
    low: Array
    high: Array
    slow: Array
    fast: Array
    order: int
    cap: float

    def speeds(self, x: Array) -> tuple[Array, Array]:
        """Bounds of g' at any x."""
        left = np.clip(np.searchsorted(self.nodes, x, "right") - 1, 0, len(self.nodes) - 2)
        before, after = x - self.nodes[left], self.nodes[left + 1] - x
        if self.order == 2:
            reach = (self.cap * before, self.cap * after)
            slow = np.maximum(self.slow[left] - reach[0], self.slow[left + 1] - reach[1])
            fast = np.minimum(self.fast[left] + reach[0], self.fast[left + 1] + reach[1])
            return slow, fast
        # |g'''| ≤ cap: g' leaves its chord by no more than this
        apart = 0.5 * self.cap * before * after
        slow = np.interp(x, self.nodes, self.slow) - apart
        return slow, np.interp(x, self.nodes, self.fast) + apart

    def positions(self, x: Array) -> tuple[Array, Array]:
        """Bounds of g at any x."""
        left = np.clip(np.searchsorted(self.nodes, x, "right") - 1, 0, len(self.nodes) - 2)
        before, after = x - self.nodes[left], self.nodes[left + 1] - x
        least, most = self._extremes()
        slow, fast = least[left], most[left]
        high = np.minimum(self.high[left] + before * fast, self.high[left + 1] - after * slow)
        low = np.maximum(self.low[left] + before * slow, self.low[left + 1] - after * fast)
        return low, high

    def _extremes(self) -> tuple[Array, Array]:
        """Bounds of g' over every interval."""
        width = np.diff(self.nodes)
        over = self.cap * width * (0.5 if self.order == 2 else 0.125 * width)
        slow = np.minimum(self.slow[:-1], self.slow[1:]) - over
        return slow, np.maximum(self.fast[:-1], self.fast[1:]) + over
