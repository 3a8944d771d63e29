"""The smallest cylindrical cam: minimise the cylinder's radius."""

from __future__ import annotations

from typing import ClassVar, Literal

from synthesis.spatial.objectives.base import SpatialObjective


class CylinderRadius(SpatialObjective):
    """Minimise the radius of the cylinder that the groove is cut into."""

    kind: Literal["cylinder_radius"] = "cylinder_radius"
    title: ClassVar[str] = "Cylinder radius"
    wire_name: ClassVar[str] = "cylinder_radius_mm"
