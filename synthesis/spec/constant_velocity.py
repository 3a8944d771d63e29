"""Segments at constant velocity."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import model_validator
from pydantic_core import PydanticCustomError

from synthesis.catalogue.motion import PlacedSegment, SegmentKind
from synthesis.catalogue.ranges import Angle
from synthesis.numerics.piecewise import Piecewise
from synthesis.spec.segment import Part, TravelUnit, signed
from synthesis.units import CORE_UNITS, DEGREE, MotionUnits

LINE = Piecewise.of([0.0, 1.0], [[0.0, 1.0]])


class ConstantSpeed(Part):
    """The follower runs at constant velocity; neighbouring splines and polynomials pick it up."""

    kind: Literal["constant_velocity"] = "constant_velocity"
    angle_deg: Angle
    velocity_mm_per_s: Annotated[
        float | None, signed("The velocity, with its sign [mm/s]; or give a lift.", 1e12)
    ] = None
    velocity_deg_per_s: Annotated[
        float | None, signed("The same of a follower on an arm [deg/s].", 1e12)
    ] = None
    lift_mm: Annotated[
        float | None, signed("Distance gained, with its sign [mm]; or give a velocity.", 1e6)
    ] = None
    lift_deg: Annotated[
        float | None, signed("Angle gained by a follower on an arm, with its sign [deg].", 180.0)
    ] = None

    def _given(self) -> list[tuple[int, TravelUnit, float]]:
        """Order of the derivative, unit and value of what is given."""
        fields: list[tuple[int, TravelUnit, float | None]] = [
            (1, "mm", self.velocity_mm_per_s),
            (1, "deg", self.velocity_deg_per_s),
            (0, "mm", self.lift_mm),
            (0, "deg", self.lift_deg),
        ]
        return [(order, unit, value) for order, unit, value in fields if value is not None]

    @model_validator(mode="after")
    def _one_of_both(self) -> ConstantSpeed:
        given = self._given()
        if len(given) != 1:
            raise PydanticCustomError(
                "velocity_or_lift",
                "A constant_velocity segment has exactly one of velocity_mm_per_s and lift_mm "
                "(on an arm velocity_deg_per_s and lift_deg), not {count}. "
                "Give one of them: the other follows from angle and speed.",
                {"count": len(given)},
            )
        if abs(given[0][2]) < 1e-9:
            raise PydanticCustomError(
                "velocity_zero",
                "A constant_velocity segment that moves by {value} stands still. "
                "Use a dwell, or give a velocity or lift other than 0.",
                {"value": given[0][2]},
            )
        return self

    @property
    def units(self) -> frozenset[TravelUnit]:
        return frozenset(unit for _, unit, _ in self._given())

    @property
    def law_name(self) -> str:
        return "constant_velocity"

    def gain(self, units: MotionUnits) -> float:
        ((order, _, value),) = self._given()
        return units.to_core(value, order) * (self.degrees * DEGREE) ** order

    def place(
        self,
        index: int,
        start: float,
        angle: float,
        s_start: float,
        units: MotionUnits = CORE_UNITS,
    ) -> PlacedSegment:
        gain = self.gain(units)
        kind: SegmentKind = "rise" if gain > 0.0 else "return"
        return PlacedSegment(index, kind, start, angle, s_start, s_start + gain, LINE)
