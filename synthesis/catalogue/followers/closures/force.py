"""A spring, a weight or the load holds the roller on the cam."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from pydantic import Field
from pydantic_core import PydanticCustomError

from synthesis.catalogue.followers.closures.base import Closure, Rim
from synthesis.catalogue.followers.flank import Flank
from synthesis.catalogue.followers.kinematics import TracePoint


class Force(Closure):
    """A force holds the roller on the cam, from outside, or from inside on a ring.

    On a ring the follower moves away from the cam's axis under the force, and the cam pushes it
    back; the base radius is the smallest radius of the ring's hollow, Rp + Rr.
    """

    kind: Literal["force"] = "force"
    title: ClassVar[str] = "Force-closed, touched from outside or inside"
    contact: Annotated[
        Literal["outside", "inside"],
        Field(description="inside: the roller runs in a ring whose hollow is the cam."),
    ] = "outside"

    rim_mm: Rim = 0.0

    def check(self, roller_radius: float, largest: float, gap: float) -> None:
        if self.rim_mm > 0.0 and self.contact == "outside":
            raise PydanticCustomError(
                "rim_without_ring",
                "rim_mm = {value} is the wall of a ring, but contact is outside. "
                "Leave rim_mm out, or choose contact inside.",
                {"value": self.rim_mm},
            )
        if largest + gap <= 0.0:
            raise PydanticCustomError(
                "roller_fills_ring",
                "base_radius_mm = {value} is not above the roller radius {roller} mm: touched from "
                "inside, the roller would fill the ring. Take a larger base radius or a smaller "
                "roller.",
                {"value": largest, "roller": roller_radius},
            )

    def flanks(self, trace: TracePoint, roller_radius: float) -> tuple[Flank, ...]:
        side: Literal[1, -1] = 1 if self.contact == "outside" else -1
        return (Flank("", side, roller_radius, "", trace, self.rim_mm),)
