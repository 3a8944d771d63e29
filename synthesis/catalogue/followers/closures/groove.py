"""A roller between the two flanks of a groove."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar, Literal

from pydantic import Field
from pydantic_core import PydanticCustomError

from synthesis.catalogue.followers.closures.base import Closure, Rim
from synthesis.catalogue.followers.flank import Flank
from synthesis.catalogue.followers.kinematics import TracePoint


class Groove(Closure):
    """One roller in a groove: the inner flank pushes it outwards, the outer one inwards.

    The groove is as wide as the roller and the clearance together, its middle line is the pitch
    curve: each flank lies at D = Rr + clearance/2 from it. The base radius is the inner flank's.
    """

    kind: Literal["groove"] = "groove"
    title: ClassVar[str] = "Groove with an inner and an outer flank"
    clearance_mm: Annotated[
        float,
        Field(ge=0.0, le=1e6, description="By how much the groove is wider than the roller."),
    ] = 0.0

    rim_mm: Rim = 0.0

    def flanks(self, trace: TracePoint, roller_radius: float) -> tuple[Flank, ...]:
        distance = self._distance(roller_radius)
        slack = 0.5 * self.clearance_mm
        return (
            Flank("inner", 1, distance, "", trace, 0.0, slack),
            Flank("outer", -1, distance, "", trace, self.rim_mm, slack),
        )

    def check(self, roller_radius: float, largest: float, gap: float) -> None:
        if roller_radius <= 0.0:
            raise PydanticCustomError(
                "groove_needs_roller",
                "roller_radius_mm = {value} is a knife edge, which cannot run in a groove. "
                "Give the roller a radius, or choose the closure force.",
                {"value": roller_radius},
            )

    def dimensions(self, roller_radius: float) -> Mapping[str, float]:
        return {
            "groove_width_mm": 2.0 * self._distance(roller_radius),
            "clearance_mm": self.clearance_mm,
        }

    def _distance(self, roller_radius: float) -> float:
        return roller_radius + 0.5 * self.clearance_mm
