"""What machines say of their rollers: fields, the roller's geometry, and checks."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field
from pydantic_core import PydanticCustomError

from synthesis.catalogue.ranges import Dimension, ends
from synthesis.numerics.geometry.swept_roller import Roller

PLACES = 17  # samples along a crowned roller; its profile is smooth, and the judge measures anyway

RollerWidth = Annotated[float, Field(gt=0.0, le=1e5, description="Roller's width.")]
RollerDepth = Annotated[
    float,
    Field(gt=0.0, le=1e5, description="Roller's width, all of which reaches into the cam."),
]
CrownRadius = Annotated[
    float | None,
    Field(
        gt=0.0,
        le=1e7,
        description="Radius of the crowned roller's outline; left out: a cylindrical roller.",
    ),
]


def roller_of(radius: float, inner: float, width: float, crown: float | None) -> Roller:
    """The roller of this radius and width whose inner end is at ρ = ``inner`` [mm]."""
    return Roller(radius, inner, inner + width, crown or 0.0)


def check_crown(width: float, crown: float | None, radius: Dimension) -> None:
    """Refuse a crown whose outline reaches the roller's axis within the roller's width.

    Raises:
        PydanticCustomError: it does, or the outline's circle is narrower than the roller.
    """
    if crown is None:
        return
    half, largest = 0.5 * width, ends(radius)[1]
    if crown <= half or crown - np.sqrt(crown**2 - half**2) >= largest:
        raise PydanticCustomError(
            "crown_too_round",
            "With crown_radius_mm = {crown} the outline of a roller {width} mm wide meets the "
            "roller's axis before its ends. Increase crown_radius_mm, or reduce the width.",
            {"crown": crown, "width": width},
        )


def crown_slope(roller: Roller) -> float:
    """The largest |r'|: tan of the pressure angle that the roller's ends have even at rest."""
    _, lean, _ = roller.profile(np.array([roller.inner, roller.outer]))
    return float(np.max(np.abs(lean)))


def critical_places(roller: Roller, slope: float) -> tuple[tuple[float, float], ...]:
    """Places that decide the pressure angle: (foot on the axis [mm], tan α that is left there).

    On a cylindrical roller that is the inner end. On a crowned one the contact at ρ has its foot at
    ρ + r r', and its normal leans by r' more: 1 + tan² α = (1 + r'²)(1 + tan² α_foot).

    Args:
        roller: the roller. slope: tan α_max; where |r'| exceeds it, 0 is left.
    """
    if roller.crown == 0.0:
        return ((roller.inner, slope),)
    rho = np.linspace(roller.inner, roller.outer, PLACES)
    radius, lean, _ = roller.profile(rho)
    left = np.sqrt(np.maximum((1.0 + slope**2) / (1.0 + lean**2) - 1.0, 0.0))
    return tuple(zip((rho + radius * lean).tolist(), left.tolist(), strict=True))
