"""The delivered motion in ball arithmetic, from the numbers on the wire.

Splines are taken apart into polynomials by de Boor's recurrence, in exact knots and coefficients; a
named law is its table of numbers. Cam angles are the exact sums of the segments' degrees.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

from flint import arb, arb_poly, arb_series

from synthesis.confirmation.arithmetic import degree, term
from synthesis.design import Design, SplineCurve
from synthesis.numerics.piecewise import Piecewise

Wave = tuple[arb, arb, arb]


@dataclass(frozen=True)
class Law:
    """One piece of a normalised law: a polynomial and sinusoids in x − origin, on [low, high]."""

    low: arb
    high: arb
    origin: arb
    poly: tuple[arb, ...]
    waves: tuple[Wave, ...] = ()


@dataclass(frozen=True)
class Piece:
    """One piece of the motion, x from 0 to 1 over its segment.

    Attributes:
        stretch: index of the segment. law: its piece of the law.
        start, angle: of the whole segment [rad].
        level, unit: displacement at its start and what the law is multiplied by, mm or rad.
        process: of the process force, cam angle, value there and slope; None: not asked about.
    """

    stretch: int
    law: Law
    start: arb
    angle: arb
    level: arb
    unit: arb
    process: tuple[arb, arb, arb] | None = None

    def displacement(self, x: arb) -> arb_series:
        """s (mm) or φ (rad) as a series in the cam angle, about x or over a ball of x."""
        y = arb_series([x - self.law.origin, 1 / self.angle])
        found = arb_series([0])
        for coefficient in reversed(self.law.poly):
            found = found * y + coefficient
        for amplitude, frequency, phase in self.law.waves:
            found = found + (y * frequency + phase).sin() * amplitude
        return found * self.unit + self.level

    def angle_at(self, x: arb) -> arb:
        """Cam angle [rad]."""
        return self.start + self.angle * x


@dataclass(frozen=True, eq=False)
class ExactCourse:
    """The motion of a design, piece by piece round the turn."""

    design: Design

    @cached_property
    def pieces(self) -> tuple[Piece, ...]:
        """All pieces; segments of no extent have none."""
        return tuple(self._all())

    def _all(self) -> Iterator[Piece]:
        unit = degree() if self.in_degrees else arb(1)
        program = self.design.numbered.program
        turn = sum((arb(segment.degrees) for segment in program), arb(0))
        gone = arb(0)
        for index, (stretch, told) in enumerate(
            zip(self.design.curve.stretches, self.design.motion, strict=True)
        ):
            width = arb(program[index].degrees)
            start, angle = 2 * arb.pi() * gone / turn, 2 * arb.pi() * width / turn
            gone += width
            if stretch.angle <= 0.0:
                continue
            low, high = (arb(level) for level in told.levels)
            scale = high - low
            if told.spline is not None:
                scale = next(
                    (arb(u) for u in (told.spline.unit_mm, told.spline.unit_deg) if u is not None),
                    scale,
                )
                laws = taken_apart(told.spline)
            else:
                assert stretch.law is not None
                laws = tabled(stretch.law)
            for law in laws:
                yield Piece(index, law, start, angle, low * unit, scale * unit)

    @property
    def in_degrees(self) -> bool:
        """Whether displacement is the angle of an arm."""
        return self.design.built.follower.travel.unit == "deg"

    @cached_property
    def highest(self) -> arb:
        """Displacement at the highest end of a segment."""
        levels = [level for told in self.design.motion for level in told.levels]
        return arb(max(levels)) * (degree() if self.in_degrees else 1)

    def of(self, stretches: Sequence[int]) -> list[Piece]:
        """The pieces of these segments."""
        return [piece for piece in self.pieces if piece.stretch in stretches]

    def joints(self) -> Iterator[tuple[Piece, Piece]]:
        """Every piece with the one that follows, the last with the first."""
        following = (*self.pieces[1:], self.pieces[0])
        yield from zip(self.pieces, following, strict=True)


def jump(before: Piece, after: Piece, order: int) -> arb:
    """By how much the ``order``-th derivative differs from one piece to the next, per radian."""
    left = before.displacement(before.law.high)
    right = after.displacement(after.law.low)
    return (term(right, order) - term(left, order)) * math.factorial(order)


def tabled(law: Piecewise) -> list[Law]:
    """A law as it is kept: its numbers taken as exact."""
    return [
        Law(
            arb(float(law.breaks[i])),
            arb(float(law.breaks[i + 1])),
            arb(float(law.origins[i])),
            tuple(arb(float(c)) for c in law.poly[i]),
            tuple((arb(float(a)), arb(float(w)), arb(float(p))) for a, w, p in law.waves[i]),
        )
        for i in range(law.count)
    ]


def taken_apart(spline: SplineCurve) -> list[Law]:
    """A B-spline's polynomials about the left ends of its intervals (de Boor's recurrence)."""
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
        found.append(Law(left, breaks[i + 1], left, tuple(poly)))
    return found
