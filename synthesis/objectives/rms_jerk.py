"""The lowest root mean square of the jerk."""

from __future__ import annotations

from typing import ClassVar, Literal

from synthesis.limits.base import Machine
from synthesis.objectives.base import Objective


class RmsJerk(Objective):
    """Minimise √(1/2π ∫ j² dθ) over the whole turn."""

    kind: Literal["rms_jerk"] = "rms_jerk"
    title: ClassVar[str] = "Rms jerk"
    quantity: ClassVar[str] = "rms_jerk"
    wire_name: ClassVar[str] = "rms_jerk_mm_per_s3"

    def energy_order(self) -> int:
        return 3

    def to_wire(self, value: float, machine: Machine) -> float:
        return value * machine.omega**3

    def from_wire(self, value: float, machine: Machine) -> float:
        return value / machine.omega**3
