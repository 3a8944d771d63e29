"""Laws from a dwell to a turn, where the follower goes back without resting (VDI 2143: R-U)."""

from __future__ import annotations

from fractions import Fraction
from math import pi
from typing import ClassVar, Literal

from synthesis.catalogue.laws.base import (
    EndDerivatives,
    EndKinds,
    LawEntry,
    MotionLaw,
    Turn,
    mirrored,
)
from synthesis.catalogue.laws.rest_to_rest import about_both_ends
from synthesis.catalogue.motion import SegmentKind
from synthesis.numerics.piecewise import Piecewise

# s in units of 1e-5, from the constant term on: whole, so that s(1) = 1 and s'(1) = 0 exactly
KLOOMOK_MUFFLEY = (0, 0, 0, 609755, 0, -2078040, 2673155, -1360965, 256095)


def double_harmonic() -> Piecewise:
    """s = 3/8 − cos(πx)/2 + cos(2πx)/8, the last half about x = 1."""
    cosine = pi / 2.0
    second = (1 / 8, 2.0 * pi, cosine)
    waves = [[(-1 / 2, pi, cosine), second], [(1 / 2, pi, cosine), second]]
    return Piecewise.of([0.0, 0.5, 1.0], [[3 / 8], [3 / 8]], waves, [0.0, 1.0])


class DwellTurn(MotionLaw):
    """From a dwell to a turn: acceleration starts from zero, and is largest at the turn.

    For a rise and a return with no dwell between them; with equal lifts, angles and laws the
    acceleration is continuous at the turn.

    | kind | s |
    |---|---|
    | `double_harmonic` | [(1 − cos πx) − (1 − cos 2πx)/4]/2 |
    | `polynomial_3_4_5_6` | 8x³ − 12x⁴ + 6x⁵ − x⁶: with its mirror image 64y³(1 − y)³, y = x/2 |
    | `kloomok_muffley_8` | 6.09755x³ − 20.78040x⁵ + 26.73155x⁶ − 13.60965x⁷ + 2.56095x⁸ |
    """

    kind: Literal["double_harmonic", "polynomial_3_4_5_6", "kloomok_muffley_8"]
    turn: Turn = "top"
    entries: ClassVar = {
        "double_harmonic": LawEntry(
            "Double harmonic",
            "Kloomok and Muffley, Plate cam design, Product Engineering (1955); Rothbart (1956)",
            double_harmonic(),
        ),
        "polynomial_3_4_5_6": LawEntry(
            "3-4-5-6 polynomial (single dwell)",
            "Norton, Design of Machinery, single-dwell cam",
            about_both_ends([Fraction(c) for c in (0, 0, 0, 8, -12, 6, -1)], Fraction(1)),
        ),
        "kloomok_muffley_8": LawEntry(
            "Eighth-power polynomial (Kloomok–Muffley)",
            "Kloomok and Muffley, Plate cam design, Product Engineering (1955)",
            about_both_ends([Fraction(c, 100_000) for c in KLOOMOK_MUFFLEY], Fraction(1)),
        ),
    }

    @property
    def ends(self) -> EndKinds:
        return "R-U" if self.turn == "top" else "U-R"

    @property
    def tasks(self) -> tuple[str, ...]:
        return (self.ends,)

    def curve(self, segment: SegmentKind) -> Piecewise:
        towards_turn = (segment == "rise") == (self.turn == "top")
        return self.entry.shape if towards_turn else mirrored(self.entry.shape)

    def with_end_derivatives(
        self, segment: SegmentKind, start: EndDerivatives, end: EndDerivatives
    ) -> Piecewise:
        """The law itself: its velocity is zero at both ends, its acceleration its own."""
        return self.curve(segment)
