"""Limits of spatial cams: one file each. A new one is a file and its name in the union."""

from __future__ import annotations

from typing import Annotated, get_args

from pydantic import Field

from synthesis.limits import Limit
from synthesis.limits.acceleration import Acceleration
from synthesis.limits.jerk import Jerk
from synthesis.limits.velocity import Velocity
from synthesis.spatial.limits.base import SpatialLimit
from synthesis.spatial.limits.pressure_angle import SpatialPressureAngle
from synthesis.spatial.limits.rib_thickness import RibThickness
from synthesis.spatial.limits.wall_radius import WallRadius

AnySpatialLimit = Annotated[
    SpatialPressureAngle | WallRadius | RibThickness | Velocity | Acceleration | Jerk,
    Field(discriminator="kind"),
]

LIMITS: tuple[type[Limit], ...] = get_args(get_args(AnySpatialLimit)[0])
"""The same as a tuple, in that order."""

__all__ = ["LIMITS", "AnySpatialLimit", "SpatialLimit"]
