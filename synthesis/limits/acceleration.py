"""Acceleration of the follower: |s''| ω² at the given cam speed."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from pydantic import Field

from synthesis.limits.derivative import DerivativeLimit


class Acceleration(DerivativeLimit):
    """|a| ≤ the limit at every cam angle, on both sides of a jump."""

    kind: Literal["acceleration"] = "acceleration"
    title: ClassVar[str] = "Acceleration"
    order: ClassVar[int] = 2
    field: ClassVar[str] = "max_mm_per_s2"
    unit: ClassVar[str] = "mm/s²"
    max_mm_per_s2: Annotated[float, Field(gt=0.0, le=1e30, description="Largest |acceleration|.")]

    @property
    def largest(self) -> float:
        return self.max_mm_per_s2
