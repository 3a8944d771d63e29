"""SpatialCamSpec: what is asked of a spatial cam. It is the request body."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from itertools import accumulate
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, model_validator
from pydantic_core import PydanticCustomError

from synthesis.fields import CamRotation, CamSpeed, Name
from synthesis.motion import Stretch
from synthesis.placing import angles_of, check_turn, check_units, placed
from synthesis.program import Segment
from synthesis.ranges import Range, ends
from synthesis.spatial.freedom import check_free
from synthesis.spatial.limits import AnySpatialLimit
from synthesis.spatial.machines import AnyMachine
from synthesis.spatial.objectives import AnySpatialObjective
from synthesis.units import Pace, rad_per_s

MAX_SEGMENTS = 100


class SpatialCamSpec(BaseModel):
    """What the follower must do and which machine it is part of."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    name: Annotated[Name, Field(description="Shown in reports and files.")] = ""
    speed_rpm: CamSpeed = 60.0
    rotation: CamRotation = "ccw"
    program: Annotated[
        list[Segment],
        Field(
            min_length=1,
            max_length=MAX_SEGMENTS,
            description="Segments in order; their angles sum to 360°. A turret goes on by a whole "
            "number of rollers in a turn; any other follower ends where it began.",
        ),
    ]
    machine: Annotated[AnyMachine, Field(description="The machine around the cam.")]
    limits: Annotated[
        list[AnySpatialLimit], Field(max_length=50, description="What may not be exceeded.")
    ] = []
    objective: Annotated[
        AnySpatialObjective | None,
        Field(
            description="What to make small where something is left free; left out: the dimension "
            "that the machine grows by, its centre distance or its cylinder's radius."
        ),
    ] = None
    tolerance: Annotated[
        float,
        Field(
            ge=1e-6,
            le=1.0,
            description="Relative gap to the best possible that is good enough: it buys time.",
        ),
    ] = 1e-3

    @model_validator(mode="after")
    def _closes(self) -> SpatialCamSpec:
        unit, kind = self.machine.travel.unit, self.machine.kind
        moves = f"the follower of a {kind} moves by {unit}"
        check_units(self.program, self.limits, unit, moves)
        check_turn(self.program)
        self.machine.check_gain(self.gain)
        placed = self.stretches()
        levels = [level for each in placed for level in (each.s_start, each.highest)]
        self.machine.check_reach(min(*levels, placed[-1].s_end), max(levels))
        return self

    @model_validator(mode="after")
    def _has_a_best(self) -> SpatialCamSpec:
        sought, objective = self.machine.sought, self.objective
        if objective is not None and objective.wire_name != sought:
            raise PydanticCustomError(
                "objective_does_not_suit",
                "{objective} is no dimension that a {kind} is made small by. Leave objective out, "
                "or give {own}.",
                {"objective": objective.kind, "kind": self.machine.kind,
                 "own": sought.removesuffix("_mm") or "none"},
            )  # fmt: skip
        check_free(self.machine, self.limits, any(s.sought for s in self.stretches()))
        return self

    @property
    def omega(self) -> float:
        """Cam speed [rad/s]."""
        return rad_per_s(self.speed_rpm)

    @property
    def turns(self) -> int:
        """+1 where the cam turns ccw, −1 where it turns cw."""
        return 1 if self.rotation == "ccw" else -1

    @property
    def gain(self) -> float:
        """What the follower has moved on after a turn [rad or mm]."""
        return math.fsum(segment.gain(self._pace) for segment in self.program)

    @property
    def _pace(self) -> Pace:
        return Pace(self.machine.travel, self.omega)

    def stretches(self) -> tuple[Stretch, ...]:
        """The program placed on the cam: q is 0 where it starts [rad or mm]."""
        gains = [segment.gain(self._pace) for segment in self.program]
        levels = list(accumulate(gains, initial=0.0))[:-1]
        return placed(self.program, angles_of(self.program), levels, self._pace)

    def left_free(self) -> Iterator[tuple[str, Any]]:
        """JSON pointer and value of numbers of the program that are left free."""
        for position, segment in enumerate(self.program):
            for name, value in segment.left_open().items():
                if isinstance(value, Range):
                    yield f"/program/{position}/{name}", value.model_dump()

    @property
    def given(self) -> bool:
        """Whether every law and every dimension is given, so that nothing is left to choose."""
        free = any(stretch.sought for stretch in self.stretches())
        return not free and self.given_sizes() is not None

    def given_sizes(self) -> Mapping[str, float] | None:
        """The machine's dimensions where all of them are given [mm]."""
        both = {name: ends(value) for name, value in self.machine.sizes().items()}
        if any(low != high for low, high in both.values()):
            return None
        return {name: low for name, (low, _) in both.items()}
