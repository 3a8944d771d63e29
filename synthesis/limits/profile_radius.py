"""Smallest radius of curvature where the profile is convex; at 0 it says: no undercut."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from synthesis.followers.flank import labelled
from synthesis.limits.base import Claim, Limit, Machine, where
from synthesis.motion import Stretch
from synthesis.numerics.piecewise import Array
from synthesis.terms import Curved, Implied, Row, Traced


class ProfileRadius(Limit):
    """Radius of the convex profile ≥ ``min_mm``: ρ_pitch ≥ Rr + min wherever ρ_pitch is positive.

    The follower says it in linear rows where it can (a flat face: ρ = Rb + s + s''). For a roller
    it is written as κ_pitch ≤ 1/(Rr + min), which is free of division by what may vanish; of a
    flank touched from inside with −κ_pitch, because there a hollow pitch curve is convex. Signed:
    a hollow flank (negative curvature) is the business of the limit ``cutter_radius``.
    """

    kind: Literal["profile_radius"] = "profile_radius"
    title: ClassVar[str] = "Smallest convex radius of the profile"
    same_everywhere: ClassVar[bool] = True
    min_mm: Annotated[
        float,
        Field(ge=0.0, le=1e6, description="Smallest radius of the convex profile; 0: no undercut."),
    ] = 0.0

    @property
    def keeps_large(self) -> bool:
        return self.min_mm > 0.0  # at 0 it says what every cam keeps

    @property
    def least_circle(self) -> float:
        return self.min_mm

    def rows(self, stretch: Stretch, machine: Machine) -> tuple[Row, ...]:
        rows = machine.follower.profile_radius_rows(self.min_mm)
        return tuple(replace(row, source="profile_radius") for row in rows)

    def curved(self, stretch: Stretch, machine: Machine) -> tuple[Curved, ...]:
        curves = machine.follower.profile_radius_curves(self.min_mm)
        return tuple(replace(curve, source="profile_radius") for curve in curves)

    def implied(self, stretch: Stretch, machine: Machine) -> tuple[Implied, ...]:
        return tuple(curve for curve in self.curved(stretch, machine) if curve.implies)

    def traced(self, stretch: Stretch, machine: Machine) -> tuple[Traced, ...]:
        return tuple(
            replace(rows, source=labelled("profile_radius", flank.name))
            for flank in machine.follower.flanks
            if flank.distance + self.min_mm > 0.0
            for rows in flank.trace.curvature_implied(
                flank.side, 1.0 / (flank.distance + self.min_mm)
            )
        )

    def smooth(
        self, stretch: Stretch, machine: Machine, theta: Array, s: Any, z: Any
    ) -> tuple[Any, ...]:
        curves = self.curved(stretch, machine)
        if curves:
            return tuple(value for curve in curves for value in curve.excess(s, z))
        if self.rows(stretch, machine):
            return ()
        found = []
        for flank in machine.follower.flanks:
            smallest = flank.distance + self.min_mm
            if smallest > 0.0:
                numerator, speed_squared = flank.trace.curvature_terms(s, z)
                # σκ ≤ 1/ρ_min with κ = N/W³, divided by W² to keep the size of the numbers even
                found.append(flank.side * smallest * numerator / speed_squared**1.5 - 1.0)
        return tuple(found)

    def claims(self, stretches: Sequence[Stretch], machine: Machine) -> tuple[Claim, ...]:
        measures = (
            (flank, machine.follower.profile_radius_measure(flank, self.min_mm))
            for flank in machine.follower.flanks
        )
        return tuple(
            Claim(
                labelled("profile_radius", flank.name),
                found.quantity,
                where(stretches),
                found.lower,
                found.upper,
                "mm",
                found.to_wire,
                "profile_radius/min_mm",
                flank.path,
            )
            for flank, found in measures
            if found is not None
        )
