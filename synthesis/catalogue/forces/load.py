"""The load as the wire gives it: on a slide in kg and N, on an arm in kg m² and N m."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Literal, Self

from pydantic import Field, field_validator, model_validator
from pydantic_core import PydanticCustomError

from synthesis.catalogue.fields import FiniteModel
from synthesis.catalogue.followers import Follower
from synthesis.catalogue.forces.friction import AnyFriction, FrictionModel
from synthesis.catalogue.forces.load_parts import (
    ArmSpring,
    Contact,
    ForcePoint,
    MomentPoint,
    Point,
    ProcessPoint,
    RollerBearing,
    SlideSpring,
    Spring,
    check_order,
    force_course,
)
from synthesis.catalogue.forces.reduced import MILLI, ReducedLoad
from synthesis.catalogue.motion import PlacedSegment
from synthesis.units import DEGREE, rad_per_s

GRAVITY = 9.80665  # m/s²
MOST_POINTS = 2000  # of a process force: more takes long and is measured noise
PROCESS = (
    "Force of the task over the cam angle: points joined by straight lines, round the turn; two at "
    "the same angle make a jump, a single one is constant."
)


class SpeedRange(FiniteModel):
    """Cam speeds between two ends."""

    min_rpm: float = Field(ge=0.0, le=1e9, description="Lowest cam speed.")
    max_rpm: float = Field(gt=0.0, le=1e9, description="Highest cam speed.")

    @model_validator(mode="after")
    def _ordered(self) -> SpeedRange:
        if self.min_rpm > self.max_rpm:
            raise PydanticCustomError(
                "speeds_crossed",
                "min_rpm = {low} is above max_rpm = {high}. Exchange the two.",
                {"low": self.min_rpm, "high": self.max_rpm},
            )
        return self


@dataclass(frozen=True)
class WireLoad:
    """A load in the units of the wire: of a slide N, kg and m, of an arm N m, kg m² and rad.

    Attributes:
        points: cam angle [deg] and process force or moment.
        metre: metres or radians in a unit of the displacement, which is mm or rad.
        lever: what a force in N times a lever in the unit of displacement comes to: 1, or 1e-3.
    """

    mass: float
    damping: float
    rate: float
    preload: float
    weight: float
    points: tuple[Point, ...]
    metre: float
    lever: float


class Load(FiniteModel, ABC):
    """What loads a follower, and what its contact is made of; only what is given is modelled."""

    kind: str
    title: ClassVar[str]
    unit: ClassVar[str]  # of the displacement of followers that it suits

    speeds: SpeedRange | None = Field(
        None, description="Speeds at which the follower must not float; left out, the cam's."
    )
    contact: Contact | None = Field(
        None, description="Line contact; needed for the Hertz pressure."
    )
    bearing: RollerBearing | None = Field(None, description="The roller's bearing, for its life.")

    if TYPE_CHECKING:  # declared by the kinds of load, at their places among the fields of the wire
        spring: Spring | None
        process: Sequence[ProcessPoint]
        friction: FrictionModel | None

    @field_validator("process", check_fields=False)
    @classmethod
    def _in_order(cls, points: list[ProcessPoint]) -> list[ProcessPoint]:
        check_order(points)
        return points

    @property
    @abstractmethod
    def wire_values(self) -> WireLoad:
        """Its numbers as they are on the wire; what is free of the spring, at its least."""

    def _wire_load(
        self, mass: float, damping: float, weight: float, metre: float, lever: float
    ) -> WireLoad:
        none = ((0.0, 0.0), (0.0, 0.0))
        (rate, _), (preload, _) = none if self.spring is None else self.spring.ranges
        points = tuple(point.as_pair for point in self.process)
        return WireLoad(mass, damping, rate, preload, weight, points, metre, lever)

    @property
    def free_spring(self) -> dict[str, tuple[float, float]]:
        """What of the spring is to be chosen: field, and the ends between which it lies."""
        if self.spring is None:
            return {}
        both = zip(self.spring.requested, self.spring.ranges, strict=True)
        return {name: (low, high) for name, (low, high) in both if low != high}

    def with_spring(self, numbers: dict[str, float]) -> Self:
        """The same with numbers for what of the spring was left free, by field."""
        if self.spring is None or not numbers:
            return self
        return self.model_copy(update={"spring": self.spring.model_copy(update=numbers)})

    def reduced(self, follower: Follower, omega: float) -> ReducedLoad:
        """The load along the follower's displacement; what is free of the spring, at its least."""
        given, both_ways = self.wire_values, self.pushed_both_ways(follower)
        # s is in mm, or the arc lφ in mm of an arm: a moment in N m is 1000/l N along it
        length = follower.travel.per_unit / (1.0 if given.lever == 1.0 else DEGREE)
        force = 1.0 / (given.lever * length)
        speeds = (omega, omega)
        if self.speeds is not None:
            speeds = rad_per_s(self.speeds.min_rpm), rad_per_s(self.speeds.max_rpm)
        return ReducedLoad(
            mass=given.mass * force * given.metre / (MILLI * length),
            damping=given.damping * force * given.metre / (MILLI * length),
            rate=given.rate * force / length,
            preload=given.preload * force,
            weight=given.weight * force,
            process=force_course(given.points, force),
            side=1 if both_ways else follower.without_free_counter().flanks[0].side,
            friction=self.friction,
            contact=self.contact,
            bearing=self.bearing,
            speeds=speeds,
            pushed_both_ways=both_ways,
        )

    @staticmethod
    def pushed_both_ways(follower: Follower) -> bool:
        """Whether the cam pushes the follower inwards as well as outwards."""
        both = follower.closure.counter_paths
        return bool(both) or len(follower.without_free_counter().flanks) > 1

    def check_against(self, follower: Follower, segments: Sequence[PlacedSegment]) -> None:
        """Refuse a load of another kind of follower, or that does not press it on its cam."""
        if follower.travel.unit != self.unit:
            raise PydanticCustomError(
                "load_does_not_suit",
                "load is {title}, but the {kind} follower {move}. Give a load of kind {other}.",
                {"title": self.title.lower(), "kind": follower.kind,
                 "move": {"mm": "slides", "deg": "swings"}[follower.travel.unit],
                 "other": {"mm": "slide", "deg": "arm"}[follower.travel.unit]},
            )  # fmt: skip
        reduced = self.reduced(follower, 1.0)
        process, breaks = reduced.process, reduced.process.breaks
        most = max(reduced.side * p for p in (*process(breaks), *process(breaks, 0, "left")))
        pressed = most + reduced.side * reduced.weight > 0.0 or reduced.preload or reduced.rate
        if not (pressed or self.free_spring or reduced.pushed_both_ways):
            raise PydanticCustomError(
                "nothing_presses_follower",
                "Nothing presses the {kind} follower on its cam: neither a spring, nor its weight, "
                "nor a process force; it would float. Give load/spring, or choose a closure that "
                "pushes both ways, such as a groove.",
                {"kind": follower.kind},
            )


