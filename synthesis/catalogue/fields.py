"""Fields on the wire: names, speeds; dimensions that are given, free within a range, or free."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from functools import cache
from typing import Annotated, Any, Literal, Self

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    GetCoreSchemaHandler,
    GetPydanticSchema,
    ValidationError,
    model_validator,
)
from pydantic_core import PydanticCustomError, core_schema, from_json

from synthesis.catalogue.hub import HUB_RULE

Name = Annotated[str, Field(max_length=200)]
"""What a person calls a cam or a set of cams."""

Speed = Annotated[float, Field(ge=1e-6, le=1e9)]
"""Constant speed of a cam or its shaft [rpm]."""

Rotation = Literal["ccw", "cw"]
"""Sense of turning, seen with the cam's axis towards the viewer."""

CamSpeed = Annotated[Speed, Field(description="Cam speed, constant over the turn [rpm].")]
CamRotation = Annotated[Rotation, Field(description="Sense in which the cam turns.")]


def _checked_once(source: Any, handler: GetCoreSchemaHandler) -> core_schema.CoreSchema:
    read = handler(source)
    made = core_schema.no_info_wrap_validator_function(
        lambda value, check: value if type(value) is source else check(value), read
    )
    return core_schema.json_or_python_schema(read, made)


CHECKED_ONCE = GetPydanticSchema(_checked_once)
"""A part that has been made is in order, and not checked again.

What is read from JSON is checked as JSON: there a tuple is a list, also in strict mode.
"""


class AnswerModel(BaseModel):
    """A part of an answer: frozen, and without fields that the contract does not name."""

    model_config = ConfigDict(frozen=True, extra="forbid")


class FiniteModel(BaseModel):
    """The same with finite numbers only: requests, and answers without infinities."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    def __init__(self, /, **fields: Any) -> None:
        try:
            super().__init__(**fields)
        except ValidationError as error:
            raise _explained(error, type(self), fields) from None

    # For pydantic, which else calls it for each part of a body instead of validating that.
    __init__.__pydantic_base_init__ = True  # type: ignore[attr-defined]

    @classmethod
    def model_validate(cls, obj: Any, **options: Any) -> Self:
        """As pydantic does, with errors that say what to write."""
        try:
            return super().model_validate(obj, **options)
        except ValidationError as error:
            raise _explained(error, cls, obj) from None

    @classmethod
    def model_validate_json(cls, json_data: str | bytes | bytearray, **options: Any) -> Self:
        """As pydantic does, with errors that say what to write."""
        try:
            return super().model_validate_json(json_data, **options)
        except ValidationError as error:
            if error.errors(include_input=False)[0]["type"] == "json_invalid":
                raise
            raise _explained(error, cls, from_json(json_data)) from None


def doc(description: str) -> Any:
    """A required field with its description in the contract."""
    return Field(description=description)


def _explained(error: ValidationError, model: type[BaseModel], body: Any) -> ValidationError:
    # Imported here: few models are wrong, and the words take as long to load as the models.
    from synthesis.errors.explanation import explained

    return explained(error, model, body)


class UnitFields(FiniteModel):
    """A body with displacements in twin fields: in mm of a slide, and in degrees of an arm.

    The names of twins differ by the unit alone, as ``lift_mm`` and ``lift_deg``.
    """

    def given_field(self, stem: str) -> str:
        """Name of that twin which is given, by the names' common beginning; mm where none is."""
        mm, deg, default = twins(type(self))[stem]
        return mm if getattr(self, deg) == default else deg

    def given(self, stem: str) -> Any:
        """Value of that twin which is given; the default where none is."""
        return getattr(self, self.given_field(stem))

    @property
    def units(self) -> frozenset[str]:
        """Units, mm and deg, of all displacements in it, those of its parts included."""
        used = set[str]()
        for mm, deg, default in twins(type(self)).values():
            pairs = (("mm", mm), ("deg", deg))
            used.update(unit for unit, name in pairs if getattr(self, name) != default)
        for value in vars(self).values():
            for part in value if isinstance(value, list) else (value,):
                if isinstance(part, UnitFields):
                    used |= part.units
        return frozenset(used)

    def check_one_unit(self, what: str) -> None:
        """Refuse a body that mixes lengths and angles of the follower."""
        if len(self.units) > 1:
            raise PydanticCustomError(
                "units_mixed",
                "the {what} gives displacements both in mm and in deg. "
                "Give all in mm for a follower that slides, or all in deg for one on an arm.",
                {"what": what},
            )


@cache
def twins(model: type[BaseModel]) -> Mapping[str, tuple[str, str, Any]]:
    """The twin fields in mm and deg and their default, by what their names begin with."""
    fields = model.model_fields
    pairs = ((name, name.replace("_mm", "_deg", 1)) for name in fields)
    return {
        mm.partition("_mm")[0]: (mm, deg, fields[deg].default)
        for mm, deg in pairs
        if mm != deg and deg in fields
    }


Number = Annotated[float, Field(ge=-1e30, le=1e30)]
"""A number of either sign. The limits keep its powers from an overflow, in any unit of length."""


class Range(FiniteModel):
    """A dimension left free between two ends; an end left out is open."""

    min: Number | None = Field(None, description="Smallest value allowed.")
    max: Number | None = Field(None, description="Largest value allowed.")

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


def range_between(low: float | None, high: float | None) -> Range:
    """A range in a question of our own: its ends may lie beyond what may be asked for."""
    return Range().model_copy(update={"min": low, "max": high})


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


Across = Annotated[float | None, Field(gt=0.0, le=1e6)]
ShaftDiameter = Annotated[
    Across,
    Field(
        description="Diameter of the shaft, which is the bore of the cam. Its hub is "
        f"{HUB_RULE} across, the rule for cast iron (Cam Design Handbook, Rothbart, ed., "
        "eq. 6.21), and the base circle is no smaller than the hub."
    ),
]
HubDiameter = Annotated[
    Across,
    Field(description="Diameter of the hub, where the rule for the shaft is not to decide it."),
]
Keyway = Annotated[
    bool, Field(description="Whether solids have a keyway in the bore, by DIN 6885-1.")
]

Dimension = Annotated[
    Number | Range | None,
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
    if isinstance(dimension, float | int):
        return dimension, dimension
    low, high = (None, None) if dimension is None else (dimension.min, dimension.max)
    return -math.inf if low is None else low, math.inf if high is None else high


def named_lengths(*models: BaseModel) -> Iterator[tuple[str, float, float]]:
    """Every length that models name: the path of its field, its lower and its upper end [mm]."""
    for model in models:
        for name in type(model).model_fields:
            value = getattr(model, name)
            if isinstance(value, BaseModel) and not isinstance(value, Range):
                for path, low, high in named_lengths(value):
                    yield f"{name}/{path}", low, high
            elif name.endswith("_mm") and isinstance(value, float | Range):
                yield (name, *ends(value))


def without_end(dimension: float | Range | None, end: str) -> Range | None:
    """A dimension with its ``min`` or ``max`` left open; a number with both ends left open."""
    if isinstance(dimension, Range) and end in Range.model_fields:
        return dimension.model_copy(update={end: None})
    return None
