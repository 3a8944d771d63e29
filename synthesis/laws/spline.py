"""The law that is part of the answer."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from pydantic import BaseModel, ConfigDict, Field

from synthesis.laws.base import Known
from synthesis.motion import FreeLaw, StretchKind


class SplineLaw(BaseModel):
    """Let the service find the motion: a spline, chosen together with the cam's size.

    It joins its neighbours with continuous displacement and velocity, and with as many further
    derivatives as ``smoothness`` asks for: the acceleration, where nothing is said.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    kind: Literal["spline"] = "spline"
    smoothness: Annotated[
        Literal[1, 2, 3, 4],
        Field(
            description="Number of continuous derivatives. 1: the acceleration may jump, inside "
            "and at both ends, so that nothing may speak of jerk (quadratic spline); 2: the jerk "
            "is bounded and may jump (cubic spline, the smallest cam); 3: the jerk is continuous "
            "(quartic); 4: its slope too (quintic)."
        ),
    ] = 2
    overshoot: Annotated[
        bool,
        Field(description="Allow the follower to move backwards within the segment."),
    ] = False

    takes: ClassVar[int] = 0  # from its neighbours: that is settled where the spline is

    @property
    def overshoots(self) -> bool:
        """Whether it may move backwards."""
        return self.overshoot

    def curve(self, stretch: StretchKind) -> None:
        """Nothing yet: the curve is part of the answer."""
        return None

    def between(self, stretch: StretchKind, start: Known, end: Known) -> None:
        """Nothing yet: the states asked for are rows of the formulation."""
        return None

    def roughened(self) -> SplineLaw:
        """The same of class C2."""
        return self.model_copy(update={"smoothness": 2}) if self.smoothness > 2 else self

    def free(self, knots: tuple[float, ...] = ()) -> FreeLaw:
        """The law's place in the formulation; ``knots``: where it must be free to bend."""
        return FreeLaw(self.smoothness, self.overshoot, knots=knots)
