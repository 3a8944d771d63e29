"""ShaperSpec: the request body of a six-bar shaper, given in full or to be sized."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from synthesis.catalogue.fields import FiniteModel, Name, Range, Rotation, Speed, ends
from synthesis.machines.linkages.shaper.mechanism import Drive, Shaper, Side
from synthesis.units import DEGREE, rad_per_s

LENGTHS = ("crank_mm", "guide_mm", "coupler_mm", "pivot_distance_mm", "ram_line_mm")
SMALLEST, LARGEST = 1e-6, 1e6  # mm: far from any machine, so that products stay finite

Length = Annotated[float, Field(ge=SMALLEST, le=LARGEST)]
Height = Annotated[float, Field(ge=-LARGEST, le=LARGEST)]
Ratio = Annotated[float, Field(ge=1.0, le=100.0)]


class LengthRange(Range):
    """A range in which a length is left free."""

    min: Length = Field(description="Smallest allowed [mm].")
    max: Length = Field(description="Largest allowed [mm].")


class HeightRange(Range):
    """A range in which a height is left free."""

    min: Height = Field(description="Smallest allowed [mm].")
    max: Height = Field(description="Largest allowed [mm].")


class StrokeRange(Range):
    """A range of the required stroke."""

    min: Length = Field(description="Smallest stroke [mm].")
    max: Length = Field(description="Largest stroke [mm].")


class RatioRange(Range):
    """A range of the required quick-return ratio."""

    min: Ratio = Field(description="Smallest ratio.")
    max: Ratio = Field(description="Largest ratio.")


class LongestLink(FiniteModel):
    """Minimise the longest link: the smallest machine."""

    kind: Literal["longest_link"] = "longest_link"


class TransmissionAngle(FiniteModel):
    """Maximise the least transmission angle at the ram."""

    kind: Literal["transmission_angle"] = "transmission_angle"


class RamAcceleration(FiniteModel):
    """Minimise the largest acceleration of the ram."""

    kind: Literal["ram_acceleration"] = "ram_acceleration"


Objective = Annotated[
    LongestLink | TransmissionAngle | RamAcceleration, Field(discriminator="kind")
]


def _length(description: str) -> Any:
    return Field(description=f"{description} [mm]; {{min, max}} leaves it free between them.")


class ShaperSpec(FiniteModel):
    """A shaper: its dimensions, its crank's motion, and what is required of it.

    The guide's pivot is the origin, the crank's pivot lies above it, the ram slides along a
    horizontal line. Angles are measured from the x axis, counter-clockwise.
    """

    name: Name = Field("", description="Shown in reports and files.")
    crank_mm: Length | LengthRange = _length("Crank")
    guide_mm: Length | LengthRange = _length("Guide, from its pivot to its end")
    coupler_mm: Length | LengthRange = _length("Coupler, from the guide's end to the ram")
    pivot_distance_mm: Length | LengthRange = _length(
        "Height of the crank's pivot above the guide's"
    )
    ram_line_mm: Height | HeightRange = _length("Height of the ram's line above the guide's pivot")
    ram_side: Side = Field(
        "right",
        description="Assembly branch: the side of the guide's end on which the ram's pin is. "
        "The two are mirror images, with the crank turning in the opposite sense.",
    )
    speed_rpm: Speed = Field(
        60.0, description="Crank speed [rpm]; with an acceleration, that at the start of the turn."
    )
    rotation: Rotation = Field("ccw", description="Sense in which the crank turns.")
    acceleration_rad_per_s2: float = Field(
        0.0,
        ge=-1e12,
        le=1e12,
        description="Angular acceleration of the crank over the turn, positive where it "
        "speeds up [rad/s²].",
    )
    start_deg: float = Field(
        0.0, ge=-360.0, le=360.0, description="Crank angle at the start of the turn [deg]."
    )
    stroke_mm: Length | StrokeRange | None = Field(
        None, description="Required stroke of the ram [mm]."
    )
    quick_return_ratio: Ratio | RatioRange | None = Field(
        None,
        description="Required quick-return ratio: crank angle of the slow stroke over that of "
        "the quick one.",
    )
    least_transmission_angle_deg: float | None = Field(
        None,
        gt=0.0,
        lt=90.0,
        description="Required least angle between the coupler and the perpendicular to the "
        "ram's line: at 90° all of the coupler's force drives the ram [deg].",
    )
    objective: Objective = Field(
        LongestLink(), description="What to optimise where dimensions are left free."
    )
    tolerance: float = Field(
        1e-2, ge=1e-6, le=1.0, description="Relative gap to the bound at which the search stops."
    )
    time_budget_s: float | None = Field(
        None, gt=0.0, le=3600.0, description="Stop after this long with the best so far."
    )

    @model_validator(mode="after")
    def _check_sizing(self) -> ShaperSpec:
        if not self.free:
            return self
        for name in ("stroke_mm", "quick_return_ratio"):
            if getattr(self, name) is None:
                raise PydanticCustomError(
                    "wish_missing",
                    "{name} is required while {free} is left free. Give a number or "
                    "{min, max}, or give every length as a number.",
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
