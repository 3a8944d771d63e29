"""A finished design as exact numbers, and the result of measuring one line of its certificate."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

from flint import arb, arb_series

from synthesis.catalogue.followers.kinematics import Link
from synthesis.catalogue.limits.base import Claim, Machine
from synthesis.certify.second import Remeasured
from synthesis.certify.second.exact_motion import (
    ExactMotion,
    Maximum,
    MotionPiece,
    Span,
    coefficient,
    degree,
    enclose_maximum,
    hull,
)
from synthesis.certify.second.quantities import FORCES, QUANTITIES, ExactLoad, LinkState, contact
from synthesis.design.design import Design, Extreme

VALUE_ROUNDING: Final = 16.0 * 2.0**-53  # relative, of a certificate's value in wire units
ANGLE_ROUNDING: Final = 8.0 * 2.0 * math.pi * 2.0**-53  # of the cam angle where a piece ends [rad]
DIGITS: Final = 25  # of a reported value


@dataclass(frozen=True, eq=False)
class ExactDesign:
    """A design to be measured again, with its output link in balls and its motion."""

    design: Design
    link: Link
    motion: ExactMotion

    @cached_property
    def machine(self) -> Machine:
        """The machine as built."""
        return self.design.completed_spec.machine()

    @cached_property
    def omega(self) -> arb:
        """ω [rad/s]."""
        return 2 * arb.pi() * arb(self.design.speed_rpm) / 60

    @cached_property
    def to_wire(self) -> arb:
        """Displacement in wire units per mm or rad."""
        return 1 / degree() if self.motion.in_degrees else arb(1)

    def rate(self, order: int) -> arb:
        """Factor from the ``order``-th derivative per radian to the wire's unit."""
        return self.omega**order * self.to_wire

    @cached_property
    def from_core(self) -> arb:
        """Factor from the core's displacement, an arc in mm on arms, to mm or rad."""
        return 1 / (arb(self.machine.follower.travel.per_unit) * self.to_wire)

    def spans(self, claim: Claim) -> list[Span]:
        """The parts of pieces that a claim is about; for forces, cut where the load bends."""
        found = []
        first, last = (arb(0), arb(1)) if claim.interval is None else map(arb, claim.interval)
        for piece in self.motion.pieces_of(claim.segments):
            low, high = piece.law.low.max(first).mid(), piece.law.high.min(last).mid()
            if low < high or (first == last and low <= high):
                found.append((piece, low, high))
        if claim.quantity in FORCES:
            return [part for span in found for part in self.load.split(*span)]
        return found

    @cached_property
    def load(self) -> ExactLoad:
        """The load of the follower."""
        load = self.design.completed_spec.load
        assert load is not None
        own = load.reduced(self.machine.follower, 1.0)
        return ExactLoad(load.wire_values, self.omega, own.side, own.friction is not None)

    @cached_property
    def contact_compliance(self) -> arb:
        """π b [(1 − ν1²)/E1 + (1 − ν2²)/E2] [mm/MPa], of Hertz's formula for a line contact."""
        load = self.design.completed_spec.load
        assert load is not None
        assert load.contact is not None
        bodies = (load.contact.cam, load.contact.follower)
        each = ((1 - arb(m.poisson_ratio) ** 2) / arb(m.elastic_modulus_mpa) for m in bodies)
        return arb.pi() * arb(load.contact.width_mm) * sum(each, arb(0))

    def extreme(self, claim: Claim, spans: Sequence[Span], sign: int) -> Maximum:
        """The largest (sign 1) or smallest (−1) value of a claim's quantity, times the sign."""
        return enclose_maximum(self._series(claim), spans, sign)

    def slope(self, claim: Claim, spans: Sequence[Span], x: arb) -> arb:
        """|df/dθ| of a quantity at x; the larger one where two pieces meet [per rad]."""
        found, series = arb(0), self._series(claim)
        for piece, low, high in spans:
            if low <= x <= high:
                found = found.max(abs(coefficient(series(piece, x), 1)))
        return found

    def _series(self, claim: Claim) -> Callable[[MotionPiece, arb], arb_series]:
        """The claim's quantity as a function of a piece and x."""
        formula = FORCES.get(claim.quantity) or QUANTITIES[claim.quantity]
        return lambda piece, x: formula(contact(self._state(claim, piece, x), claim.path))

    def _state(self, claim: Claim, piece: MotionPiece, x: arb) -> LinkState:
        """The link at x of a piece, with its drive where a force is measured."""
        displacement = piece.displacement(x)
        if piece.process is None:
            return LinkState(self.link, displacement)
        flanks = self.machine.follower.flanks
        flank = next((each for each in flanks if each.name == claim.flank), flanks[0])
        drive = self.load.drive(displacement, piece, x)
        return LinkState(self.link, displacement, drive, flank)

    def value_at_rest(self, quantity: str, path: str, displacement: arb) -> arb:
        """A quantity while the follower is at rest."""
        touching = contact(LinkState(self.link, arb_series([displacement])), path)
        return coefficient(QUANTITIES[quantity](touching), 0)


def remeasured(
    extreme: Extreme,
    low: arb | None = None,
    high: arb | None = None,
    holds: bool | None = None,
    agrees: bool | None = None,
    how: str = "not covered by the second judge",
    angle: float | None = None,
) -> Remeasured:
    """The second measurement of one line, an enclosure [low, high] in the wire's unit.

    ``angle`` [deg]. None is what is not known, or does not exist.
    """
    value = width = difference = None
    if low is not None and high is not None:
        middle = (low + high) / 2
        value, width = middle.str(DIGITS, radius=False), float(high - low)
        difference = None if extreme.value is None else float(middle - arb(extreme.value))
    return Remeasured(
        limit=extreme.limit, field=extreme.field, unit=extreme.unit, value=value, width=width,
        angle_deg=angle, certificate=extreme.value, difference=difference, holds=holds,
        agrees=agrees, how=how,
    )  # fmt: skip


def compare(
    extreme: Extreme,
    low: arb,
    high: arb,
    holds: bool | None,
    how: str,
    angle: float | None = None,
    blur: float = 0.0,
) -> Remeasured:
    """A finite value beside the certificate's.

    They agree if they differ by no more than the certificate's width, rounding of its value, and
    ``blur``; and if both verdicts are the same.
    """
    if extreme.value is None:
        agrees: bool | None = False
    else:
        allowed = extreme.width + VALUE_ROUNDING * abs(extreme.value) + blur
        difference = abs(hull(low, high) - arb(extreme.value))
        agrees = True if difference <= allowed else False if difference > allowed else None
    if holds is not None and agrees is not None:
        # the certificate may refuse a bound only because its enclosure reaches across it
        margin = None if extreme.holds else extreme.margin
        refused_for_width = margin is not None and abs(margin) <= extreme.width
        agrees = agrees and (holds == extreme.holds or refused_for_width)
    return remeasured(extreme, low, high, holds, agrees, how, angle)


def satisfies(low: arb, high: arb, bound: float, direction: int) -> bool | None:
    """Whether a value is at most a bound (direction 1) or at least (−1); None if undecided."""
    worst, best = (high, low) if direction > 0 else (-low, -high)
    limit = arb(bound) * direction
    return True if worst <= limit else False if best > limit else None
