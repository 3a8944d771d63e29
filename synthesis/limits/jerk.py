"""Jerk of the follower: |s'''| ω³ at the given cam speed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from synthesis.limits.base import Claim, Limit, Machine, times, where
from synthesis.motion import Stretch
from synthesis.terms import Row


class Jerk(Limit):
    """|j| ≤ the limit at every cam angle. A jump of the acceleration is an infinite jerk."""

    kind: Literal["jerk"] = "jerk"
    title: ClassVar[str] = "Jerk"
    max_mm_per_s3: Annotated[float, Field(gt=0.0, le=1e30, description="Largest |jerk|.")]

    def rows(self, stretch: Stretch, machine: Machine) -> tuple[Row, ...]:
        largest = self.max_mm_per_s3 / machine.omega**3
        return (
            Row((0.0, 0.0, 0.0, 1.0), (), largest, source="jerk"),
            Row((0.0, 0.0, 0.0, -1.0), (), largest, source="jerk"),
        )

    def claims(self, stretches: Sequence[Stretch], machine: Machine) -> tuple[Claim, ...]:
        to_wire = machine.omega**3
        largest = self.max_mm_per_s3 / to_wire
        everywhere = where(stretches)
        return (
            Claim(
                "jerk",
                "jerk",
                everywhere,
                -largest,
                largest,
                "mm/s³",
                times(to_wire),
                "jerk/max_mm_per_s3",
            ),
        )
