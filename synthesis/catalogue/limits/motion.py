"""Limits in the unit of the follower's displacement.

Velocity, acceleration and jerk; windows and points of a program (``SegmentBound``); and residual
vibration, what an elastic follower train still swings with when a dwell begins.
"""

from __future__ import annotations

from abc import ABC
from collections.abc import Sequence
from math import inf
from typing import Annotated, ClassVar, Literal, Self

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from synthesis.catalogue.constraints import LinearInequality, VibrationBound, derivative
from synthesis.catalogue.fields import twins
from synthesis.catalogue.limits.base import AtLowerSpeed, Claim, Limit, Machine, scaling
from synthesis.catalogue.motion import PlacedSegment, Segments
from synthesis.units import FULL_TURN

Largest = Annotated[float, Field(gt=0.0, le=1e30)] | None


class TravelLimit(Limit, ABC):
    """A largest value, ``max…``, in mm of a slide, or in degrees of an arm."""

    @model_validator(mode="after")
    def _given_once(self) -> Self:
        slide, swing, _ = twins(type(self))["max"]
        if len(self.units) != 1:
            raise PydanticCustomError(
                "limit_unclear",
                "{kind} gives {number}. Give {slide} for a follower that slides, or {swing} for "
                "one on an arm.",
                {"kind": self.kind, "number": "two limits" if self.units else "no limit",
                 "slide": slide, "swing": swing},
            )  # fmt: skip
        return self

    @property
    def field(self) -> str:
        """The field that gives it."""
        return self.given_field("max")

    @property
    def bound(self) -> float:
        """The largest value in the wire's unit."""
        return float(self.given("max"))


ACCELERATION = 2  # order of the derivative


class DerivativeLimit(TravelLimit, ABC):
    """|s^(order)| ω^order ≤ a limit, at every cam angle and on both sides of a jump."""

    order: ClassVar[int]
    at_lower_speed: ClassVar[AtLowerSpeed] = "easier"
    upper: ClassVar[bool] = True  # ``bound`` is a largest value

    @property
    def quantity(self) -> str:
        """Name of the measured quantity."""
        return self.kind

    @property
    def limits_acceleration(self) -> bool:
        return self.order >= ACCELERATION

    def rows(self, segment: PlacedSegment, machine: Machine) -> tuple[LinearInequality, ...]:
        largest = self.bound / machine.wire_factor(self.order)
        return tuple(
            LinearInequality(derivative(self.order, sign), (), largest, source=self.kind)
            for sign in (1.0, -1.0)
        )

    def claims(self, segments: Segments, machine: Machine) -> tuple[Claim, ...]:
        factor, unit = machine.wire_factor(self.order), machine.derivative_unit(self.order)
        bounds = -self.bound / factor, self.bound / factor
        return (self._claim(segments, bounds, self.field, unit, to_wire=scaling(factor)),)


class Velocity(DerivativeLimit):
    """|v| ≤ the limit at every cam angle."""

    kind: Literal["velocity"] = "velocity"
    title: ClassVar[str] = "Velocity"
    order: ClassVar[int] = 1
    max_mm_per_s: Largest = Field(None, description="Largest |velocity| of a slide.")
    max_deg_per_s: Largest = Field(None, description="Largest |velocity| of an arm.")


class Acceleration(DerivativeLimit):
    """|a| ≤ the limit at every cam angle, on both sides of a jump."""

    kind: Literal["acceleration"] = "acceleration"
    title: ClassVar[str] = "Acceleration"
    order: ClassVar[int] = 2
    max_mm_per_s2: Largest = Field(None, description="Largest |acceleration| of a slide.")
    max_deg_per_s2: Largest = Field(None, description="Largest |acceleration| of an arm.")


class Jerk(DerivativeLimit):
    """|j| ≤ the limit at every cam angle. A jump of the acceleration is an infinite jerk."""

    kind: Literal["jerk"] = "jerk"
    title: ClassVar[str] = "Jerk"
    order: ClassVar[int] = 3
    max_mm_per_s3: Largest = Field(None, description="Largest |jerk| of a slide.")
    max_deg_per_s3: Largest = Field(None, description="Largest |jerk| of an arm.")


