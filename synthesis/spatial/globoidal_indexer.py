"""Globoidal (roller gear) indexing cams: a turret with radial rollers across the cam's axis."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar, Literal

import numpy as np
from pydantic import model_validator

from synthesis.geometry.swept_roller import Pivot, SweptRoller
from synthesis.ranges import Dimension, Range
from synthesis.spatial import roller, turret
from synthesis.spatial.machine import Seat, SpatialMachine
from synthesis.units import DEGREE, FULL_TURN, Travel

X, Y, Z = np.eye(3)


class GloboidalIndexer(SpatialMachine):
    """A turret with radial rollers; its axis crosses the cam's at a right angle, some way off.

    Its frame has the origin on the turret's axis, x along the common perpendicular to the cam's
    axis, z along the turret's, about which it turns as its travel grows. The cam turns about y
    where its thread is left-handed, about −y where it is right-handed. The same cam turned over,
    end for end, is seen to turn the other way, and so is its turret: ``rotation`` changes no wall.
    """

    kind: Literal["globoidal_indexer"] = "globoidal_indexer"
    title: ClassVar[str] = "globoidal indexer"
    travel: ClassVar[Travel] = Travel("deg", DEGREE)
    period: ClassVar[float] = FULL_TURN

    rollers: turret.Rollers
    hand: turret.Hand = "right"
    dwell_on: turret.DwellOn = "rib"
    centre_distance_mm: Dimension = None
    roller_radius_mm: Dimension = None
    roller_inner_mm: Dimension = None
    roller_width_mm: roller.RollerWidth
    crown_radius_mm: roller.CrownRadius = None
    mesh_angle_deg: turret.MeshAngle = None

    @model_validator(mode="after")
    def _crown_fits(self) -> GloboidalIndexer:
        roller.check_crown(self.roller_width_mm, self.crown_radius_mm, self.roller_radius_mm)
        return self

    def sizes(self) -> Mapping[str, float | Range | None]:
        names = ("centre_distance_mm", "roller_radius_mm", "roller_inner_mm")
        return {name: getattr(self, name) for name in names}

    def swept(self, sizes: Mapping[str, float], turns: int) -> SweptRoller:
        return SweptRoller(
            centre=np.array([sizes["centre_distance_mm"], 0.0, 0.0]),
            axis=Y,
            joint=Pivot(0.0 * X, Z),
            origin=0.0 * X,
            along=X,
            roller=roller.of(
                sizes["roller_radius_mm"],
                sizes["roller_inner_mm"],
                self.roller_width_mm,
                self.crown_radius_mm,
            ),
            hand=turret.thread(self.hand),
        )

    def seats(self) -> tuple[Seat, ...]:
        return turret.seats(self.rollers, self.dwell_on)

    def mesh(self, sizes: Mapping[str, float]) -> tuple[float, float]:
        return turret.mesh(self.rollers, self.mesh_angle_deg)

    def check_gain(self, gain: float) -> None:
        turret.check_index(gain, self.rollers)
