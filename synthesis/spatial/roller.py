"""What machines say of their rollers: fields, the roller itself, and rules they share."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field
from pydantic_core import PydanticCustomError

from synthesis.geometry.swept_roller import Roller
from synthesis.ranges import Dimension, ends

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
