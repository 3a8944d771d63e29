"""Acceleration of the follower: |s''| ω² at the given cam speed."""

from __future__ import annotations

from typing import ClassVar, Literal

from pydantic import Field

from synthesis.catalogue.limits.derivative import DerivativeLimit
from synthesis.catalogue.limits.travel import Largest


class Acceleration(DerivativeLimit):
    """|a| ≤ the limit at every cam angle, on both sides of a jump."""

    kind: Literal["acceleration"] = "acceleration"
    title: ClassVar[str] = "Acceleration"
    order: ClassVar[int] = 2
    fields: ClassVar[dict[str, str]] = {"mm": "max_mm_per_s2", "deg": "max_deg_per_s2"}
    max_mm_per_s2: Largest = Field(None, description="Largest |acceleration| of a slide.")
    max_deg_per_s2: Largest = Field(None, description="Largest |acceleration| of an arm.")
