"""The motion program on the wire: what the follower does, segment by segment."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import Annotated, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, model_validator
from pydantic_core import PydanticCustomError

from synthesis import table
from synthesis.laws import AnyLaw, SplineLaw
from synthesis.limits.demand import Demand
from synthesis.motion import ANY_STATE, EndState, FreeLaw, Readings, Stretch, StretchKind
from synthesis.numerics.piecewise import Array, Piecewise
from synthesis.ranges import Angle, AngleRange, DwellAngle, Lift, LiftRange, ends
from synthesis.units import DEGREE
from synthesis.windows import MOST, Point, Window, check_bounds, check_places, check_stroke
from synthesis.windows import demands as demanded
from synthesis.windows import knots as wanted_knots

LINE = Piecewise.of([0.0, 1.0], [[0.0, 1.0]])
TABLE_JOINS = 2  # derivatives that a smoothed table shares with its neighbours
STILL = Piecewise.of([0.0, 1.0], [[0.0]])


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


def _states(start: State | None, end: State | None, omega: float) -> tuple[EndState, EndState]:
    """Both end states per radian; nothing asked where nothing is given."""
    first, last = (
        ANY_STATE if state is None else state.per_radian(omega) for state in (start, end)
    )
    return first, last


class _Segment(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    angle_deg: float | AngleRange

    @property
    def degrees(self) -> float:
        """Its cam angle [deg]; the smallest one while it is left free."""
        return ends(self.angle_deg)[0]

    def left_open(self) -> dict[str, float | AngleRange | LiftRange]:
        """Fields that may be left free, with what is asked of them."""
        return {"angle_deg": self.angle_deg}

    @property
    def signed_lift(self) -> float:
        """Displacement gained over the segment [mm]; the smallest one while it is left free."""
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

    def span(self, omega: float) -> tuple[float, float]:
        """Lowest and highest displacement on the segment, from its start [mm]."""
        gain = self.gain(omega)
        return min(gain, 0.0), max(gain, 0.0)

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

    def demands(self, index: int) -> tuple[Demand, ...]:
        """What its windows and points ask for, as bounds that the segment has to keep."""
        return ()


class Dwell(_Segment):
    """The follower stands still."""

    kind: Literal["dwell"] = "dwell"
    angle_deg: DwellAngle

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
        check_places(self.degrees, self.windows, self.points)
        check_bounds(self.windows)
        free = self.law.free()
        if free is not None and not free.overshoot:
            sense = 1.0 if self.signed_lift > 0.0 else -1.0
            check_stroke(ends(self.lift_mm)[1], sense, self.windows, self.points)
        return self

    def left_open(self) -> dict[str, float | AngleRange | LiftRange]:
        return {"angle_deg": self.angle_deg, "lift_mm": self.lift_mm}

    @property
    def law_name(self) -> str:
        return self.law.kind

    @property
    def takes(self) -> int:
        return self.law.takes

    @property
    def overshoots(self) -> bool:
        return self.law.overshoots

    def demands(self, index: int) -> tuple[Demand, ...]:
        return demanded(index, self.degrees, self.windows, self.points)

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
        first, last = _states(self.start, self.end, omega)
        free = self.law.free()
        if free is not None:
            free = replace(free, knots=wanted_knots(self.degrees, self.windows, self.points))
        placed = Stretch(index, kind, start, angle, s_start, s_end, None, free, first, last)
        return self.between(placed, first, last)

    def between(self, placed: Stretch, start: EndState, end: EndState) -> Stretch:
        known = (state.normalised(placed.angle, placed.lift) for state in (start, end))
        return replace(placed, law=self.law.between(placed.kind, *known))


class Rise(_Move):
    """The follower moves away from the cam's axis."""

    kind: Literal["rise"] = "rise"

    @property
    def signed_lift(self) -> float:
        return ends(self.lift_mm)[0]

    def stretch(
        self, index: int, start: float, angle: float, s_start: float, omega: float = 1.0
    ) -> Stretch:
        return self._placed("rise", index, start, angle, s_start, omega)


class Return(_Move):
    """The follower moves back towards the cam's axis."""

    kind: Literal["return"] = "return"

    @property
    def signed_lift(self) -> float:
        return -ends(self.lift_mm)[0]

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
        return self.velocity_mm_per_s / omega * self.degrees * DEGREE

    def stretch(
        self, index: int, start: float, angle: float, s_start: float, omega: float = 1.0
    ) -> Stretch:
        gain = self.gain(omega)
        kind: StretchKind = "rise" if gain > 0.0 else "return"
        return Stretch(index, kind, start, angle, s_start, s_start + gain, LINE)


