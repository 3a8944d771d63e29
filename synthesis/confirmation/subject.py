"""A finished design as exact numbers, and what one measurement of it comes to."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

from flint import arb, arb_series

from synthesis.confirmation.arithmetic import degree, hull, term
from synthesis.confirmation.course import ExactCourse, Piece
from synthesis.confirmation.forces import FORCES, Burden
from synthesis.confirmation.quantities import QUANTITIES, View
from synthesis.confirmation.search import Found, Span, largest
from synthesis.design import Design, Extreme
from synthesis.followers.link import Link
from synthesis.limits.base import Claim, Machine

ROUNDINGS: Final = 16.0 * 2.0**-53  # relative: a certificate's values on their way to the wire
ANGLES: Final = 8.0 * 2.0 * math.pi * 2.0**-53  # rad: eight roundings of where a piece ends
DIGITS: Final = 25


@dataclass(frozen=True)
class Measured:
    """One measurement, in the wire's unit.

    Attributes:
        low, high: ends of the enclosure; None where there is no finite value.
        holds: whether the bound is kept; None where that could not be told.
        agrees: whether the certificate is right. how: how it was measured.
        angle: cam angle [deg], None where none is meant.
    """

    low: arb | None
    high: arb | None
    holds: bool | None
    agrees: bool | None
    how: str
    angle: float | None = None


NOTHING: Final = Measured(None, None, None, None, "not measured here")


@dataclass(frozen=True, eq=False)
class Subject:
    """A design whose certificate is looked at.

    Attributes:
        link: its output link in balls. course: its motion.
    """

    design: Design
    link: Link
    course: ExactCourse

    @property
    def machine(self) -> Machine:
        """The machine as built."""
        return self.design.built.machine()

    @cached_property
    def omega(self) -> arb:
        """ω [rad/s]."""
        return 2 * arb.pi() * arb(self.design.speed_rpm) / 60

    @cached_property
    def to_wire(self) -> arb:
        """Displacement on the wire of one mm or rad."""
        return 1 / degree() if self.course.in_degrees else arb(1)

    def rate(self, order: int) -> arb:
        """From the ``order``-th derivative per radian to the wire's."""
        return self.omega**order * self.to_wire

    @cached_property
    def from_core(self) -> arb:
        """From the core's displacement, an arc in mm on arms, to mm or rad."""
        return 1 / (arb(self.machine.follower.travel.per_unit) * self.to_wire)

    def spans(self, claim: Claim) -> list[Span]:
        """The parts of pieces that a claim is about."""
        found = []
        first, last = (arb(0), arb(1)) if claim.part is None else map(arb, claim.part)
        for piece in self.course.of(claim.stretches):
            low, high = piece.law.low.max(first).mid(), piece.law.high.min(last).mid()
            if low < high or (first == last and low <= high):
                found.append((piece, low, high))
        if claim.quantity in FORCES:
            return [part for span in found for part in self.burden.cut(*span)]
        return found

    @cached_property
    def burden(self) -> Burden:
        """What loads the follower."""
        load = self.design.built.load
        assert load is not None
        side = load.reduced(self.machine.follower, 1.0).side
        return Burden(load.as_told, self.omega, side, load.friction_told is not None)

    @cached_property
    def stiffness(self) -> arb:
        """π b [(1 − ν1²)/E1 + (1 − ν2²)/E2] [mm/MPa]: force over it is p² times a length."""
        load = self.design.built.load
        assert load is not None
        assert load.contact is not None
        each = (load.contact.cam, load.contact.follower)
        soft = sum(
            ((1 - arb(m.poisson_ratio) ** 2) / arb(m.elastic_modulus_mpa) for m in each), arb(0)
        )
        return arb.pi() * arb(load.contact.width_mm) * soft

    def extreme(self, claim: Claim, spans: Sequence[Span], sign: int) -> Found:
        """The largest (sign 1) or smallest (−1) value of a claim's quantity, times the sign."""
        formula = self._formula(claim)

        def at(piece: Piece, x: arb) -> arb_series:
            return formula(self._view(claim, piece, x), claim.path)

        return largest(at, spans, sign)

    def slope(self, claim: Claim, spans: Sequence[Span], x: arb) -> arb:
        """How steep a quantity is at x, on the steeper side where pieces meet [per rad]."""
        found, formula = arb(0), self._formula(claim)
        for piece, low, high in spans:
            if low <= x <= high:
                found = found.max(abs(term(formula(self._view(claim, piece, x), claim.path), 1)))
        return found

    @staticmethod
    def _formula(claim: Claim) -> Callable[[View, str], arb_series]:
        return FORCES.get(claim.quantity) or QUANTITIES[claim.quantity]

    def _view(self, claim: Claim, piece: Piece, x: arb) -> View:
        """The link at x of a piece, with what drives it where that is asked about."""
        moved = piece.displacement(x)
        if piece.process is None:
            return View(self.link, moved)
        flanks = self.machine.follower.flanks
        flank = next((each for each in flanks if each.name == claim.flank), flanks[0])
        return View(self.link, moved, self.burden.drive(moved, piece, x), flank)

    def value(self, quantity: str, path: str, displacement: arb) -> arb:
        """A quantity while the follower stands still."""
        found = QUANTITIES[quantity](View(self.link, arb_series([displacement])), path)
        return term(found, 0)


def compared(
    extreme: Extreme,
    low: arb,
    high: arb,
    holds: bool | None,
    how: str,
    angle: float | None = None,
    slope: float = 0.0,
) -> Measured:
    """A finite value beside the certificate's; ``slope``: how fast it grows there, per radian."""
    if extreme.value is None:
        agrees: bool | None = False
    else:
        allowed = extreme.width + ROUNDINGS * abs(extreme.value) + ANGLES * slope
        apart = hull(low, high) - arb(extreme.value)
        agrees = True if abs(apart) <= allowed else False if abs(apart) > allowed else None
    if holds is not None and agrees is not None:
        agrees = agrees and (holds == extreme.holds or undecided(extreme))
    return Measured(low, high, holds, agrees, how, angle)


def undecided(extreme: Extreme) -> bool:
    """Whether the certificate refused a bound only because its enclosure reaches over it."""
    return not extreme.holds and extreme.margin is not None and abs(extreme.margin) <= extreme.width


def within(low: arb, high: arb, bound: float, direction: int) -> bool | None:
    """Whether a value is at most a bound (direction 1), or at least (−1)."""
    worst, best = (high, low) if direction > 0 else (-low, -high)
    limit = arb(bound) * direction
    return True if worst <= limit else False if best > limit else None
