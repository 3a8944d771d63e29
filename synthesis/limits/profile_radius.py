"""Smallest radius of curvature where the profile is convex; at 0 it says: no undercut."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from synthesis.limits.base import Claim, Limit, Machine, where
from synthesis.motion import Stretch


class ProfileRadius(Limit):
    """Radius of the convex profile ≥ ``min_mm``: ρ_pitch ≥ Rr + min wherever ρ_pitch is positive.

    Written as κ_pitch ≤ 1/(Rr + min), which is free of division by what may vanish. Signed: a
    hollow flank (negative curvature) is the business of the limit ``cutter_radius``.
    """

    kind: Literal["profile_radius"] = "profile_radius"
    title: ClassVar[str] = "Smallest convex radius of the profile"
    min_mm: Annotated[
        float,
        Field(ge=0.0, le=1e6, description="Smallest radius of the convex profile; 0: no undercut."),
    ] = 0.0

    def _pitch_radius(self, machine: Machine) -> float:
        """Smallest convex radius of the pitch curve [mm]."""
        return machine.follower.roller_radius + self.min_mm

    def smooth(self, stretch: Stretch, machine: Machine, s: Any, z: Any) -> tuple[Any, ...]:
        smallest = self._pitch_radius(machine)
        if smallest <= 0.0:
            return ()
        numerator, speed_squared = machine.follower.curvature_terms(s, z)
        # κ ≤ 1/ρ_min with κ = N/W³, divided by W² to keep the size of the numbers even
        return (smallest * numerator / speed_squared**1.5 - 1.0,)

    def claims(self, stretches: Sequence[Stretch], machine: Machine) -> tuple[Claim, ...]:
        smallest = self._pitch_radius(machine)
        if smallest <= 0.0:
            return ()
        roller = machine.follower.roller_radius
        return (
            Claim(
                "profile_radius",
                "pitch_curvature",
                where(stretches),
                None,
                1.0 / smallest,
                "mm",
                lambda curvature: 1.0 / curvature - roller if curvature > 0.0 else None,
                "profile_radius/min_mm",
            ),
        )
