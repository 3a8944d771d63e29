"""Cylindrical cams whose follower swings on an arm."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, ClassVar, Literal

from pydantic import Field
from pydantic_core import PydanticCustomError

from synthesis.geometry.swept_roller import SweptRoller
from synthesis.spatial import drum
from synthesis.spatial.cylindrical_follower import CylindricalFollower
from synthesis.spatial.leverage import Leverage
from synthesis.spatial.machine import Seat
from synthesis.spatial.swinging import SwingPressure
from synthesis.units import DEGREE, Travel

SQUARE = 0.5 * math.pi


class CylindricalOscillating(CylindricalFollower):
    """An arm whose pivot crosses the cam's axis at a right angle, some way off, as its roller does.

    Frame as in ``drum``; the pivot is at y = pivot distance, z = 0, and parallel to x. Where the
    arm stands square to the cam's axis, its angle is 0.
    """

    kind: Literal["cylindrical_oscillating"] = "cylindrical_oscillating"
    title: ClassVar[str] = "cylindrical cam, follower on an arm"
    travel: ClassVar[Travel] = Travel("deg", DEGREE)

    arm_mm: Annotated[
        float,
        Field(
            gt=0.0,
            le=1e6,
            description="Length of the arm: pivot to roller, or to the middle between two.",
        ),
    ]
    pivot_distance_mm: Annotated[
        float | None,
        Field(
            gt=0.0,
            le=1e6,
            description="Distance between the pivot's axis and the cam's; left out: the arm's "
            "length, so that the axis of a single roller meets the cam's where the arm is square "
            "to it.",
        ),
    ] = None
    initial_angle_deg: Annotated[
        float,
        Field(
            gt=-90.0,
            lt=90.0,
            description="Where the program starts: the arm's angle to the line square to the "
            "cam's axis, growing with the motion. Minus half the swing is symmetric.",
        ),
    ] = 0.0

    def swept(self, sizes: Mapping[str, float], turns: int) -> SweptRoller:
        joint, origin = drum.arm(*self._lengths)
        width, crown = self.roller_width_mm, self.crown_radius_mm
        return drum.swept(sizes, joint, origin, width, crown, turns)

    @property
    def _lengths(self) -> tuple[float, float]:
        """Pivot to roller, and to the cam's axis [mm]."""
        reach = math.hypot(self.arm_mm, 0.5 * (self.roller_distance_mm or 0.0))
        return reach, self.pivot_distance_mm or self.arm_mm

    def seats(self) -> tuple[Seat, ...]:
        rest, distance = self.initial_angle_deg * DEGREE, self.roller_distance_mm
        apart = None if distance is None else 2.0 * math.atan2(0.5 * distance, self.arm_mm)
        return drum.seats(rest, apart)

    def check_reach(self, lowest: float, highest: float) -> None:
        drum.check_moves(lowest, highest)
        starts = [seat.start for seat in self.seats()]
        least, most = min(starts) + lowest, max(starts) + highest
        if least <= -SQUARE or most >= SQUARE:
            raise PydanticCustomError(
                "arm_along_cam",
                "A roller on the arm swings from {least}° to {most}° about the line square to the "
                "cam's axis; at 90° it runs along the cam and drives nothing. Change "
                "initial_angle_deg, or make the swing smaller.",
                {"least": drum.figure(least / DEGREE), "most": drum.figure(most / DEGREE)},
            )
        drum.check_beside(
            *self._lengths, (least, most), self.cylinder_radius_mm, self.roller_width_mm
        )

    @property
    def sizable(self) -> bool:
        # where a roller's axis passes beside the cam's, a crown's contacts lean otherwise
        return self.crown_radius_mm is None

    def reach(self, sizes: Mapping[str, float]) -> float:
        return self._lengths[0]

    def pressure_angle_curves(
        self, sizes: Mapping[str, float], slope: float, turns: int
    ) -> tuple[Leverage, ...]:
        starts, place = tuple(seat.start for seat in self.seats()), (self.roller_width_mm, slope)
        return (SwingPressure("pressure_angle", starts, self._lengths[0], turns, (place,)),)
