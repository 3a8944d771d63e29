"""Coulomb friction of a roller follower's slide in its guide.

The contact pushes the slide sideways with N sin α at the roller, an overhang A before the guide of
length B. The guide answers at its two ends with N sin α (A + B)/B and N sin α A/B; friction is μ
times their sum (Rothbart; Norton ch. 12), along the slide and against its motion. As the follower
is lifted the roller comes nearer to the guide: A = A0 − s.
"""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field


class GuideFriction(BaseModel):
    """Friction in the guide of a roller on a slide; at rest none is counted."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    coefficient: Annotated[float, Field(ge=0.0, le=2.0, description="Coulomb's μ.")]
    overhang_mm: Annotated[
        float,
        Field(
            ge=0.0,
            le=1e6,
            description="From the roller's centre to the guide at the lowest position.",
        ),
    ] = 0.0
    bearing_length_mm: Annotated[
        float | None,
        Field(gt=0.0, le=1e6, description="Length of the guide; left out, long beside that."),
    ] = None

    def effective(self, s: Any) -> Any:
        """Friction along the slide over |side force| at a displacement [mm]: μ (2A + B)/B."""
        if self.bearing_length_mm is None:
            return self.coefficient
        overhang = self.overhang_mm - s
        return (overhang * 2.0 + self.bearing_length_mm) * (
            self.coefficient / self.bearing_length_mm
        )
