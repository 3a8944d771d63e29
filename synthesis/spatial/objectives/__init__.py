"""Objectives of spatial cams: one file each. A new one is a file and its name in the union."""

from __future__ import annotations

from typing import Annotated, get_args

from pydantic import Field

from synthesis.spatial.objectives.base import SpatialObjective
from synthesis.spatial.objectives.centre_distance import CentreDistance
from synthesis.spatial.objectives.cylinder_radius import CylinderRadius

AnySpatialObjective = Annotated[CentreDistance | CylinderRadius, Field(discriminator="kind")]

OBJECTIVES: tuple[type[SpatialObjective], ...] = get_args(get_args(AnySpatialObjective)[0])
"""The same as a tuple, in that order."""


def objective_of(dimension: str) -> SpatialObjective:
    """The objective that makes a dimension small, by its field's name."""
    return next(kind for kind in OBJECTIVES if kind.wire_name == dimension).model_validate({})


__all__ = ["OBJECTIVES", "AnySpatialObjective", "SpatialObjective", "objective_of"]
