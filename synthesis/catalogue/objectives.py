"""Objectives: what is minimised. A new one is a class here and its name in ``AnyObjective``.

An objective states its value as a norm of the size, as linear inequalities with the epigraph
variable P, or as the mean square of a derivative; and how the value reads on the wire. The
conformance tests ask for a scene in which its proven bound is near its value.
"""

from __future__ import annotations

from abc import ABC
from dataclasses import replace
from math import atan, tan
from typing import Annotated, ClassVar, Literal, get_args

import numpy as np
from pydantic import Field
from pydantic_core import PydanticCustomError

from synthesis.catalogue.constraints import AffineNorm, LinearInequality, Vector, derivative
from synthesis.catalogue.fields import FiniteModel
from synthesis.catalogue.followers.base import base_gap, paths
from synthesis.catalogue.followers.kinematics import pressure_angle_sine_cosine
from synthesis.catalogue.limits.base import Limit, Machine
from synthesis.catalogue.limits.pressure_angle import PressureAngle
from synthesis.catalogue.motion import PlacedSegment, Segments
from synthesis.numerics.maxima import maximise_formula
from synthesis.numerics.piecewise import Array
from synthesis.units import DEGREE

MOST_ALLOWED = 9.0  # of the least value: ten times as much; more is no objective any longer


class Objective(FiniteModel, ABC):
    """One quantity to minimise, as ``norm``, ``energy_order`` or ``rows``; the others are empty.

    Attributes:
        title: for people.
        quantity: what ``certify`` measures, in core units (mm, per radian, tan α).
        wire_name: name of its value on the wire, with the unit; see ``name_on_wire``.
        quasiconvex: its rows hold for one trial ``level`` at a time (quasi-convex).
    """

    kind: str
    allowance: float | None = Field(
        None,
        gt=0.0,
        le=MOST_ALLOWED,
        description="In a list: what later objectives may add to the least possible value of this "
        "one, as a share of it (0.25: a quarter). Left out: half of the tolerance.",
    )
    title: ClassVar[str]
    quantity: ClassVar[str]
    wire_name: ClassVar[str]
    quasiconvex: ClassVar[bool] = False

    def allowed_gap(self, tolerance: float) -> float:
        """The gap (value − bound)/value that is good enough: the tolerance, or the allowance."""
        share = 0.0 if self.allowance is None else self.allowance / (1.0 + self.allowance)
        return max(tolerance, share)

    def check(self, segments: Segments, machine: Machine, position: int) -> None:
        """Refuse an objective about forces for which the load is missing or incomplete."""
        return None

    def norm(self, machine: Machine) -> AffineNorm | None:
        """The value as a norm of the size variables."""
        return None

    def energy_order(self) -> int | None:
        """k where the value is the rms over the turn of the k-th derivative."""
        return None

    def rows(
        self, segment: PlacedSegment, machine: Machine, level: float
    ) -> tuple[LinearInequality, ...]:
        """Rows in which P is an upper bound of the value.

        Where ``quasiconvex`` they bound by P how much a trial ``level`` is exceeded.
        """
        return ()

    def equivalent_limits(self, value: float, machine: Machine) -> tuple[Limit, ...]:
        """Limits that bound the value [core units], where no rows or norms do; () otherwise."""
        return ()

    def segment_value(self, segment: PlacedSegment, machine: Machine, size: Vector) -> float:
        """The value on one segment with a known law, where ``equivalent_limits`` state it."""
        raise NotImplementedError(f"{self.kind} is not measured segment by segment")

    def name_on_wire(self, machine: Machine) -> str:
        """Name of its value on the wire, with the unit that such a follower has."""
        return self.wire_name

    def wire_factor(self, machine: Machine) -> float:
        """The wire's unit, where the value there is a multiple of that in core units."""
        raise NotImplementedError(f"{self.kind} is no multiple of its value on the wire")

    def to_wire(self, value: float, machine: Machine) -> float:
        """The value in the wire's unit; monotone, so that it carries bounds as well."""
        return value * self.wire_factor(machine)

    def from_wire(self, value: float, machine: Machine) -> float:
        """The inverse of ``to_wire``."""
        return value / self.wire_factor(machine)


class BaseRadius(Objective):
    """Minimise Rb: the prime radius less Rr, plus Rr where the roller runs in a ring."""

    kind: Literal["base_radius"] = "base_radius"
    title: ClassVar[str] = "Base radius"
    quantity: ClassVar[str] = "prime_radius"
    wire_name: ClassVar[str] = "base_radius_mm"

    def norm(self, machine: Machine) -> AffineNorm:
        return machine.follower.radius_norm()

    def to_wire(self, value: float, machine: Machine) -> float:
        return machine.follower.radius_from_norm(value) - base_gap(machine.follower)

    def from_wire(self, value: float, machine: Machine) -> float:
        return machine.follower.norm_from_radius(value + base_gap(machine.follower))


class DerivativeObjective(Objective, ABC):
    """A value of s^(order) per radian; on the wire times ω^order."""

    order: ClassVar[int]

    def name_on_wire(self, machine: Machine) -> str:
        return f"{self.kind}_{machine.follower.travel.field_suffix(self.order)}"

    def wire_factor(self, machine: Machine) -> float:
        return machine.wire_factor(self.order)


class PeakDerivative(DerivativeObjective, ABC):
    """The largest |s^(order)| over the turn: |s^(order)| ≤ P at every cam angle."""

    def rows(
        self, segment: PlacedSegment, machine: Machine, level: float
    ) -> tuple[LinearInequality, ...]:
        return tuple(
            LinearInequality(derivative(self.order, sign), (), 0.0, level=-1.0, source=self.kind)
            for sign in (1.0, -1.0)
        )


