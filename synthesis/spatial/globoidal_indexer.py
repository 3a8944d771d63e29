"""Globoidal (roller gear) indexing cams: a turret with radial rollers across the cam's axis."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field
from pydantic_core import PydanticCustomError

from synthesis.geometry.swept_roller import Pivot, Roller, SweptRoller
from synthesis.ranges import Dimension, Range
from synthesis.spatial.leverage import Leverage, TurretPressure, places
from synthesis.spatial.machine import Seat, SpatialMachine
from synthesis.units import DEGREE, FULL_TURN, Travel

WHOLE = 1e-9  # of a spacing: a gain that is a whole number of rollers
X, Y, Z = np.eye(3)


class GloboidalIndexer(SpatialMachine):
    """A turret with radial rollers; its axis crosses the cam's at a right angle, some way off.

    Its frame has the origin on the turret's axis, x along the common perpendicular to the cam's
    axis, z along the turret's.
    """

    kind: Literal["globoidal_indexer"] = "globoidal_indexer"
    title: ClassVar[str] = "globoidal indexer"
    travel: ClassVar[Travel] = Travel("deg", DEGREE)
    sought: ClassVar[str] = "centre_distance_mm"

    rollers: Annotated[int, Field(ge=3, le=64, description="Rollers on the turret.")]
    hand: Annotated[Literal["left", "right"], Field(description="Hand of the cam's thread.")] = (
        "right"
    )
    dwell_on: Annotated[
        Literal["rib", "groove"],
        Field(
            description="What lies on the common perpendicular while the turret rests: a rib "
            "between two rollers, or a groove with one roller in it."
        ),
    ] = "rib"
    centre_distance_mm: Dimension = None
    roller_radius_mm: Dimension = None
    roller_inner_mm: Dimension = None
    roller_width_mm: Annotated[float, Field(gt=0.0, le=1e5, description="Roller's width.")]
    crown_radius_mm: Annotated[
        float | None,
        Field(gt=0.0, le=1e7, description="Radius of a crowned roller's outline; left out: none."),
    ] = None
    mesh_angle_deg: Annotated[
        float | None,
        Field(
            gt=0.0,
            le=90.0,
            description="A roller meets the cam up to so far from the common perpendicular; left "
            "out: from where one that rests beside it gets to within one index.",
        ),
    ] = None

    @property
    def spacing(self) -> float:
        """Angle from roller to roller [rad]."""
        return FULL_TURN / self.rollers

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
            hand=turns * (1 if self.hand == "right" else -1),
        )

    def _roller(self, sizes: Mapping[str, float]) -> Roller:
        inner, crown = sizes["roller_inner_mm"], self.crown_radius_mm or 0.0
        return Roller(sizes["roller_radius_mm"], inner, inner + self.roller_width_mm, crown)

    def seats(self) -> tuple[Seat, ...]:
        first = 0.5 * self.spacing if self.dwell_on == "rib" else 0.0
        return tuple(Seat(i + 1, first - i * self.spacing) for i in range(self.rollers))

    def mesh(self, sizes: Mapping[str, float]) -> tuple[float, float]:
        asked = self.mesh_angle_deg
        most = min(1.5 * self.spacing, 0.5 * math.pi) if asked is None else asked * DEGREE
        return -most, most

    def check_gain(self, gain: float) -> None:
        rollers = gain / self.spacing
        if round(rollers) == 0 or abs(rollers - round(rollers)) > WHOLE:
            raise PydanticCustomError(
                "index_not_whole",
                "The program turns the turret by {gain}° in a turn of the cam, which is {rollers} "
                "times the {spacing}° between two of {count} rollers. Make the lifts of the "
                "program sum to a whole number of these, and not to none.",
                {
                    "gain": float(f"{gain / DEGREE:.9g}"),
                    "rollers": float(f"{rollers:.9g}"),
                    "spacing": float(f"{self.spacing / DEGREE:.9g}"),
                    "count": self.rollers,
                },
            )

    def reach(self, sizes: Mapping[str, float]) -> float:
        return sizes["roller_inner_mm"] + self.roller_width_mm

    def pressure_angle_curves(
        self, sizes: Mapping[str, float], slope: float
    ) -> tuple[Leverage, ...]:
        length, first = self.reach(sizes), self.seats()[0].start
        at = places(self._roller(sizes), length, slope)
        return (TurretPressure("pressure_angle", first, self.spacing, length, at),)