EXACT = 1e-9  # of lift/β^k: allowance for rounding where a derivative has to have one value
TRAVEL = 0  # order of the derivative
NAMES = ("travel", "velocity", "acceleration", "jerk")
FIELDS = {
    "mm": ("travel_mm", "velocity_mm_per_s", "acceleration_mm_per_s2", "jerk_mm_per_s3"),
    "deg": ("travel_deg", "velocity_deg_per_s", "acceleration_deg_per_s2", "jerk_deg_per_s3"),
}


class SegmentBound(Limit):
    """min ≤ one derivative ≤ max on a part of one segment; equal where both are.

    Attributes:
        segment: its index in the program. place: in the segment, as in ``windows/0``.
        field: path of what sets it, from the program on.
        order: 0 for the travel since the segment's start, positive in the sense of the move;
            k for the k-th derivative by time, positive away from the cam's axis.
        interval: first and last x of the segment, in [0, 1]; equal for a point.
        min, max: bounds in the wire's units, None where there is none.
    """

    kind: Literal["segment_bound"] = "segment_bound"
    title: ClassVar[str] = "Window or point of one segment"
    at_lower_speed: ClassVar[AtLowerSpeed] = "either"
    segment: int
    place: str
    field: str
    order: int
    interval: tuple[float, float]
    min: float | None = None
    max: float | None = None

    @property
    def limits_acceleration(self) -> bool:
        return self.order >= ACCELERATION

    @property
    def equality(self) -> bool:
        """Whether the two bounds are one value."""
        return self.min is not None and self.min == self.max

    @property
    def name(self) -> str:
        """Name in the certificate: segment, window or point, quantity, and side if it is one."""
        where = self.place.replace("s/", "_")
        side = "_max" if self.min is None else "_min" if self.max is None else ""
        return f"program_{self.segment}_{where}_{NAMES[self.order]}{side}"

    def unit(self, segment: PlacedSegment, machine: Machine) -> float:
        """Natural size of the quantity on the wire: lift ω^k/β^k."""
        return abs(segment.lift) / segment.angle**self.order * machine.wire_factor(self.order)

    def _to_wire(self, segment: PlacedSegment, machine: Machine) -> tuple[float, float]:
        """Factor on the derivative per radian, and what is subtracted, to give the wire's value."""
        factor = machine.wire_factor(self.order)
        if self.order != TRAVEL:
            return factor, 0.0
        factor = -factor if segment.lift < 0.0 else factor
        return factor, factor * segment.s_start

    def rows(self, segment: PlacedSegment, machine: Machine) -> tuple[LinearInequality, ...]:
        if segment.index != self.segment:
            return ()
        factor, start = self._to_wire(segment, machine)
        sides = ((1.0, self.max), (-1.0, None if self.equality else self.min))
        scale = abs(factor)
        width = inf if self.min is None or self.max is None else (self.max - self.min) / scale
        return tuple(
            LinearInequality(
                derivative(self.order, sign * factor / scale), (), sign * (value + start) / scale,
                source=self.name, interval=self.interval, equality=self.equality, range_width=width,
            )
            for sign, value in sides
            if value is not None
        )  # fmt: skip

    def claims(self, segments: Sequence[PlacedSegment], machine: Machine) -> tuple[Claim, ...]:
        segment = next((s for s in segments if s.index == self.segment), None)
        if segment is None:
            return ()
        factor, start = self._to_wire(segment, machine)
        spare = EXACT * self.unit(segment, machine) if self.equality else 0.0
        low = None if self.min is None else (self.min - spare + start) / factor
        high = None if self.max is None else (self.max + spare + start) / factor
        if factor < 0.0:
            low, high = high, low
        return (
            Claim(
                self.name, NAMES[self.order], (self.segment,), low, high,
                machine.derivative_unit(self.order), scaling(factor, start), self.field,
                interval=self.interval, equality=self.equality,
            ),
        )  # fmt: skip