class PeakAcceleration(PeakDerivative):
    """Minimise the largest |a| over the turn."""

    kind: Literal["peak_acceleration"] = "peak_acceleration"
    title: ClassVar[str] = "Peak acceleration"
    quantity: ClassVar[str] = "acceleration"
    order: ClassVar[int] = 2


class PeakJerk(PeakDerivative):
    """Minimise the largest |j| over the turn."""

    kind: Literal["peak_jerk"] = "peak_jerk"
    title: ClassVar[str] = "Peak jerk"
    quantity: ClassVar[str] = "jerk"
    order: ClassVar[int] = 3


class RmsDerivative(DerivativeObjective, ABC):
    """√(1/2π ∫ (s^(order))² dθ) over the turn."""

    def energy_order(self) -> int:
        return self.order


class RmsAcceleration(RmsDerivative):
    """Minimise √(1/2π ∫ a² dθ) over the whole turn."""

    kind: Literal["rms_acceleration"] = "rms_acceleration"
    title: ClassVar[str] = "Rms acceleration"
    quantity: ClassVar[str] = "rms_acceleration"
    order: ClassVar[int] = 2


class RmsJerk(RmsDerivative):
    """Minimise √(1/2π ∫ j² dθ) over the whole turn."""

    kind: Literal["rms_jerk"] = "rms_jerk"
    title: ClassVar[str] = "Rms jerk"
    quantity: ClassVar[str] = "rms_jerk"
    order: ClassVar[int] = 3


class PeakDriveForce(Objective):
    """Minimise the largest drive G over the turn; pushed both ways, the largest |G|.

    G = m s'' ω² + c s' ω + k s + F0 + P + W is linear in the law, so the least peak is found and
    bounded like that of the acceleration. Under an upright flat face it is the contact force;
    elsewhere N = G / cos α lies above it.
    """

    kind: Literal["peak_drive_force"] = "peak_drive_force"
    title: ClassVar[str] = "Peak force along the motion"
    quantity: ClassVar[str] = "drive_force"
    wire_name: ClassVar[str] = "peak_drive_force_n"

    def check(self, segments: Segments, machine: Machine, position: int) -> None:
        if machine.load is None:
            raise PydanticCustomError(
                "objective_needs_load",
                "peak_drive_force is to be small, but the spec gives no load on the follower. "
                "Give load, or choose another objective.",
            )
        for segment in segments:
            low, high = machine.load.process_range(segment)
            if segment.kind != "dwell" and segment.angle > 0.0 and low != high:
                raise PydanticCustomError(
                    "process_not_steady",
                    "peak_drive_force can be made small where the process force does not change "
                    "along a rise or return, and along program/{segment} it does. Give it the same "
                    "value at both ends of the segment (two points at one angle make a jump), or "
                    "limit contact_force and make something else small.",
                    {"segment": segment.index},
                )

    def rows(
        self, segment: PlacedSegment, machine: Machine, level: float
    ) -> tuple[LinearInequality, ...]:
        load, found = machine.load, list[LinearInequality]()
        assert load is not None
        for side in (1, -1) if load.pushed_both_ways else (load.side,):
            process = max(side * end for end in load.process_range(segment))
            drive = tuple(side * c for c in load.coefficients(machine.omega))
            upper = -(side * load.constant_force + process)
            found.append(LinearInequality(drive, (), upper, -1.0, self.kind))
        return tuple(found)

    def name_on_wire(self, machine: Machine) -> str:
        return self.wire_name if machine.follower.travel.unit == "mm" else "peak_drive_moment_n_m"

    def wire_factor(self, machine: Machine) -> float:
        """N m of a newton along the arc of an arm; 1 on a slide."""
        travel = machine.follower.travel
        return 1.0 if travel.unit == "mm" else 1e-3 * travel.per_unit / DEGREE


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
            rates, traced = [*s, np.zeros_like(s[0])], paths(machine.follower).values()
            parts = (pressure_angle_sine_cosine(path, rates, size) for path in traced)
            with np.errstate(divide="ignore"):
                each = [np.where(n > 0.0, np.abs(g) / n, np.inf) for g, n in parts]
            return np.asarray(np.max(each, axis=0))

        return maximise_formula(segment.placed(), slope, 2)[0]

    def to_wire(self, value: float, machine: Machine) -> float:
        return atan(value) / DEGREE

    def from_wire(self, value: float, machine: Machine) -> float:
        return tan(value * DEGREE)


AnyObjective = Annotated[
    BaseRadius
    | PeakAcceleration
    | PeakJerk
    | RmsAcceleration
    | RmsJerk
    | PeakPressureAngle
    | PeakDriveForce,
    Field(discriminator="kind"),
]

SMALL_AND_SMOOTH: tuple[AnyObjective, ...] = (RmsJerk(allowance=0.25), BaseRadius())
"""What is assumed where a spec says nothing of acceleration or jerk.

The smallest cam alone is rough without end: its law bends ever more sharply. The least rms jerk
alone does not care for the size. With a quarter more than that, peaks of acceleration and jerk are
some 20 % above those of a modified sine, and the base radius is a quarter smaller than with it.
"""

OBJECTIVES: tuple[type[Objective], ...] = get_args(get_args(AnyObjective)[0])
"""The same as a tuple, in that order."""
