"""CamSetSpec: what is asked of several cams on one shaft.

Frames, all right-handed with z along the shaft, seen with z towards the viewer; ς = +1 where the
shaft turns counter-clockwise, −1 clockwise; R(a) a turn by a, counter-clockwise positive.

* Shaft angle Θ: how far the shaft has turned from its zero position, in its own sense.
* The shaft's frame turns with the shaft and is the machine's at Θ = 0.
* A cam's own frame is the one that its design is given in: y along an upward follower at cam
  angle 0. Its follower may stand elsewhere round the shaft: then that frame's y axis points in
  the follower's direction δ at cam angle 0 (δ = 90°: upwards, nothing is turned).

Cam i's program starts when the shaft has turned by its phase φ: the follower's displacement is
s(Θ − φ). So at Θ = φ the cam's own frame must lie at R(δ − 90°) in the machine, and there the
shaft's frame lies at R(ς φ). On the shaft the cam is therefore turned by

    turn = δ − 90° − ς φ :    the phase turns a cam *against* the sense of rotation.
"""

from __future__ import annotations

from typing import Any

from pydantic import Field, ValidationInfo, field_validator, model_validator
from pydantic_core import PydanticCustomError

from synthesis.catalogue.fields import FiniteModel, Name, Rotation, Speed
from synthesis.spec.design_spec import DesignSpec

MAX_CAMS = 50  # of a set
UPWARDS_DEG = 90.0  # from the x axis
SHAFT_FIELDS = ("speed_rpm", "rotation")


class CamOnShaft(FiniteModel):
    """One cam of a set: what it must do, and how it sits on the shaft."""

    name: Name = Field(
        "",
        description="Shown in the diagram and in file names. Where several cams share a name, "
        "the answer puts each one's number behind it.",
    )
    phase_deg: float = Field(
        0.0,
        ge=-360.0,
        le=360.0,
        description="Shaft angle at which the cam's program starts: at shaft angle Θ its "
        "follower stands where the design alone has it at cam angle Θ − phase [deg].",
    )
    axial_mm: float = Field(
        0.0, ge=-1e6, le=1e6, description="Position along the shaft: z of the points [mm]."
    )
    follower_direction_deg: float = Field(
        UPWARDS_DEG,
        ge=-360.0,
        le=360.0,
        description="Where about the shaft the follower is mounted: direction of the y axis "
        "of its design's frame, counter-clockwise from x; 90 is upwards, as in a design on "
        "its own [deg].",
    )
    spec: DesignSpec = Field(
        description="The cam. `speed_rpm` and `rotation` are the shaft's: leave them out here, "
        "or give the same. `name` is the cam's where it is left out."
    )

    def turn_deg(self, rotation: Rotation) -> float:
        """Angle by which the cam is turned on the shaft, in (−180, 180] [deg]; see above."""
        sense = -1.0 if rotation == "cw" else 1.0
        return within_half_turn(self.follower_direction_deg - UPWARDS_DEG - sense * self.phase_deg)


class CamSetSpec(FiniteModel):
    """Several cams on one shaft: how it turns, and the cams with their phases."""

    name: Name = Field("", description="Shown in reports and files.")
    speed_rpm: Speed = Field(60.0, description="Speed of the shaft, constant [rpm].")
    rotation: Rotation = Field("ccw", description="Sense in which the shaft turns.")
    cams: list[CamOnShaft] = Field(
        min_length=1, max_length=MAX_CAMS, description="The cams, in any order."
    )
    time_budget_s: float | None = Field(
        None,
        gt=0.0,
        le=3600.0,
        description="Stop after this long with the best so far; the cams share it: each gets "
        "an equal part of what the ones before it have left.",
    )

    @field_validator("cams", mode="before")
    @classmethod
    def _turn_with_the_shaft(cls, cams: Any, info: ValidationInfo) -> Any:
        """Hand speed and sense of rotation on to the cams that leave them out.

        Before the cams are checked, for what they ask may depend on the speed.
        """
        if not isinstance(cams, list):
            return cams
        shaft = {field: info.data[field] for field in SHAFT_FIELDS if field in info.data}
        return [_with_shaft_fields(cam, shaft) for cam in cams]

    @model_validator(mode="after")
    def _is_one_shaft(self) -> CamSetSpec:
        for position, cam in enumerate(self.cams):
            for field in SHAFT_FIELDS:
                own, shaft = getattr(cam.spec, field), getattr(self, field)
                if own != shaft:
                    raise PydanticCustomError(
                        "cam_off_the_shaft",
                        "{field} is {value} here and {shaft} of the shaft: all cams turn with it. "
                        "Leave it out, or give the same.",
                        {"position": position, "field": field, "value": own, "shaft": shaft},
                    )
        return self


def _with_shaft_fields(cam: Any, shaft: dict[str, Any]) -> Any:
    """A cam as it came, with what its spec leaves out."""
    if not isinstance(cam, dict) or not isinstance(cam.get("spec"), dict):
        return cam
    left_out = {**shaft, "name": cam["name"]} if isinstance(cam.get("name"), str) else shaft
    return {**cam, "spec": {**left_out, **cam["spec"]}}


def within_half_turn(degrees: float) -> float:
    """The same direction in (−180, 180], without the last digits' noise [deg]."""
    return round(180.0 - round(180.0 - degrees, 9) % 360.0, 9)


def wrap_turn(degrees: float) -> float:
    """The same direction in [0, 360), without the last digits' noise [deg]."""
    return round(degrees, 9) % 360.0