class SlideLoad(Load):
    """The load of a follower on a slide."""

    kind: Literal["slide"] = "slide"
    title: ClassVar[str] = "Load of a follower on a slide"
    unit: ClassVar[str] = "mm"

    moving_mass_kg: float = Field(
        0.0, ge=0.0, le=1e9, description="Mass that moves with the follower."
    )
    damping_n_s_per_m: float = Field(0.0, ge=0.0, le=1e12, description="Viscous damping.")
    spring: SlideSpring | None = Field(None, description="Spring that presses it on the cam.")
    rise_from_vertical_deg: float | None = Field(
        None,
        ge=0.0,
        le=180.0,
        description="Angle between the follower's rise and upwards: 0 where it is lifted "
        "against its weight, 180 where it hangs. Left out, no weight counts.",
    )
    process: list[ForcePoint] = Field(
        [], max_length=MOST_POINTS, fail_fast=True, description=PROCESS
    )
    friction: AnyFriction | None = Field(
        None, description="Friction in the guide; of a roller, force-closed."
    )

    @property
    def wire_values(self) -> WireLoad:
        tilt, mass = self.rise_from_vertical_deg, self.moving_mass_kg
        weight = 0.0 if tilt is None else mass * GRAVITY * math.cos(tilt * DEGREE)
        return self._wire_load(mass, self.damping_n_s_per_m, weight, 1e-3, 1.0)

    def check_against(self, follower: Follower, segments: Sequence[PlacedSegment]) -> None:
        super().check_against(follower, segments)
        if self.friction is None:
            return
        guided = not follower.always_convex and follower.travel.unit == "mm"
        if not guided or self.pushed_both_ways(follower):
            raise PydanticCustomError(
                "friction_does_not_suit",
                "load/friction is of the guide of a force-closed roller on a slide, which this "
                "{kind} follower is not. Leave it out.",
                {"kind": follower.kind},
            )
        for segment in segments:
            if segment.kind == "table" or segment.may_overshoot:
                raise PydanticCustomError(
                    "friction_needs_sense",
                    "load/friction acts against the motion, and program/{segment} may move both "
                    "ways. Leave friction out, or make it a rise or a return without overshoot.",
                    {"segment": segment.index},
                )
        self.friction.check(max(segment.max_displacement for segment in segments))


class ArmLoad(Load):
    """The load of a follower on an arm, about its pivot."""

    kind: Literal["arm"] = "arm"
    title: ClassVar[str] = "Load of a follower on an arm"
    unit: ClassVar[str] = "deg"
    friction: ClassVar[FrictionModel | None] = None  # type: ignore[misc]

    moment_of_inertia_kg_m2: float = Field(
        0.0, ge=0.0, le=1e12, description="Of all that swings, about the pivot."
    )
    damping_n_m_s_per_rad: float = Field(
        0.0, ge=0.0, le=1e12, description="Viscous damping about the pivot."
    )
    spring: ArmSpring | None = Field(None, description="Spring that turns it against the cam.")
    process: list[MomentPoint] = Field(
        [], max_length=MOST_POINTS, fail_fast=True, description=PROCESS.replace("Force", "Moment")
    )

    @property
    def wire_values(self) -> WireLoad:
        inertia, damping = self.moment_of_inertia_kg_m2, self.damping_n_m_s_per_rad
        return self._wire_load(inertia, damping, 0.0, 1.0, 1e-3)
