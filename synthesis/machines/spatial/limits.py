"""Limits of spatial cams: those on walls and rollers, and the catalogue's on the motion.

A new one is a class here and its name in the union.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from math import tan
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from synthesis.catalogue.constraints import LinearInequality, NonconvexConstraint
from synthesis.catalogue.limits.base import Claim, Limit, Machine
from synthesis.catalogue.limits.derivatives import Acceleration, Jerk, Velocity
from synthesis.catalogue.motion import PlacedSegment
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
    upper: ClassVar[bool]

    @property
    @abstractmethod
    def bound(self) -> float:
        """The bound in the wire's unit."""

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
    def bound(self) -> float:
        return self.max_deg

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
    upper: ClassVar[bool] = False

    min_mm: Annotated[
        float,
        Field(ge=0.0, le=1e6, description="Smallest radius of curvature of a convex wall part."),
    ]

    @property
    def bound(self) -> float:
        return self.min_mm

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
    upper: ClassVar[bool] = False

    min_mm: Annotated[float, Field(ge=0.0, le=1e6, description="Smallest rib thickness.")]

    @property
    def bound(self) -> float:
        return self.min_mm


AnySpatialLimit = Annotated[
    SpatialPressureAngle | WallRadius | RibThickness | Velocity | Acceleration | Jerk,
    Field(discriminator="kind"),
]
