"""Largest cutter or grinding wheel that must reach every hollow of the profile."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from synthesis.followers.flank import Flank, labelled
from synthesis.limits.base import Claim, Limit, Machine, where
from synthesis.motion import Stretch
from synthesis.numerics.piecewise import Array
from synthesis.terms import Traced


class CutterRadius(Limit):
    """Hollow flanks must let in a cutter of radius ``radius_mm``: |ρ_profile| ≥ Rg there.

    With ρ_profile = |ρ_pitch| + D on a hollow at the distance D this is σκ_pitch ≥ −1/(Rg − D),
    σ = 1 where the cam is touched from outside, −1 from inside; a cutter not larger than the
    roller fits everywhere.
    """

    kind: Literal["cutter_radius"] = "cutter_radius"
    title: ClassVar[str] = "Cutter or grinding wheel that must fit every hollow"
    same_everywhere: ClassVar[bool] = True
    radius_mm: Annotated[float, Field(gt=0.0, le=1e9, description="Radius of the cutter.")]

    @property
    def keeps_large(self) -> bool:
        return True

    def _hollows(self, machine: Machine) -> Iterator[tuple[Flank, float]]:
        """Flanks that the cutter may not fit, and their smallest hollow pitch radius [mm]."""
        for flank in () if machine.follower.always_convex else machine.follower.flanks:
            if self.radius_mm > flank.distance:
                yield flank, self.radius_mm - flank.distance

    def traced(self, stretch: Stretch, machine: Machine) -> tuple[Traced, ...]:
        return tuple(
            replace(rows, source=labelled("cutter_radius", flank.name))
            for flank, radius in self._hollows(machine)
            for rows in flank.trace.curvature_implied(-flank.side, 1.0 / radius)
        )

    def smooth(
        self, stretch: Stretch, machine: Machine, theta: Array, s: Any, z: Any
    ) -> tuple[Any, ...]:
        found = []
        for flank, radius in self._hollows(machine):
            numerator, speed_squared = flank.trace.curvature_terms(s, z)
            speed = speed_squared**0.5
            # σκ ≥ −1/R times W/(W + R): even numbers for a cutter of any size, the same zero
            bend = flank.side * radius * numerator
            found.append(-(bend / speed_squared + speed) / (speed + radius))
        return tuple(found)

    def claims(self, stretches: Sequence[Stretch], machine: Machine) -> tuple[Claim, ...]:
        return tuple(
            _claim(flank, radius, where(stretches)) for flank, radius in self._hollows(machine)
        )


def _claim(flank: Flank, radius: float, everywhere: tuple[int, ...]) -> Claim:
    """The flank's sharpest hollow lets the cutter in."""
    side, distance, sharpest = flank.side, flank.distance, -flank.side / radius

    def to_wire(curvature: float) -> float | None:
        bend = side * curvature
        return distance - 1.0 / bend if bend < 0.0 else None

    low, high = (sharpest, None) if side > 0 else (None, sharpest)
    return Claim(
        labelled("cutter_radius", flank.name), "pitch_curvature", everywhere, low, high, "mm",
        to_wire, "cutter_radius/radius_mm", flank.path,
    )  # fmt: skip
