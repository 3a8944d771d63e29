"""Cylindrical cams whose follower slides along the cam's axis."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar, Literal

from synthesis.geometry.swept_roller import Guide, SweptRoller
from synthesis.spatial import drum, roller
from synthesis.spatial.cylindrical_follower import CylindricalFollower
from synthesis.spatial.machine import Seat
from synthesis.terms import Row
from synthesis.units import Travel


class CylindricalTranslating(CylindricalFollower):
    """A slide along the cam's axis; its roller's axis crosses the cam's at a right angle.

    Frame as in ``drum``; s is z of the roller, or of the middle between two astride a rib.
    """

    kind: Literal["cylindrical_translating"] = "cylindrical_translating"
    title: ClassVar[str] = "cylindrical cam, follower on a slide"
    travel: ClassVar[Travel] = Travel()

    def swept(self, sizes: Mapping[str, float], turns: int) -> SweptRoller:
        width, crown = self.roller_width_mm, self.crown_radius_mm
        return drum.swept(sizes, Guide(drum.Z), 0.0 * drum.Z, width, crown, turns)

    def seats(self) -> tuple[Seat, ...]:
        return drum.seats(0.0, self.roller_distance_mm)

    def check_reach(self, lowest: float, highest: float) -> None:
        drum.check_moves(lowest, highest)

    def pressure_angle_rows(self, sizes: Mapping[str, float], slope: float) -> tuple[Row, ...]:
        """|s'| ≤ t (R − depth) for every place so deep in the cylinder, t what is left of tan α."""
        width = self.roller_width_mm
        kept = roller.of(sizes["roller_radius_mm"], 0.0, width, self.crown_radius_mm)
        return tuple(
            Row((0.0, sign, 0.0, 0.0), (-left,), -left * (width - foot))
            for foot, left in roller.steepest(kept, slope)
            for sign in (1.0, -1.0)
        )
