"""Smallest radii of the profile: where it is convex (at 0: no undercut), and of its hollows."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any, ClassVar, Literal

from pydantic import Field

from synthesis.catalogue.constraints import LinearInequality, NonconvexConstraint
from synthesis.catalogue.followers.curvature_bound import CurvatureBound
from synthesis.catalogue.followers.kinematics import (
    Flank,
    curvature_measure,
    labelled,
    profile_radius_measure,
)
from synthesis.catalogue.limits.base import Claim, Limit, Machine
from synthesis.catalogue.motion import PlacedSegment, Segments
from synthesis.numerics.piecewise import Array


class ProfileRadius(Limit):
    """Radius of the convex profile ≥ ``min_mm``: ρ_pitch ≥ Rr + min wherever ρ_pitch is positive.

    The follower says it in linear rows where it can (a flat face: ρ = Rb + s + s''). For a roller
    it is written as κ_pitch ≤ 1/(Rr + min), which is free of division by what may vanish; of a
    flank touched from inside with −κ_pitch, because there a hollow pitch curve is convex. Signed:
    a hollow flank (negative curvature) is the business of the limit ``cutter_radius``.
    """

    kind: Literal["profile_radius"] = "profile_radius"
    title: ClassVar[str] = "Smallest convex radius of the profile"
    same_on_every_segment: ClassVar[bool] = True
    min_mm: float = Field(
        0.0, ge=0.0, le=1e6, description="Smallest radius of the convex profile; 0: no undercut."
    )

    @property
    def bounds_size_below(self) -> bool:
        return self.min_mm > 0.0  # at 0 it says what every cam keeps

    @property
    def min_circle_radius(self) -> float:
        return self.min_mm

    def rows(self, segment: PlacedSegment, machine: Machine) -> tuple[LinearInequality, ...]:
        rows = machine.follower.profile_radius_rows(self.min_mm)
        return tuple(replace(row, source="profile_radius") for row in rows)

    def nonconvex(
        self, segment: PlacedSegment, machine: Machine
    ) -> tuple[NonconvexConstraint, ...]:
        curves = machine.follower.profile_radius_constraints(self.min_mm)
        return tuple(replace(curve, source="profile_radius") for curve in curves)

    def curvature_bounds(
        self, segment: PlacedSegment, machine: Machine
    ) -> tuple[CurvatureBound, ...]:
        return tuple(
            replace(rows, source=labelled("profile_radius", flank.name))
            for flank in machine.follower.flanks
            if flank.distance + self.min_mm > 0.0
            for rows in flank.trace.curvature_bounds(
                flank.side, 1.0 / (flank.distance + self.min_mm)
            )
        )

    def smooth_constraints(
        self, segment: PlacedSegment, machine: Machine, theta: Array, s: Any, z: Any
    ) -> tuple[Any, ...]:
        curved = super().smooth_constraints(segment, machine, theta, s, z)
        if curved or self.rows(segment, machine):
            return curved
        found = []
        for flank in machine.follower.flanks:
            smallest = flank.distance + self.min_mm
            if smallest > 0.0:
                numerator, speed_squared = flank.trace.curvature_terms(s, z)
                # σκ ≤ 1/ρ_min with κ = N/W³, divided by W² to keep the size of the numbers even
                found.append(flank.side * smallest * numerator / speed_squared**1.5 - 1.0)
        return tuple(found)

    def claims(self, segments: Segments, machine: Machine) -> tuple[Claim, ...]:
        convex = machine.follower.always_convex
        return tuple(
            self._claim(
                segments, (found.lower, found.upper), "min_mm", "mm", label=flank.name,
                quantity=found.quantity, to_wire=found.to_wire, path=flank.path,
            )
            for flank in machine.follower.flanks
            if (found := profile_radius_measure(flank, self.min_mm, convex)) is not None
        )  # fmt: skip


class CutterRadius(Limit):
    """Hollow flanks must let in a cutter of radius ``radius_mm``: |ρ_profile| ≥ Rg there.

    With ρ_profile = |ρ_pitch| + D on a hollow at the distance D this is σκ_pitch ≥ −1/(Rg − D),
    σ = 1 where the cam is touched from outside, −1 from inside; a cutter not larger than the
    roller fits everywhere.
    """

    kind: Literal["cutter_radius"] = "cutter_radius"
    title: ClassVar[str] = "Cutter or grinding wheel that must fit every hollow"
    same_on_every_segment: ClassVar[bool] = True
    radius_mm: float = Field(gt=0.0, le=1e9, description="Radius of the cutter.")

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
