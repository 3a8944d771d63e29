"""The motion program on the wire: what the follower does, segment by segment."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

from synthesis.laws import AnyLaw, SplineLaw
from synthesis.motion import Stretch, StretchKind
from synthesis.numerics.piecewise import Piecewise

STILL = Piecewise.of([0.0, 1.0], [[0.0]])
Angle = Annotated[float, Field(gt=0.0, le=360.0, description="Cam angle of the segment [deg].")]
Lift = Annotated[
    float, Field(ge=1e-6, le=1e6, description="Distance that the follower moves [mm], positive.")
]


class _Segment(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    @property
    def signed_lift(self) -> float:
        """Displacement gained over the segment [mm]."""
        return 0.0

    @property
    def law_name(self) -> str:
        """Name of the law on the wire."""
        return "dwell"

    def stretch(self, index: int, start: float, angle: float, s_start: float) -> Stretch:
        """The segment placed on the cam (angles in rad)."""
        raise NotImplementedError


class Dwell(_Segment):
    """The follower stands still."""

    kind: Literal["dwell"] = "dwell"
    angle_deg: Annotated[
        float, Field(ge=0.0, le=360.0, description="Cam angle of the dwell [deg].")
    ]

    def stretch(self, index: int, start: float, angle: float, s_start: float) -> Stretch:
        return Stretch(index, "dwell", start, angle, s_start, s_start, STILL)


class _Move(_Segment):
    angle_deg: Angle
    lift_mm: Lift
    law: AnyLaw = Field(
        default_factory=SplineLaw,
        description="A named motion law, or `spline`: then the law is part of the answer.",
    )

    @property
    def law_name(self) -> str:
        return self.law.kind

    def _placed(
        self, kind: StretchKind, index: int, start: float, angle: float, s_start: float
    ) -> Stretch:
        s_end = s_start + self.signed_lift
        curve, free = self.law.curve(kind), self.law.free()
        return Stretch(index, kind, start, angle, s_start, s_end, curve, free)


class Rise(_Move):
    """The follower moves away from the cam's axis."""

    kind: Literal["rise"] = "rise"

    @property
    def signed_lift(self) -> float:
        return self.lift_mm

    def stretch(self, index: int, start: float, angle: float, s_start: float) -> Stretch:
        return self._placed("rise", index, start, angle, s_start)


class Return(_Move):
    """The follower moves back towards the cam's axis."""

    kind: Literal["return"] = "return"

    @property
    def signed_lift(self) -> float:
        return -self.lift_mm

    def stretch(self, index: int, start: float, angle: float, s_start: float) -> Stretch:
        return self._placed("return", index, start, angle, s_start)


Segment = Annotated[Rise | Dwell | Return, Field(discriminator="kind")]
