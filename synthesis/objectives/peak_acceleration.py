"""The lowest peak acceleration."""

from __future__ import annotations

from typing import ClassVar, Literal

from synthesis.limits.base import Machine
from synthesis.motion import Stretch
from synthesis.objectives.base import Objective
from synthesis.terms import Row


class PeakAcceleration(Objective):
    """Minimise the largest |a| over the turn."""

    kind: Literal["peak_acceleration"] = "peak_acceleration"
    title: ClassVar[str] = "Peak acceleration"
    quantity: ClassVar[str] = "acceleration"
    wire_name: ClassVar[str] = "peak_acceleration_mm_per_s2"

    def rows(self, stretch: Stretch, machine: Machine, level: float) -> tuple[Row, ...]:
        return (
            Row((0.0, 0.0, 1.0, 0.0), (), 0.0, level=-1.0, source="peak_acceleration"),
            Row((0.0, 0.0, -1.0, 0.0), (), 0.0, level=-1.0, source="peak_acceleration"),
        )

    def to_wire(self, value: float, machine: Machine) -> float:
        return value * machine.omega**2

    def from_wire(self, value: float, machine: Machine) -> float:
        return value / machine.omega**2
