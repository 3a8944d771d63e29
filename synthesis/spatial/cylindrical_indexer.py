"""Cylindrical (barrel) indexing cams: a turret whose rollers are parallel to its axis."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, ClassVar, Literal

from pydantic import Field, model_validator

from synthesis.geometry.charts import Chart, Drum
from synthesis.geometry.swept_roller import SweptRoller
from synthesis.ranges import Dimension, Range
from synthesis.spatial import drum, roller, turret
from synthesis.spatial.machine import Seat, SpatialMachine
from synthesis.units import DEGREE, FULL_TURN, Travel


class CylindricalIndexer(SpatialMachine):
    """A turret that crosses the cam's axis at a right angle, some way off, as its rollers do.

    Frame as in ``drum``; the turret's axis is at y = centre distance, z = 0, and parallel to x. A
    roller's angle is 0 where it is nearest to the cam's axis, seen along the turret's.
    """

    kind: Literal["cylindrical_indexer"] = "cylindrical_indexer"
    title: ClassVar[str] = "cylindrical (barrel) indexer"
    travel: ClassVar[Travel] = Travel("deg", DEGREE)
    unrolls: ClassVar[bool] = True
    period: ClassVar[float] = FULL_TURN

    rollers: turret.Rollers
    hand: turret.Hand = "right"
    dwell_on: turret.DwellOn = "rib"
    turret_radius_mm: Annotated[
        float,
        Field(gt=0.0, le=1e6, description="Radius of the circle on which the rollers stand."),
    ]
    centre_distance_mm: Annotated[
        float | None,
        Field(
            gt=0.0,
            le=1e6,
            description="Distance between the turret's axis and the cam's; left out: the radius "
            "of the rollers' circle.",
        ),
    ] = None
    cylinder_radius_mm: Dimension = None
    roller_radius_mm: Dimension = None
    roller_width_mm: roller.RollerDepth
    crown_radius_mm: roller.CrownRadius = None
    mesh_angle_deg: turret.MeshAngle = None

    @model_validator(mode="after")
    def _fits(self) -> CylindricalIndexer:
        roller.check_crown(self.roller_width_mm, self.crown_radius_mm, self.roller_radius_mm)
        width, cylinder = self.roller_width_mm, self.cylinder_radius_mm
        drum.check_room(cylinder, width)
        drum.check_beside(*self._lengths, (0.0,), cylinder, width)
        return self

    def sizes(self) -> Mapping[str, float | Range | None]:
        return {name: getattr(self, name) for name in ("cylinder_radius_mm", "roller_radius_mm")}

    def swept(self, sizes: Mapping[str, float], turns: int) -> SweptRoller:
        joint, origin = drum.arm(*self._lengths)
        width, crown, hand = self.roller_width_mm, self.crown_radius_mm, turret.thread(self.hand)
        return drum.swept(sizes, joint, origin, width, crown, hand)

    @property
    def _lengths(self) -> tuple[float, float]:
        """Turret's axis to rollers, and to the cam's axis [mm]."""
        return self.turret_radius_mm, self.centre_distance_mm or self.turret_radius_mm

    def seats(self) -> tuple[Seat, ...]:
        return turret.seats(self.rollers, self.dwell_on)

    def mesh(self, sizes: Mapping[str, float]) -> tuple[float, float]:
        low, high = turret.mesh(self.rollers, self.mesh_angle_deg)
        radius, distance = self._lengths
        lowest = distance - drum.beside(sizes, self.roller_width_mm)
        leaves = math.acos(min(max(lowest / radius, -1.0), 1.0))
        return max(low, -leaves), min(high, leaves)

    def cylinder(self, sizes: Mapping[str, float]) -> tuple[float, float]:
        return drum.cylinder(sizes, self.roller_width_mm)

    def chart(self, sizes: Mapping[str, float]) -> Chart:
        return Drum()

    def check_gain(self, gain: float) -> None:
        turret.check_index(gain, self.rollers)
