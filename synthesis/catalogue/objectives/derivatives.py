"""Objectives on acceleration and jerk: their peak, and their root mean square over the turn."""

from __future__ import annotations

from abc import ABC
from typing import ClassVar, Literal

from synthesis.catalogue.constraints import LinearInequality, derivative
from synthesis.catalogue.limits.base import Machine
from synthesis.catalogue.motion import PlacedSegment
from synthesis.catalogue.objectives.base import Objective


class DerivativeObjective(Objective, ABC):
    """A value of s^(order) per radian; on the wire times ω^order."""

    order: ClassVar[int]

    def name_on_wire(self, machine: Machine) -> str:
        return f"{self.kind}_{machine.follower.travel.field_suffix(self.order)}"

    def to_wire(self, value: float, machine: Machine) -> float:
        return value * machine.wire_factor(self.order)

    def from_wire(self, value: float, machine: Machine) -> float:
        return value / machine.wire_factor(self.order)


class PeakDerivative(DerivativeObjective, ABC):
    """The largest |s^(order)| over the turn: |s^(order)| ≤ P at every cam angle."""

    def rows(
        self, segment: PlacedSegment, machine: Machine, level: float
    ) -> tuple[LinearInequality, ...]:
        up, down = (
            LinearInequality(derivative(self.order, sign), (), 0.0, level=-1.0, source=self.kind)
            for sign in (1.0, -1.0)
        )
        return up, down


class PeakAcceleration(PeakDerivative):
    """Minimise the largest |a| over the turn."""

    kind: Literal["peak_acceleration"] = "peak_acceleration"
    title: ClassVar[str] = "Peak acceleration"
    quantity: ClassVar[str] = "acceleration"
    order: ClassVar[int] = 2


class PeakJerk(PeakDerivative):
    """Minimise the largest |j| over the turn."""

    kind: Literal["peak_jerk"] = "peak_jerk"
    title: ClassVar[str] = "Peak jerk"
    quantity: ClassVar[str] = "jerk"
    order: ClassVar[int] = 3


class RmsDerivative(DerivativeObjective, ABC):
    """√(1/2π ∫ (s^(order))² dθ) over the turn."""

    def energy_order(self) -> int:
        return self.order


class RmsAcceleration(RmsDerivative):
    """Minimise √(1/2π ∫ a² dθ) over the whole turn."""

    kind: Literal["rms_acceleration"] = "rms_acceleration"
    title: ClassVar[str] = "Rms acceleration"
    quantity: ClassVar[str] = "rms_acceleration"
    order: ClassVar[int] = 2


class RmsJerk(RmsDerivative):
    """Minimise √(1/2π ∫ j² dθ) over the whole turn."""

    kind: Literal["rms_jerk"] = "rms_jerk"
    title: ClassVar[str] = "Rms jerk"
    quantity: ClassVar[str] = "rms_jerk"
    order: ClassVar[int] = 3
