"""The lowest peak pressure angle on rises and returns."""

from __future__ import annotations

from dataclasses import replace
from math import atan, tan
from typing import ClassVar, Literal

import numpy as np

from synthesis.catalogue.constraints import LinearInequality, Vector
from synthesis.catalogue.followers.base import paths
from synthesis.catalogue.followers.kinematics import pressure_angle_sine_cosine
from synthesis.catalogue.limits.base import Limit, Machine
from synthesis.catalogue.limits.pressure_angle import PressureAngle
from synthesis.catalogue.motion import PlacedSegment
from synthesis.catalogue.objectives.base import Objective
from synthesis.numerics.maxima import maximise_formula
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE


class PeakPressureAngle(Objective):
    """Minimise the largest |α| on rises and returns; the value inside the core is tan |α|.

    A ratio of two linear forms: for a trial slope t the rows ask how far
    |s' − e| − t (s0 + s) exceeds zero, and t is lowered until it no longer can be (Dinkelbach).
    On an arm no fixed row says it: there the limit on the pressure angle is what is searched for.
    """

    kind: Literal["peak_pressure_angle"] = "peak_pressure_angle"
    title: ClassVar[str] = "Peak pressure angle"
    quantity: ClassVar[str] = "pressure_slope"
    wire_name: ClassVar[str] = "peak_pressure_angle_deg"
    quasiconvex: ClassVar[bool] = True

    def rows(
        self, segment: PlacedSegment, machine: Machine, level: float
    ) -> tuple[LinearInequality, ...]:
        if segment.kind == "dwell":
            return ()
        return tuple(
            replace(row, level=-1.0, source=self.kind)
            for path in paths(machine.follower).values()
            for row in path.pressure_angle_rows(level)
        )

    def equivalent_limits(self, value: float, machine: Machine) -> tuple[Limit, ...]:
        if not machine.follower.pressure_angle_constraints(1.0):
            return ()
        most = self.to_wire(value, machine)
        return (PressureAngle(rise_deg=most, return_deg=most),)

    def segment_value(self, segment: PlacedSegment, machine: Machine, size: Vector) -> float:
        if segment.kind == "dwell" or segment.angle <= 0.0:
            return 0.0

        def slope(s: Array) -> Array:
            still = np.zeros_like(s[0])
            parts = (
                pressure_angle_sine_cosine(path, [*s, still], size)
                for path in paths(machine.follower).values()
            )
            with np.errstate(divide="ignore"):
                each = [np.where(n > 0.0, np.abs(g) / n, np.inf) for g, n in parts]
            return np.asarray(np.max(each, axis=0))

        return maximise_formula(segment.placed(), slope, 2)

    def to_wire(self, value: float, machine: Machine) -> float:
        return atan(value) / DEGREE

    def from_wire(self, value: float, machine: Machine) -> float:
        return tan(value * DEGREE)
