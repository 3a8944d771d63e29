"""Limits and objectives of spatial cams; limits on the motion are the catalogue's.

A new one is a class here and its name in the union.
"""

from __future__ import annotations

from abc import ABC
from collections.abc import Sequence
from math import tan
from typing import Annotated, Any, ClassVar, Literal, get_args

from pydantic import Field

from synthesis.catalogue.constraints import AffineNorm, LinearInequality, NonconvexConstraint
from synthesis.catalogue.limits.base import Claim, Limit, Machine
from synthesis.catalogue.limits.motion import Acceleration, Jerk, Velocity
from synthesis.catalogue.motion import PlacedSegment
from synthesis.catalogue.objectives import Objective
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE


class SpatialLimit(Limit, ABC):
    """A bound on a quantity that is measured on the finished cam.

    Attributes:
        quantity: its name among the extremes. field: the field that sets the bound.
        upper: whether the bound is the largest allowed value, not the least.
    """

    quantity: ClassVar[str]
    field: ClassVar[str]
    upper: ClassVar[bool] = False

    @property
    def bound(self) -> float:
        """The bound in the wire's unit."""
        return float(getattr(self, self.field))

    def smooth_constraints(
        self, segment: PlacedSegment, machine: Machine, theta: Array, s: Any, z: Any
    ) -> tuple[Any, ...]:
        return ()  # no local solver is run on spatial cams

    def claims(self, segments: Sequence[PlacedSegment], machine: Machine) -> tuple[Claim, ...]:
        return ()  # ``measuring`` takes extremes over whole walls, not segment by segment


class SpatialPressureAngle(SpatialLimit):
    """|α| ≤ the limit at every contact of every roller that meshes with the cam."""

    kind: Literal["pressure_angle"] = "pressure_angle"
    title: ClassVar[str] = "Pressure angle"
    quantity: ClassVar[str] = "pressure_angle"
    field: ClassVar[str] = "max_deg"
    upper: ClassVar[bool] = True

    max_deg: Annotated[float, Field(gt=0.0, lt=90.0, description="Largest |pressure angle|.")]

    @property
    def bounds_size_below(self) -> bool:
        return True

    @property
    def max_slope(self) -> float:
        return tan(self.max_deg * DEGREE)

    def rows(self, segment: PlacedSegment, machine: Machine) -> tuple[LinearInequality, ...]:
        return machine.follower.pressure_angle_rows(self.max_slope)

    def nonconvex(
        self, segment: PlacedSegment, machine: Machine
    ) -> tuple[NonconvexConstraint, ...]:
        return machine.follower.pressure_angle_constraints(self.max_slope)


class WallRadius(SpatialLimit):
    """Principal radius of curvature of the walls ≥ the limit where they are convex."""

    kind: Literal["wall_radius"] = "wall_radius"
    title: ClassVar[str] = "Wall radius"
    quantity: ClassVar[str] = "convex_radius"
    field: ClassVar[str] = "min_mm"

    min_mm: Annotated[
        float,
        Field(ge=0.0, le=1e6, description="Smallest radius of curvature of a convex wall part."),
    ]

    def nonconvex(
        self, segment: PlacedSegment, machine: Machine
    ) -> tuple[NonconvexConstraint, ...]:
        return machine.follower.profile_radius_constraints(self.min_mm)


class RibThickness(SpatialLimit):
    """Rib ≥ the limit, from contact to contact of the rollers on its two sides.

    It has no rows: sizing enlarges the cam until the measured rib keeps it.
    """

    kind: Literal["rib_thickness"] = "rib_thickness"
    title: ClassVar[str] = "Rib thickness"
    quantity: ClassVar[str] = "rib_thickness"
    field: ClassVar[str] = "min_mm"

    min_mm: Annotated[float, Field(ge=0.0, le=1e6, description="Smallest rib thickness.")]


AnySpatialLimit = Annotated[
    SpatialPressureAngle | WallRadius | RibThickness | Velocity | Acceleration | Jerk,
    Field(discriminator="kind"),
]


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
