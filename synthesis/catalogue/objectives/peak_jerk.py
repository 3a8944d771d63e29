"""The lowest peak jerk."""

from __future__ import annotations

from typing import ClassVar, Literal

from synthesis.catalogue.constraints import LinearInequality
from synthesis.catalogue.limits.base import Machine
from synthesis.catalogue.motion import PlacedSegment
from synthesis.catalogue.objectives.derivative import DerivativeObjective, peak_inequalities


class PeakJerk(DerivativeObjective):
    """Minimise the largest |j| over the turn."""

    kind: Literal["peak_jerk"] = "peak_jerk"
    title: ClassVar[str] = "Peak jerk"
    quantity: ClassVar[str] = "jerk"
    order: ClassVar[int] = 3

    def rows(
        self, segment: PlacedSegment, machine: Machine, level: float
    ) -> tuple[LinearInequality, ...]:
        return peak_inequalities(self.order, self.kind)
