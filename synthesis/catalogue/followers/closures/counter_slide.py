"""The counter roller of conjugate cams on a slide: a point that the main roller's motion moves.

Symbols: e, s0 offset and height of the main roller; e2 offset of the counter roller, L its
distance below the main one. Its centre is (e2, s0 + s − L), beyond the axis. Seen upside down (the
machine turned by half a turn) it is a translating roller with

    Y = L − s0 − s,   Y' = −s',   Y'' = −s'',   offset −e2,   v = Y' + e2 = e2 − s'

so tan α = v / Y and κ = [Y² + v (2Y' + e2) − Y Y''] / (Y² + v²)^{3/2}.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from synthesis.catalogue.constraints import (
    AffineNorm,
    LinearInequality,
    PressureTerm,
    SlideCoordinates,
)
from synthesis.catalogue.followers.curvature_bound import CurvatureBound
from synthesis.catalogue.followers.kinematics import TracePoint, Vector2


@dataclass(frozen=True)
class CounterSlide(TracePoint):
    """The counter roller; the size z is the main follower's (e, s0).

    Attributes:
        offset: e2 [mm]. distance: L [mm].
    """

    offset: float
    distance: float

    def position(self, s: Any, z: Any) -> tuple[Vector2, ...]:
        zero = 0.0 * s[0]
        height = s[0] + (z[1] - self.distance)
        return ((zero + self.offset, height), (zero, s[1]), (zero, s[2]), (zero, s[3]))

    def drive_direction(self, s: Any, z: Any) -> tuple[Vector2, Vector2]:
        # the counter cam pushes its roller away from the axis: downwards
        zero = 0.0 * s[0]
        return (zero, zero - 1.0), (zero, zero)

    def lever(self, s: Any, z: Any) -> Any:
        return -1.0  # as s grows it follows the other way

    def curvature_terms(self, s: Any, z: Any) -> tuple[Any, Any]:
        y, v = self.distance - z[1] - s[0], self.offset - s[1]
        return y * y + v * (self.offset - 2.0 * s[1]) + y * s[2], y * y + v * v

    def curvature_bounds(
        self, side: int, most: float, thrust: PressureTerm | None = None
    ) -> tuple[CurvatureBound, ...]:
        constants = (self.distance, self.offset, -self.offset)
        seen = SlideCoordinates(-1, constants, ((0.0, -1.0), (0.0, 0.0), (0.0, 0.0)))
        return (CurvatureBound("", seen, side, most, thrust),)

    def pressure_angle_rows(self, slope: float) -> tuple[LinearInequality, ...]:
        # −slope (L − s0 − s) ≤ s' − e2 ≤ slope (L − s0 − s)
        reach = slope * self.distance
        return (
            LinearInequality(
                (slope, 1.0, 0.0, 0.0), (0.0, slope), reach + self.offset, source="pressure_angle"
            ),
            LinearInequality(
                (slope, -1.0, 0.0, 0.0), (0.0, slope), reach - self.offset, source="pressure_angle"
            ),
        )

    def radius_rows(self, least: float) -> tuple[LinearInequality, ...]:
        # L − s0 − s ≥ √(least² − e2²), beyond the axis
        height = math.sqrt(max(least**2 - self.offset**2, 0.0))
        return (LinearInequality((1.0, 0.0, 0.0, 0.0), (0.0, 1.0), self.distance - height),)

    def outer_radius_norm(self, s_max: float) -> AffineNorm:
        # highest above its own axis where the main roller is lowest
        return AffineNorm(((0.0, 0.0), (0.0, -1.0)), (self.offset, self.distance))

    def nearest_displacement(self, s_max: float) -> float:
        return s_max