SPARE = 1e-9  # of the stroke: what rounding leaves of an amplitude that is to be none
PER_TURN = (0.01, 5000.0)  # swings of the train in one turn: fewer or more are wrong units
Amplitude = Annotated[float, Field(ge=0.0, le=1e30)] | None


class ResidualVibration(TravelLimit):
    """Amplitude ≤ the limit where a dwell begins, of one mode of the follower train.

    Every run of segments between two dwells counts by itself, the train at rest before it. The
    amplitude is the modulus of an integral that is linear in the motion, so that it is a cone, and
    0 two equalities.
    """

    kind: Literal["residual_vibration"] = "residual_vibration"
    title: ClassVar[str] = "Residual vibration"
    at_lower_speed: ClassVar[AtLowerSpeed] = "either"
    natural_frequency_hz: float = Field(
        gt=0.0,
        le=1e9,
        description="Undamped natural frequency of the train's mode, the cam's side held fast; "
        "0.01 to 5000 times the speed of the cam.",
    )
    damping_ratio: float = Field(
        0.0, ge=0.0, lt=1.0, description="Damping of the mode, as a share of the critical one."
    )
    max_mm: Amplitude = Field(
        None,
        description="Largest amplitude of the output's swing about its place, of a slide, where a "
        "dwell begins; 0 for none at all. The train is at rest before each run of moves.",
    )
    max_deg: Amplitude = Field(None, description="The same of an arm.")

    def check(self, segments: Segments, machine: Machine, position: int) -> None:
        swings = self.natural_frequency_hz * FULL_TURN / machine.omega
        if not PER_TURN[0] <= swings <= PER_TURN[1]:
            raise PydanticCustomError(
                "vibration_too_far_off",
                "residual_vibration is about {frequency} Hz, {swings} swings in one turn of the "
                "cam; between {least} and {most} make sense. Give the frequency in Hz and the "
                "speed in rpm, or leave the limit out.",
                {"frequency": self.natural_frequency_hz, "swings": float(f"{swings:.4g}"),
                 "least": PER_TURN[0], "most": PER_TURN[1]},
            )  # fmt: skip
        if not runs_between_dwells(segments):
            raise PydanticCustomError(
                "no_dwell_to_ring_in",
                "residual_vibration limits what a dwell begins with, but program holds no dwell "
                "with an angle. Add one, or leave the limit out.",
            )

    def vibration_bounds(self, segments: Segments, machine: Machine) -> tuple[VibrationBound, ...]:
        frequency = self.natural_frequency_hz * FULL_TURN / machine.omega
        largest = self.bound / machine.wire_factor(0)
        return tuple(
            VibrationBound(run, frequency, self.damping_ratio, largest, self.kind)
            for run in runs_between_dwells(segments)
        )

    def claims(self, segments: Segments, machine: Machine) -> tuple[Claim, ...]:
        bounds = self.vibration_bounds(segments, machine)
        moving = tuple(sorted(index for bound in bounds for index in bound.run))
        levels = [level for s in segments for level in (s.s_start, s.s_end)]
        spare = SPARE * (max(levels) - min(levels)) if self.bound == 0.0 else 0.0
        factor, unit = machine.wire_factor(0), machine.derivative_unit(0)
        claim = self._claim(
            segments, (None, self.bound / factor + spare), self.field, unit,
            to_wire=scaling(factor), indices=moving, vibration=bounds,
        )  # fmt: skip
        return (claim,)


def runs_between_dwells(segments: Segments) -> tuple[tuple[int, ...], ...]:
    """Indices of the segments between two dwells, run by run; segments of no angle do not count."""
    placed = [s for s in segments if s.angle > 0.0]
    dwells = [k for k, s in enumerate(placed) if s.kind == "dwell"]
    ends = zip(dwells[-1:] + dwells[:-1], dwells, strict=True)
    gaps = [(one + 1, (other - one - 1) % len(placed)) for one, other in ends]
    turn = [s.index for s in (*placed, *placed)]
    return tuple(tuple(turn[start : start + count]) for start, count in gaps if count)
