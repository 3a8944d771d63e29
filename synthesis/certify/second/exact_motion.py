"""The delivered motion in ball arithmetic, from the numbers of the response.

Splines are converted to polynomials by de Boor's recurrence, with exact knots and coefficients; a
named law is its table of coefficients. Cam angles are exact sums of the segments' degrees.

A ball is a number with a proven radius; every operation enlarges the radius by its rounding error
(Johansson, IEEE Trans. Comput. 66 (2017) 1281). A series holds the Taylor coefficients of a
function at a point or, if its first coefficient is a wide ball, their ranges over an interval.

The largest value of a function on pieces is enclosed to 25 digits by best-first branch and bound.
On an interval of half width r about its middle f ≤ c0 + c1 τ + C τ², |τ| ≤ r, with c0 and c1 the
Taylor coefficients at the middle and C the largest second coefficient over the interval. This bound
exceeds the maximum by O(r³). The maximum of the parabola is tried as the incumbent. The search
keeps its own queue instead of the level-wise ``numerics/box_search``: every bound is expensive
here, so the interval with the largest bound is divided first, and no other.
"""

from __future__ import annotations

import heapq
import math
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from typing import Final

from flint import arb, arb_poly, arb_series, ctx

from synthesis.design.design import Design, SplineCurve
from synthesis.numerics.piecewise import Piecewise

Wave = tuple[arb, arb, arb]  # amplitude, frequency, phase of a sine


@dataclass(frozen=True)
class LawPiece:
    """One piece of a normalised law: a polynomial and sinusoids in x − origin, on [low, high]."""

    low: arb
    high: arb
    origin: arb
    poly: tuple[arb, ...]
    waves: tuple[Wave, ...] = ()


@dataclass(frozen=True)
class MotionPiece:
    """One piece of the motion; x runs from 0 to 1 over its segment.

    Attributes:
        start, angle: of the whole segment [rad].
        level, unit: displacement at its start, and factor of the law; mm or rad.
        process: cam angle, value and slope of the process force; None where no force is measured.
    """

    law: LawPiece
    segment: int  # its index
    start: arb
    angle: arb
    level: arb
    unit: arb
    process: tuple[arb, arb, arb] | None = None

    def displacement(self, x: arb) -> arb_series:
        """s (mm) or φ (rad) as a series in the cam angle, about x or over a ball of x."""
        y = arb_series([x - self.law.origin, 1 / self.angle])
        found = arb_series([0])
        for factor in reversed(self.law.poly):
            found = found * y + factor
        for amplitude, frequency, phase in self.law.waves:
            found = found + (y * frequency + phase).sin() * amplitude
        return found * self.unit + self.level

    def angle_at(self, x: arb) -> arb:
        """Cam angle [rad]."""
        return self.start + self.angle * x


@dataclass(frozen=True, eq=False)
class ExactMotion:
    """The motion of a design, piece by piece round the turn."""

    design: Design

    @cached_property
    def pieces(self) -> tuple[MotionPiece, ...]:
        """All pieces; segments of no extent have none."""
        found, unit = list[MotionPiece](), degree() if self.in_degrees else arb(1)
        widths = [arb(segment.degrees) for segment in self.design.resolved_spec.program]
        turn, before = sum(widths, arb(0)), arb(0)  # degrees in all, and of the segments before
        each = zip(self.design.curve.segments, self.design.motion, widths, strict=True)
        for index, (placed, segment, width) in enumerate(each):
            start, angle = 2 * arb.pi() * before / turn, 2 * arb.pi() * width / turn
            before += width
            if placed.angle <= 0.0:
                continue
            low, high = (arb(level) for level in segment.levels)
            scale = high - low
            if segment.spline is not None:
                units = (segment.spline.unit_mm, segment.spline.unit_deg)
                scale = next((arb(u) for u in units if u is not None), scale)
                laws = spline_pieces(segment.spline)
            else:
                assert placed.law is not None
                laws = table_pieces(placed.law)
            placing = index, start, angle, low * unit, scale * unit
            found += [MotionPiece(law, *placing) for law in laws]
        return tuple(found)

    @property
    def in_degrees(self) -> bool:
        """Whether displacement is the angle of an arm."""
        return self.design.completed_spec.follower.travel.unit == "deg"

    @cached_property
    def highest(self) -> arb:
        """Largest displacement at an end of a segment, mm or rad."""
        levels = [level for segment in self.design.motion for level in segment.levels]
        return arb(max(levels)) * (degree() if self.in_degrees else 1)

    def pieces_of(self, segments: Sequence[int]) -> list[MotionPiece]:
        """The pieces of these segments."""
        return [piece for piece in self.pieces if piece.segment in segments]

    def junctions(self) -> Iterator[tuple[MotionPiece, MotionPiece]]:
        """Every piece with the one that follows, the last with the first."""
        return zip(self.pieces, (*self.pieces[1:], self.pieces[0]), strict=True)


def jump(before: MotionPiece, after: MotionPiece, order: int) -> arb:
    """The ``order``-th derivative on the right of a junction less that on its left [per rad]."""
    left = before.displacement(before.law.high)
    right = after.displacement(after.law.low)
    return (coefficient(right, order) - coefficient(left, order)) * math.factorial(order)


def table_pieces(law: Piecewise) -> list[LawPiece]:
    """A named law from its table, whose numbers are taken as exact."""
    tables = (law.breaks, law.breaks[1:], law.origins, law.poly, law.waves)
    rows = zip(*(table.tolist() for table in tables), strict=False)
    return [
        LawPiece(
            arb(low), arb(high), arb(origin), tuple(map(arb, poly)),
            tuple((arb(a), arb(w), arb(p)) for a, w, p in waves),
        )
        for low, high, origin, poly, waves in rows
    ]  # fmt: skip


