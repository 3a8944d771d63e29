"""Jerk of the follower: |s'''| ω³ at the given cam speed."""

from __future__ import annotations

from typing import ClassVar, Literal

from pydantic import Field

from synthesis.catalogue.limits.derivative import DerivativeLimit
from synthesis.catalogue.limits.travel import Largest


class Jerk(DerivativeLimit):
    """|j| ≤ the limit at every cam angle. A jump of the acceleration is an infinite jerk."""

    kind: Literal["jerk"] = "jerk"
    title: ClassVar[str] = "Jerk"
    order: ClassVar[int] = 3
    fields: ClassVar[dict[str, str]] = {"mm": "max_mm_per_s3", "deg": "max_deg_per_s3"}
    max_mm_per_s3: Largest = Field(None, description="Largest |jerk| of a slide.")
    max_deg_per_s3: Largest = Field(None, description="Largest |jerk| of an arm.")
