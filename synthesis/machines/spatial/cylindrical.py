"""What machines around cylindrical cams share: the frame, the roller fields and their checks.

Frame: the origin lies on the cam's axis, which is z; x points along the roller's axis, and ρ is the
distance along it from the cam's axis. The follower moves towards larger z as q grows.
"""

from __future__ import annotations

import math
from abc import ABC
from collections.abc import Mapping, Sequence
from typing import Annotated, ClassVar, Self

import numpy as np
from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from synthesis.catalogue.ranges import Dimension, Range, ends
from synthesis.machines.spatial import roller
from synthesis.machines.spatial.machine import LEFT, RIGHT, Seat, SpatialMachine, six_digits
from synthesis.numerics.geometry.charts import Chart, Drum
from synthesis.numerics.geometry.swept_roller import Joint, Pivot, SweptRoller
from synthesis.numerics.piecewise import Array

CLOSURE = 1e-9  # mm or deg: rounding of a sum of lifts that closes after one turn
X, Y, Z = np.eye(3)


class CylindricalMachine(SpatialMachine, ABC):
    """A machine whose grooves are cut into a cylinder; frame as in this module."""

    size_field: ClassVar[str] = "cylinder_radius_mm"
    developable: ClassVar[bool] = True

    cylinder_radius_mm: Dimension = None
    roller_radius_mm: Dimension = None
    roller_width_mm: roller.RollerDepth
    crown_radius_mm: roller.CrownRadius = None

    @model_validator(mode="after")
    def _check_rollers(self) -> Self:
        width, largest = self.roller_width_mm, ends(self.cylinder_radius_mm)[1]
        roller.check_crown(width, self.crown_radius_mm, self.roller_radius_mm)
        if width >= largest:
            raise PydanticCustomError(
                "roller_reaches_axis",
                "A roller with roller_width_mm = {width} reaches through a cylinder of radius "
                "{radius} mm to its axis. Increase cylinder_radius_mm, or reduce roller_width_mm.",
                {"width": width, "radius": largest},
            )
        return self

    def sizes(self) -> Mapping[str, float | Range | None]:
        return {name: getattr(self, name) for name in ("cylinder_radius_mm", "roller_radius_mm")}

    def chart(self, sizes: Mapping[str, float]) -> Chart:
        return Drum()

    def wall_radii(self, sizes: Mapping[str, float]) -> tuple[float, float]:
        return sizes["cylinder_radius_mm"] - self.roller_width_mm, sizes["cylinder_radius_mm"]

    def _swept(
        self, sizes: Mapping[str, float], joint: Joint, origin: Array, hand: int
    ) -> SweptRoller:
        """The kinematics of the roller against the cam.

        Args:
            sizes: ``cylinder_radius_mm`` and ``roller_radius_mm`` [mm].
            joint, origin: what the follower moves on, and its roller's place at q = 0.
            hand: +1 where the cam turns about z as θ grows, −1 about −z.
        """
        inner, radius = self.wall_radii(sizes)[0], sizes["roller_radius_mm"]
        rolled = roller.roller_of(radius, inner, self.roller_width_mm, self.crown_radius_mm)
        return SweptRoller(0.0 * X, Z, joint, origin, X, rolled, hand)

    def _largest_offset(self, cylinder: float) -> float:
        """Largest distance of the roller's axis from the cam's at which it meets the cylinder."""
        floor = cylinder - self.roller_width_mm
        return math.sqrt(max(cylinder**2 - floor**2, 0.0))

    def _check_offset(self, arm: float, distance: float, angles: Sequence[float]) -> None:
        """Refuse a roller whose axis passes beside the cylinder.

        Args:
            arm, distance: roller to pivot, and pivot to the cam's axis [mm].
            angles: of the arm, least and largest [rad].

        Raises:
            PydanticCustomError: even the largest cylinder is missed somewhere.
        """
        largest = ends(self.cylinder_radius_mm)[1]
        if math.isinf(largest):
            return
        least, most = min(angles), max(angles)
        nearest = min(max(0.0, least), most)
        allowed = self._largest_offset(largest)
        offset = max((distance - arm * math.cos(at) for at in (least, nearest, most)), key=abs)
        if abs(offset) >= allowed:
            raise PydanticCustomError(
                "roller_beside_cylinder",
                "The roller's axis passes {offset} mm beside the cam's axis, but a roller {width} "
                "mm wide reaches into a cylinder of radius {radius} mm only within {allowed} mm. "
                "Change the distance of the arm's pivot or the turret from the cam's axis, or "
                "increase cylinder_radius_mm.",
                {
                    "offset": six_digits(abs(offset)),
                    "width": self.roller_width_mm,
                    "radius": largest,
                    "allowed": six_digits(allowed),
                },
            )


class CylindricalFollower(CylindricalMachine, ABC):
    """A follower that returns: one roller in a groove, or two rollers on both sides of a rib."""

    roller_distance_mm: Annotated[
        float | None,
        Field(
            gt=0.0,
            le=1e6,
            description="Distance between the axes of two rollers on both sides of a rib; left "
            "out: one roller in a groove.",
        ),
    ] = None

    @model_validator(mode="after")
    def _check_rib(self) -> Self:
        distance, smallest = self.roller_distance_mm, ends(self.roller_radius_mm)[0]
        if distance is not None and distance <= 2.0 * smallest:
            raise PydanticCustomError(
                "rollers_touch",
                "Rollers of radius {radius} mm whose axes are {distance} mm apart leave no rib "
                "between them. Make roller_distance_mm larger than twice roller_radius_mm.",
                {"radius": smallest, "distance": distance},
            )
        return self

    def mesh_range(self, sizes: Mapping[str, float]) -> tuple[float, float]:
        return -math.inf, math.inf

    def check_gain(self, gain: float) -> None:
        rest = gain / self.travel.per_unit
        if abs(rest) > CLOSURE:
            raise PydanticCustomError(
                "program_lift",
                "The follower ends the turn {rest} {unit} away from where it started. "
                "Make the lifts of rises and returns sum to zero.",
                {"rest": float(f"{rest:.9g}"), "unit": self.travel.unit},
            )

    def check_positions(self, lowest: float, highest: float) -> None:
        if lowest == highest:
            raise PydanticCustomError(
                "program_still",
                "The follower never moves: program has no rise and no return. Add both.",
                {},
            )

    def dwell_rib(self, sizes: Mapping[str, float]) -> float:
        distance = self.roller_distance_mm
        return math.inf if distance is None else distance - 2.0 * sizes["roller_radius_mm"]


def pivot(length: float, distance: float) -> tuple[Pivot, Array]:
    """A pivot across the cam's axis, ``distance`` away, and the roller's place at q = 0 [mm].

    At q = 0 the arm of this ``length`` is perpendicular to the cam's axis.
    """
    return Pivot(distance * Y, -X), (distance - length) * Y


def roller_seats(rest: float, spacing: float | None) -> tuple[Seat, ...]:
    """One roller in a groove, or two ``spacing`` apart with a rib between them [rad or mm]."""
    if spacing is None:
        return (Seat(1, rest),)
    return Seat(1, rest + 0.5 * spacing, (LEFT,)), Seat(2, rest - 0.5 * spacing, (RIGHT,))
