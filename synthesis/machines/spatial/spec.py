"""SpatialCamSpec: the request body of a spatial cam, its limits, and when it has a best cam.

A new machine is a class and its name here, a new limit or objective a class here and its name in
the union. Limits on the motion are the catalogue's.
"""

from __future__ import annotations

import math
from abc import ABC
from collections.abc import Iterator, Mapping, Sequence
from itertools import accumulate
from typing import Annotated, Any, ClassVar, Literal, get_args

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, model_validator
from pydantic_core import PydanticCustomError

from synthesis.catalogue.constraints import AffineNorm, LinearInequality, NonconvexConstraint
from synthesis.catalogue.fields import CamRotation, CamSpeed, Name, Range
from synthesis.catalogue.limits import Limit
from synthesis.catalogue.limits.base import Claim, Machine
from synthesis.catalogue.limits.motion import Acceleration, Jerk, Velocity
from synthesis.catalogue.motion import PlacedSegment
from synthesis.catalogue.objectives import Objective
from synthesis.machines.spatial.cylindrical import (
    CylindricalIndexer,
    CylindricalOscillating,
    CylindricalTranslating,
)
from synthesis.machines.spatial.globoidal_indexer import GloboidalIndexer
from synthesis.machines.spatial.machine import ROLLER_RADIUS
from synthesis.numerics.piecewise import Array
from synthesis.spec.program import Segment
from synthesis.spec.schedule import angles_of, check_turn, check_units, placed
from synthesis.units import DEGREE, MotionUnits, rad_per_s

MAX_SEGMENTS = 100  # of a program
MACHINES = (GloboidalIndexer, CylindricalTranslating, CylindricalOscillating, CylindricalIndexer)
AnyMachine = Annotated[
    GloboidalIndexer | CylindricalTranslating | CylindricalOscillating | CylindricalIndexer,
    Field(discriminator="kind"),
]


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
        return math.tan(self.max_deg * DEGREE)

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

    min_mm: float = Field(
        ge=0.0, le=1e6, description="Smallest radius of curvature of a convex wall part."
    )

    def nonconvex(
        self, segment: PlacedSegment, machine: Machine
    ) -> tuple[NonconvexConstraint, ...]:
        return machine.follower.profile_radius_constraints(self.min_mm)


