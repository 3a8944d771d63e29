"""Largest cutter or grinding wheel that must reach every hollow of the profile."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from synthesis.limits.base import Claim, Limit, Machine, where
from synthesis.motion import Stretch


class CutterRadius(Limit):
    """Hollow flanks must let in a cutter of radius ``radius_mm``: |ρ_profile| ≥ Rg there.

    With ρ_profile = |ρ_pitch| + Rr on a hollow flank this is κ_pitch ≥ −1/(Rg − Rr); a cutter
    not larger than the roller fits everywhere.
    """

    kind: Literal["cutter_radius"] = "cutter_radius"
    title: ClassVar[str] = "Cutter or grinding wheel that must fit every hollow"
    radius_mm: Annotated[float, Field(gt=0.0, le=1e9, description="Radius of the cutter.")]

    def _pitch_radius(self, machine: Machine) -> float | None:
        """Smallest hollow radius of the pitch curve [mm]; None where the cutter always fits."""
        if machine.follower.always_convex:
            return None
        radius = self.radius_mm - machine.follower.roller_radius
        return radius if radius > 0.0 else None

    def smooth(self, stretch: Stretch, machine: Machine, s: Any, z: Any) -> tuple[Any, ...]:
        radius = self._pitch_radius(machine)
        if radius is None:
            return ()
        numerator, speed_squared = machine.follower.curvature_terms(s, z)
        speed = speed_squared**0.5
        # κ ≥ −1/R times W/(W + R): even numbers for a cutter of any size, the same zero
        return (-(radius * numerator / speed_squared + speed) / (speed + radius),)

    def claims(self, stretches: Sequence[Stretch], machine: Machine) -> tuple[Claim, ...]:
        radius = self._pitch_radius(machine)
        if radius is None:
            return ()
        roller = machine.follower.roller_radius
        return (
            Claim(
                "cutter_radius",
                "pitch_curvature",
                where(stretches),
                -1.0 / radius,
                None,
                "mm",
                lambda curvature: roller - 1.0 / curvature if curvature < 0.0 else None,
                "cutter_radius/radius_mm",
            ),
        )
