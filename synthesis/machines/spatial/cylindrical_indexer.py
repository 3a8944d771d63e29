"""Cylindrical (barrel) indexing cams: a turret whose rollers are parallel to its axis."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, ClassVar, Literal

from pydantic import Field, model_validator

from synthesis.machines.spatial import turret
from synthesis.machines.spatial.cylindrical import CylindricalMachine, pivot
from synthesis.machines.spatial.machine import Seat
from synthesis.numerics.geometry.swept_roller import SweptRoller
from synthesis.units import DEGREE, FULL_TURN, Travel


class CylindricalIndexer(CylindricalMachine):
    """A turret whose axis and rollers are perpendicular to the cam's axis, at a distance from it.

    Frame as in ``cylindrical``; the turret's axis is parallel to x, at y = centre distance and
    z = 0. A roller's angle is 0 where it is nearest to the cam's axis, seen along the turret's.
    It is not sized yet: its rollers' axes pass beside the cam's, so that the pressure angle has no
    closed form in the motion and the radius.
    """

    kind: Literal["cylindrical_indexer"] = "cylindrical_indexer"
    title: ClassVar[str] = "cylindrical (barrel) indexer"
    travel: ClassVar[Travel] = Travel("deg", DEGREE)
    size_field: ClassVar[str] = ""
    period: ClassVar[float] = FULL_TURN

    rollers: turret.Rollers
    hand: turret.Hand = "right"
    dwell_on: turret.DwellOn = "rib"
    turret_radius_mm: Annotated[
        float,
        Field(gt=0.0, le=1e6, description="Radius of the circle through the rollers' axes."),
    ]
    centre_distance_mm: Annotated[
        float | None,
        Field(
            gt=0.0,
            le=1e6,
            description="Distance between the turret's axis and the cam's; left out: "
            "turret_radius_mm.",
        ),
    ] = None
    mesh_angle_deg: turret.MeshAngle = None

    @model_validator(mode="after")
    def _check_turret(self) -> CylindricalIndexer:
        self._check_offset(*self._lengths, (0.0,))
        return self

    def swept_roller(self, sizes: Mapping[str, float], rotation: int) -> SweptRoller:
        return self._swept(sizes, *pivot(*self._lengths), turret.thread_sign(self.hand))

    @property
    def _lengths(self) -> tuple[float, float]:
        """Turret's axis to the rollers, and to the cam's axis [mm]."""
        return self.turret_radius_mm, self.centre_distance_mm or self.turret_radius_mm

    def seats(self) -> tuple[Seat, ...]:
        return turret.seats(self.rollers, self.dwell_on)

    def mesh_range(self, sizes: Mapping[str, float]) -> tuple[float, float]:
        low, high = turret.mesh_range(self.rollers, self.mesh_angle_deg)
        radius, distance = self._lengths
        lowest = distance - self._largest_offset(sizes["cylinder_radius_mm"])
        leaves = math.acos(min(max(lowest / radius, -1.0), 1.0))
        return max(low, -leaves), min(high, leaves)

    def check_gain(self, gain: float) -> None:
        turret.check_index(gain, self.rollers)
