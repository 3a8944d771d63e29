"""Radius of curvature of the walls where they bulge, which is 0 where they begin to be undercut."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from pydantic import Field

from synthesis.limits.base import Machine
from synthesis.motion import Stretch
from synthesis.spatial.limits.base import SpatialLimit
from synthesis.terms import Curved


class WallRadius(SpatialLimit):
    """Principal radius of the walls ≥ the limit where they are convex."""

    kind: Literal["wall_radius"] = "wall_radius"
    title: ClassVar[str] = "Wall radius"
    quantity: ClassVar[str] = "convex_radius"
    field: ClassVar[str] = "min_mm"
    upper: ClassVar[bool] = False

    min_mm: Annotated[
        float, Field(ge=0.0, le=1e6, description="Smallest radius of a convex part of a wall.")
    ]

    @property
    def bound(self) -> float:
        return self.min_mm

    def curved(self, stretch: Stretch, machine: Machine) -> tuple[Curved, ...]:
        return machine.follower.profile_radius_curves(self.min_mm)
