"""The lowest root mean square of the acceleration."""

from __future__ import annotations

from typing import ClassVar, Literal

from synthesis.catalogue.objectives.derivative import DerivativeObjective


class RmsAcceleration(DerivativeObjective):
    """Minimise √(1/2π ∫ a² dθ) over the whole turn."""

    kind: Literal["rms_acceleration"] = "rms_acceleration"
    title: ClassVar[str] = "Rms acceleration"
    quantity: ClassVar[str] = "rms_acceleration"
    order: ClassVar[int] = 2

    def energy_order(self) -> int:
        return self.order
