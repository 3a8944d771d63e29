"""Velocity of the follower: |s'| ω at the given cam speed."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from pydantic import Field

from synthesis.limits.derivative import DerivativeLimit


class Velocity(DerivativeLimit):
    """|v| ≤ the limit at every cam angle."""

    kind: Literal["velocity"] = "velocity"
    title: ClassVar[str] = "Velocity"
    order: ClassVar[int] = 1
    field: ClassVar[str] = "max_mm_per_s"
    unit: ClassVar[str] = "mm/s"
    max_mm_per_s: Annotated[float, Field(gt=0.0, le=1e30, description="Largest |velocity|.")]

    @property
    def largest(self) -> float:
        return self.max_mm_per_s
