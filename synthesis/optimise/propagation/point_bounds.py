"""Bounds of the point that a limit speaks of, at nodes of a law and between them.

Between two nodes they follow from the cap of |s^(m)|, or of ∫ (s^(m))² dθ by Schwarz's
inequality (``conic.law_bounds``). All of them hold for every motion that keeps to the bounds at
nodes and to the cap.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf

import numpy as np

from synthesis.numerics.piecewise import Array, Mask
from synthesis.optimise.conic.law_bounds import bend, change

CLOSEST_NODES = 0.005  # of a law: closer ones cost more linear programs than their rows gain
SAME = 1e-9  # of a part: rounding of a quotient that is a whole number
DEVIATION = 0.1  # of the bounds at two nodes: how far u may leave these in between


@dataclass(frozen=True, eq=False)
class PointBounds:
    """Bounds at nodes of a free law: low ≤ (X, u) ≤ high, (2, n) each; of (X, u, s'') (3, n).

    Sums of motion and size are bounded more narrowly than motion and size one by one: what makes a
    cam larger makes its law slower.

    Attributes:
        nodes: (n,) in [0, 1]. parts: first and last node of every part of interest.
        angle: of the law [rad]. order: m, 2 or 3. cap: of |s^(m)| [length/rad^m]. square: where the
            cap is infinite, of ∫ (s^(m))² dθ.
        monotone: whether X can only rise (1) or fall (−1) along the law; 0: either.
        offsets: least and largest e.
    """

    nodes: Array
    parts: tuple[tuple[float, float], ...]
    angle: float
    order: int
    cap: float
    monotone: int
    low: Array
    high: Array
    offsets: tuple[float, float]
    square: float = inf

    @property
    def is_empty(self) -> bool:
        """Whether no cam keeps to it."""
        return bool(np.any(self.low > self.high)) or self.offsets[0] > self.offsets[1]

    @property
    def width(self) -> float:
        """How far X and u are open, on average [length]: at nodes, and u in between by more."""
        return float(np.mean(self.high[:2] - self.low[:2]) + np.mean(self._deviations()))

    def with_closer_nodes(self) -> PointBounds:
        """The same with more nodes between two where u may deviate from the bounds at these.

        Bounds at nodes become narrower with every iteration; what the cap leaves open in between
        does not, and falls with a power of their distance.
        """
        middle, distance = 0.5 * (self.nodes[1:] + self.nodes[:-1]), np.diff(self.nodes)
        open_ = np.maximum(self.high[1] - self.low[1], 0.0)
        allowed = DEVIATION * np.minimum(open_[1:], open_[:-1])
        # a mean square leaves as much open as a power of the distance that is less by one half
        power = self.order - (1.0 if self.cap < inf else 1.5)
        wanted = (self._deviations() / np.maximum(allowed, 1e-100)) ** (1.0 / power)
        inside = np.any([(a < middle) & (middle < b) for a, b in self.parts], axis=0)
        wanted = np.where(inside, np.minimum(wanted, distance / CLOSEST_NODES), 1.0)
        counts = np.maximum(np.ceil(wanted - SAME).astype(int), 1)
        if np.all(counts == 1):
            return self
        # equal parts of every interval: where it begins, and the number of the part
        of = np.repeat(np.arange(len(counts)), counts)
        number = np.arange(len(of)) - np.repeat(np.cumsum(counts) - counts, counts)
        nodes = np.append(self.nodes[of] + number / counts[of] * distance[of], self.nodes[-1])
        new = np.append(number > 0, False)
        both = zip(self.at(nodes[new]), self.acceleration_bounds(nodes[new]), strict=True)
        low, high = (np.stack([*here[:2], bends])[: len(self.low)] for here, bends in both)
        return self._with_nodes(nodes, new, low, high)

    def with_parts(
        self, parts: Sequence[tuple[float, float]], distance: float, unbounded: float
    ) -> PointBounds:
        """The same on further parts too: nodes on these no farther apart than a distance, open."""
        merged = list[tuple[float, float]]()
        for low, high in sorted([*self.parts, *parts]):
            if merged and low <= merged[-1][1]:
                merged[-1] = merged[-1][0], max(merged[-1][1], high)
            else:
                merged.append((low, high))
        nodes = self.nodes
        for low, high in merged:
            own = np.union1d(nodes[(low < nodes) & (nodes < high)], [low, high])
            counts = np.ceil(np.diff(own) / distance - SAME).astype(int)
            more = [np.linspace(a, b, n + 1) for a, b, n in zip(own, own[1:], counts, strict=False)]
            nodes = np.union1d(nodes, np.concatenate(more))
        wider = self._with_nodes(nodes, ~np.isin(nodes, self.nodes), -unbounded, unbounded)
        return replace(wider, parts=tuple(merged))

    def _with_nodes(
        self, nodes: Array, new: Mask, low: Array | float, high: Array | float
    ) -> PointBounds:
        """The same at these nodes, with bounds low and high at the new ones among them."""
        ends = np.empty((2, len(self.low), len(nodes)))
        ends[:, :, ~new] = self.low, self.high
        ends[0][:, new], ends[1][:, new] = low, high
        return replace(self, nodes=nodes, low=ends[0], high=ends[1])

    def _deviations(self) -> Array:
        """How far u may leave what its values at two nodes say, at most, in between: (n − 1,)."""
        width = self.angle * np.diff(self.nodes)
        if self.order == 2:
            return self._change(0.5 * width)
        return np.asarray(0.25 * bend(width, self.cap, self.square) * width**2)

    def _change(self, distance: Array) -> Array:
        """What u (order 2) or s'' (order 3) changes by over distances [rad]."""
        return change(distance, self.cap, self.square)

    def along(self, spans: Array) -> tuple[Array, Array]:
        """Bounds of (X, u, e) all along spans (r, 2) that ascend: (3, r) each.

        For order 2 alone, and between the first node and the last of a part.
        """
        # divided at nodes, then the widest of each span
        ends = np.union1d(
            spans, self.nodes[(spans[0, 0] < self.nodes) & (self.nodes < spans[-1, 1])]
        )
        low, high = self.at(ends[:-1], ends[1:])
        # every span from its first place to its last; a column more, as the last may be the end
        places = np.searchsorted(ends, spans).ravel()
        low = np.minimum.reduceat(np.pad(low, ((0, 0), (0, 1))), places, axis=1)
        high = np.maximum.reduceat(np.pad(high, ((0, 0), (0, 1))), places, axis=1)
        return low[:, ::2], high[:, ::2]

    def at(self, x: Array, until: Array | None = None) -> tuple[Array, Array]:
        """Bounds of (X, u, e) at any x between the first node and the last: (3, m) each.

        ``until``: (m,) of order 2 alone: bounds all along spans from x, none across a node.
        """
        ends = x if until is None else until
        assert ends is x or self.order == 2
        left = np.searchsorted(self.nodes, 0.5 * (x + ends), "right") - 1
        left = np.clip(left, 0, len(self.nodes) - 2)
        # from the node before to the far end of a span, and to the node behind from its near end
        before = self.angle * (ends - self.nodes[left])
        after = self.angle * (self.nodes[left + 1] - x)
        low, high = self.low[1], self.high[1]
        if self.order == 2:
            # u' is capped: u leaves its value at a node by no more than this
            ahead, back = self._change(before), self._change(after)
            slow = np.maximum(low[left] - ahead, low[left + 1] - back)
            fast = np.minimum(high[left] + ahead, high[left + 1] + back)
        else:
            # u'' is capped: u leaves its chord by no more than this
            width = self.angle * np.diff(self.nodes)
            deviation = bend(width, self.cap, self.square)[left] * before * after
            slow = np.interp(x, self.nodes, low) - deviation
            fast = np.interp(x, self.nodes, high) + deviation
        least, most = (speed[left] for speed in self._interval_speed_bounds())
        # X between two lines from the node before, and two to the node behind: of each the end of
        # the span where it bounds less
        length = self.angle * (ends - x)
        nearer, closer = before - length, after - length
        low = np.maximum(
            self.low[0, left] + np.minimum(before * least, nearer * least),
            self.low[0, left + 1] - np.maximum(after * most, closer * most),
        )
        high = np.minimum(
            self.high[0, left] + np.maximum(before * most, nearer * most),
            self.high[0, left + 1] - np.minimum(after * least, closer * least),
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
        if self.order == 2:
            return np.full_like(x, -self.cap), np.full_like(x, self.cap)
        if len(self.low) < 3:
            return np.full_like(x, -np.inf), np.full_like(x, np.inf)
        left = np.clip(np.searchsorted(self.nodes, x, "right") - 1, 0, len(self.nodes) - 2)
        before = self._change(self.angle * (x - self.nodes[left]))
        after = self._change(self.angle * (self.nodes[left + 1] - x))
        low = np.maximum(self.low[2, left] - before, self.low[2, left + 1] - after)
        return low, np.minimum(self.high[2, left] + before, self.high[2, left + 1] + after)

    def _interval_speed_bounds(self) -> tuple[Array, Array]:
        """Bounds of X' = u + e over every interval."""
        over = self._deviations()
        slow = np.minimum(self.low[1, :-1], self.low[1, 1:]) - over + self.offsets[0]
        fast = np.maximum(self.high[1, :-1], self.high[1, 1:]) + over + self.offsets[1]
        if self.monotone > 0:
            slow = np.maximum(slow, 0.0)
        if self.monotone < 0:
            fast = np.minimum(fast, 0.0)
        return slow, fast
