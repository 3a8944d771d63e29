"""Fields on the wire: names, speeds; dimensions that are given, free within a range, or free."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator
from pydantic_core import PydanticCustomError

Name = Annotated[str, Field(max_length=200)]
"""What a person calls a cam or a set of cams."""

Speed = Annotated[float, Field(ge=1e-6, le=1e9)]
"""Constant speed of a cam or its shaft [rpm]."""

Rotation = Literal["ccw", "cw"]
"""Sense of turning, seen with the cam's axis towards the viewer."""

CamSpeed = Annotated[Speed, Field(description="Cam speed, constant over the turn [rpm].")]
CamRotation = Annotated[Rotation, Field(description="Sense in which the cam turns.")]


class AnswerModel(BaseModel):
    """A part of an answer: frozen, and without fields that the contract does not name."""

    model_config = ConfigDict(frozen=True, extra="forbid")


class FiniteModel(BaseModel):
    """The same with finite numbers only: requests, and answers without infinities."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


def doc(description: str) -> Any:
    """A required field with its description in the contract."""
    return Field(description=description)


class Range(FiniteModel):
    """A dimension left free between two ends; an end left out is open."""

    min: float | None = Field(None, description="Smallest value allowed.")
    max: float | None = Field(None, description="Largest value allowed.")

    @model_validator(mode="after")
    def _ordered(self) -> Range:
        if self.min is not None and self.max is not None and self.min > self.max:
            raise PydanticCustomError(
                "range_empty",
                "min = {low} is above max = {high}: nothing lies between. "
                "Exchange the two, or leave one out.",
                {"low": self.min, "high": self.max},
            )
        return self


class AngleRange(Range):
    """A cam angle left free between two ends."""

    min: float = Field(gt=0.0, le=360.0, description="Smallest angle allowed [deg].")
    max: float = Field(gt=0.0, le=360.0, description="Largest angle allowed [deg].")


class LiftRange(Range):
    """A lift left free between two ends."""

    min: float = Field(ge=1e-6, le=1e6, description="Smallest lift allowed [mm].")
    max: float = Field(ge=1e-6, le=1e6, description="Largest lift allowed [mm].")


class SwingRange(Range):
    """An arm's swing left free between two ends."""

    min: float = Field(ge=1e-6, lt=180.0, description="Smallest swing allowed [deg].")
    max: float = Field(ge=1e-6, lt=180.0, description="Largest swing allowed [deg].")


class ArmRange(Range):
    """The length of an arm left free between two ends."""

    min: float = Field(gt=0.0, le=1e6, description="Smallest length allowed [mm].")
    max: float = Field(gt=0.0, le=1e6, description="Largest length allowed [mm].")


Dimension = Annotated[
    float | Range | None,
    Field(
        description="A number fixes it; {min, max} leaves it free in between; "
        "left out, it is free within what is physical."
    ),
]


Angle = Annotated[
    Annotated[float, Field(gt=0.0, le=360.0)] | AngleRange,
    Field(
        description="Cam angle of the segment [deg]; {min, max} leaves it free in between, and "
        "then that of another segment too."
    ),
]
Lift = Annotated[
    Annotated[float, Field(ge=1e-6, le=1e6)] | LiftRange,
    Field(
        description="Distance that the follower moves [mm], positive; {min, max} leaves it free "
        "in between, and then that of another segment too."
    ),
]
Swing = Annotated[
    Annotated[float, Field(ge=1e-6, lt=180.0)] | SwingRange,
    Field(
        description="Angle that the follower's arm swings [deg], positive; {min, max} leaves it "
        "free in between, and then that of another segment too."
    ),
]
ArmLength = Annotated[
    Annotated[float, Field(gt=0.0, le=1e6)] | ArmRange,
    Field(
        description="Length of the arm, pivot to roller centre [mm]; {min, max} leaves it free in "
        "between. Both ends are needed: a cam with nothing but angles limited shrinks with its "
        "arm, and without an end there would be no smallest one."
    ),
]
DwellAngle = Annotated[
    Annotated[float, Field(ge=0.0, le=360.0)] | AngleRange,
    Field(
        description="Cam angle of the dwell [deg]; {min, max} leaves it free in between, and "
        "then that of another segment too."
    ),
]


def ends(dimension: float | Range | None) -> tuple[float, float]:
    """Lower and upper end of a dimension, −inf and inf where open."""
    if isinstance(dimension, Range):
        low = -math.inf if dimension.min is None else dimension.min
        high = math.inf if dimension.max is None else dimension.max
        return low, high
    if dimension is None:
        return -math.inf, math.inf
    return dimension, dimension


def without_end(dimension: float | Range | None, end: str) -> Range | None:
    """A dimension with its ``min`` or ``max`` left open; a number, or another word, with both."""
    if isinstance(dimension, Range) and end in Range.model_fields:
        return dimension.model_copy(update={end: None})
    return None
