"""What keeps a roller on its cam. A new closure is a class here, or in a module of its own as
``conjugate``, and its name in ``SlideClosure`` or ``ArmClosure`` there.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field
from pydantic_core import PydanticCustomError

from synthesis.catalogue.constraints import Ends, Vector
from synthesis.catalogue.fields import FiniteModel, Range
from synthesis.catalogue.followers.kinematics import Flank, Tip, TracePoint, Vector2
from synthesis.catalogue.motion import Motion

Rim = Annotated[
    float,
    Field(
        ge=0.0,
        le=1e6,
        description="Material around the flank that is touched from inside; the limit "
        "outer_radius counts it in.",
    ),
]


class Closure(FiniteModel):
    """What keeps a roller on its cam, and with it: which curves the cam is made of.

    Attributes:
        kind: name on the wire. title: name for people.
        counter_paths: names of the traced curves of counter rollers.
        eased_by_distance: whether every limit of a counter cam but its outer radius is eased where
            its roller is farther away.
    """

    kind: str
    title: ClassVar[str]
    counter_paths: ClassVar[tuple[str, ...]] = ()
    eased_by_distance: ClassVar[bool] = True

    def flanks(self, trace: TracePoint, roller_radius: float) -> tuple[Flank, ...]:
        """The cam's flanks, the base radius that of the first: one that is touched from outside."""
        return (Flank("", 1, roller_radius, "", trace),)

    def contact_points(
        self, at: Vector2, pivot: Vector2 | None, turn: int, degree: Any
    ) -> tuple[Tip, ...]:
        """The rollers' centres on the follower's link (``Follower.link``), the main one's ``at``.

        The link's pivot is None where it slides, ``degree`` π/180 in the arithmetic of the others.
        """
        return (Tip("", at),)

    def check(self, roller_radius: float, largest: float, gap: float) -> None:
        """Refuse a roller that it cannot hold.

        ``largest`` base radius allowed; ``gap``: prime radius less base radius [mm].
        """
        return None

    def dimensions(self, roller_radius: float) -> Mapping[str, float]:
        """Its dimensions as named on the wire [mm]."""
        return {}

    def motion_dimensions(
        self, trace: TracePoint, motion: Motion, z: Vector
    ) -> Mapping[str, float]:
        """Dimensions that follow from the finished motion [mm]."""
        return {}

    def counter_dimensions(self) -> Mapping[str, tuple[str, float | Range | None]]:
        """Dimensions chosen after the size, by field: name on the wire, and requested value."""
        return {}

    def counter_range(self, trace: TracePoint, z: Vector, s_max: float) -> Ends:
        """Nearest and farthest place of a counter roller whose cam has the axis inside [wire]."""
        return -math.inf, math.inf

    def without_free_counter(self) -> Closure:
        """The same without a counter roller whose place is free."""
        return self

    def with_counter(self, values: Mapping[str, float]) -> Closure:
        """The same with its counter roller at a place, by the names of the dimensions."""
        return self

    def counter_only(self, values: Mapping[str, float]) -> Closure:
        """The same with the flanks of its counter roller alone, at a place."""
        return self


SINGLE_FLANK = Closure(kind="single_flank")
"""That of a family which has no choice of one."""


class Force(Closure):
    """A force holds the roller on the cam, from outside, or from inside on a ring.

    On a ring the follower moves away from the cam's axis under the force, and the cam pushes it
    back; the base radius is the smallest radius of the ring's hollow, Rp + Rr.
    """

    kind: Literal["force"] = "force"
    title: ClassVar[str] = "Force-closed, touched from outside or inside"
    contact: Literal["outside", "inside"] = Field(
        "outside", description="inside: the roller runs in a ring whose hollow is the cam."
    )
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


class Groove(Closure):
    """One roller in a groove: the inner flank pushes it outwards, the outer one inwards.

    The groove is as wide as the roller and the clearance together, its middle line is the pitch
    curve: each flank lies at D = Rr + clearance/2 from it. The base radius is the inner flank's.
    """

    kind: Literal["groove"] = "groove"
    title: ClassVar[str] = "Groove with an inner and an outer flank"
    clearance_mm: float = Field(
        0.0, ge=0.0, le=1e6, description="By how much the groove is wider than the roller."
    )
    rim_mm: Rim = 0.0

    def flanks(self, trace: TracePoint, roller_radius: float) -> tuple[Flank, ...]:
        slack = 0.5 * self.clearance_mm
        return (
            Flank("inner", 1, roller_radius + slack, "", trace, 0.0, slack),
            Flank("outer", -1, roller_radius + slack, "", trace, self.rim_mm, slack),
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
        width = 2.0 * (roller_radius + 0.5 * self.clearance_mm)
        return {"groove_width_mm": width, "clearance_mm": self.clearance_mm}
