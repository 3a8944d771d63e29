"""The smallest machine around a globoidal cam: minimise the centre distance."""

from __future__ import annotations

from typing import ClassVar, Literal

from synthesis.spatial.objectives.base import SpatialObjective


class CentreDistance(SpatialObjective):
    """Minimise the distance of the turret's axis from the cam's."""

    kind: Literal["centre_distance"] = "centre_distance"
    title: ClassVar[str] = "Centre distance"
    wire_name: ClassVar[str] = "centre_distance_mm"
