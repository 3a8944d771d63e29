"""Cylindrical cams whose follower slides along the cam's axis."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar, Literal

from synthesis.catalogue.constraints import LinearInequality
from synthesis.machines.spatial import roller
from synthesis.machines.spatial.cylindrical import CylindricalFollower, Z, roller_seats
from synthesis.machines.spatial.machine import Seat
from synthesis.numerics.geometry.swept_roller import Guide, SweptRoller
from synthesis.units import Travel


class CylindricalTranslating(CylindricalFollower):
    """A slide along the cam's axis; the roller's axis crosses the cam's at a right angle.

    Frame as in ``cylindrical``; s is z of the roller, or of the midpoint between two rollers.
    """

    kind: Literal["cylindrical_translating"] = "cylindrical_translating"
    title: ClassVar[str] = "cylindrical cam, follower on a slide"
    travel: ClassVar[Travel] = Travel()

    def swept_roller(self, sizes: Mapping[str, float], rotation: int) -> SweptRoller:
        return self._swept(sizes, Guide(Z), 0.0 * Z, rotation)

    def seats(self) -> tuple[Seat, ...]:
        return roller_seats(0.0, self.roller_distance_mm)

    def pressure_angle_rows(
        self, sizes: Mapping[str, float], slope: float
    ) -> tuple[LinearInequality, ...]:
        """|s'| ≤ t (R − depth) at each critical depth, with t the remaining tan α there."""
        width, radius = self.roller_width_mm, sizes["roller_radius_mm"]
        rolled = roller.roller_of(radius, 0.0, width, self.crown_radius_mm)
        return tuple(
            LinearInequality((0.0, sign, 0.0, 0.0), (-remaining,), -remaining * (width - foot))
            for foot, remaining in roller.critical_places(rolled, slope)
            for sign in (1.0, -1.0)
        )
