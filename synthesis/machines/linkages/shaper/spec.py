"""ShaperSpec: the request body of a six-bar shaper, given in full or to be sized."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator
from pydantic_core import PydanticCustomError

from synthesis.catalogue.fields import Name, Rotation, Speed
from synthesis.catalogue.ranges import Range, ends
from synthesis.machines.linkages.shaper.drive import Drive
from synthesis.machines.linkages.shaper.mechanism import Shaper, Side
from synthesis.units import DEGREE, rad_per_s

LENGTHS = ("crank_mm", "guide_mm", "coupler_mm", "pivot_distance_mm", "ram_line_mm")
SMALLEST, LARGEST = 1e-6, 1e6


class LengthRange(Range):
    """A range in which a length is left free."""

    min: Annotated[float, Field(ge=SMALLEST, le=LARGEST, description="Smallest allowed [mm].")]
    max: Annotated[float, Field(ge=SMALLEST, le=LARGEST, description="Largest allowed [mm].")]


class HeightRange(Range):
    """A range in which a height is left free."""

    min: Annotated[float, Field(ge=-LARGEST, le=LARGEST, description="Smallest allowed [mm].")]
    max: Annotated[float, Field(ge=-LARGEST, le=LARGEST, description="Largest allowed [mm].")]


class StrokeRange(Range):
    """A range of the required stroke."""

    min: Annotated[float, Field(ge=SMALLEST, le=LARGEST, description="Smallest stroke [mm].")]
    max: Annotated[float, Field(ge=SMALLEST, le=LARGEST, description="Largest stroke [mm].")]


class RatioRange(Range):
    """A range of the required quick-return ratio."""

    min: Annotated[float, Field(ge=1.0, le=100.0, description="Smallest ratio.")]
    max: Annotated[float, Field(ge=1.0, le=100.0, description="Largest ratio.")]


Given = Annotated[float, Field(ge=SMALLEST, le=LARGEST)]
FREE = "{min, max} leaves it free between them."


def length(what: str) -> object:
    """A length's description."""
    return Field(description=f"{what} [mm]; {FREE}")


class LongestLink(BaseModel):
    """Minimise the longest link: the smallest machine."""

    model_config = ConfigDict(frozen=True, extra="forbid")
    kind: Literal["longest_link"] = "longest_link"


class TransmissionAngle(BaseModel):
    """Maximise the least transmission angle at the ram."""

    model_config = ConfigDict(frozen=True, extra="forbid")
    kind: Literal["transmission_angle"] = "transmission_angle"


class RamAcceleration(BaseModel):
    """Minimise the largest acceleration of the ram."""

    model_config = ConfigDict(frozen=True, extra="forbid")
    kind: Literal["ram_acceleration"] = "ram_acceleration"


Objective = Annotated[
    LongestLink | TransmissionAngle | RamAcceleration, Field(discriminator="kind")
]


class ShaperSpec(BaseModel):
    """A shaper: its dimensions, its crank's motion, and what is required of it.

    The guide's pivot is the origin, the crank's pivot lies above it, the ram slides along a
    horizontal line. Angles are measured from the x axis, counter-clockwise.
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
            description="Assembly branch: the side of the guide's end on which the ram's pin is. "
            "The two are mirror images, with the crank turning in the opposite sense."
        ),
    ] = "right"
    speed_rpm: Annotated[
        Speed,
        Field(
            description="Crank speed [rpm]; with an acceleration, that at the start of the turn."
        ),
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
        float, Field(ge=-360.0, le=360.0, description="Crank angle at the start of the turn [deg].")
    ] = 0.0
    stroke_mm: Annotated[
        Given | StrokeRange | None, Field(description="Required stroke of the ram [mm].")
    ] = None
    quick_return_ratio: Annotated[
        Annotated[float, Field(ge=1.0, le=100.0)] | RatioRange | None,
        Field(
            description="Required quick-return ratio: crank angle of the slow stroke over that of "
            "the quick one."
        ),
    ] = None
    least_transmission_angle_deg: Annotated[
        float | None,
        Field(
            gt=0.0,
            lt=90.0,
            description="Required least angle between the coupler and the perpendicular to the "
            "ram's line: at 90° all of the coupler's force drives the ram [deg].",
        ),
    ] = None
    objective: Annotated[
        Objective, Field(description="What to optimise where dimensions are left free.")
    ] = LongestLink()
    tolerance: Annotated[
        float,
        Field(ge=1e-6, le=1.0, description="Relative gap to the bound at which the search stops."),
    ] = 1e-2
    time_budget_s: Annotated[
        float | None,
        Field(gt=0.0, le=3600.0, description="Stop after this long with the best so far."),
    ] = None

    @model_validator(mode="after")
    def _check_sizing(self) -> ShaperSpec:
        if not self.free:
            return self
        required = {"stroke_mm": self.stroke_mm, "quick_return_ratio": self.quick_return_ratio}
        for name, asked in required.items():
            if asked is None:
                raise PydanticCustomError(
                    "wish_missing",
                    "{name} is required while {free} is left free. Give a number or "
                    "{{min, max}}, or give every length as a number.",
                    {"name": name, "free": self.free[0]},
                )
        if self.acceleration_rad_per_s2:
            raise PydanticCustomError(
                "sized_at_constant_speed",
                "acceleration_rad_per_s2 = {value} while {free} is left free, but lengths are "
                "chosen for a crank at constant speed. Leave it out, or give every length.",
                {"value": self.acceleration_rad_per_s2, "free": self.free[0]},
            )
        return self

    @property
    def free(self) -> list[str]:
        """Names of the lengths that are left free."""
        return [name for name in LENGTHS if len(set(ends(getattr(self, name)))) > 1]

    def length_ranges(self) -> dict[str, tuple[float, float]]:
        """Least and largest value of every length [mm]."""
        return {name: ends(getattr(self, name)) for name in LENGTHS}

    def shaper(self, lengths: dict[str, float]) -> Shaper:
        """The mechanism with these lengths [mm]."""
        crank, guide, coupler, pivot_distance, ram_line = (lengths[name] for name in LENGTHS)
        return Shaper(crank, guide, coupler, pivot_distance, ram_line, self.ram_side)

    @property
    def drive(self) -> Drive:
        """The crank's motion."""
        sense = 1.0 if self.rotation == "ccw" else -1.0
        speed = rad_per_s(self.speed_rpm)
        return Drive(self.start_deg * DEGREE, sense, speed, self.acceleration_rad_per_s2)
