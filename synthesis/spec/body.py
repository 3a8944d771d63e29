"""The cam as a body: what its mass follows from."""

from __future__ import annotations

from pydantic import Field

from synthesis.catalogue.fields import FiniteModel


class CamBody(FiniteModel):
    """The cam as a plate: for its mass and moment of inertia, nothing else."""

    thickness_mm: float = Field(gt=0.0, le=1e5, description="Thickness of the plate.")
    density_kg_per_m3: float = Field(
        7850.0, gt=0.0, le=1e5, description="Density of the material; steel where left out."
    )
    bore_mm: float | None = Field(
        None, gt=0.0, le=1e6, description="Diameter of the bore around the axis; left out: none."
    )
