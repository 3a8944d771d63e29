"""Segments that follow a table."""

from __future__ import annotations

from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from synthesis.catalogue.motion import FreeLaw, PlacedSegment, TablePoints
from synthesis.numerics.piecewise import Array
from synthesis.spec import tabulated_motion
from synthesis.spec.segment import Part, State, TravelUnit, end_states, one_unit, signed, units_of
from synthesis.units import CORE_UNITS, MotionUnits

JOINS = 2  # derivatives that a smoothed table shares with its neighbours
# Long lists fail fast: thousands of errors help nobody and take long to make.
Column = tuple[float, ...] | None


class Table(Part):
    """The follower runs through a table, smoothed within a tolerance.

    The motion is the spline of least mean square jerk that passes no row by more than the
    tolerance and joins its neighbours with their velocity and acceleration. Only differences of
    the displacements count. A table that moves both ways is held to the pressure-angle limits of
    rises and of returns all along; for either alone, split it where it turns.
    """

    kind: Literal["table"] = "table"
    angle_deg: Annotated[
        float, Field(gt=0.0, le=360.0, description="Cam angle of the segment [deg].")
    ]
    points: Annotated[
        tuple[tuple[float, float], ...] | None,
        Field(
            max_length=tabulated_motion.MOST,
            fail_fast=True,
            description="Rows: cam angle from the segment's start [deg], displacement [mm, or "
            "deg of an arm, as tolerance]. The first row is at 0, the last at angle_deg; on a "
            "whole turn that one may be missing.",
        ),
    ] = None
    angles_deg: Annotated[
        Column,
        Field(
            max_length=tabulated_motion.MOST,
            fail_fast=True,
            description="The first column, instead of points [deg].",
        ),
    ] = None
    displacements_mm: Annotated[
        Column,
        Field(
            max_length=tabulated_motion.MOST,
            fail_fast=True,
            description="The second column, instead of points [mm].",
        ),
    ] = None
    displacements_deg: Annotated[
        Column,
        Field(
            max_length=tabulated_motion.MOST,
            fail_fast=True,
            description="The same of a follower on an arm [deg].",
        ),
    ] = None
    tolerance_mm: Annotated[
        float | None,
        Field(ge=1e-7, le=1e3, description="How far the motion may pass a row [mm]."),
    ] = None
    tolerance_deg: Annotated[
        float | None,
        Field(ge=1e-9, le=10.0, description="The same of a follower on an arm [deg]."),
    ] = None
    lift_mm: Annotated[
        float | None,
        signed(
            "Displacement gained, with its sign [mm], where the table's own is inexact; left "
            "out: last row less first row, on a whole turn 0.",
            1e6,
        ),
    ] = None
    lift_deg: Annotated[float | None, signed("The same of a follower on an arm [deg].", 180.0)] = (
        None
    )
    smoothness: Annotated[
        Literal[2, 3, 4], Field(description="Number of continuous derivatives.")
    ] = 4
    start: State | None = Field(None, description="Velocity and acceleration at its start.")
    end: State | None = Field(None, description="Velocity and acceleration at its end.")

    @property
    def units(self) -> frozenset[TravelUnit]:
        given: dict[TravelUnit, tuple[object, ...]] = {
            "mm": (self.displacements_mm, self.tolerance_mm, self.lift_mm),
            "deg": (self.displacements_deg, self.tolerance_deg, self.lift_deg),
        }
        used = frozenset(u for u, row in given.items() if any(value is not None for value in row))
        return used | units_of(self.start, self.end)

    def with_unit_fields(self) -> Self:
        if self.points is None:
            return self
        angles, displacements = zip(*self.points, strict=True)
        unit = self.tolerance_field.removeprefix("tolerance")
        columns = {"angles_deg": angles, f"displacements{unit}": displacements}
        return self.model_copy(update={"points": None, **columns})

    @property
    def tolerance_field(self) -> str:
        """The field that sets the tolerance."""
        return "tolerance_deg" if self.tolerance_mm is None else "tolerance_mm"

    @property
    def _tolerance(self) -> float:
        given = self.tolerance_deg if self.tolerance_mm is None else self.tolerance_mm
        assert given is not None  # one is, or the segment had been refused
        return given

    @property
    def _table(self) -> tuple[Array, Array, float]:
        """Fractions of the segment, displacement from its start and the lift, in its unit."""
        second = self.displacements_deg if self.displacements_mm is None else self.displacements_mm
        lift = self.lift_deg if self.lift_mm is None else self.lift_mm
        return tabulated_motion.read(self.points, self.angles_deg, second, self.angle_deg, lift)

    @model_validator(mode="after")
    def _makes_sense(self) -> Table:
        one_unit(self.units, "table")
        tabulated_motion.check_tolerance(self.tolerance_mm, self.tolerance_deg)
        s = self._table[1]
        tabulated_motion.check_lift(float(s[-1] - s[0]), self.signed_lift, self._tolerance)
        tabulated_motion.check_range(float(np.ptp(s)), self._tolerance)
        return self

    @property
    def law_name(self) -> str:
        return "table"

    @property
    def signed_lift(self) -> float:
        return self._table[2]

    def span(self, units: MotionUnits) -> tuple[float, float]:
        s = self._table[1]
        ends = (0.0, self.signed_lift)
        return units.to_core(min(s.min(), *ends)), units.to_core(max(s.max(), *ends))

    def place(
        self,
        index: int,
        start: float,
        angle: float,
        s_start: float,
        units: MotionUnits = CORE_UNITS,
    ) -> PlacedSegment:
        x, s, _ = self._table
        unit = units.to_core(1.0)
        given = TablePoints(x, s_start + unit * s, unit * self._tolerance, self.tolerance_field)
        return PlacedSegment(
            index, tabulated_motion.sense(s, self._tolerance), start, angle, s_start,
            s_start + self.gain(units), None,
            FreeLaw(self.smoothness, overshoot=True, end_continuity=(JOINS, JOINS)),
            *end_states(self.start, self.end, units), given,
        )  # fmt: skip
