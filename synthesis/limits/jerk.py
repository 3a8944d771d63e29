"""Jerk of the follower: |s'''| ω³ at the given cam speed."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from pydantic import Field

from synthesis.limits.derivative import DerivativeLimit


class Jerk(DerivativeLimit):
    """|j| ≤ the limit at every cam angle. A jump of the acceleration is an infinite jerk."""

    kind: Literal["jerk"] = "jerk"
    title: ClassVar[str] = "Jerk"
    order: ClassVar[int] = 3
    field: ClassVar[str] = "max_mm_per_s3"
    unit: ClassVar[str] = "mm/s³"
    max_mm_per_s3: Annotated[float, Field(gt=0.0, le=1e30, description="Largest |jerk|.")]

    @property
    def largest(self) -> float:
        return self.max_mm_per_s3
