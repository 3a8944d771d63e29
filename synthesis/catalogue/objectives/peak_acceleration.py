"""The lowest peak acceleration."""

from __future__ import annotations

from typing import ClassVar, Literal

from synthesis.catalogue.constraints import LinearInequality
from synthesis.catalogue.limits.base import Machine
from synthesis.catalogue.motion import PlacedSegment
from synthesis.catalogue.objectives.derivative import DerivativeObjective, peak_inequalities


class PeakAcceleration(DerivativeObjective):
    """Minimise the largest |a| over the turn."""

    kind: Literal["peak_acceleration"] = "peak_acceleration"
    title: ClassVar[str] = "Peak acceleration"
    quantity: ClassVar[str] = "acceleration"
    order: ClassVar[int] = 2

    def rows(
        self, segment: PlacedSegment, machine: Machine, level: float
    ) -> tuple[LinearInequality, ...]:
        return peak_inequalities(self.order, self.kind)
