"""What machines say of their rollers: fields, the roller itself, and rules they share."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field
from pydantic_core import PydanticCustomError

from synthesis.geometry.swept_roller import Roller
from synthesis.ranges import Dimension, ends

PLACES = 17  # on a crowned roller

RollerWidth = Annotated[float, Field(gt=0.0, le=1e5, description="Roller's width.")]
RollerDepth = Annotated[
    float,
    Field(gt=0.0, le=1e5, description="Roller's width, all of which reaches into the cam."),
]
CrownRadius = Annotated[
    float | None,
    Field(gt=0.0, le=1e7, description="Radius of a crowned roller's outline; left out: none."),
]


def of(radius: float, inner: float, width: float, crown: float | None) -> Roller:
    """The roller of this width, from ρ = ``inner`` on [mm]."""
    return Roller(radius, inner, inner + width, crown or 0.0)


def check_crown(width: float, crown: float | None, radius: Dimension) -> None:
    """Refuse a crown that leaves a roller nothing at its ends.

    Raises:
        PydanticCustomError: its outline ends before the roller does, or comes to its axis.
    """
    if crown is None:
        return
    half, largest = 0.5 * width, ends(radius)[1]
    if crown <= half or crown - np.sqrt(crown**2 - half**2) >= largest:
        raise PydanticCustomError(
            "crown_too_round",
            "An outline of crown_radius_mm = {crown} comes to the axis of a roller {width} mm "
            "wide before its ends. Make the crown's radius larger, or the roller narrower.",
            {"crown": crown, "width": width},
        )


def steepest(kept: Roller, slope: float) -> tuple[tuple[float, float], ...]:
    """Where a roller across a cylinder's axis may first exceed tan α: (foot, tan α left there).

    Of a cylindrical roller at its inner end alone. On a crowned one the contact at ρ has its foot
    at ρ + r r' and leans by r' more: 1 + tan² α = (1 + r'²)(1 + tan² α_foot).

    Args:
        kept: the roller. slope: tan α_max; nothing is left where r' alone exceeds it.
    """
    if kept.crown == 0.0:
        return ((kept.inner, slope),)
    rho = np.linspace(kept.inner, kept.outer, PLACES)
    radius, lean, _ = kept.profile(rho)
    left = np.sqrt(np.maximum((1.0 + slope**2) / (1.0 + lean**2) - 1.0, 0.0))
    return tuple(zip((rho + radius * lean).tolist(), left.tolist(), strict=True))
