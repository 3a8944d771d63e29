"""SpatialCamSpec: the request body of a spatial cam."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from itertools import accumulate
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, model_validator
from pydantic_core import PydanticCustomError

from synthesis.catalogue.fields import CamRotation, CamSpeed, Name
from synthesis.catalogue.motion import PlacedSegment
from synthesis.catalogue.ranges import Range, ends
from synthesis.machines.spatial.limits import AnySpatialLimit
from synthesis.machines.spatial.machines import AnyMachine
from synthesis.machines.spatial.objectives import AnySpatialObjective
from synthesis.machines.spatial.well_posedness import check_well_posed
from synthesis.spec.program import Segment
from synthesis.spec.schedule import angles_of, check_turn, check_units, placed
from synthesis.units import MotionUnits, rad_per_s

MAX_SEGMENTS = 100


class SpatialCamSpec(BaseModel):
    """The follower's program, the machine around the cam, limits and objective."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    name: Annotated[Name, Field(description="Shown in reports and files.")] = ""
    speed_rpm: CamSpeed = 60.0
    rotation: CamRotation = "ccw"
    program: Annotated[
        list[Segment],
        Field(
            min_length=1,
            max_length=MAX_SEGMENTS,
            description="Segments in order; their angles sum to 360°. A turret indexes by a whole "
            "number of rollers in a turn; any other follower ends where it started.",
        ),
    ]
    machine: Annotated[AnyMachine, Field(description="The machine around the cam.")]
    limits: Annotated[
        list[AnySpatialLimit],
        Field(max_length=50, description="Limits on walls, rollers and motion."),
    ] = []
    objective: Annotated[
        AnySpatialObjective | None,
        Field(
            description="The dimension to minimise where something is left free; left out: the "
            "machine's own, its centre distance or its cylinder's radius."
        ),
    ] = None
    tolerance: Annotated[
        float,
        Field(
            ge=1e-6,
            le=1.0,
            description="Relative gap to the lower bound at which the search stops.",
        ),
    ] = 1e-3

    @model_validator(mode="after")
    def _check_program(self) -> SpatialCamSpec:
        unit, kind = self.machine.travel.unit, self.machine.kind
        moves = f"the follower of a {kind} moves by {unit}"
        check_units(self.program, self.limits, unit, moves)
        check_turn(self.program)
        self.machine.check_gain(self.gain)
        placed = self.placed_segments()
        levels = [level for each in placed for level in (each.s_start, each.max_displacement)]
        self.machine.check_positions(min(*levels, placed[-1].s_end), max(levels))
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
        check_well_posed(
            self.machine, self.limits, any(s.law_is_free for s in self.placed_segments())
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
        gains = [segment.gain(self._motion_units) for segment in self.program]
        levels = list(accumulate(gains, initial=0.0))[:-1]
        return placed(self.program, angles_of(self.program), levels, self._motion_units)

    def left_free(self) -> Iterator[tuple[str, Any]]:
        """JSON pointer and value of each number of the program that is left free."""
        for position, segment in enumerate(self.program):
            for name, value in segment.free_fields().items():
                if isinstance(value, Range):
                    yield f"/program/{position}/{name}", value.model_dump()

    @property
    def given(self) -> bool:
        """Whether every law and every dimension is given."""
        free = any(segment.law_is_free for segment in self.placed_segments())
        return not free and self.given_sizes() is not None

    def given_sizes(self) -> Mapping[str, float] | None:
        """The machine's dimensions by field [mm]; None where one is left free."""
        both = {name: ends(value) for name, value in self.machine.sizes().items()}
        if any(low != high for low, high in both.values()):
            return None
        return {name: low for name, (low, _) in both.items()}
