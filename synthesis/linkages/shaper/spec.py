"""ShaperSpec: a six-bar shaper, given or to be dimensioned. It is the request body."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator
from pydantic_core import PydanticCustomError

from synthesis.fields import Name, Rotation, Speed
from synthesis.linkages.shaper.drive import Drive
from synthesis.linkages.shaper.mechanism import Shaper, Side
from synthesis.ranges import Range, ends
from synthesis.units import DEGREE, rad_per_s

LENGTHS = ("crank_mm", "guide_mm", "coupler_mm", "pivot_distance_mm", "ram_line_mm")
SMALLEST, LARGEST = 1e-6, 1e6


class LengthRange(Range):
    """A length left free between two ends."""

    min: Annotated[float, Field(ge=SMALLEST, le=LARGEST, description="Smallest allowed [mm].")]
    max: Annotated[float, Field(ge=SMALLEST, le=LARGEST, description="Largest allowed [mm].")]


class HeightRange(Range):
    """A height left free between two ends."""

    min: Annotated[float, Field(ge=-LARGEST, le=LARGEST, description="Smallest allowed [mm].")]
    max: Annotated[float, Field(ge=-LARGEST, le=LARGEST, description="Largest allowed [mm].")]


class StrokeRange(Range):
    """A stroke wanted between two ends."""

    min: Annotated[float, Field(ge=SMALLEST, le=LARGEST, description="Smallest stroke [mm].")]
    max: Annotated[float, Field(ge=SMALLEST, le=LARGEST, description="Largest stroke [mm].")]


class RatioRange(Range):
    """A quick-return ratio wanted between two ends."""

    min: Annotated[float, Field(ge=1.0, le=100.0, description="Smallest ratio.")]
    max: Annotated[float, Field(ge=1.0, le=100.0, description="Largest ratio.")]


Given = Annotated[float, Field(ge=SMALLEST, le=LARGEST)]
FREE = "{min, max} leaves it free in between."


def length(what: str) -> object:
    """A length's description."""
    return Field(description=f"{what} [mm]; {FREE}")


class LongestLink(BaseModel):
    """The smallest machine: its longest length as short as can be."""

    model_config = ConfigDict(frozen=True, extra="forbid")
    kind: Literal["longest_link"] = "longest_link"


class TransmissionAngle(BaseModel):
    """The least transmission angle at the ram as large as can be."""

    model_config = ConfigDict(frozen=True, extra="forbid")
    kind: Literal["transmission_angle"] = "transmission_angle"


class RamAcceleration(BaseModel):
    """The largest acceleration of the ram as small as can be."""

    model_config = ConfigDict(frozen=True, extra="forbid")
    kind: Literal["ram_acceleration"] = "ram_acceleration"


Objective = Annotated[
    LongestLink | TransmissionAngle | RamAcceleration, Field(discriminator="kind")
]


class ShaperSpec(BaseModel):
    """A shaper: its dimensions, how its crank turns, and what is wanted of it.

    The guide's pivot is the origin, the crank's pivot lies above it, the ram slides along a
    horizontal line. Angles count from the x axis, counter-clockwise.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    name: Annotated[Name, Field(description="Shown in reports and files.")] = ""
    crank_mm: Annotated[Given | LengthRange, length("Crank")]
    guide_mm: Annotated[Given | LengthRange, length("Guide, from its pivot to its end")]
    coupler_mm: Annotated[Given | LengthRange, length("Coupler, from the guide's end to the ram")]
    pivot_distance_mm: Annotated[
        Given | LengthRange, length("Height of the crank's pivot above the guide's")
    ]
    ram_line_mm: Annotated[
        Annotated[float, Field(ge=-LARGEST, le=LARGEST)] | HeightRange,
        length("Height of the ram's line above the guide's pivot"),
    ]
    ram_side: Annotated[
        Side,
        Field(
            description="Assembly branch: on which side of the guide's end the ram's pin is. The "
            "two are mirror images, with the crank turning the other way round."
        ),
    ] = "right"
    speed_rpm: Annotated[
        Speed, Field(description="Crank speed [rpm]; with an acceleration, that at its start.")
    ] = 60.0
    rotation: Annotated[Rotation, Field(description="Sense in which the crank turns.")] = "ccw"
    acceleration_rad_per_s2: Annotated[
        float,
        Field(
            ge=-1e12,
            le=1e12,
            description="Angular acceleration of the crank over the turn, positive where it "
            "speeds up [rad/s²].",
        ),
    ] = 0.0
    start_deg: Annotated[
        float, Field(ge=-360.0, le=360.0, description="Crank angle where the turn begins [deg].")
    ] = 0.0
    stroke_mm: Annotated[
        Given | StrokeRange | None, Field(description="Stroke wanted of the ram [mm].")
    ] = None
    quick_return_ratio: Annotated[
        Annotated[float, Field(ge=1.0, le=100.0)] | RatioRange | None,
        Field(description="Crank angle of the slow stroke over that of the quick one, as wanted."),
    ] = None
    least_transmission_angle_deg: Annotated[
        float | None,
        Field(
            gt=0.0,
            lt=90.0,
            description="Least angle wanted between the coupler and the upright at the ram: at "
            "90° all of the coupler's force drives the ram [deg].",
        ),
    ] = None
    objective: Annotated[
        Objective, Field(description="What is best, where dimensions are left free.")
    ] = LongestLink()
    tolerance: Annotated[
        float,
        Field(ge=1e-6, le=1.0, description="Relative gap to the best possible that is enough."),
    ] = 1e-2
    time_budget_s: Annotated[
        float | None,
        Field(gt=0.0, le=3600.0, description="Stop after this long with the best so far."),
    ] = None

    @model_validator(mode="after")
    def _can_be_sized(self) -> ShaperSpec:
        if not self.free:
            return self
        wishes = {"stroke_mm": self.stroke_mm, "quick_return_ratio": self.quick_return_ratio}
        for name, asked in wishes.items():
            if asked is None:
                raise PydanticCustomError(
                    "wish_missing",
                    "{name} is not given while {free} is left free. Give a number or "
                    "{{min, max}}, or give every length as a number.",
                    {"name": name, "free": self.free[0]},
                )
        if self.acceleration_rad_per_s2:
            raise PydanticCustomError(
                "sized_at_constant_speed",
                "acceleration_rad_per_s2 = {value} while {free} is left free: dimensions are "
                "chosen for a crank at constant speed. Leave it out, or give every length.",
                {"value": self.acceleration_rad_per_s2, "free": self.free[0]},
            )
        return self

    @property
    def free(self) -> list[str]:
        """Names of the lengths that are left free."""
        return [name for name in LENGTHS if len(set(ends(getattr(self, name)))) > 1]

    def given(self) -> dict[str, tuple[float, float]]:
        """Both ends of every length [mm]."""
        return {name: ends(getattr(self, name)) for name in LENGTHS}

    def shaper(self, lengths: dict[str, float]) -> Shaper:
        """The machine with these lengths."""
        crank, guide, coupler, pivot_distance, ram_line = (lengths[name] for name in LENGTHS)
        return Shaper(crank, guide, coupler, pivot_distance, ram_line, self.ram_side)

    @property
    def drive(self) -> Drive:
        """How the crank turns."""
        sense = 1.0 if self.rotation == "ccw" else -1.0
        speed = rad_per_s(self.speed_rpm)
        return Drive(self.start_deg * DEGREE, sense, speed, self.acceleration_rad_per_s2)
