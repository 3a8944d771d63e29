"""Segments that follow a table of displacement over cam angle."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from synthesis.catalogue.motion import FreeLaw, PlacedSegment, SegmentKind, TablePoints
from synthesis.numerics.piecewise import Array
from synthesis.spec.segment import SegmentSpec, State, signed, with_states
from synthesis.units import MotionUnits

FEWEST, MOST = 4, 20_000  # rows
SAME_ANGLE = 1e-9  # deg: where a table begins and ends
WHOLE_TURN = 360.0  # deg
JOINS = 2  # derivatives that a smoothed table shares with its neighbours
# Long lists fail fast: thousands of errors help nobody and take long to make.
Column = Annotated[tuple[float, ...] | None, Field(max_length=MOST, fail_fast=True)]


class Table(SegmentSpec):
    """The follower runs through a table, smoothed within a tolerance.

    The motion is the spline of least mean square jerk that passes no row by more than the
    tolerance and joins its neighbours with their velocity and acceleration. Only differences of
    the displacements count. A table that moves both ways is held to the pressure-angle limits of
    rises and of returns all along; for either alone, split it where it turns.
    """

    kind: Literal["table"] = "table"
    angle_deg: float = Field(gt=0.0, le=360.0, description="Cam angle of the segment [deg].")
    points: tuple[tuple[float, float], ...] | None = Field(
        None,
        max_length=MOST,
        fail_fast=True,
        description="Rows: cam angle from the segment's start [deg], displacement [mm, or "
        "deg of an arm, as tolerance]. The first row is at 0, the last at angle_deg; on a "
        "whole turn that one may be missing.",
    )
    angles_deg: Column = Field(None, description="The first column, instead of points [deg].")
    displacements_mm: Column = Field(None, description="The second column, instead of points [mm].")
    displacements_deg: Column = Field(None, description="The same of a follower on an arm [deg].")
    tolerance_mm: float | None = Field(
        None, ge=1e-7, le=1e3, description="How far the motion may pass a row [mm]."
    )
    tolerance_deg: float | None = Field(
        None, ge=1e-9, le=10.0, description="The same of a follower on an arm [deg]."
    )
    lift_mm: float | None = signed(
        "Displacement gained, with its sign [mm], where the table's own is inexact; left "
        "out: last row less first row, on a whole turn 0.",
        1e6,
    )
    lift_deg: float | None = signed("The same of a follower on an arm [deg].", 180.0)
    smoothness: Literal[2, 3, 4] = Field(4, description="Number of continuous derivatives.")
    start: State | None = Field(None, description="Velocity and acceleration at its start.")
    end: State | None = Field(None, description="Velocity and acceleration at its end.")

    def with_unit_fields(self) -> Self:
        if self.points is None:
            return self
        angles, displacements = zip(*self.points, strict=True)
        unit = self.given_field("tolerance").removeprefix("tolerance")
        columns = {"angles_deg": angles, f"displacements{unit}": displacements}
        return self.model_copy(update={"points": None, **columns})

    @property
    def _table(self) -> tuple[Array, Array, float]:
        """Fractions of the segment, displacement from its start and the lift, in its unit."""
        displacements, lift = self.given("displacements"), self.given("lift")
        return read_table(self.points, self.angles_deg, displacements, self.angle_deg, lift)

    @model_validator(mode="after")
    def _makes_sense(self) -> Table:
        self.check_one_unit("table")
        tolerance = self.given("tolerance")
        if tolerance is None:
            raise PydanticCustomError(
                "table_tolerance",
                "A table needs a tolerance: how far the motion may pass a row. "
                "Give tolerance_mm for a follower that slides, or tolerance_deg for one on an arm.",
            )
        # A lift may differ from the table's own by the tolerance at both ends.
        s = self._table[1]
        own, moved = float(s[-1] - s[0]), float(np.ptp(s))
        error = abs(own - self.signed_lift)
        if error > 2.0 * tolerance:
            raise PydanticCustomError(
                "table_lift",
                "{error} lie between the lift of the table, {lift}, and the one asked for: more "
                "than twice its tolerance. Correct the lift or the table; a table of a whole turn "
                "ends where it begins.",
                {"error": error, "lift": own},
            )
        if moved <= 2.0 * tolerance:
            raise PydanticCustomError(
                "table_still",
                "{range} is all that the table moves, within its tolerance. "
                "Use a dwell, or a smaller tolerance.",
                {"range": moved},
            )
        return self

    @property
    def signed_lift(self) -> float:
        return self._table[2]

    def span(self, units: MotionUnits) -> tuple[float, float]:
        s = self._table[1]
        ends = (0.0, self.signed_lift)
        return units.to_core(min(s.min(), *ends)), units.to_core(max(s.max(), *ends))

    def with_motion(self, placed: PlacedSegment, units: MotionUnits) -> PlacedSegment:
        x, s, _ = self._table
        tolerance, unit = self.given("tolerance"), units.to_core(1.0)
        return replace(
            with_states(placed, self.start, self.end, units),
            kind=sense(s, tolerance),
            free=FreeLaw(self.smoothness, overshoot=True, end_continuity=(JOINS, JOINS)),
            table=TablePoints(
                x, placed.s_start + unit * s, unit * tolerance, self.given_field("tolerance")
            ),
        )


@lru_cache(maxsize=64)
def read_table(
    points: tuple[tuple[float, float], ...] | None,
    angles: tuple[float, ...] | None,
    displacements: tuple[float, ...] | None,
    angle: float,
    lift: float | None,
) -> tuple[Array, Array, float]:
    """Where the rows are, as fractions of the segment, what they say, and the lift: (m,), (m,).

    Displacement counts from the segment's start, so that the first and the last row miss its two
    ends by the same amount. A lift that is not given is last row less first row, on a whole turn 0.
    """
    degrees, s = columns(points, angles, displacements)
    check_angles(degrees, angle)
    if angle - degrees[-1] > SAME_ANGLE:  # a whole turn whose last row is missing: it is the first
        degrees, s = np.append(degrees, angle), np.append(s, s[0])
    own = 0.0 if angle >= WHOLE_TURN else float(s[-1] - s[0])
    gained = own if lift is None else lift
    return degrees / degrees[-1], s - (s[0] + s[-1] - gained) / 2.0, gained


def columns(
    points: Sequence[tuple[float, float]] | None,
    angles: Sequence[float] | None,
    displacements: Sequence[float] | None,
) -> tuple[Array, Array]:
    """The two columns [deg, mm], from rows or from columns of equal length: one is given."""
    by_rows, by_columns = points is not None, angles is not None or displacements is not None
    if by_rows == by_columns or (angles is None) != (displacements is None):
        raise PydanticCustomError(
            "table_columns",
            "A table is given once: as points, or as angles_deg with displacements_mm (on an arm "
            "displacements_deg). "
            "Give one of the two.",
        )
    if points is not None:
        table = np.array(points, dtype=float).reshape(-1, 2)
        return table[:, 0], table[:, 1]
    one, other = np.array(angles, dtype=float), np.array(displacements, dtype=float)
    if len(one) != len(other):
        raise PydanticCustomError(
            "table_columns",
            "{angles} angles_deg stand beside {displacements} displacements. "
            "Give as many of one as of the other.",
            {"angles": len(one), "displacements": len(other)},
        )
    return one, other


def check_angles(degrees: Array, angle: float) -> None:
    """Angles must increase, and span the segment; the first row that breaks the rule is named."""
    if not FEWEST <= len(degrees) <= MOST:
        raise PydanticCustomError(
            "table_size",
            "A table of {count} rows cannot be read: it takes {fewest} to {most}. "
            "Give more rows, or a named law; or leave some out.",
            {"count": len(degrees), "fewest": FEWEST, "most": MOST},
        )
    for row in np.flatnonzero(np.diff(degrees) <= 0.0)[:1] + 1:
        again = degrees[row] == degrees[row - 1]
        raise PydanticCustomError(
            "table_order",
            "{angle}° in row {row} does not come after the {before}° of the row before. {remedy}",
            {"angle": float(degrees[row]), "row": int(row), "before": float(degrees[row - 1]),
             "remedy": "Remove one of the two rows." if again else "Sort the rows by angle."},
        )  # fmt: skip
    outside = (degrees < -SAME_ANGLE) | (degrees > angle + SAME_ANGLE)
    for row in np.flatnonzero(outside)[:1]:
        raise PydanticCustomError(
            "table_outside",
            "{angle}° in row {row} lies outside the segment, which runs from 0° to {end}°. "
            "Count angles from the segment's start, or remove the row.",
            {"angle": float(degrees[row]), "row": int(row), "end": angle},
        )
    last = angle if angle < WHOLE_TURN - SAME_ANGLE else float(degrees[-1])
    for row, end in ((0, 0.0), (len(degrees) - 1, last)):
        if abs(degrees[row] - end) > SAME_ANGLE:
            raise PydanticCustomError(
                "table_ends",
                "{angle}° in row {row} should be {end}°: a table begins at 0° and ends at its "
                "angle_deg. Add a row there (on a whole turn the last one may be missing).",
                {"angle": float(degrees[row]), "row": row, "end": end},
            )


def sense(displacements: Array, tolerance: float) -> SegmentKind:
    """Whether a table rises, returns or stands still but for its tolerance; or turns back."""
    rising = np.max(np.maximum.accumulate(displacements) - displacements) <= 2.0 * tolerance
    falling = np.max(displacements - np.minimum.accumulate(displacements)) <= 2.0 * tolerance
    if rising and falling:
        return "dwell"
    return "rise" if rising else "return" if falling else "table"
