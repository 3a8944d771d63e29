"""What a caller may choose about a solid cam."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from pydantic import Field

from synthesis.errors import InputError
from synthesis.exporters.options import Axial, BoreDiameter, Options, Turn

Length = Annotated[float | None, Field(gt=0.0, le=1e6)]


@dataclass(frozen=True, kw_only=True)
class SolidOptions(Options):
    """The cam as a body; ``z_mm``: of its back."""

    curve: Annotated[
        Literal["profile", "main", "counter"],
        Field(description="Of conjugate cams, which; otherwise `profile`."),
    ] = "profile"
    thickness_mm: Annotated[float, Field(gt=0.0, le=1e5, description="Of plate, ring or disc.")] = (
        10.0
    )
    tolerance_um: Annotated[
        float,
        Field(
            ge=1e-3,
            le=1e3,
            description="Largest distance of the flanks from the true curve, along its normal "
            "[µm]. What is reached is told in the header Camwright-Curve-Error-Mm.",
        ),
    ] = 1e-3
    bore_mm: BoreDiameter = None
    keyway: Annotated[bool, Field(description="A keyway in the bore, by DIN 6885-1.")] = False
    keyway_width_mm: Annotated[
        Length, Field(description="Width of the keyway; left out: by the bore.")
    ] = None
    keyway_depth_mm: Annotated[
        Length, Field(description="Depth beyond the bore's radius; left out: by the bore.")
    ] = None
    keyway_deg: Annotated[
        float,
        Field(
            ge=-360.0,
            le=360.0,
            description="Direction of the keyway in the cam's own frame; in a cam set it is told "
            "for every cam.",
        ),
    ] = 90.0
    hub_diameter_mm: Annotated[Length, Field(description="Of a hub on the back.")] = None
    hub_length_mm: Annotated[Length, Field(description="How far the hub stands out.")] = None
    groove_depth_mm: Annotated[
        Length, Field(description="Of a groove; left out: half the thickness.")
    ] = None
    outer_diameter_mm: Annotated[
        Length,
        Field(
            description="Of a ring or a grooved disc; left out: the largest radius and the rim, "
            "or a tenth of that radius where the design has no rim."
        ),
    ] = None
    turn_deg: Turn = 0.0
    z_mm: Axial = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if (self.hub_diameter_mm is None) != (self.hub_length_mm is None):
            missing = "hub_length_mm" if self.hub_length_mm is None else "hub_diameter_mm"
            rule = "A hub has a diameter and a length."
            raise InputError(f"/{missing}", None, rule, "Give both of them, or neither.")
        if self.keyway and self.bore_mm is None:
            raise InputError("/bore_mm", None, "A keyway needs a bore.", "Give its diameter.")
        if self.groove_depth_mm is not None and not self.groove_depth_mm < self.thickness_mm:
            raise InputError(
                "/groove_depth_mm",
                self.groove_depth_mm,
                f"The groove must be less deep than the disc is thick, {self.thickness_mm:g} mm.",
                "Make the disc thicker, or the groove less deep.",
            )
