"""The free law: a spline that the optimiser chooses together with the size of the cam."""

from __future__ import annotations

from typing import ClassVar, Literal

from pydantic import Field

from synthesis.catalogue.fields import FiniteModel
from synthesis.catalogue.laws.base import EndDerivatives
from synthesis.catalogue.motion import FreeLaw, SegmentKind


class SplineLaw(FiniteModel):
    """Let the service find the motion: a spline, chosen together with the cam's size.

    It joins its neighbours with continuous displacement and velocity, and with as many further
    derivatives as ``smoothness`` asks for: the acceleration, where nothing is said.
    """

    kind: Literal["spline"] = "spline"
    smoothness: Literal[1, 2, 3, 4] = Field(
        2,
        description="Number of continuous derivatives. 1: the acceleration may jump, inside "
        "and at both ends, so that nothing may speak of jerk (quadratic spline); 2: the jerk "
        "is bounded and may jump (cubic spline, the smallest cam); 3: the jerk is continuous "
        "(quartic); 4: its slope too (quintic).",
    )
    overshoot: bool = Field(
        False, description="Allow the follower to move backwards within the segment."
    )

    inherited_derivatives: ClassVar[int] = 0  # states of neighbours are equality rows

    @property
    def may_reverse(self) -> bool:
        """Whether it may move backwards."""
        return self.overshoot

    def with_end_derivatives(
        self, segment: SegmentKind, start: EndDerivatives, end: EndDerivatives
    ) -> None:
        """None: required end states are equality rows of the optimisation problem."""
        return None

    def with_smoothness_2(self) -> SplineLaw:
        """The same of class C2."""
        return self.model_copy(update={"smoothness": 2}) if self.smoothness > 2 else self

    def free_law(self, knots: tuple[float, ...] = ()) -> FreeLaw:
        """The spline's class; ``knots``: x where its highest derivative may jump."""
        return FreeLaw(self.smoothness, self.overshoot, knots=knots)
