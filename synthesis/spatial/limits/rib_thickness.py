"""Thickness of the rib between two neighbouring rollers."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from pydantic import Field

from synthesis.spatial.limits.base import SpatialLimit


class RibThickness(SpatialLimit):
    """Rib ≥ the limit, from contact to contact of the rollers astride it.

    It speaks of the rollers alone: their radius and where on the turret they are.
    """

    kind: Literal["rib_thickness"] = "rib_thickness"
    title: ClassVar[str] = "Rib thickness"
    quantity: ClassVar[str] = "rib_thickness"
    field: ClassVar[str] = "min_mm"
    upper: ClassVar[bool] = False

    min_mm: Annotated[float, Field(ge=0.0, le=1e6, description="Thinnest rib allowed.")]

    @property
    def bound(self) -> float:
        return self.min_mm
