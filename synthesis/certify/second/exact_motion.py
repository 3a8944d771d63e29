"""The delivered motion in ball arithmetic, from the numbers of the response.

Splines are converted to polynomials by de Boor's recurrence, with exact knots and coefficients; a
named law is its table of coefficients. Cam angles are exact sums of the segments' degrees.

A ball is a number with a proven radius; every operation enlarges the radius by its rounding error
(Johansson, IEEE Trans. Comput. 66 (2017) 1281). A series holds the Taylor coefficients of a
function at a point or, if its first coefficient is a wide ball, their ranges over an interval.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Iterator, Sequence
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
        segment: index of the segment. law: its piece of the law.
        start, angle: of the whole segment [rad].
        level, unit: displacement at its start, and factor of the law; mm or rad.
        process: cam angle, value and slope of the process force; None where no force is measured.
    """

    segment: int
    law: LawPiece
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
        return tuple(self._all_pieces())

    def _all_pieces(self) -> Iterator[MotionPiece]:
        unit = degree() if self.in_degrees else arb(1)
        program = self.design.resolved_spec.program
        turn = sum((arb(segment.degrees) for segment in program), arb(0))
        before = arb(0)  # degrees of the segments before
        for index, (placed, segment) in enumerate(
            zip(self.design.curve.segments, self.design.motion, strict=True)
        ):
            width = arb(program[index].degrees)
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
            for law in laws:
                yield MotionPiece(index, law, start, angle, low * unit, scale * unit)

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
        following = (*self.pieces[1:], self.pieces[0])
        yield from zip(self.pieces, following, strict=True)


def jump(before: MotionPiece, after: MotionPiece, order: int) -> arb:
    """The ``order``-th derivative on the right of a junction less that on its left [per rad]."""
    left = before.displacement(before.law.high)
    right = after.displacement(after.law.low)
    return (coefficient(right, order) - coefficient(left, order)) * math.factorial(order)


def table_pieces(law: Piecewise) -> list[LawPiece]:
    """A named law from its table, whose numbers are taken as exact."""
    return [
        LawPiece(
            arb(float(law.breaks[i])),
            arb(float(law.breaks[i + 1])),
            arb(float(law.origins[i])),
            tuple(arb(float(c)) for c in law.poly[i]),
            tuple((arb(float(a)), arb(float(w)), arb(float(p))) for a, w, p in law.waves[i]),
        )
        for i in range(law.count)
    ]


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
        poly = [row[p][j] for j in range(p + 1)]
        found.append(LawPiece(left, breaks[i + 1], left, tuple(poly)))
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


def hull(low: arb, high: arb) -> arb:
    """The ball over the interval between two exact numbers."""
    return arb((low + high) / 2, (high - low) / 2)


def coefficient(series: arb_series, order: int) -> arb:
    """One Taylor coefficient of a series; 0 beyond its last."""
    coefficients = series.coeffs()
    return coefficients[order] if order < len(coefficients) else arb(0)
