"""The motion program on the wire: what the follower does, segment by segment."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator
from pydantic_core import PydanticCustomError

from synthesis.laws import AnyLaw, SplineLaw
from synthesis.motion import ANY_STATE, EndState, Stretch, StretchKind
from synthesis.numerics.piecewise import Piecewise
from synthesis.units import DEGREE

LINE = Piecewise.of([0.0, 1.0], [[0.0, 1.0]])
STILL = Piecewise.of([0.0, 1.0], [[0.0]])
Angle = Annotated[float, Field(gt=0.0, le=360.0, description="Cam angle of the segment [deg].")]
Lift = Annotated[
    float, Field(ge=1e-6, le=1e6, description="Distance that the follower moves [mm], positive.")
]


class State(BaseModel):
    """The motion asked for at one end of a segment; what is left out is the neighbour's.

    Signs are those of the motion: a return runs at negative velocity. VDI 2143 names the states:
    R rests (velocity and acceleration 0), G runs at constant velocity (acceleration 0), U turns
    back (velocity 0), B moves.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    velocity_mm_per_s: Annotated[
        float | None, Field(ge=-1e12, le=1e12, description="Velocity there, with its sign [mm/s].")
    ] = None
    acceleration_mm_per_s2: Annotated[
        float | None,
        Field(ge=-1e18, le=1e18, description="Acceleration there, with its sign [mm/s²]."),
    ] = None

    def per_radian(self, omega: float) -> EndState:
        """The state as s' and s''."""
        v, a = self.velocity_mm_per_s, self.acceleration_mm_per_s2
        return EndState(None if v is None else v / omega, None if a is None else a / omega**2)


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

    @property
    def takes(self) -> int:
        """How many derivatives its law takes over from its neighbours at each end."""
        return 0

    @property
    def overshoots(self) -> bool:
        """Whether it may move backwards."""
        return False

    def gain(self, omega: float) -> float:
        """Displacement gained over the segment [mm] at cam speed ω [rad/s]."""
        return self.signed_lift

    def stretch(
        self, index: int, start: float, angle: float, s_start: float, omega: float = 1.0
    ) -> Stretch:
        """The segment placed on the cam (angles in rad, ω in rad/s), neighbours unheard."""
        raise NotImplementedError

    def between(self, placed: Stretch, start: EndState, end: EndState) -> Stretch:
        """The placed segment with its law run between these states."""
        return placed


class Dwell(_Segment):
    """The follower stands still."""

    kind: Literal["dwell"] = "dwell"
    angle_deg: Annotated[
        float, Field(ge=0.0, le=360.0, description="Cam angle of the dwell [deg].")
    ]

    def stretch(
        self, index: int, start: float, angle: float, s_start: float, omega: float = 1.0
    ) -> Stretch:
        return Stretch(index, "dwell", start, angle, s_start, s_start, STILL)


class _Move(_Segment):
    angle_deg: Angle
    lift_mm: Lift
    law: AnyLaw = Field(
        default_factory=SplineLaw,
        description="A named motion law, or `spline`: then the law is part of the answer.",
    )

    start: State | None = Field(None, description="Velocity and acceleration at its start.")
    end: State | None = Field(None, description="Velocity and acceleration at its end.")

    @property
    def law_name(self) -> str:
        return self.law.kind

    @property
    def takes(self) -> int:
        return self.law.takes

    @property
    def overshoots(self) -> bool:
        return self.law.overshoots

    def _placed(
        self,
        kind: StretchKind,
        index: int,
        start: float,
        angle: float,
        s_start: float,
        omega: float,
    ) -> Stretch:
        s_end = s_start + self.signed_lift
        first, last = (
            ANY_STATE if state is None else state.per_radian(omega)
            for state in (self.start, self.end)
        )
        placed = Stretch(
            index, kind, start, angle, s_start, s_end, None, self.law.free(), first, last
        )
        return self.between(placed, first, last)

    def between(self, placed: Stretch, start: EndState, end: EndState) -> Stretch:
        known = (state.normalised(placed.angle, placed.lift) for state in (start, end))
        return replace(placed, law=self.law.between(placed.kind, *known))


class Rise(_Move):
    """The follower moves away from the cam's axis."""

    kind: Literal["rise"] = "rise"

    @property
    def signed_lift(self) -> float:
        return self.lift_mm

    def stretch(
        self, index: int, start: float, angle: float, s_start: float, omega: float = 1.0
    ) -> Stretch:
        return self._placed("rise", index, start, angle, s_start, omega)


class Return(_Move):
    """The follower moves back towards the cam's axis."""

    kind: Literal["return"] = "return"

    @property
    def signed_lift(self) -> float:
        return -self.lift_mm

    def stretch(
        self, index: int, start: float, angle: float, s_start: float, omega: float = 1.0
    ) -> Stretch:
        return self._placed("return", index, start, angle, s_start, omega)


class ConstantSpeed(_Segment):
    """The follower runs at constant velocity; neighbouring splines and polynomials pick it up."""

    kind: Literal["constant_velocity"] = "constant_velocity"
    angle_deg: Angle
    velocity_mm_per_s: Annotated[
        float | None,
        Field(
            ge=-1e12, le=1e12, description="The velocity, with its sign [mm/s]; or give lift_mm."
        ),
    ] = None
    lift_mm: Annotated[
        float | None,
        Field(
            ge=-1e6, le=1e6,
            description="Distance gained, with its sign [mm]; or give velocity_mm_per_s.",
        ),
    ] = None  # fmt: skip

    @model_validator(mode="after")
    def _one_of_both(self) -> ConstantSpeed:
        given = [v for v in (self.velocity_mm_per_s, self.lift_mm) if v is not None]
        if len(given) != 1:
            raise PydanticCustomError(
                "velocity_or_lift",
                "A constant_velocity segment has exactly one of velocity_mm_per_s and lift_mm, "
                "not {count}. Give one of them: the other follows from angle and speed.",
                {"count": len(given)},
            )
        if abs(given[0]) < 1e-9:
            raise PydanticCustomError(
                "velocity_zero",
                "A constant_velocity segment that moves by {value} stands still. "
                "Use a dwell, or give a velocity or lift other than 0.",
                {"value": given[0]},
            )
        return self

    @property
    def law_name(self) -> str:
        return "constant_velocity"

    def gain(self, omega: float) -> float:
        if self.lift_mm is not None:
            return self.lift_mm
        assert self.velocity_mm_per_s is not None
        return self.velocity_mm_per_s / omega * self.angle_deg * DEGREE

    def stretch(
        self, index: int, start: float, angle: float, s_start: float, omega: float = 1.0
    ) -> Stretch:
        gain = self.gain(omega)
        kind: StretchKind = "rise" if gain > 0.0 else "return"
        return Stretch(index, kind, start, angle, s_start, s_start + gain, LINE)


Segment = Annotated[Rise | Dwell | Return | ConstantSpeed, Field(discriminator="kind")]
