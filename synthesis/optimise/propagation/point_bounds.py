"""What every better cam's traced point keeps to along a law: bounds of X and u, nodes and between.

X is the point's height and u = X' − e how fast it moves past the axis. Bounded as they are, sums of
motion and size, they are narrower than motion and size one by one: what makes a cam larger makes
its law slower.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from synthesis.numerics.piecewise import Array


@dataclass(frozen=True, eq=False)
class PointBounds:
    """Bounds at nodes of a free law: low ≤ (X, u) ≤ high, (2, n) each; of (X, u, s'') (3, n).

    Attributes:
        nodes: (n,) in [0, 1]. parts: first and last node of every part of interest.
        angle: of the law [rad]. cap: cap of |u''| [length/rad²].
        monotone: whether X can only rise (1) or fall (−1) along the law; 0: either.
        offsets: least and largest e.
    """

    nodes: Array
    parts: tuple[tuple[float, float], ...]
    angle: float
    cap: float
    monotone: int
    low: Array
    high: Array
    offsets: tuple[float, float]

    @property
    def is_empty(self) -> bool:
        """Whether no cam keeps to it."""
        return bool(np.any(self.low > self.high)) or self.offsets[0] > self.offsets[1]

    @property
    def width(self) -> float:
        """How far X and u are open at a node, on average [length]."""
        return float(np.mean(self.high[:2] - self.low[:2]))

    def at(self, x: Array) -> tuple[Array, Array]:
        """Bounds of (X, u, e) at any x between the first node and the last: (3, m) each."""
        left = np.clip(np.searchsorted(self.nodes, x, "right") - 1, 0, len(self.nodes) - 2)
        before = self.angle * (x - self.nodes[left])
        after = self.angle * (self.nodes[left + 1] - x)
        # |u''| is capped: u leaves its chord by no more than this
        deviation = 0.5 * self.cap * before * after
        slow = np.interp(x, self.nodes, self.low[1]) - deviation
        fast = np.interp(x, self.nodes, self.high[1]) + deviation
        least, most = (speed[left] for speed in self._interval_speed_bounds())
        low = np.maximum(self.low[0, left] + before * least, self.low[0, left + 1] - after * most)
        high = np.minimum(
            self.high[0, left] + before * most, self.high[0, left + 1] - after * least
        )
        one = np.ones_like(x)
        return (
            np.stack([low, slow, self.offsets[0] * one]),
            np.stack([high, fast, self.offsets[1] * one]),
        )

    def acceleration_bounds(self, x: Array) -> tuple[Array, Array]:
        """Bounds of s'' at any x between the first node and the last: (m,) each.

        Infinite where they are not known at nodes.
        """
        if len(self.low) < 3:
            return np.full_like(x, -np.inf), np.full_like(x, np.inf)
        left = np.clip(np.searchsorted(self.nodes, x, "right") - 1, 0, len(self.nodes) - 2)
        before = self.cap * self.angle * (x - self.nodes[left])
        after = self.cap * self.angle * (self.nodes[left + 1] - x)
        low = np.maximum(self.low[2, left] - before, self.low[2, left + 1] - after)
        return low, np.minimum(self.high[2, left] + before, self.high[2, left + 1] + after)

    def _interval_speed_bounds(self) -> tuple[Array, Array]:
        """Bounds of X' = u + e over every interval."""
        width = self.angle * np.diff(self.nodes)
        over = 0.125 * self.cap * width**2
        slow = np.minimum(self.low[1, :-1], self.low[1, 1:]) - over + self.offsets[0]
        fast = np.maximum(self.high[1, :-1], self.high[1, 1:]) + over + self.offsets[1]
        if self.monotone > 0:
            slow = np.maximum(slow, 0.0)
        if self.monotone < 0:
            fast = np.minimum(fast, 0.0)
        return slow, fast