class RibThickness(SpatialLimit):
    """Rib ≥ the limit, from contact to contact of the rollers on its two sides.

    Note:
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


class SpatialCamSpec(BaseModel):
    """The follower's program, the machine around the cam, limits and objective."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    name: Annotated[Name, Field(description="Shown in reports and files.")] = ""
    speed_rpm: CamSpeed = 60.0
    rotation: CamRotation = "ccw"
    program: list[Segment] = Field(
        min_length=1,
        max_length=MAX_SEGMENTS,
        description="Segments in order; their angles sum to 360°. A turret indexes by a whole "
        "number of rollers in a turn; any other follower ends where it started.",
    )
    machine: Annotated[AnyMachine, Field(description="The machine around the cam.")]
    limits: list[AnySpatialLimit] = Field(
        [], max_length=50, description="Limits on walls, rollers and motion."
    )
    objective: AnySpatialObjective | None = Field(
        None,
        description="The dimension to minimise where something is left free; left out: the "
        "machine's own, its centre distance or its cylinder's radius.",
    )
    tolerance: float = Field(
        1e-3, ge=1e-6, le=1.0,
        description="Relative gap to the lower bound at which the search stops.",
    )  # fmt: skip

    @model_validator(mode="after")
    def _check_program(self) -> SpatialCamSpec:
        unit, kind = self.machine.travel.unit, self.machine.kind
        moves = f"the follower of a {kind} moves by {unit}"
        check_units(self.program, self.limits, unit, moves)
        check_turn(self.program)
        placed = self.placed_segments()
        levels = [level for each in placed for level in (each.s_start, each.max_displacement)]
        self.machine.check_travel(self.gain, min(*levels, placed[-1].s_end), max(levels))
        return self

    @model_validator(mode="after")
    def _check_objective(self) -> SpatialCamSpec:
        sought, objective = self.machine.size_field, self.objective
        if objective is not None and objective.wire_name != sought:
            raise PydanticCustomError(
                "objective_does_not_suit",
                "{objective} cannot be minimised for a {kind}. Leave objective out, or give {own}.",
                {"objective": objective.kind, "kind": self.machine.kind,
                 "own": sought.removesuffix("_mm") or "none"},
            )  # fmt: skip
        return self

    @model_validator(mode="after")
    def _check_well_posed(self) -> SpatialCamSpec:
        """Refuse a spec whose minimum does not exist or is not bounded away from zero."""
        machine = self.machine
        ranges = machine.ranges()
        free = [name for name, (low, high) in ranges.items() if low != high]
        keeps_large = any(limit.bounds_size_below for limit in self.limits)
        if not free and not self.has_free_law:
            return self
        if not machine.can_be_sized:
            raise PydanticCustomError(
                "machine_in_full",
                "A {kind} of this form can be measured but not sized yet, and {what} is left free. "
                "Give the number, or name the law.",
                {"kind": machine.kind, "what": free[0] if free else "a law"},
            )
        if (self.has_free_law or machine.size_field in free) and not keeps_large:
            raise PydanticCustomError(
                "nothing_keeps_large",
                "{what} is left free, and no limit bounds the size of the cam from below. Add a "
                "limit on pressure_angle, or give the number or the law.",
                {"what": machine.size_field if machine.size_field in free else "A law"},
            )
        # Rollers may not vanish: neither radius, nor radius and inner end together, go to zero.
        open_below = [
            name for name in ranges if name != machine.size_field and ranges[name][0] <= 0.0
        ]
        if machine.inner_end_field in open_below and ROLLER_RADIUS in open_below:
            raise PydanticCustomError(
                "rollers_vanish",
                "{place} and {radius} are both left free without a min: the cam becomes smaller "
                "without end as the rollers become smaller and move towards the turret's axis. "
                "Give one of them a number or a min.",
                {"place": machine.inner_end_field, "radius": ROLLER_RADIUS},
            )
        sizes = {name: low if low > 0.0 else 1.0 for name, (low, _) in ranges.items()}
        roller = machine.swept_roller(sizes, 1).roller
        if ROLLER_RADIUS in open_below and roller.crown > 0.0:
            raise PydanticCustomError(
                "rollers_vanish",
                "{radius} of crowned rollers is left free without a min: below a certain radius "
                "the crown meets the roller's axis before its ends. Give it a number or a min.",
                {"radius": ROLLER_RADIUS},
            )
        # The largest |r'| is the tangent of the pressure angle that the roller's ends have at rest.
        slope = float(np.max(np.abs(roller.profile(roller.places(2))[1])))
        for position, limit in enumerate(self.limits):
            if isinstance(limit, SpatialPressureAngle) and slope >= limit.max_slope:
                raise PydanticCustomError(
                    "crown_leans",
                    "limits/{position} allows a pressure angle of at most {bound}°, but at the "
                    "ends of the crowned rollers it is larger even at rest. Increase "
                    "crown_radius_mm, reduce roller_width_mm, or raise the limit.",
                    {"position": position, "bound": float(f"{limit.max_deg:.9g}")},
                )
        return self

    @property
    def omega(self) -> float:
        """Cam speed [rad/s]."""
        return rad_per_s(self.speed_rpm)

    @property
    def rotation_sign(self) -> int:
        """+1 where the cam turns ccw, −1 where it turns cw."""
        return 1 if self.rotation == "ccw" else -1

    @property
    def gain(self) -> float:
        """Net displacement of the follower in one turn [rad or mm]."""
        return math.fsum(segment.gain(self._motion_units) for segment in self.program)

    @property
    def _motion_units(self) -> MotionUnits:
        return MotionUnits(self.machine.travel, self.omega)

    def placed_segments(self) -> tuple[PlacedSegment, ...]:
        """The segments placed on the cam; q is 0 at the start of the program [rad or mm]."""
        units = self._motion_units
        *levels, _ = accumulate((segment.gain(units) for segment in self.program), initial=0.0)
        return placed(self.program, angles_of(self.program), levels, units)

    def left_free(self) -> Iterator[tuple[str, Any]]:
        """JSON pointer and value of each number of the program that is left free."""
        for position, segment in enumerate(self.program):
            for name, value in segment.free_fields().items():
                if isinstance(value, Range):
                    yield f"/program/{position}/{name}", value.model_dump()

    @property
    def has_free_law(self) -> bool:
        """Whether some motion law is left free."""
        return any(segment.law_is_free for segment in self.placed_segments())

    def given_sizes(self) -> Mapping[str, float] | None:
        """The machine's dimensions by field [mm]; None where one is left free."""
        ranges = self.machine.ranges()
        if any(low != high for low, high in ranges.values()):
            return None
        return {name: low for name, (low, _) in ranges.items()}
