"""A bound on one derivative on a part of one segment: what windows and points of a program mean."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import inf
from typing import ClassVar, Literal

from synthesis.catalogue.constraints import LinearInequality, derivative
from synthesis.catalogue.limits.base import Claim, Limit, Machine, scaling
from synthesis.catalogue.motion import PlacedSegment

EXACT = 1e-9  # of lift/β^k: allowance for rounding where a derivative has to have one value
TRAVEL = 0
NAMES = ("travel", "velocity", "acceleration", "jerk")
FIELDS = {
    "mm": ("travel_mm", "velocity_mm_per_s", "acceleration_mm_per_s2", "jerk_mm_per_s3"),
    "deg": ("travel_deg", "velocity_deg_per_s", "acceleration_deg_per_s2", "jerk_deg_per_s3"),
}


class SegmentBound(Limit):
    """min ≤ one derivative ≤ max on a part of one segment; equal where both are.

    Attributes:
        segment: index of the segment in the program.
        place: where it stands in the segment, as in ``windows/0``.
        field: path of what sets it, from the program on.
        order: 0 for the travel since the segment's start, positive in the sense of the move;
            k for the k-th derivative by time, positive away from the cam's axis.
        part: first and last x of the segment, in [0, 1]; equal for a point.
        min, max: bounds in the wire's units, None where there is none.
    """

    kind: Literal["segment_bound"] = "segment_bound"
    title: ClassVar[str] = "Window or point of one segment"
    segment: int
    place: str
    field: str
    order: int
    interval: tuple[float, float]
    min: float | None = None
    max: float | None = None

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

    def _factor(self, segment: PlacedSegment, machine: Machine) -> float:
        """What the derivative per radian is multiplied by to give the wire's value."""
        backwards = self.order == TRAVEL and segment.lift < 0.0
        return -machine.wire_factor(TRAVEL) if backwards else machine.wire_factor(self.order)

    def rows(self, segment: PlacedSegment, machine: Machine) -> tuple[LinearInequality, ...]:
        if segment.index != self.segment:
            return ()
        factor = self._factor(segment, machine)
        start = factor * segment.s_start if self.order == TRAVEL else 0.0
        sides = ((1.0, self.max), (-1.0, None if self.equality else self.min))
        scale = abs(factor)
        room = inf if self.min is None or self.max is None else (self.max - self.min) / scale
        return tuple(
            LinearInequality(
                derivative(self.order, sign * factor / scale), (), sign * (value + start) / scale,
                source=self.name, interval=self.interval, equality=self.equality, range_width=room,
            )
            for sign, value in sides
            if value is not None
        )  # fmt: skip

    def claims(self, segments: Sequence[PlacedSegment], machine: Machine) -> tuple[Claim, ...]:
        segment = next((s for s in segments if s.index == self.segment), None)
        if segment is None:
            return ()
        factor = self._factor(segment, machine)
        start = factor * segment.s_start if self.order == TRAVEL else 0.0
        spare = EXACT * self.unit(segment, machine) if self.equality else 0.0
        low = None if self.min is None else (self.min - spare + start) / factor
        high = None if self.max is None else (self.max + spare + start) / factor
        if factor < 0.0:
            low, high = high, low
        return (
            Claim(
                self.name, NAMES[self.order], (self.segment,), low, high,
                machine.derivative_unit(self.order), _moved(factor, start), self.field,
                interval=self.interval, equality=self.equality,
            ),
        )  # fmt: skip


def _moved(factor: float, start: float) -> Callable[[float], float]:
    """The map from a derivative per radian to the wire's value."""
    return scaling(factor) if start == 0.0 else lambda value: value * factor - start