class Table(_Segment):
    """The follower runs through a table, smoothed within a tolerance.

    The motion is the spline of least mean square jerk that passes no row by more than the
    tolerance and joins its neighbours with their velocity and acceleration. Only differences of
    the displacements count. A table that moves both ways is held to the pressure-angle limits of
    rises and of returns; for either alone, split it where it turns.
    """

    kind: Literal["table"] = "table"
    angle_deg: Annotated[
        float, Field(gt=0.0, le=360.0, description="Cam angle of the segment [deg].")
    ]
    points: Annotated[
        list[tuple[float, float]] | None,
        Field(
            max_length=table.MOST,
            description="Rows: cam angle from the segment's start [deg], displacement [mm]. The "
            "first row is at 0, the last at angle_deg; on a whole turn that one may be missing.",
        ),
    ] = None
    angles_deg: Annotated[
        list[float] | None,
        Field(max_length=table.MOST, description="The first column, instead of points [deg]."),
    ] = None
    displacements_mm: Annotated[
        list[float] | None,
        Field(max_length=table.MOST, description="The second column, instead of points [mm]."),
    ] = None
    tolerance_mm: Annotated[
        float,
        Field(ge=1e-7, le=1e3, description="How far the motion may pass a row [mm]."),
    ]
    lift_mm: Annotated[
        float | None,
        Field(
            ge=-1e6,
            le=1e6,
            description="Displacement gained, with its sign [mm], where the table's own is "
            "inexact; left out: last row less first row, on a whole turn 0.",
        ),
    ] = None
    smoothness: Annotated[
        Literal[2, 3, 4], Field(description="Number of continuous derivatives.")
    ] = 4
    start: State | None = Field(None, description="Velocity and acceleration at its start.")
    end: State | None = Field(None, description="Velocity and acceleration at its end.")

    @cached_property
    def _table(self) -> tuple[Array, Array]:
        """Fractions of the segment, and displacement from the segment's start [mm]."""
        degrees, s = table.columns(self.points, self.angles_deg, self.displacements_mm)
        table.check(degrees, self.degrees)
        degrees, s = table.closed(degrees, s, self.degrees)
        return degrees / degrees[-1], s - (s[0] + s[-1] - self._gain(s)) / 2.0

    def _gain(self, s: Array) -> float:
        whole = self.angle_deg >= table.WHOLE_TURN
        own = 0.0 if whole else float(s[-1] - s[0])
        return own if self.lift_mm is None else self.lift_mm

    @model_validator(mode="after")
    def _makes_sense(self) -> Table:
        s = self._table[1]
        error = abs(float(s[-1] - s[0]) - self._gain(s))
        if error > 2.0 * self.tolerance_mm:
            raise PydanticCustomError(
                "table_lift",
                "{error} mm lie between the lift of the table, {lift} mm, and the one asked for: "
                "more than twice its tolerance. Correct lift_mm or the table; a table of a whole "
                "turn ends where it begins.",
                {"error": error, "lift": float(s[-1] - s[0])},
            )
        if float(np.ptp(s)) <= 2.0 * self.tolerance_mm:
            raise PydanticCustomError(
                "table_still",
                "{range} mm is all that the table moves, within its tolerance. "
                "Use a dwell, or a smaller tolerance_mm.",
                {"range": float(np.ptp(s))},
            )
        return self

    @property
    def law_name(self) -> str:
        return "table"

    def gain(self, omega: float) -> float:
        return self._gain(self._table[1])

    def span(self, omega: float) -> tuple[float, float]:
        s = self._table[1]
        ends = (0.0, self.gain(omega))
        return min(float(s.min()), *ends), max(float(s.max()), *ends)

    def stretch(
        self, index: int, start: float, angle: float, s_start: float, omega: float = 1.0
    ) -> Stretch:
        x, s = self._table
        readings = Readings(x, s_start + s, self.tolerance_mm)
        return Stretch(
            index, table.sense(s, self.tolerance_mm), start, angle, s_start,
            s_start + self.gain(omega), None,
            FreeLaw(self.smoothness, overshoot=True, joins=(TABLE_JOINS, TABLE_JOINS)),
            *_states(self.start, self.end, omega), readings,
        )  # fmt: skip


Segment = Annotated[Rise | Dwell | Return | ConstantSpeed | Table, Field(discriminator="kind")]
