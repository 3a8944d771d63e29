"""The lowest peak jerk."""

from __future__ import annotations

from typing import ClassVar, Literal

from synthesis.limits.base import Machine
from synthesis.motion import Stretch
from synthesis.objectives.derivative import DerivativeObjective, peak_rows
from synthesis.terms import Row


class PeakJerk(DerivativeObjective):
    """Minimise the largest |j| over the turn."""

    kind: Literal["peak_jerk"] = "peak_jerk"
    title: ClassVar[str] = "Peak jerk"
    quantity: ClassVar[str] = "jerk"
    order: ClassVar[int] = 3

    def rows(self, stretch: Stretch, machine: Machine, level: float) -> tuple[Row, ...]:
        return peak_rows(self.order, self.kind)
