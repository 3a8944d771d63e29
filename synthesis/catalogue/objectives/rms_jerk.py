"""The lowest root mean square of the jerk."""

from __future__ import annotations

from typing import ClassVar, Literal

from synthesis.catalogue.objectives.derivative import DerivativeObjective


class RmsJerk(DerivativeObjective):
    """Minimise √(1/2π ∫ j² dθ) over the whole turn."""

    kind: Literal["rms_jerk"] = "rms_jerk"
    title: ClassVar[str] = "Rms jerk"
    quantity: ClassVar[str] = "rms_jerk"
    order: ClassVar[int] = 3

    def energy_order(self) -> int:
        return self.order
