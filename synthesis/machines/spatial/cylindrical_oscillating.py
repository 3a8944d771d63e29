"""Cylindrical cams whose follower swings on an arm."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, ClassVar, Literal

from pydantic import Field
from pydantic_core import PydanticCustomError

from synthesis.machines.spatial.cylindrical import CylindricalFollower, pivot, roller_seats
from synthesis.machines.spatial.machine import Seat, six_digits
from synthesis.machines.spatial.pressure_angle_constraints import ArmPressureAngle, SizeConstraint
from synthesis.numerics.geometry.swept_roller import SweptRoller
from synthesis.units import DEGREE, Travel

RIGHT_ANGLE = 0.5 * math.pi


class CylindricalOscillating(CylindricalFollower):
    """A swinging arm; its pivot's axis and its roller's axis are perpendicular to the cam's.

    Frame as in ``cylindrical``; the pivot is parallel to x, at y = pivot distance and z = 0. The
    arm's angle is 0 where the arm is perpendicular to the cam's axis.
    """

    kind: Literal["cylindrical_oscillating"] = "cylindrical_oscillating"
    title: ClassVar[str] = "cylindrical cam, follower on an arm"
    travel: ClassVar[Travel] = Travel("deg", DEGREE)

    arm_mm: Annotated[
        float,
        Field(
            gt=0.0,
            le=1e6,
            description="Length of the arm: from the pivot to the roller, or to the midpoint "
            "between two.",
        ),
    ]
    pivot_distance_mm: Annotated[
        float | None,
        Field(
            gt=0.0,
            le=1e6,
            description="Distance between the pivot's axis and the cam's; left out: the arm's "
            "length, so that the axis of a single roller meets the cam's axis where the arm is "
            "perpendicular to it.",
        ),
    ] = None
    initial_angle_deg: Annotated[
        float,
        Field(
            gt=-90.0,
            lt=90.0,
            description="Angle of the arm at the start of the program, measured from the "
            "perpendicular to the cam's axis and growing with the motion. Minus half the swing "
            "makes the swing symmetric.",
        ),
    ] = 0.0

    def swept_roller(self, sizes: Mapping[str, float], rotation: int) -> SweptRoller:
        return self._swept(sizes, *pivot(*self._lengths), rotation)

    @property
    def _lengths(self) -> tuple[float, float]:
        """Pivot to roller, and pivot to the cam's axis [mm]."""
        arm = math.hypot(self.arm_mm, 0.5 * (self.roller_distance_mm or 0.0))
        return arm, self.pivot_distance_mm or self.arm_mm

    def seats(self) -> tuple[Seat, ...]:
        rest, distance = self.initial_angle_deg * DEGREE, self.roller_distance_mm
        spacing = None if distance is None else 2.0 * math.atan2(0.5 * distance, self.arm_mm)
        return roller_seats(rest, spacing)

    def check_positions(self, lowest: float, highest: float) -> None:
        super().check_positions(lowest, highest)
        starts = [seat.start for seat in self.seats()]
        least, most = min(starts) + lowest, max(starts) + highest
        if least <= -RIGHT_ANGLE or most >= RIGHT_ANGLE:
            raise PydanticCustomError(
                "arm_along_cam",
                "A roller on the arm swings from {least}° to {most}° about the perpendicular to "
                "the cam's axis; at 90° the arm is parallel to the cam's axis and the cam cannot "
                "drive it. Change initial_angle_deg, or reduce the swing.",
                {"least": six_digits(least / DEGREE), "most": six_digits(most / DEGREE)},
            )
        self._check_offset(*self._lengths, (least, most))

    @property
    def can_be_sized(self) -> bool:
        # The pressure angle of a crowned roller whose axis passes beside the cam's has no closed
        # form in the motion and the cylinder's radius.
        return self.crown_radius_mm is None

    def length_scale(self, sizes: Mapping[str, float]) -> float:
        return self._lengths[0]

    def pressure_angle_curves(
        self, sizes: Mapping[str, float], slope: float, rotation: int
    ) -> tuple[SizeConstraint, ...]:
        starts, place = tuple(seat.start for seat in self.seats()), (self.roller_width_mm, slope)
        return (ArmPressureAngle("pressure_angle", starts, self._lengths[0], rotation, (place,)),)
