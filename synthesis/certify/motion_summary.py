"""The motion of a finished cam in numbers: peaks, coefficients, jumps, and the reference law."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from synthesis.catalogue.laws import LAWS
from synthesis.catalogue.laws.base import EndDerivatives, MotionLaw
from synthesis.catalogue.laws.figures import ORDERS, LawFigures, figures
from synthesis.catalogue.limits.base import Machine
from synthesis.catalogue.motion import PlacedSegment
from synthesis.certify.piecewise_motion import PiecewiseMotion
from synthesis.certify.quantities import MeasuredCam
from synthesis.design.summary import (
    Coefficients,
    DerivativeSummary,
    MotionSummary,
    MoveSummary,
    PeakValue,
    ReferenceLaw,
)
from synthesis.numerics.piecewise import Indices
from synthesis.numerics.polynomial_extrema import EQUAL
from synthesis.units import DEGREE, FULL_TURN

ANGLE_DIGITS: Final = 9  # decimals of a cam angle: drops the rounding of degrees to rad and back
ROUNDING: Final = 1e-12  # of a derivative's peak: an opposite peak that is smaller is 0
AT_REST: Final = 1e-6  # of Cv and Ca: smaller rates at an end between two moves count as none
REFERENCES: Final = {
    "R-R": "modified_sine",
    "R-U": "polynomial_3_4_5_6",
    "U-R": "polynomial_3_4_5_6",
    "U-U": "simple_harmonic",
}
"""Named laws by the kinds of both ends; between others the polynomial that meets their states."""
OTHERWISE: Final = "polynomial_5"


def summarise_motion(cam: MeasuredCam) -> MotionSummary:
    """Peaks with sign and place, coefficients and jumps of every move and of the whole turn."""
    return _Motion.of(cam.motion, cam.machine).summary()


@dataclass(frozen=True, eq=False)
class _Motion:
    """A motion with what several of its figures need; ``moves``: segments that move."""

    motion: PiecewiseMotion
    machine: Machine
    moves: Sequence[PlacedSegment]

    @classmethod
    def of(cls, motion: PiecewiseMotion, machine: Machine) -> _Motion:
        moves = [s for s in motion.segments if s.angle > 0.0 and s.kind != "dwell" and s.scale]
        return cls(motion, machine, moves)

    def summary(self) -> MotionSummary:
        """The figures, on the wire."""
        each = [self._move(segment) for segment in self.moves]
        v, a, j = (
            self._over_turn(order, [getattr(move, name) for move in each])
            for order, name in zip(ORDERS, ("velocity", "acceleration", "jerk"), strict=True)
        )
        return MotionSummary(velocity=v, acceleration=a, jerk=j, moves=each)

    def _move(self, segment: PlacedSegment) -> MoveSummary:
        assert segment.law is not None
        own = figures(segment.law)
        junctions = self.motion.junctions_of([segment.index])  # its own ends included
        each = [self._on_segment(segment, own, order, junctions) for order in ORDERS]
        finite = [entry.rms is not None for entry in each]
        return MoveSummary(
            segment=segment.index,
            velocity=each[0],
            acceleration=each[1],
            jerk=each[2],
            coefficients=_coefficients(own, finite),
            reference=self._reference(segment),
        )

    def _on_segment(
        self, segment: PlacedSegment, own: LawFigures, order: int, junctions: Indices
    ) -> DerivativeSummary:
        unit = segment.scale / segment.angle**order * self.machine.wire_factor(order)
        # on a return the scale is negative, and the law's largest value the motion's smallest
        ends = own.extremes[order - 1]
        high, low = ends if unit > 0.0 else ends[::-1]

        # a spline that starts from rest does so but for the rounding of its control points
        rounding = ROUNDING * max(abs(high[0]), abs(low[0]))

        def peak(value: float, x: float) -> PeakValue:
            value = unit * value + 0.0 if abs(value) > rounding else 0.0
            angle = degrees(segment.start + segment.angle * x)
            return PeakValue(value=value, angle_deg=angle, segment=segment.index)

        rms = abs(unit) * math.sqrt(own.mean_squares[order - 1])
        return self._derivative(order, peak(*high), peak(*low), rms, junctions)

    def _over_turn(self, order: int, parts: Sequence[DerivativeSummary]) -> DerivativeSummary:
        factor = self.machine.wire_factor(order)
        square = sum(
            s.scale**2 * s.angle ** (1 - 2 * order) * figures(s.law).mean_squares[order - 1]
            for s in self.moves
            if s.law is not None
        )
        return self._derivative(
            order,
            _highest([part.largest for part in parts], 1.0),
            _highest([part.smallest for part in parts], -1.0),
            factor * math.sqrt(square / FULL_TURN),
            np.arange(self.motion.curve.count),
        )

    def _derivative(
        self, order: int, largest: PeakValue, smallest: PeakValue, rms: float, junctions: Indices
    ) -> DerivativeSummary:
        """``junctions``: those of the segment, or of the turn."""
        *lower, at = (self.motion.discontinuities(k, junctions) for k in range(1, order + 1))
        infinite, biggest = any(map(len, lower)), None
        if len(at):
            sizes = self.motion.jump_sizes(order, at)
            k = int(np.argmax(np.abs(sizes)))
            after = int(self.motion.next_piece[at[k]])
            biggest = PeakValue(
                value=float(sizes[k]) * self.machine.wire_factor(order),
                angle_deg=degrees(float(self.motion.curve.breaks[after])),
                segment=int(self.motion.segment_of_piece[after]),
            )
        return DerivativeSummary(
            unit=self.machine.derivative_unit(order), largest=largest, smallest=smallest,
            rms=None if infinite else rms, jumps=len(at), largest_jump=biggest,
        )  # fmt: skip

    def _reference(self, segment: PlacedSegment) -> ReferenceLaw | None:
        if segment.kind == "table":  # it moves both ways: no law of one sense compares
            return None
        start, end = self._end(segment, at_start=True), self._end(segment, at_start=False)
        ends = f"{start[0]}-{end[0]}"
        law: MotionLaw = LAWS[REFERENCES.get(ends, OTHERWISE)]
        # a law run backwards, U-R for R-U, has the same figures
        curve = law.with_end_derivatives("rise", start[1], end[1])
        return ReferenceLaw(
            law=law.kind, ends=ends, source=law.entry.source,
            coefficients=_coefficients(figures(curve)),
        )  # fmt: skip

    def _end(self, segment: PlacedSegment, *, at_start: bool) -> tuple[str, EndDerivatives]:
        """Kind of an end by VDI 2143, and the g' and g'' that a law has to meet there."""
        turning = [s for s in self.motion.segments if s.angle > 0.0]
        here = next(k for k, s in enumerate(turning) if s.index == segment.index)
        beside = turning[(here + (-1 if at_start else 1)) % len(turning)]
        if beside.kind == "dwell":
            return "R", (0.0, 0.0)
        if {beside.kind, segment.kind} == {"rise", "return"}:
            own = self._rates(segment, at_start=at_start)
            return "U", (0.0, own[1])
        v, a = self._rates(segment, at_start=at_start)
        moving, bent = abs(v) > AT_REST, abs(a) > AT_REST
        kind = ("B" if bent else "G") if moving else ("U" if bent else "R")
        return kind, (v if moving else 0.0, a if bent else 0.0)

    def _rates(self, segment: PlacedSegment, *, at_start: bool) -> tuple[float, float]:
        """g' and g'' just inside an end."""
        _, v, a = segment.end_derivatives(2, at_start=at_start)
        return float(v) * segment.angle / segment.scale, float(a) * segment.angle**2 / segment.scale


def _coefficients(own: LawFigures, finite: Sequence[bool] = (True,) * 3) -> Coefficients:
    """Of a normalised law. ``finite``: whether velocity, acceleration and jerk are."""

    def where(order: int, value: float) -> float | None:
        return value if finite[order - 1] else None

    return Coefficients(
        Cv=where(1, own.peak(1)),
        Ca=where(2, own.peak(2)),
        Cj=where(3, own.peak(3)),
        Cva=where(2, own.product_peak),
        Ea=where(2, own.mean_squares[1]),
        Ej=where(3, own.mean_squares[2]),
    )


def _highest(peaks: Sequence[PeakValue], sign: float) -> PeakValue:
    """The first of those that are highest (sign 1) or lowest (−1), but for rounding."""
    top = max(sign * peak.value for peak in peaks)
    return next(peak for peak in peaks if sign * peak.value >= top - EQUAL * abs(top))


def degrees(angle: float) -> float:
    """A cam angle of the turn [rad] in degrees, from 0 to below 360."""
    return round(angle / DEGREE, ANGLE_DIGITS) % 360.0
