"""Coulomb friction of a follower in its guide. A new model is a class here and its name below.

A roller's contact pushes the slide sideways with N sin α at the roller, an overhang A before the
guide of length B. The guide answers at its two ends with N sin α (A + B)/B and N sin α A/B;
friction is μ times their sum (Rothbart; Norton ch. 12), along the slide and against its motion. As
the follower is lifted the roller comes nearer to the guide: A = A0 − s.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

from pydantic import Field
from pydantic_core import PydanticCustomError

from synthesis.catalogue.fields import FiniteModel


class FrictionModel(FiniteModel, ABC):
    """Friction along the guide as a share of the side force N |sin α|; at rest there is none.

    The share depends on the displacement alone, is not negative, and does not increase with it:
    rows and relaxations take its values at the ends of a range of displacements as its extremes,
    and that at 0 as the largest. Optimiser and certificate evaluate it by the same method: on
    floats, NumPy arrays, enclosures and CasADi columns, so that it is written in arithmetic alone.

    Every length is a field whose name ends in ``_mm``, as elsewhere in a spec: by these endings the
    optimiser's copy of the model gets its lengths in units of its own (``NondimensionalSpec``).
    """

    @abstractmethod
    def share_of_side_force(self, s: Any) -> Any:
        """Friction along the guide over the side force.

        ``s``: displacement, in the unit of the model's lengths: mm in the certificate, the longest
        travel in the optimiser.
        """

    def check(self, stroke: float) -> None:
        """Refuse a model that does not hold up to a displacement ``stroke`` [mm]."""
        return None


class GuideFriction(FrictionModel):
    """Friction in the guide of a roller on a slide; at rest none is counted."""

    coefficient: float = Field(ge=0.0, le=2.0, description="Coulomb's μ.")
    overhang_mm: float = Field(
        0.0,
        ge=0.0,
        le=1e6,
        description="From the roller's centre to the guide at the lowest position.",
    )
    bearing_length_mm: float | None = Field(
        None, gt=0.0, le=1e6, description="Length of the guide; left out, long beside that."
    )

    def share_of_side_force(self, s: Any) -> Any:
        """μ (2A + B)/B with A = A0 − s; μ alone where the guide is long."""
        if self.bearing_length_mm is None:
            return self.coefficient
        overhang = self.overhang_mm - s
        return (overhang * 2.0 + self.bearing_length_mm) * (
            self.coefficient / self.bearing_length_mm
        )

    def check(self, stroke: float) -> None:
        if self.bearing_length_mm is not None and self.overhang_mm < stroke:
            raise PydanticCustomError(
                "overhang_too_short",
                "overhang_mm = {overhang} is less than the stroke of {stroke} mm: the roller would "
                "be drawn into its guide. Give the overhang at the lowest position.",
                {"overhang": self.overhang_mm, "stroke": stroke},
            )


AnyFriction = GuideFriction
"""Every model, as a union of its classes."""
