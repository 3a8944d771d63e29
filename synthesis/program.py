"""The motion program on the wire: what the follower does, segment by segment."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

from synthesis.laws import AnyLaw, SplineLaw
from synthesis.limits.demand import Demand
from synthesis.motion import Stretch, StretchKind
from synthesis.numerics.piecewise import Piecewise
from synthesis.windows import MOST, Point, Window, check_bounds, check_places, check_stroke
from synthesis.windows import demands as demanded
from synthesis.windows import knots as wanted_knots

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

    def demands(self, index: int) -> tuple[Demand, ...]:
        """What its windows and points ask for, as bounds that the segment has to keep."""
        return ()


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

    windows: Annotated[
        list[Window],
        Field(max_length=MOST, description="Bounds that hold on a part of the segment."),
    ] = []
    points: Annotated[
        list[Point],
        Field(max_length=MOST, description="Points that the follower passes through."),
    ] = []

    @model_validator(mode="after")
    def _windows_fit(self) -> _Move:
        check_places(self.angle_deg, self.windows, self.points)
        check_bounds(self.windows)
        free = self.law.free()
        if free is not None and not free.overshoot:
            sense = 1.0 if self.signed_lift > 0.0 else -1.0
            check_stroke(self.lift_mm, sense, self.windows, self.points)
        return self

    @property
    def law_name(self) -> str:
        return self.law.kind

    def demands(self, index: int) -> tuple[Demand, ...]:
        return demanded(index, self.angle_deg, self.windows, self.points)

    def _placed(
        self, kind: StretchKind, index: int, start: float, angle: float, s_start: float
    ) -> Stretch:
        s_end = s_start + self.signed_lift
        curve, free = self.law.curve(kind), self.law.free()
        if free is not None:
            free = replace(free, knots=wanted_knots(self.angle_deg, self.windows, self.points))
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
