"""The base of every closure: what keeps a roller on its cam."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BaseModel, ConfigDict, Field

from synthesis.catalogue.followers.flank import CounterRollerRange, Flank
from synthesis.catalogue.followers.kinematics import TracePoint, Vector2
from synthesis.catalogue.followers.link import Tip
from synthesis.catalogue.motion import Motion
from synthesis.catalogue.ranges import Range

MIN_PRIME_RADIUS_RATIO = (
    1e-3  # of the base radius: smallest prime radius of a cam that is touched from inside
)

Rim = Annotated[
    float,
    Field(
        ge=0.0,
        le=1e6,
        description="Material around the flank that is touched from inside; the limit "
        "outer_radius counts it in.",
    ),
]


class Closure(BaseModel, ABC):
    """What keeps a roller on its cam, and with it: which curves the cam is made of."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    kind: str
    title: ClassVar[str]
    counter_paths: ClassVar[tuple[str, ...]] = ()  # paths of further rollers

    @abstractmethod
    def flanks(self, trace: TracePoint, roller_radius: float) -> tuple[Flank, ...]:
        """The cam's flanks; the base radius is that of the first."""

    def contact_points(
        self, at: Vector2, pivot: Vector2 | None, turn: int, degree: Any
    ) -> tuple[Tip, ...]:
        """The rollers' centres on the follower's link, see ``link``.

        Args:
            at: the main roller's. pivot: of the link, None where it slides.
            turn: sense in which it turns. degree: π/180, in the arithmetic of the others.
        """
        return (Tip("", at),)

    def check(self, roller_radius: float, largest: float, gap: float) -> None:
        """Refuse a roller that it cannot hold.

        Args:
            roller_radius: Rr [mm].
            largest: largest base radius allowed [mm].
            gap: prime radius less base radius [mm].
        """
        return None

    def counter_dimensions(self) -> Mapping[str, tuple[str, float | Range | None]]:
        """Dimensions of a second roller that may be left free: field, dimension, value."""
        return {}

    def counter_range(
        self, trace: TracePoint, z: tuple[float, ...], s_max: float
    ) -> CounterRollerRange:
        """Where a second roller makes sense, beside a main roller that moves up to ``s_max``."""
        return CounterRollerRange(-math.inf, math.inf, True)

    def with_free_counter(self) -> Closure:
        """The same with the place of its counter roller left free."""
        return self

    def without_free_counter(self) -> Closure:
        """The same without a counter roller whose place is free."""
        return self

    def counter_only(self, values: Mapping[str, float]) -> Closure:
        """The same with the flanks of further rollers alone."""
        return self

    def with_counter(self, values: Mapping[str, float]) -> Closure:
        """The same with dimensions that were left free, by their names among the dimensions."""
        return self

    def dimensions(self, roller_radius: float) -> Mapping[str, float]:
        """Its dimensions as named on the wire [mm]."""
        return {}

    def motion_dimensions(
        self, trace: TracePoint, motion: Motion, z: tuple[float, ...]
    ) -> Mapping[str, float]:
        """Dimensions that follow from the finished motion [mm]."""
        return {}


class SingleFlank(Closure):
    """The closure of a family that has no choice of one: a single flank, touched from outside."""

    kind: Literal["single_flank"] = "single_flank"
    title: ClassVar[str] = "Touched from outside"

    def flanks(self, trace: TracePoint, roller_radius: float) -> tuple[Flank, ...]:
        return (Flank("", 1, roller_radius, "", trace),)


SINGLE_FLANK = SingleFlank()
