"""Acceleration of the follower: |s''| ω² at the given cam speed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from synthesis.limits.base import Claim, Limit, Machine, times, where
from synthesis.motion import Stretch
from synthesis.terms import Row


class Acceleration(Limit):
    """|a| ≤ the limit at every cam angle, on both sides of a jump."""

    kind: Literal["acceleration"] = "acceleration"
    title: ClassVar[str] = "Acceleration"
    max_mm_per_s2: Annotated[float, Field(gt=0.0, le=1e30, description="Largest |acceleration|.")]

    def rows(self, stretch: Stretch, machine: Machine) -> tuple[Row, ...]:
        largest = self.max_mm_per_s2 / machine.omega**2
        return (
            Row((0.0, 0.0, 1.0, 0.0), (), largest, source="acceleration"),
            Row((0.0, 0.0, -1.0, 0.0), (), largest, source="acceleration"),
        )

    def claims(self, stretches: Sequence[Stretch], machine: Machine) -> tuple[Claim, ...]:
        to_wire = machine.omega**2
        largest = self.max_mm_per_s2 / to_wire
        everywhere = where(stretches)
        return (
            Claim(
                "acceleration",
                "acceleration",
                everywhere,
                -largest,
                largest,
                "mm/s²",
                times(to_wire),
                "acceleration/max_mm_per_s2",
            ),
        )
