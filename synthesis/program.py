"""The motion program on the wire: what the follower does, segment by segment."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator
from pydantic_core import PydanticCustomError

from synthesis.laws import AnyLaw, SplineLaw
from synthesis.motion import Stretch, StretchKind
from synthesis.numerics.piecewise import Piecewise

STILL = Piecewise.of([0.0, 1.0], [[0.0]])
Angle = Annotated[float, Field(gt=0.0, le=360.0, description="Cam angle of the segment [deg].")]
Lift = Annotated[
    float, Field(ge=1e-6, le=1e6, description="Distance that the follower moves [mm], positive.")
]
Swing = Annotated[
    float,
    Field(ge=1e-6, lt=180.0, description="Angle that the follower's arm swings [deg], positive."),
]


class _Segment(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    @property
    def signed_lift(self) -> float:
        """Displacement gained over the segment, in its own unit."""
        return 0.0

    @property
    def lift_unit(self) -> str | None:
        """Unit of the lift, as in the field's name; None where there is none."""
        return None

    @property
    def law_name(self) -> str:
        """Name of the law on the wire."""
        return "dwell"

    def stretch(
        self, index: int, start: float, angle: float, s_start: float, per_unit: float = 1.0
    ) -> Stretch:
        """The segment placed on the cam (angles in rad, displacement in mm).

        ``per_unit``: the core's mm in one unit of its lift.
        """
        raise NotImplementedError


class Dwell(_Segment):
    """The follower stands still."""

    kind: Literal["dwell"] = "dwell"
    angle_deg: Annotated[
        float, Field(ge=0.0, le=360.0, description="Cam angle of the dwell [deg].")
    ]

    def stretch(
        self, index: int, start: float, angle: float, s_start: float, per_unit: float = 1.0
    ) -> Stretch:
        return Stretch(index, "dwell", start, angle, s_start, s_start, STILL)


class _Move(_Segment):
    angle_deg: Angle
    lift_mm: Lift | None = None
    lift_deg: Swing | None = None
    law: AnyLaw = Field(
        default_factory=SplineLaw,
        description="A named motion law, or `spline`: then the law is part of the answer.",
    )

    @property
    def law_name(self) -> str:
        return self.law.kind

    @model_validator(mode="after")
    def _lifts(self) -> _Move:
        if (self.lift_mm is None) == (self.lift_deg is None):
            raise PydanticCustomError(
                "lift_unclear",
                "the segment gives {number}. Give lift_mm for a follower that slides, or "
                "lift_deg for one on an arm.",
                {"number": "no lift" if self.lift_mm is None else "two lifts"},
            )
        return self

    @property
    def lift_unit(self) -> str | None:
        return "deg" if self.lift_mm is None else "mm"

    @property
    def _lift(self) -> float:
        """Lift in its own unit."""
        given = self.lift_deg if self.lift_mm is None else self.lift_mm
        assert given is not None  # exactly one is, or the segment had been refused
        return given

    def _placed(
        self,
        kind: StretchKind,
        index: int,
        start: float,
        angle: float,
        s_start: float,
        per_unit: float,
    ) -> Stretch:
        s_end = s_start + self.signed_lift * per_unit
        curve, free = self.law.curve(kind), self.law.free()
        return Stretch(index, kind, start, angle, s_start, s_end, curve, free)


class Rise(_Move):
    """The follower moves away from the cam's axis."""

    kind: Literal["rise"] = "rise"

    @property
    def signed_lift(self) -> float:
        return self._lift

    def stretch(
        self, index: int, start: float, angle: float, s_start: float, per_unit: float = 1.0
    ) -> Stretch:
        return self._placed("rise", index, start, angle, s_start, per_unit)


class Return(_Move):
    """The follower moves back towards the cam's axis."""

    kind: Literal["return"] = "return"

    @property
    def signed_lift(self) -> float:
        return -self._lift

    def stretch(
        self, index: int, start: float, angle: float, s_start: float, per_unit: float = 1.0
    ) -> Stretch:
        return self._placed("return", index, start, angle, s_start, per_unit)


Segment = Annotated[Rise | Dwell | Return, Field(discriminator="kind")]