def spline_pieces(spline: SplineCurve) -> list[LawPiece]:
    """Polynomials of a B-spline about the left ends of its intervals, by de Boor's recurrence."""
    p, breaks = spline.degree, [arb(x) for x in spline.knots]
    knots = [breaks[0]] * p + breaks + [breaks[-1]] * p
    found = []
    for i in range(len(breaks) - 1):
        left, k = breaks[i], i + p
        row = [arb_poly([arb(c)]) for c in spline.coefficients[k - p : k + 1]]
        for r in range(1, p + 1):
            for j in range(p, r - 1, -1):
                low, high = knots[j + k - p], knots[j + 1 + k - r]
                share = arb_poly([(left - low) / (high - low), 1 / (high - low)])
                row[j] = share * row[j] + (1 - share) * row[j - 1]
        found.append(LawPiece(left, breaks[i + 1], left, tuple(row[p][j] for j in range(p + 1))))
    return found


BITS: Final = 200  # 60 digits: 25 are left after cancellation in every quantity
TERMS: Final = 6  # of a series: s to its fifth derivative, for the jerk to its second
_LOCK = threading.Lock()  # precision is global state of the library

SeriesVector = tuple[arb_series, arb_series]


@contextmanager
def ball_precision() -> Iterator[None]:
    """Inside the context balls have ``BITS`` bits and series ``TERMS`` terms."""
    with _LOCK:
        before = ctx.prec, ctx.cap
        ctx.prec, ctx.cap = BITS, TERMS
        try:
            yield
        finally:
            ctx.prec, ctx.cap = before


def degree() -> arb:
    """π/180."""
    return arb.pi() / 180


def middle_of(low: arb, high: arb) -> arb:
    """The middle of two exact numbers, exact itself."""
    return ((low + high) / 2).mid()


def hull(low: arb, high: arb) -> arb:
    """The ball over the interval between two exact numbers."""
    return arb((low + high) / 2, (high - low) / 2)


def coefficient(series: arb_series, order: int) -> arb:
    """One Taylor coefficient of a series; 0 beyond its last."""
    coefficients = series.coeffs()
    return coefficients[order] if order < len(coefficients) else arb(0)


SUFFICIENT_WIDTH: Final = arb("1e-25")  # of the enclosure, relative to the largest value met
MAX_INTERVALS: Final = 20_000  # of one enclosure; after that its bound is as wide as it is

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


def enclose_maximum(function: Function, spans: Sequence[Span], sign: int = 1) -> Maximum:
    """The largest value of sign · f on parts of pieces, both ends included."""
    search = _Search(function, sign)

    def entry(piece: MotionPiece, low: arb, high: arb) -> tuple[arb, int, MotionPiece, arb, arb]:
        # the interval with the largest bound comes first, then the older
        return -search.bound(piece, low, high), search.intervals, piece, low, high

    queue = [entry(*span) for span in spans]
    heapq.heapify(queue)
    while search.intervals < MAX_INTERVALS:
        if -queue[0][0] - search.incumbent <= SUFFICIENT_WIDTH * search.scale:
            break
        _, _, piece, low, high = heapq.heappop(queue)
        middle = middle_of(low, high)
        heapq.heappush(queue, entry(piece, low, middle))
        heapq.heappush(queue, entry(piece, middle, high))
    assert search.piece is not None
    return Maximum(search.incumbent, -queue[0][0], search.piece, search.x, search.intervals)


class _Search:
    """The incumbent of a search, and bounds on intervals."""

    def __init__(self, function: Function, sign: int) -> None:
        self.function, self.sign = function, sign
        self.incumbent, self.x = arb.neg_inf(), arb(0)
        self.piece: MotionPiece | None = None
        self.scale = arb(0)  # largest |f| met
        self.intervals = 0

    def bound(self, piece: MotionPiece, low: arb, high: arb) -> arb:
        """Upper bound on an interval; its middle and likely best point are tried as incumbents."""
        self.intervals += 1
        middle = middle_of(low, high)
        at_middle = self._series(piece, middle, highest_only=False)
        self._try(piece, middle, at_middle)
        if high <= low:  # a single point
            return _upper(at_middle, 0)
        over = self._series(piece, hull(low, high), highest_only=True)
        if at_middle is None:
            return arb.pos_inf()
        # maximum of the parabola c0 + c1 τ + C τ² over |τ| ≤ reach
        reach = (piece.angle * (high - low) / 2).upper()
        slope, bend = coefficient(at_middle, 1), _upper(over, 2)
        vertex = -slope / (2 * bend) if bend < 0 else arb.nan()
        inside = abs(vertex) <= reach
        if inside:
            rise = -slope * slope / (4 * bend)
        else:  # at an end; bent downwards it falls short only if the vertex is surely beyond it
            beyond = bend < 0 and abs(vertex) > reach
            curve = bend if beyond else bend.max(arb(0))
            rise = abs(slope).upper() * reach + curve * reach * reach
        upper = _upper(at_middle, 0) + rise
        likely = vertex if inside else reach if slope > 0 else -reach
        x = (middle + likely / piece.angle).mid().max(low).min(high).mid()
        self._try(piece, x, self._series(piece, x, highest_only=False))
        return upper.upper() if upper.is_finite() else arb.pos_inf()

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
