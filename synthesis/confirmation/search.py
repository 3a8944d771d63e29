"""The largest value of a function on pieces, enclosed to 25 digits by branch and bound.

On a box of half width r about its middle f ≤ c0 + c1 τ + C τ², |τ| ≤ r, with c0 and c1 the Taylor
coefficients at the middle and C the largest second one over the box; so the bound is off by r³, and
the best point of that parabola is tried as the place of the maximum.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

from flint import arb, arb_series

from synthesis.confirmation.arithmetic import hull, term
from synthesis.confirmation.course import Piece

ENOUGH: Final = arb("1e-25")  # of the largest value met: width that ends a search
MOST_BOXES: Final = 20_000

Function = Callable[[Piece, arb], arb_series]  # of a piece and x, a number or a ball
Span = tuple[Piece, arb, arb]


@dataclass(frozen=True)
class Found:
    """The largest value lies in [lower, upper]; it is met at x of a piece to within that.

    ``upper`` is infinite where the function could not be enclosed.
    """

    lower: arb
    upper: arb
    piece: Piece
    x: arb
    boxes: int


@dataclass(frozen=True, eq=False)
class _Box:
    piece: Piece
    low: arb
    high: arb
    upper: arb

    def __lt__(self, other: _Box) -> bool:
        """The box of the largest bound comes first."""
        return bool(self.upper > other.upper)


def largest(function: Function, spans: Sequence[Span], sign: int = 1) -> Found:
    """The largest value of sign · f on parts of pieces, both ends included."""
    return _Search(function, sign).run(spans)


class _Search:
    def __init__(self, function: Function, sign: int) -> None:
        self.function, self.sign = function, sign
        self.best, self.x = arb.neg_inf(), arb(0)
        self.piece: Piece | None = None
        self.scale = arb(0)
        self.boxes = 0

    def run(self, spans: Sequence[Span]) -> Found:
        queue = [self._box(*span) for span in spans]
        heapq.heapify(queue)
        while self.boxes < MOST_BOXES:
            box = queue[0]
            if box.upper - self.best <= ENOUGH * self.scale:
                break
            heapq.heappop(queue)
            middle = ((box.low + box.high) / 2).mid()
            heapq.heappush(queue, self._box(box.piece, box.low, middle))
            heapq.heappush(queue, self._box(box.piece, middle, box.high))
        assert self.piece is not None
        return Found(self.best, queue[0].upper, self.piece, self.x, self.boxes)

    def _box(self, piece: Piece, low: arb, high: arb) -> _Box:
        """A box with its bound; takes in the values at its ends and at its likely best point."""
        self.boxes += 1
        middle = ((low + high) / 2).mid()
        here = self._series(piece, middle, ball=False)
        self._take(piece, middle, here)
        if high <= low:
            return _Box(piece, low, high, _top(here, 0))
        over = self._series(piece, hull(low, high), ball=True)
        if here is None or over is None:
            return _Box(piece, low, high, arb.pos_inf())
        reach = (piece.angle * (high - low) / 2).upper()
        slope, bend = term(here, 1), _top(over, 2)
        vertex = -slope / (2 * bend) if bend < 0 else arb.nan()
        steepest = reach if slope > 0 else -reach
        at = vertex if abs(vertex) <= reach else steepest
        upper = _top(here, 0) + abs(slope).upper() * reach + bend.max(arb(0)) * reach * reach
        if abs(vertex) <= reach:
            upper = _top(here, 0) - slope * slope / (4 * bend)
        elif bend < 0:
            upper = _top(here, 0) + abs(slope).upper() * reach + bend * reach * reach
        x = (middle + at / piece.angle).mid().max(low).min(high).mid()
        self._take(piece, x, self._series(piece, x, ball=False))
        return _Box(piece, low, high, upper.upper() if upper.is_finite() else arb.pos_inf())

    def _series(self, piece: Piece, x: arb, *, ball: bool) -> arb_series | None:
        """sign · f to its second derivative, None where it cannot be formed."""
        try:
            found = self.function(piece, x) * self.sign
        except (ZeroDivisionError, ValueError):
            return None
        finite = all(term(found, k).is_finite() for k in range(0 if not ball else 2, 3))
        return found if finite else None

    def _take(self, piece: Piece, x: arb, series: arb_series | None) -> None:
        """Keep a value if it is the best."""
        if series is None:
            return
        value = term(series, 0).lower()
        self.scale = self.scale.max(abs(value)).mid()
        if self.piece is None or value > self.best:
            self.best, self.piece, self.x = value, piece, x


def _top(series: arb_series | None, order: int) -> arb:
    return arb.pos_inf() if series is None else term(series, order).upper()
