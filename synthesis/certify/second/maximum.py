"""The largest value of a function on pieces, enclosed to 25 digits by best-first branch and bound.

On an interval of half width r about its middle f ≤ c0 + c1 τ + C τ², |τ| ≤ r, with c0 and c1 the
Taylor coefficients at the middle and C the largest second coefficient over the interval. This bound
exceeds the maximum by O(r³). The maximum of the parabola is tried as the incumbent.

The search keeps its own queue instead of the level-wise ``numerics/box_search``: every bound is
expensive here, so the interval with the largest bound is divided first, and no other.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

from flint import arb, arb_series

from synthesis.certify.second.exact_motion import MotionPiece, coefficient, hull

SUFFICIENT_WIDTH: Final = arb("1e-25")  # of the enclosure, relative to the largest value met
MAX_INTERVALS: Final = 20_000

Function = Callable[[MotionPiece, arb], arb_series]  # of a piece and x, a number or a ball
Span = tuple[MotionPiece, arb, arb]  # a piece and a part of its x


@dataclass(frozen=True)
class Maximum:
    """The largest value lies in [lower, upper]; ``lower`` is reached at x of a piece.

    ``upper`` is infinite if the function could not be enclosed.
    """

    lower: arb
    upper: arb
    piece: MotionPiece
    x: arb
    boxes: int


@dataclass(frozen=True, eq=False)
class _Interval:
    piece: MotionPiece
    low: arb
    high: arb
    upper: arb

    def __lt__(self, other: _Interval) -> bool:
        """The interval with the largest bound comes first in the queue."""
        return bool(self.upper > other.upper)


def enclose_maximum(function: Function, spans: Sequence[Span], sign: int = 1) -> Maximum:
    """The largest value of sign · f on parts of pieces, both ends included."""
    return _Search(function, sign).run(spans)


class _Search:
    def __init__(self, function: Function, sign: int) -> None:
        self.function, self.sign = function, sign
        self.incumbent, self.x = arb.neg_inf(), arb(0)
        self.piece: MotionPiece | None = None
        self.scale = arb(0)  # largest |f| met
        self.intervals = 0

    def run(self, spans: Sequence[Span]) -> Maximum:
        queue = [self._bounded(*span) for span in spans]
        heapq.heapify(queue)
        while self.intervals < MAX_INTERVALS:
            first = queue[0]
            if first.upper - self.incumbent <= SUFFICIENT_WIDTH * self.scale:
                break
            heapq.heappop(queue)
            middle = ((first.low + first.high) / 2).mid()
            heapq.heappush(queue, self._bounded(first.piece, first.low, middle))
            heapq.heappush(queue, self._bounded(first.piece, middle, first.high))
        assert self.piece is not None
        return Maximum(self.incumbent, queue[0].upper, self.piece, self.x, self.intervals)

    def _bounded(self, piece: MotionPiece, low: arb, high: arb) -> _Interval:
        """An interval with its bound; its middle and likely best point are tried as incumbents."""
        self.intervals += 1
        middle = ((low + high) / 2).mid()
        at_middle = self._series(piece, middle, highest_only=False)
        self._try(piece, middle, at_middle)
        if high <= low:  # a single point
            return _Interval(piece, low, high, _upper(at_middle, 0))
        over = self._series(piece, hull(low, high), highest_only=True)
        if at_middle is None or over is None:
            return _Interval(piece, low, high, arb.pos_inf())
        # maximum of the parabola c0 + c1 τ + C τ² over |τ| ≤ reach
        reach = (piece.angle * (high - low) / 2).upper()
        slope, bend = coefficient(at_middle, 1), _upper(over, 2)
        vertex = -slope / (2 * bend) if bend < 0 else arb.nan()
        end = reach if slope > 0 else -reach
        inside = abs(vertex) <= reach
        if inside:
            upper = _upper(at_middle, 0) - slope * slope / (4 * bend)
        elif bend < 0 and abs(vertex) > reach:
            upper = _upper(at_middle, 0) + abs(slope).upper() * reach + bend * reach * reach
        else:  # bent upwards, or it is not known on which side of the end the vertex is
            rise = abs(slope).upper() * reach + bend.max(arb(0)) * reach * reach
            upper = _upper(at_middle, 0) + rise
        likely = vertex if inside else end
        x = (middle + likely / piece.angle).mid().max(low).min(high).mid()
        self._try(piece, x, self._series(piece, x, highest_only=False))
        return _Interval(piece, low, high, upper.upper() if upper.is_finite() else arb.pos_inf())

    def _series(self, piece: MotionPiece, x: arb, *, highest_only: bool) -> arb_series | None:
        """sign · f about x, or None if it cannot be formed to its second coefficient.

        Over a wide ball only the second coefficient is used; the others may be infinite.
        """
        try:
            found = self.function(piece, x) * self.sign
        except (ZeroDivisionError, ValueError):
            return None
        finite = all(coefficient(found, k).is_finite() for k in range(2 if highest_only else 0, 3))
        return found if finite else None

    def _try(self, piece: MotionPiece, x: arb, series: arb_series | None) -> None:
        """Make a value the incumbent if it is larger."""
        if series is None:
            return
        value = coefficient(series, 0).lower()
        self.scale = self.scale.max(abs(value)).mid()
        if self.piece is None or value > self.incumbent:
            self.incumbent, self.piece, self.x = value, piece, x


def _upper(series: arb_series | None, order: int) -> arb:
    return arb.pos_inf() if series is None else coefficient(series, order).upper()
