"""Largest radius of the finished profile."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from synthesis.limits.base import Claim, Limit, Machine, where
from synthesis.motion import Stretch
from synthesis.terms import Cone, Curved


class OuterRadius(Limit):
    """No point of the profile lies farther from the cam's axis than ``max_mm``.

    Where the profile is outermost its normal is radial, so the pitch curve is outermost there
    too, Rr farther out: the profile's largest radius is the pitch curve's less Rr.
    """

    kind: Literal["outer_radius"] = "outer_radius"
    title: ClassVar[str] = "Largest radius of the profile"
    max_mm: Annotated[float, Field(gt=0.0, le=1e9, description="Largest radius of the profile.")]

    def cones(self, stretches: Sequence[Stretch], machine: Machine) -> tuple[Cone, ...]:
        highest = max(max(s.s_start, s.s_end) for s in stretches)
        radius = self.max_mm + machine.follower.roller_radius
        norm = machine.follower.outermost(highest)
        return () if norm is None else (Cone(norm, radius, "outer_radius"),)

    def curved(self, stretch: Stretch, machine: Machine) -> tuple[Curved, ...]:
        radius = self.max_mm + machine.follower.roller_radius
        curves = machine.follower.outer_radius_curves(radius)
        return tuple(replace(curve, source="outer_radius") for curve in curves)

    def smooth(self, stretch: Stretch, machine: Machine, s: Any, z: Any) -> tuple[Any, ...]:
        return tuple(v for curve in self.curved(stretch, machine) for v in curve.excess(s, z))

    def claims(self, stretches: Sequence[Stretch], machine: Machine) -> tuple[Claim, ...]:
        radius = self.max_mm + machine.follower.roller_radius
        roller = machine.follower.roller_radius
        return (
            Claim(
                "outer_radius",
                "pitch_radius",
                where(stretches),
                None,
                radius,
                "mm",
                lambda pitch: pitch - roller,
                "outer_radius/max_mm",
            ),
        )
