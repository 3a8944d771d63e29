"""Globoidal (roller gear) indexing cams: a turret with radial rollers across the cam's axis."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from synthesis.geometry.charts import Chart, Torus
from synthesis.geometry.swept_roller import Pivot, Roller, SweptRoller
from synthesis.ranges import Dimension, Range, ends
from synthesis.spatial import roller, turret
from synthesis.spatial.bulging import TurretBulge
from synthesis.spatial.leverage import Leverage, TurretPressure, places
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
    sought: ClassVar[str] = "centre_distance_mm"
    place_field: ClassVar[str] = "roller_inner_mm"

    rollers: turret.Rollers
    hand: turret.Hand = "right"
    dwell_on: turret.DwellOn = "rib"
    centre_distance_mm: Dimension = None
    roller_radius_mm: Dimension = None
    roller_inner_mm: Dimension = None
    roller_width_mm: roller.RollerWidth
    crown_radius_mm: roller.CrownRadius = None
    mesh_angle_deg: turret.MeshAngle = None
    cam_width_mm: Annotated[
        float | None,
        Field(
            gt=0.0,
            le=1e6,
            description="Length of the cam along its axis, between its end faces, the common "
            "perpendicular in its middle; left out: as far as rollers meet it.",
        ),
    ] = None
    bottom_clearance_mm: Annotated[
        float,
        Field(ge=0.0, le=1e5, description="From the rollers' ends to the bottoms of the grooves."),
    ] = 0.0

    @model_validator(mode="after")
    def _fits(self) -> GloboidalIndexer:
        roller.check_crown(self.roller_width_mm, self.crown_radius_mm, self.roller_radius_mm)
        turret.check_room(self.rollers, self.roller_inner_mm, self.roller_radius_mm)
        self._check_core()
        return self

    def _check_core(self) -> None:
        largest = ends(self.centre_distance_mm)[1]
        inner = max(0.0, ends(self.roller_inner_mm)[0])
        reach = inner + self.roller_width_mm + self.bottom_clearance_mm
        if largest <= reach:
            raise PydanticCustomError(
                "grooves_reach_axis",
                "A cam whose axis is {distance} mm from the turret's has grooves through its axis: "
                "roller_inner_mm, roller_width_mm and bottom_clearance_mm make {reach} mm. Make "
                "centre_distance_mm larger, or the rollers shorter.",
                {"distance": largest, "reach": float(f"{reach:.9g}")},
            )

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
            roller=self._roller(sizes),
            hand=turret.thread(self.hand),
        )

    def _roller(self, sizes: Mapping[str, float]) -> Roller:
        radius, inner = sizes["roller_radius_mm"], sizes["roller_inner_mm"]
        return roller.of(radius, inner, self.roller_width_mm, self.crown_radius_mm)

    def dimensions(self, sizes: Mapping[str, float]) -> Mapping[str, float]:
        distance, inner = sizes["centre_distance_mm"], sizes["roller_inner_mm"]
        outer = inner + self.roller_width_mm
        told = {
            "roller_outer_mm": outer,
            "groove_bottom_mm": outer + self.bottom_clearance_mm,
            "throat_radius_mm": distance - inner,
            "core_radius_mm": self.core(sizes),
        }
        half = 0.5 * (self.cam_width_mm or 0.0)
        if 0.0 < half < inner:
            told["end_radius_mm"] = distance - math.sqrt(inner**2 - half**2)
        return {**sizes, **told}

    def rooms(self, sizes: Mapping[str, float]) -> Mapping[str, float]:
        inner, radius = sizes["roller_inner_mm"], sizes["roller_radius_mm"]
        gap = turret.gap(self.rollers, inner, radius)
        return {"core_radius": self.core(sizes), "roller_gap": gap}

    def core(self, sizes: Mapping[str, float]) -> float:
        """What the grooves leave of the cam around its axis, its least radius [mm].

        The rim of a roller's end comes nearest to the cam's axis where the roller stands at
        tan ψ = Rr/ρ, or as far from the common perpendicular as it meets the cam.
        """
        radius = sizes["roller_radius_mm"]
        bottom = sizes["roller_inner_mm"] + self.roller_width_mm + self.bottom_clearance_mm
        psi = min(math.atan2(radius, bottom), self.mesh(sizes)[1])
        return sizes["centre_distance_mm"] - bottom * math.cos(psi) - radius * math.sin(psi)

    def faces(self) -> tuple[float, float]:
        half = math.inf if self.cam_width_mm is None else 0.5 * self.cam_width_mm
        return -half, half

    def seats(self) -> tuple[Seat, ...]:
        return turret.seats(self.rollers, self.dwell_on)

    def mesh(self, sizes: Mapping[str, float]) -> tuple[float, float]:
        return turret.mesh(self.rollers, self.mesh_angle_deg)

    def chart(self, sizes: Mapping[str, float]) -> Chart:
        return Torus(sizes["centre_distance_mm"])

    def check_gain(self, gain: float) -> None:
        turret.check_index(gain, self.rollers)

    def rest_rib(self, sizes: Mapping[str, float]) -> float:
        # from the contact of one roller to the next roller, that is not to the contact there
        gap = turret.gap(self.rollers, sizes["roller_inner_mm"], sizes["roller_radius_mm"])
        return gap * math.cos(0.5 * turret.spacing(self.rollers))

    def reach(self, sizes: Mapping[str, float]) -> float:
        return sizes["roller_inner_mm"] + self.roller_width_mm

    def pressure_angle_curves(
        self, sizes: Mapping[str, float], slope: float, turns: int
    ) -> tuple[Leverage, ...]:
        length, first = self.reach(sizes), self.seats()[0].start
        spacing, at = turret.spacing(self.rollers), places(self._roller(sizes), length, slope)
        return (TurretPressure("pressure_angle", first, spacing, length, at),)

    def wall_curves(self, sizes: Mapping[str, float], least: float) -> tuple[Leverage, ...]:
        found = self._roller(sizes)
        if found.crown:
            return ()
        at = (found.inner, found.outer)
        spacing, first = turret.spacing(self.rollers), self.seats()[0].start
        mesh, radius = self.mesh(sizes)[1], found.radius + least
        return (TurretBulge("wall_radius", first, spacing, self.reach(sizes), radius, at, mesh),)
