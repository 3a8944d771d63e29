"""Largest cutter or grinding wheel that must reach every hollow of the profile."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from synthesis.catalogue.followers.curvature_bound import CurvatureBound
from synthesis.catalogue.followers.flank import Flank, curvature_measure, labelled
from synthesis.catalogue.limits.base import Claim, Limit, Machine
from synthesis.catalogue.motion import PlacedSegment, Segments
from synthesis.numerics.piecewise import Array


class CutterRadius(Limit):
    """Hollow flanks must let in a cutter of radius ``radius_mm``: |ρ_profile| ≥ Rg there.

    With ρ_profile = |ρ_pitch| + D on a hollow at the distance D this is σκ_pitch ≥ −1/(Rg − D),
    σ = 1 where the cam is touched from outside, −1 from inside; a cutter not larger than the
    roller fits everywhere.
    """

    kind: Literal["cutter_radius"] = "cutter_radius"
    title: ClassVar[str] = "Cutter or grinding wheel that must fit every hollow"
    same_on_every_segment: ClassVar[bool] = True
    radius_mm: Annotated[float, Field(gt=0.0, le=1e9, description="Radius of the cutter.")]

    @property
    def bounds_size_below(self) -> bool:
        return True

    def _hollows(self, machine: Machine) -> Iterator[tuple[Flank, float]]:
        """Flanks that the cutter may not fit, and their smallest hollow pitch radius [mm]."""
        for flank in () if machine.follower.always_convex else machine.follower.flanks:
            if self.radius_mm > flank.distance:
                yield flank, self.radius_mm - flank.distance

    def curvature_bounds(
        self, segment: PlacedSegment, machine: Machine
    ) -> tuple[CurvatureBound, ...]:
        return tuple(
            replace(rows, source=labelled("cutter_radius", flank.name))
            for flank, radius in self._hollows(machine)
            for rows in flank.trace.curvature_bounds(-flank.side, 1.0 / radius)
        )

    def smooth_constraints(
        self, segment: PlacedSegment, machine: Machine, theta: Array, s: Any, z: Any
    ) -> tuple[Any, ...]:
        found = []
        for flank, radius in self._hollows(machine):
            numerator, speed_squared = flank.trace.curvature_terms(s, z)
            speed = speed_squared**0.5
            # σκ ≥ −1/R times W/(W + R): even numbers for a cutter of any size, the same zero
            bend = flank.side * radius * numerator
            found.append(-(bend / speed_squared + speed) / (speed + radius))
        return tuple(found)

    def claims(self, segments: Segments, machine: Machine) -> tuple[Claim, ...]:
        return tuple(
            self._claim(
                segments, (found.lower, found.upper), "radius_mm", "mm", label=flank.name,
                quantity=found.quantity, to_wire=found.to_wire, path=flank.path,
            )
            for flank, _ in self._hollows(machine)
            for found in [curvature_measure(flank, self.radius_mm, -1)]
        )  # fmt: skip
