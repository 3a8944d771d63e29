"""The lowest peak jerk."""

from __future__ import annotations

from typing import ClassVar, Literal

from synthesis.limits.base import Machine
from synthesis.motion import Stretch
from synthesis.objectives.base import Objective
from synthesis.terms import Row


class PeakJerk(Objective):
    """Minimise the largest |j| over the turn."""

    kind: Literal["peak_jerk"] = "peak_jerk"
    title: ClassVar[str] = "Peak jerk"
    quantity: ClassVar[str] = "jerk"
    wire_name: ClassVar[str] = "peak_jerk_mm_per_s3"

    def rows(self, stretch: Stretch, machine: Machine, level: float) -> tuple[Row, ...]:
        return (
            Row((0.0, 0.0, 0.0, 1.0), (), 0.0, level=-1.0, source="peak_jerk"),
            Row((0.0, 0.0, 0.0, -1.0), (), 0.0, level=-1.0, source="peak_jerk"),
        )

    def to_wire(self, value: float, machine: Machine) -> float:
        return value * machine.omega**3

    def from_wire(self, value: float, machine: Machine) -> float:
        return value / machine.omega**3
