"""What cylindrical cams have in common whose follower goes to and fro: on a slide or on an arm."""

from __future__ import annotations

import math
from abc import ABC
from collections.abc import Mapping
from typing import ClassVar, Self

from pydantic import model_validator

from synthesis.geometry.charts import Chart, Drum
from synthesis.ranges import Dimension, Range
from synthesis.spatial import drum, roller
from synthesis.spatial.machine import SpatialMachine


class CylindricalFollower(SpatialMachine, ABC):
    """One roller in a groove, or two astride a rib; frame as in ``drum``."""

    sought: ClassVar[str] = "cylinder_radius_mm"
    unrolls: ClassVar[bool] = True

    cylinder_radius_mm: Dimension = None
    roller_radius_mm: Dimension = None
    roller_width_mm: roller.RollerDepth
    crown_radius_mm: roller.CrownRadius = None
    roller_distance_mm: drum.RollerDistance = None

    @model_validator(mode="after")
    def _fits(self) -> Self:
        roller.check_crown(self.roller_width_mm, self.crown_radius_mm, self.roller_radius_mm)
        drum.check_room(self.cylinder_radius_mm, self.roller_width_mm)
        drum.check_rib(self.roller_distance_mm, self.roller_radius_mm)
        return self

    def sizes(self) -> Mapping[str, float | Range | None]:
        return {name: getattr(self, name) for name in ("cylinder_radius_mm", "roller_radius_mm")}

    def mesh(self, sizes: Mapping[str, float]) -> tuple[float, float]:
        return drum.EVERYWHERE

    def chart(self, sizes: Mapping[str, float]) -> Chart:
        return Drum()

    def cylinder(self, sizes: Mapping[str, float]) -> tuple[float, float]:
        return drum.cylinder(sizes, self.roller_width_mm)

    def check_gain(self, gain: float) -> None:
        drum.check_return(gain, self.travel)

    def rest_rib(self, sizes: Mapping[str, float]) -> float:
        distance = self.roller_distance_mm
        return math.inf if distance is None else distance - 2.0 * sizes["roller_radius_mm"]
