"""The lowest root mean square of the acceleration."""

from __future__ import annotations

from typing import ClassVar, Literal

from synthesis.limits.base import Machine
from synthesis.objectives.base import Objective


class RmsAcceleration(Objective):
    """Minimise √(1/2π ∫ a² dθ) over the whole turn."""

    kind: Literal["rms_acceleration"] = "rms_acceleration"
    title: ClassVar[str] = "Rms acceleration"
    quantity: ClassVar[str] = "rms_acceleration"
    wire_name: ClassVar[str] = "rms_acceleration_mm_per_s2"

    def energy_order(self) -> int:
        return 2

    def to_wire(self, value: float, machine: Machine) -> float:
        return value * machine.omega**2

    def from_wire(self, value: float, machine: Machine) -> float:
        return value / machine.omega**2
