"""Velocity of the follower: |s'| ω at the given cam speed."""

from __future__ import annotations

from typing import ClassVar, Literal

from pydantic import Field

from synthesis.catalogue.limits.derivative import DerivativeLimit
from synthesis.catalogue.limits.travel import Largest


class Velocity(DerivativeLimit):
    """|v| ≤ the limit at every cam angle."""

    kind: Literal["velocity"] = "velocity"
    title: ClassVar[str] = "Velocity"
    order: ClassVar[int] = 1
    fields: ClassVar[dict[str, str]] = {"mm": "max_mm_per_s", "deg": "max_deg_per_s"}
    max_mm_per_s: Largest = Field(None, description="Largest |velocity| of a slide.")
    max_deg_per_s: Largest = Field(None, description="Largest |velocity| of an arm.")
