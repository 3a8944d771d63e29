"""A closed plane curve, span by span, and pieces of it that are made smaller where needed."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from synthesis.numerics.piecewise import Array, Indices, Mask

FIRST, LARGEST = math.radians(15.0), math.radians(60.0)  # of a piece, at first and ever
AIM = 0.8  # of what is allowed: what a spacing aims at
NEAR_TOLERANCE = 0.99  # of what is allowed: may be too much once rounding is added


@dataclass(frozen=True, eq=False)
class CurvePoints:
    """Where a curve is and how it runs on, at n places: points (n, 2) and unit tangents (n, 2).

    ``curvature``: (n,) signed, positive where the curve turns left; ``speed``: (n,) arc length per
    unit of the span's fraction [mm], not negative.
    """

    points: Array
    tangent: Array
    curvature: Array
    speed: Array


class ClosedCurve(ABC):
    """A closed curve out of spans, the first beginning where it is best cut open.

    Where one span ends the next begins, at the same point; tangent and curvature may jump.
    """

    @property
    @abstractmethod
    def span_sizes(self) -> Array:
        """(m,) how large each span is, in any unit: by it a first guess is spread [rad]."""

    @abstractmethod
    def at(self, span: Indices, fraction: Array) -> CurvePoints:
        """The course at fractions (n,) of spans (n,); at 0 and 1 the limits from inside."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """Pieces (n,) of spans: of which one, and from where to where in it.

    ``min_pieces``: (m,) fewest pieces of each span.
    """

    span: Indices
    low: Array
    high: Array
    min_pieces: Indices

    @classmethod
    def initial(cls, sizes: Array) -> Mesh:
        """Even pieces of spans of the given sizes (m,) [rad]."""
        least = np.maximum(1, np.ceil(sizes / LARGEST)).astype(np.intp)
        counts = np.maximum(1, np.ceil(sizes / FIRST)).astype(np.intp)
        span = np.repeat(np.arange(len(counts)), counts)
        k, n = np.concatenate([np.arange(count) for count in counts]), counts[span]
        return cls(span, k / n, (k + 1) / n, least)

    def select(self, which: Mask) -> Mesh:
        """Some of the pieces."""
        return Mesh(self.span[which], self.low[which], self.high[which], self.min_pieces)

    def points_at(self, within: Array) -> tuple[Indices, Array]:
        """Spans and fractions of places within each piece, (n · len(within),) each."""
        fraction = self.low[:, None] + (self.high - self.low)[:, None] * within
        fraction[:, within == 1.0] = self.high[:, None]
        return np.repeat(self.span, len(within)), fraction.ravel()

    def equidistribute(self, excess: Array, power: int, growing: bool) -> Mesh:
        """Pieces of even excess, in proportion to a power of their lengths: as many as it takes.

        ``excess``: (n,) what each piece departs by, 1 where that is just allowed; ``growing``: no
        span loses a piece any more, and one with excess gains one at least.
        """
        parts = []
        for span, least in enumerate(self.min_pieces.tolist()):
            mine = np.flatnonzero(self.span == span)
            # a piece is no better than its neighbours: at a span's ends they are by chance
            near = np.pad(excess[mine], 1, mode="edge")
            worst = np.maximum(np.maximum(near[:-2], near[2:]), near[1:-1])
            needed = np.clip(worst / AIM, 1e-9, 1e12) ** (1.0 / power)
            total = np.concatenate([[0.0], np.cumsum(needed)])
            ends = np.append(self.low[mine], 1.0)
            count = max(least, math.ceil(total[-1] - 1e-9))
            if growing:
                count = max(count, len(mine) + int(np.max(near) > NEAR_TOLERANCE))
            inner = np.interp(np.linspace(0.0, total[-1], count + 1), total, ends)
            inner[0], inner[-1] = 0.0, 1.0
            parts.append((np.full(count, span), inner[:-1], inner[1:]))
        span_of, low, high = (np.concatenate(each) for each in zip(*parts, strict=True))
        return Mesh(span_of, low, high, self.min_pieces)
