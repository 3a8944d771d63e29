"""Objectives of spatial cams: minimise one dimension of the machine.

A new one is a class here and its name in the union.
"""

from __future__ import annotations

from abc import ABC
from typing import Annotated, ClassVar, Literal, get_args

from pydantic import Field

from synthesis.catalogue.constraints import AffineNorm
from synthesis.catalogue.limits.base import Machine
from synthesis.catalogue.objectives.base import Objective


class SpatialObjective(Objective, ABC):
    """Minimise one dimension of the machine.

    Attributes:
        wire_name: field of the dimension.
    """

    quantity: ClassVar[str] = "size"

    def norm(self, machine: Machine) -> AffineNorm:
        return machine.follower.radius_norm()

    def to_wire(self, value: float, machine: Machine) -> float:
        return value

    def from_wire(self, value: float, machine: Machine) -> float:
        return value


class CentreDistance(SpatialObjective):
    """Minimise the distance between the turret's axis and the cam's."""

    kind: Literal["centre_distance"] = "centre_distance"
    title: ClassVar[str] = "Centre distance"
    wire_name: ClassVar[str] = "centre_distance_mm"


class CylinderRadius(SpatialObjective):
    """Minimise the radius of the cylinder that the groove is cut into."""

    kind: Literal["cylinder_radius"] = "cylinder_radius"
    title: ClassVar[str] = "Cylinder radius"
    wire_name: ClassVar[str] = "cylinder_radius_mm"


AnySpatialObjective = Annotated[CentreDistance | CylinderRadius, Field(discriminator="kind")]
OBJECTIVES: tuple[type[SpatialObjective], ...] = get_args(get_args(AnySpatialObjective)[0])


def objective_of(dimension: str) -> SpatialObjective:
    """The objective that minimises a dimension, by the name of its field."""
    return next(kind for kind in OBJECTIVES if kind.wire_name == dimension).model_validate({})
