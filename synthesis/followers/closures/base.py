"""What every closure promises."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar

from pydantic import BaseModel, ConfigDict, Field

from synthesis.followers.flank import Flank, Places
from synthesis.followers.link import Tip
from synthesis.followers.trace import Host, Vector2
from synthesis.motion import Motion
from synthesis.ranges import Range

LEAST = 1e-3  # of the base radius: smallest prime radius of a cam that is touched from inside

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
    companions: ClassVar[tuple[str, ...]] = ()  # paths of further rollers

    @abstractmethod
    def flanks(self, trace: Host, roller_radius: float) -> tuple[Flank, ...]:
        """The cam's flanks; the base radius is that of the first."""

    def tips(self, at: Vector2, pivot: Vector2 | None, turn: int, degree: Any) -> tuple[Tip, ...]:
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

    def companion_ranges(self) -> Mapping[str, tuple[str, float | Range | None]]:
        """Dimensions of a second roller that may be left free: field, dimension, value."""
        return {}

    def places(self, trace: Host, z: tuple[float, ...], s_max: float) -> Places:
        """Where a second roller makes sense, beside a main roller that moves up to ``s_max``."""
        return Places(-math.inf, math.inf, True)

    def opened(self) -> Closure:
        """The same with everything left free that is settled after the size."""
        return self

    def alone(self) -> Closure:
        """The same without what is settled after the size."""
        return self

    def companion(self, values: Mapping[str, float]) -> Closure:
        """The same with the flanks of further rollers alone."""
        return self

    def completed(self, values: Mapping[str, float]) -> Closure:
        """The same with dimensions that were left free, by their names among the dimensions."""
        return self

    def dimensions(self, roller_radius: float) -> Mapping[str, float]:
        """Its dimensions as named on the wire [mm]."""
        return {}

    def motion_dimensions(
        self, trace: Host, motion: Motion, z: tuple[float, ...]
    ) -> Mapping[str, float]:
        """Dimensions that follow from the finished motion [mm]."""
        return {}
