"""The lowest peak acceleration."""

from __future__ import annotations

from typing import ClassVar, Literal

from synthesis.limits.base import Machine
from synthesis.motion import Stretch
from synthesis.objectives.derivative import DerivativeObjective, peak_rows
from synthesis.terms import Row


class PeakAcceleration(DerivativeObjective):
    """Minimise the largest |a| over the turn."""

    kind: Literal["peak_acceleration"] = "peak_acceleration"
    title: ClassVar[str] = "Peak acceleration"
    quantity: ClassVar[str] = "acceleration"
    order: ClassVar[int] = 2

    def rows(self, stretch: Stretch, machine: Machine, level: float) -> tuple[Row, ...]:
        return peak_rows(self.order, self.kind)
