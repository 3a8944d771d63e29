"""The motion program on the wire: what the follower does, segment by segment."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, ClassVar, Literal, Self

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from synthesis.catalogue.fields import Angle, DwellAngle, Lift, Range, Swing, ends
from synthesis.catalogue.laws import AnyLaw, SplineLaw
from synthesis.catalogue.limits.motion import SegmentBound
from synthesis.catalogue.motion import EndState, PlacedSegment
from synthesis.numerics.piecewise import Piecewise
from synthesis.spec.motion_constraints import MOST, MotionConstraints, Point, Window
from synthesis.spec.segment import SegmentSpec, State, signed, with_states
from synthesis.spec.table import Table
from synthesis.units import DEGREE, MotionUnits

STILL = Piecewise.of([0.0, 1.0], [[0.0]])
LINE = Piecewise.of([0.0, 1.0], [[0.0, 1.0]])
LEAST_VELOCITY = 1e-9  # mm, deg, or per s: less is a dwell, but for rounding


class Dwell(SegmentSpec):
    """The follower stands still."""

    kind: Literal["dwell"] = "dwell"
    angle_deg: DwellAngle

    def with_motion(self, placed: PlacedSegment, units: MotionUnits) -> PlacedSegment:
        return placed.with_law(STILL)


class ConstantSpeed(SegmentSpec):
    """The follower runs at constant velocity; neighbouring splines and polynomials pick it up."""

    kind: Literal["constant_velocity"] = "constant_velocity"
    angle_deg: Angle
    velocity_mm_per_s: float | None = signed(
        "The velocity, with its sign [mm/s]; or give a lift.", 1e12
    )
    velocity_deg_per_s: float | None = signed("The same of a follower on an arm [deg/s].", 1e12)
    lift_mm: float | None = signed("Distance gained, with its sign [mm]; or give a velocity.", 1e6)
    lift_deg: float | None = signed(
        "Angle gained by a follower on an arm, with its sign [deg].", 180.0
    )

    @model_validator(mode="after")
    def _one_of_both(self) -> ConstantSpeed:
        values = self.velocity_mm_per_s, self.velocity_deg_per_s, self.lift_mm, self.lift_deg
        given = [value for value in values if value is not None]
        if len(given) != 1:
            raise PydanticCustomError(
                "velocity_or_lift",
                "A constant_velocity segment has exactly one of velocity_mm_per_s and lift_mm "
                "(on an arm velocity_deg_per_s and lift_deg), not {count}. "
                "Give one of them: the other follows from angle and speed.",
                {"count": len(given)},
            )
        if abs(given[0]) < LEAST_VELOCITY:
            raise PydanticCustomError(
                "velocity_zero",
                "A constant_velocity segment that moves by {value} stands still. "
                "Use a dwell, or give a velocity or lift other than 0.",
                {"value": given[0]},
            )
        return self

    def gain(self, units: MotionUnits) -> float:
        velocity = self.given("velocity")
        if velocity is None:
            return units.to_core(self.given("lift"))
        return units.to_core(velocity, 1) * (self.degrees * DEGREE)

    def with_motion(self, placed: PlacedSegment, units: MotionUnits) -> PlacedSegment:
        return placed.with_law(LINE)


class _Move(SegmentSpec):
    sign: ClassVar[float]  # of the lift

    angle_deg: Angle
    lift_mm: Lift | None = None
    lift_deg: Swing | None = None
    law: AnyLaw = Field(
        default_factory=SplineLaw,
        description="A named motion law, or `spline`: then the law is part of the answer.",
    )

    start: State | None = Field(None, description="Velocity and acceleration at its start.")
    end: State | None = Field(None, description="Velocity and acceleration at its end.")
    windows: list[Window] = Field(
        default_factory=list,
        max_length=MOST,
        description="Bounds that hold on a part of the segment.",
    )
    points: list[Point] = Field(
        default_factory=list,
        max_length=MOST,
        description="Points that the follower passes through.",
    )

    @model_validator(mode="after")
    def _lifts(self) -> _Move:
        if (self.lift_mm is None) == (self.lift_deg is None):
            raise PydanticCustomError(
                "lift_unclear",
                "the segment gives {number}. Give lift_mm for a follower that slides, or "
                "lift_deg for one on an arm.",
                {"number": "no lift" if self.lift_mm is None else "two lifts"},
            )
        self.check_one_unit("segment")
        return self

    @model_validator(mode="after")
    def _windows_fit(self) -> _Move:
        self._constraints.check()
        free = self.law.free_law()
        if free is not None and not free.overshoot:
            self._constraints.check_forward(ends(self.given("lift"))[1], self.sign)
        return self

    @property
    def _constraints(self) -> MotionConstraints:
        return MotionConstraints(self.degrees, self.windows, self.points)

    def free_fields(self) -> dict[str, float | Range]:
        return {"angle_deg": self.angle_deg, self.given_field("lift"): self.given("lift")}

    @property
    def signed_lift(self) -> float:
        return self.sign * ends(self.given("lift"))[0]

    @property
    def own_law(self) -> AnyLaw:
        return self.law

    def with_c2_splines(self) -> Self:
        return self.model_copy(update={"law": self.law.with_smoothness_2()})

    def segment_bounds(self, index: int) -> tuple[SegmentBound, ...]:
        return self._constraints.segment_bounds(index)

    def with_motion(self, placed: PlacedSegment, units: MotionUnits) -> PlacedSegment:
        held = with_states(placed, self.start, self.end, units)
        law = self._law(held, held.start_state, held.end_state)
        return replace(held, law=law, free=self.law.free_law(self._constraints.knots()))

    def with_end_states(
        self, placed: PlacedSegment, start: EndState, end: EndState
    ) -> PlacedSegment:
        return replace(placed, law=self._law(placed, start, end))

    def _law(self, placed: PlacedSegment, start: EndState, end: EndState) -> Piecewise | None:
        known = (state.normalised(placed.angle, placed.lift) for state in (start, end))
        return self.law.with_end_derivatives(placed.kind, *known)


class Rise(_Move):
    """The follower moves away from the cam's axis."""

    kind: Literal["rise"] = "rise"
    sign: ClassVar[float] = 1.0


class Return(_Move):
    """The follower moves back towards the cam's axis."""

    kind: Literal["return"] = "return"
    sign: ClassVar[float] = -1.0


Segment = Annotated[Rise | Dwell | Return | ConstantSpeed | Table, Field(discriminator="kind")]
