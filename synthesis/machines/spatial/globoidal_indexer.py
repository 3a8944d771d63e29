"""Globoidal (roller gear) indexing cams: a turret with radial rollers across the cam's axis."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import ClassVar, Literal

import numpy as np
from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from synthesis.catalogue.fields import Dimension, ends
from synthesis.machines.spatial.machine import (
    CrownRadius,
    DwellOn,
    Hand,
    MeshAngle,
    Rollers,
    TurretMachine,
    length,
    six_digits,
)
from synthesis.machines.spatial.size_constraints import (
    SizeConstraint,
    TurretPressureAngle,
    TurretWallRadius,
    critical_places,
)
from synthesis.numerics.geometry.charts import Chart, Torus
from synthesis.numerics.geometry.swept_roller import Joint, SweptRoller

X, Y, Z = np.eye(3)


class GloboidalIndexer(TurretMachine):
    """A turret with radial rollers, its axis perpendicular to the cam's at the centre distance.

    Frame: origin on the turret's axis; x along the common perpendicular towards the cam's axis; z
    along the turret's axis, about which the turret turns as its travel grows. The cam turns about
    y where its thread is left-handed, about −y where it is right-handed. Turned end for end, the
    same cam is seen to turn the other way, and so is its turret: ``rotation`` changes no wall.
    """

    kind: Literal["globoidal_indexer"] = "globoidal_indexer"
    title: ClassVar[str] = "globoidal indexer"
    size_fields: ClassVar[tuple[str, ...]] = (
        "centre_distance_mm", "roller_radius_mm", "roller_inner_mm",
    )  # fmt: skip
    size_field: ClassVar[str] = "centre_distance_mm"
    inner_end_field: ClassVar[str] = "roller_inner_mm"

    rollers: Rollers
    hand: Hand = "right"
    dwell_on: DwellOn = "rib"
    centre_distance_mm: Dimension = None
    roller_radius_mm: Dimension = None
    roller_inner_mm: Dimension = None
    roller_width_mm: float = length("Roller's width.", most=1e5)
    crown_radius_mm: CrownRadius = None
    mesh_angle_deg: MeshAngle = None
    cam_width_mm: float | None = length(
        "Length of the cam along its axis, between end faces at equal distances from the common "
        "perpendicular; left out: as far as the rollers mesh.",
        None,
    )
    bottom_clearance_mm: float = Field(
        0.0, ge=0.0, le=1e5,
        description="Gap between the rollers' ends and the bottoms of the grooves.",
    )  # fmt: skip

    @model_validator(mode="after")
    def _check_dimensions(self) -> GloboidalIndexer:
        # Rollers overlap that reach the plane midway between two neighbours.
        inner, radius = ends(self.roller_inner_mm)[1], ends(self.roller_radius_mm)[0]
        allowed = inner * math.tan(0.5 * self.spacing)
        if radius >= allowed:
            raise PydanticCustomError(
                "rollers_overlap",
                "{rollers} rollers of radius {radius} mm overlap on their turret: at "
                "roller_inner_mm = {inner} the radius must be below {allowed} mm. Reduce "
                "roller_radius_mm or rollers, or increase roller_inner_mm.",
                {"radius": radius, "rollers": self.rollers, "inner": inner,
                 "allowed": six_digits(allowed)},
            )  # fmt: skip
        largest = ends(self.centre_distance_mm)[1]
        inner = max(0.0, ends(self.roller_inner_mm)[0])
        bottom = inner + self.roller_width_mm + self.bottom_clearance_mm
        if largest <= bottom:
            raise PydanticCustomError(
                "grooves_reach_axis",
                "The grooves reach the cam's axis: roller_inner_mm + roller_width_mm + "
                "bottom_clearance_mm is {bottom} mm, and centre_distance_mm is {distance} mm. "
                "Increase centre_distance_mm, or make the rollers shorter.",
                {"distance": largest, "bottom": float(f"{bottom:.9g}")},
            )
        return self

    def swept_roller(self, sizes: Mapping[str, float], rotation: int) -> SweptRoller:
        centre = np.array([sizes["centre_distance_mm"], 0.0, 0.0])
        roller = self._roller(sizes, sizes["roller_inner_mm"])
        return SweptRoller(centre, Y, Joint.pivot(0.0 * X, Z), 0.0 * X, X, roller, self.thread_sign)

    def dimensions(self, sizes: Mapping[str, float]) -> Mapping[str, float]:
        distance, inner = sizes["centre_distance_mm"], sizes["roller_inner_mm"]
        outer = inner + self.roller_width_mm
        derived = {
            "roller_outer_mm": outer,
            "groove_bottom_mm": outer + self.bottom_clearance_mm,
            "throat_radius_mm": distance - inner,
            "core_radius_mm": self.core(sizes),
        }
        half = 0.5 * (self.cam_width_mm or 0.0)
        if 0.0 < half < inner:
            derived["end_radius_mm"] = distance - math.sqrt(inner**2 - half**2)
        return {**sizes, **derived}

    def clearances(self, sizes: Mapping[str, float]) -> Mapping[str, float]:
        return {"core_radius": self.core(sizes), "roller_gap": self._roller_gap(sizes)}

    def _roller_gap(self, sizes: Mapping[str, float]) -> float:
        """Distance between two neighbouring rollers at their inner ends [mm]."""
        half, radius = 0.5 * self.spacing, sizes["roller_radius_mm"]
        return 2.0 * (sizes["roller_inner_mm"] * math.sin(half) - radius * math.cos(half))

    def core(self, sizes: Mapping[str, float]) -> float:
        """Least radius of what the grooves leave of the cam around its axis [mm].

        The rim of a roller's end is nearest to the cam's axis where the roller's angle from the
        common perpendicular is tan ψ = Rr/ρ, or at the end of its mesh where that comes first.
        """
        radius = sizes["roller_radius_mm"]
        bottom = sizes["roller_inner_mm"] + self.roller_width_mm + self.bottom_clearance_mm
        psi = min(math.atan2(radius, bottom), self.mesh_range(sizes)[1])
        return sizes["centre_distance_mm"] - bottom * math.cos(psi) - radius * math.sin(psi)

    def end_faces(self) -> tuple[float, float]:
        half = math.inf if self.cam_width_mm is None else 0.5 * self.cam_width_mm
        return -half, half

    def chart(self, sizes: Mapping[str, float]) -> Chart:
        return Torus(sizes["centre_distance_mm"])

    def dwell_rib(self, sizes: Mapping[str, float]) -> float:
        # The distance is measured from a contact to the next roller, not to its contact.
        return self._roller_gap(sizes) * math.cos(0.5 * self.spacing)

    def length_scale(self, sizes: Mapping[str, float]) -> float:
        return sizes["roller_inner_mm"] + self.roller_width_mm

    def pressure_angle_curves(
        self, sizes: Mapping[str, float], slope: float, rotation: int
    ) -> tuple[SizeConstraint, ...]:
        length, first = self.length_scale(sizes), self.seats()[0].start
        roller = self._roller(sizes, sizes["roller_inner_mm"])
        critical = critical_places(roller, slope, roller.outer)
        places = tuple((foot, foot / (length * left)) for foot, left in critical)
        return (TurretPressureAngle("pressure_angle", length, first, self.spacing, places),)

    def wall_radius_curves(
        self, sizes: Mapping[str, float], least: float
    ) -> tuple[SizeConstraint, ...]:
        roller = self._roller(sizes, sizes["roller_inner_mm"])
        if roller.crown:
            return ()
        return (TurretWallRadius(
            "wall_radius", self.length_scale(sizes), self.seats()[0].start, self.spacing,
            radius=roller.radius + least, places=(roller.inner, roller.outer),
            mesh=self.mesh_range(sizes)[1],
        ),)  # fmt: skip
