"""The lowest peak pressure angle on rises and returns."""

from __future__ import annotations

from dataclasses import replace
from math import atan, tan
from typing import ClassVar, Literal

from synthesis.limits.base import Machine
from synthesis.motion import Stretch
from synthesis.objectives.base import Objective
from synthesis.terms import Row
from synthesis.units import DEGREE


class PeakPressureAngle(Objective):
    """Minimise the largest |α| on rises and returns; the value inside the core is tan |α|.

    A ratio of two linear forms: for a trial slope t the rows ask how far
    |s' − e| − t (s0 + s) exceeds zero, and t is lowered until it no longer can be (Dinkelbach).
    """

    kind: Literal["peak_pressure_angle"] = "peak_pressure_angle"
    title: ClassVar[str] = "Peak pressure angle"
    quantity: ClassVar[str] = "pressure_slope"
    wire_name: ClassVar[str] = "peak_pressure_angle_deg"
    fractional: ClassVar[bool] = True

    def rows(self, stretch: Stretch, machine: Machine, level: float) -> tuple[Row, ...]:
        if stretch.kind == "dwell":
            return ()
        return tuple(
            replace(row, level=-1.0, source=self.kind)
            for path in machine.follower.paths.values()
            for row in path.pressure_angle_rows(level)
        )

    def to_wire(self, value: float, machine: Machine) -> float:
        return atan(value) / DEGREE

    def from_wire(self, value: float, machine: Machine) -> float:
        return tan(value * DEGREE)
