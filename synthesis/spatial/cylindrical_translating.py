"""Cylindrical cams whose follower slides along the cam's axis."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import ClassVar, Literal

from pydantic import model_validator

from synthesis.geometry.charts import Chart, Drum
from synthesis.geometry.swept_roller import Guide, SweptRoller
from synthesis.ranges import Dimension, Range
from synthesis.spatial import drum, roller
from synthesis.spatial.machine import Seat, SpatialMachine
from synthesis.terms import Row
from synthesis.units import Travel


class CylindricalTranslating(SpatialMachine):
    """A slide along the cam's axis; its roller's axis crosses the cam's at a right angle.

    Frame as in ``drum``; s is z of the roller, or of the middle between two astride a rib.
    """

    kind: Literal["cylindrical_translating"] = "cylindrical_translating"
    title: ClassVar[str] = "cylindrical cam, follower on a slide"
    travel: ClassVar[Travel] = Travel()
    sought: ClassVar[str] = "cylinder_radius_mm"
    unrolls: ClassVar[bool] = True

    cylinder_radius_mm: Dimension = None
    roller_radius_mm: Dimension = None
    roller_width_mm: roller.RollerDepth
    crown_radius_mm: roller.CrownRadius = None
    roller_distance_mm: drum.RollerDistance = None

    @model_validator(mode="after")
    def _fits(self) -> CylindricalTranslating:
        roller.check_crown(self.roller_width_mm, self.crown_radius_mm, self.roller_radius_mm)
        drum.check_room(self.cylinder_radius_mm, self.roller_width_mm)
        drum.check_rib(self.roller_distance_mm, self.roller_radius_mm)
        return self

    def sizes(self) -> Mapping[str, float | Range | None]:
        return {name: getattr(self, name) for name in ("cylinder_radius_mm", "roller_radius_mm")}

    def swept(self, sizes: Mapping[str, float], turns: int) -> SweptRoller:
        width, crown = self.roller_width_mm, self.crown_radius_mm
        return drum.swept(sizes, Guide(drum.Z), 0.0 * drum.Z, width, crown, turns)

    def seats(self) -> tuple[Seat, ...]:
        return drum.seats(0.0, self.roller_distance_mm)

    def mesh(self, sizes: Mapping[str, float]) -> tuple[float, float]:
        return drum.EVERYWHERE

    def chart(self, sizes: Mapping[str, float]) -> Chart:
        return Drum()

    def cylinder(self, sizes: Mapping[str, float]) -> tuple[float, float]:
        return drum.cylinder(sizes, self.roller_width_mm)

    def check_gain(self, gain: float) -> None:
        drum.check_return(gain, self.travel)

    def check_reach(self, lowest: float, highest: float) -> None:
        drum.check_moves(lowest, highest)

    def rest_rib(self, sizes: Mapping[str, float]) -> float:
        distance = self.roller_distance_mm
        return math.inf if distance is None else distance - 2.0 * sizes["roller_radius_mm"]

    def pressure_angle_rows(self, sizes: Mapping[str, float], slope: float) -> tuple[Row, ...]:
        """|s'| ≤ t (R − depth) for every place so deep in the cylinder, t what is left of tan α."""
        width = self.roller_width_mm
        kept = roller.of(sizes["roller_radius_mm"], 0.0, width, self.crown_radius_mm)
        return tuple(
            Row((0.0, sign, 0.0, 0.0), (-left,), -left * (width - foot))
            for foot, left in roller.steepest(kept, slope)
            for sign in (1.0, -1.0)
        )
