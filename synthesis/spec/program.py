"""The motion program on the wire: what the follower does, segment by segment."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from synthesis.catalogue.laws import AnyLaw, SplineLaw
from synthesis.catalogue.limits.segment_bound import SegmentBound
from synthesis.catalogue.motion import EndState, PlacedSegment, SegmentKind
from synthesis.catalogue.ranges import Angle, DwellAngle, Lift, Range, Swing, ends
from synthesis.numerics.piecewise import Piecewise
from synthesis.spec.constant_velocity import ConstantSpeed
from synthesis.spec.motion_constraints import (
    MOST,
    Point,
    Window,
    bounds_of_constraints,
    check_bounds,
    check_places,
    check_stroke,
    constraint_knots,
)
from synthesis.spec.segment import Part, State, TravelUnit, end_states, one_unit, units_of
from synthesis.spec.table import Table
from synthesis.units import CORE_UNITS, MotionUnits

STILL = Piecewise.of([0.0, 1.0], [[0.0]])


class Dwell(Part):
    """The follower stands still."""

    kind: Literal["dwell"] = "dwell"
    angle_deg: DwellAngle

    @property
    def law_name(self) -> str:
        return "dwell"

    def place(
        self,
        index: int,
        start: float,
        angle: float,
        s_start: float,
        units: MotionUnits = CORE_UNITS,
    ) -> PlacedSegment:
        return PlacedSegment(index, "dwell", start, angle, s_start, s_start, STILL)


class _Move(Part):
    angle_deg: Angle
    lift_mm: Lift | None = None
    lift_deg: Swing | None = None
    law: AnyLaw = Field(
        default_factory=SplineLaw,
        description="A named motion law, or `spline`: then the law is part of the answer.",
    )

    start: State | None = Field(None, description="Velocity and acceleration at its start.")
    end: State | None = Field(None, description="Velocity and acceleration at its end.")
    windows: Annotated[
        list[Window],
        Field(
            default_factory=list,
            max_length=MOST,
            description="Bounds that hold on a part of the segment.",
        ),
    ]
    points: Annotated[
        list[Point],
        Field(
            default_factory=list,
            max_length=MOST,
            description="Points that the follower passes through.",
        ),
    ]

    @model_validator(mode="after")
    def _lifts(self) -> _Move:
        if (self.lift_mm is None) == (self.lift_deg is None):
            raise PydanticCustomError(
                "lift_unclear",
                "the segment gives {number}. Give lift_mm for a follower that slides, or "
                "lift_deg for one on an arm.",
                {"number": "no lift" if self.lift_mm is None else "two lifts"},
            )
        one_unit(self.units, "segment")
        return self

    @model_validator(mode="after")
    def _windows_fit(self) -> _Move:
        check_places(self.degrees, self.windows, self.points)
        check_bounds(self.windows)
        free = self.law.free_law()
        if free is not None and not free.overshoot:
            sense = 1.0 if self.signed_lift > 0.0 else -1.0
            check_stroke(ends(self._asked)[1], sense, self.windows, self.points)
        return self

    def free_fields(self) -> dict[str, float | Range]:
        lift = "lift_deg" if self.lift_mm is None else "lift_mm"
        return {"angle_deg": self.angle_deg, lift: self._asked}

    @property
    def units(self) -> frozenset[TravelUnit]:
        mine: frozenset[TravelUnit] = frozenset(["deg" if self.lift_mm is None else "mm"])
        parts = frozenset[TravelUnit]().union(
            *(part.units for part in (*self.windows, *self.points))
        )
        return mine | parts | units_of(self.start, self.end)

    @property
    def _asked(self) -> float | Range:
        """Lift as asked for, in its own unit."""
        given = self.lift_deg if self.lift_mm is None else self.lift_mm
        assert given is not None  # exactly one is, or the segment had been refused
        return given

    @property
    def _lift(self) -> float:
        """Lift in its own unit; the smallest one while it is left free."""
        return ends(self._asked)[0]

    @property
    def law_name(self) -> str:
        return self.law.kind

    def with_c2_splines(self) -> Self:
        return self.model_copy(update={"law": self.law.with_smoothness_2()})

    @property
    def matched_derivatives(self) -> int:
        return self.law.inherited_derivatives

    @property
    def may_reverse(self) -> bool:
        return self.law.may_reverse

    def segment_bounds(self, index: int) -> tuple[SegmentBound, ...]:
        return bounds_of_constraints(index, self.degrees, self.windows, self.points)

    def _placed(
        self,
        kind: SegmentKind,
        index: int,
        start: float,
        angle: float,
        s_start: float,
        units: MotionUnits,
    ) -> PlacedSegment:
        s_end = s_start + self.gain(units)
        first, last = end_states(self.start, self.end, units)
        free = self.law.free_law(constraint_knots(self.degrees, self.windows, self.points))
        law = self._law(kind, angle, s_end - s_start, first, last)
        return PlacedSegment(index, kind, start, angle, s_start, s_end, law, free, first, last)

    def with_end_states(
        self, placed: PlacedSegment, start: EndState, end: EndState
    ) -> PlacedSegment:
        law = self._law(placed.kind, placed.angle, placed.lift, start, end)
        return replace(placed, law=law)

    def _law(
        self, kind: SegmentKind, angle: float, lift: float, start: EndState, end: EndState
    ) -> Piecewise | None:
        known = (state.normalised(angle, lift) for state in (start, end))
        return self.law.with_end_derivatives(kind, *known)


class Rise(_Move):
    """The follower moves away from the cam's axis."""

    kind: Literal["rise"] = "rise"

    @property
    def signed_lift(self) -> float:
        return self._lift

    def place(
        self,
        index: int,
        start: float,
        angle: float,
        s_start: float,
        units: MotionUnits = CORE_UNITS,
    ) -> PlacedSegment:
        return self._placed("rise", index, start, angle, s_start, units)


class Return(_Move):
    """The follower moves back towards the cam's axis."""

    kind: Literal["return"] = "return"

    @property
    def signed_lift(self) -> float:
        return -self._lift

    def place(
        self,
        index: int,
        start: float,
        angle: float,
        s_start: float,
        units: MotionUnits = CORE_UNITS,
    ) -> PlacedSegment:
        return self._placed("return", index, start, angle, s_start, units)


Segment = Annotated[Rise | Dwell | Return | ConstantSpeed | Table, Field(discriminator="kind")]
