"""Pressure angle between the walls' normals and the ways of the rollers."""

from __future__ import annotations

from math import tan
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from synthesis.limits.base import Machine
from synthesis.motion import Stretch
from synthesis.spatial.limits.base import SpatialLimit
from synthesis.terms import Curved, Row
from synthesis.units import DEGREE


class SpatialPressureAngle(SpatialLimit):
    """|α| ≤ the limit at every contact of every roller that meets the cam."""

    kind: Literal["pressure_angle"] = "pressure_angle"
    title: ClassVar[str] = "Pressure angle"
    quantity: ClassVar[str] = "pressure_angle"
    field: ClassVar[str] = "max_deg"
    upper: ClassVar[bool] = True

    max_deg: Annotated[float, Field(gt=0.0, lt=90.0, description="Largest |pressure angle|.")]

    @property
    def bound(self) -> float:
        return self.max_deg

    @property
    def keeps_large(self) -> bool:
        return True

    @property
    def steepest(self) -> float:
        return tan(self.max_deg * DEGREE)

    def rows(self, stretch: Stretch, machine: Machine) -> tuple[Row, ...]:
        return tuple(
            row
            for path in machine.follower.paths.values()
            for row in path.pressure_angle_rows(self.steepest)
        )

    def curved(self, stretch: Stretch, machine: Machine) -> tuple[Curved, ...]:
        return machine.follower.pressure_angle_curves(self.steepest)
