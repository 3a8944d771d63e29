"""Velocity of the follower: |s'| ω at the given cam speed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from synthesis.limits.base import Claim, Limit, Machine, times, where
from synthesis.motion import Stretch
from synthesis.terms import Row


class Velocity(Limit):
    """|v| ≤ the limit at every cam angle."""

    kind: Literal["velocity"] = "velocity"
    title: ClassVar[str] = "Velocity"
    max_mm_per_s: Annotated[float, Field(gt=0.0, le=1e30, description="Largest |velocity|.")]

    def rows(self, stretch: Stretch, machine: Machine) -> tuple[Row, ...]:
        largest = self.max_mm_per_s / machine.omega
        return (
            Row((0.0, 1.0, 0.0, 0.0), (), largest, source="velocity"),
            Row((0.0, -1.0, 0.0, 0.0), (), largest, source="velocity"),
        )

    def claims(self, stretches: Sequence[Stretch], machine: Machine) -> tuple[Claim, ...]:
        to_wire = machine.omega
        largest = self.max_mm_per_s / to_wire
        everywhere = where(stretches)
        return (
            Claim(
                "velocity",
                "velocity",
                everywhere,
                -largest,
                largest,
                "mm/s",
                times(to_wire),
                "velocity/max_mm_per_s",
            ),
        )
