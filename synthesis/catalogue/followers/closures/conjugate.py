"""Two cams on one shaft, each with a roller on the same follower: what one lifts, one lowers."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field

from synthesis.catalogue.followers.closures.base import Closure
from synthesis.catalogue.followers.closures.counter_slide import CounterSlide
from synthesis.catalogue.followers.closures.force import Force
from synthesis.catalogue.followers.flank import CounterRollerRange, Flank
from synthesis.catalogue.followers.kinematics import ArmPoint, TracePoint, Vector2
from synthesis.catalogue.followers.link import Tip
from synthesis.catalogue.motion import Motion
from synthesis.catalogue.ranges import Dimension, Range, ends
from synthesis.units import DEGREE

FARTHEST = 1e4  # strokes: upper end of the search for the distance; no machine is so long
CounterRoller = Annotated[
    float, Field(ge=0.0, le=1e6, description="Radius of the counter cam's roller.")
]


class Conjugate(Closure, ABC):
    """A second roller beyond the cam's axis, on a counter cam of its own, rigidly connected.

    The farther away it is, the larger the counter cam, the smaller its pressure angle and the
    gentler its curvature: left free, its place is the nearest at which the counter cam keeps
    every limit.
    """

    kind: Literal["conjugate"] = "conjugate"
    counter_paths: ClassVar[tuple[str, ...]] = ("counter",)
    field: ClassVar[str]  # of its place
    dimension: ClassVar[str]  # the same among the dimensions
    roller_radius_mm: CounterRoller

    @property
    @abstractmethod
    def place(self) -> float | Range | None:
        """Its place, as far as it is given."""

    @abstractmethod
    def counter(self, trace: TracePoint) -> TracePoint:
        """The counter roller beside the main one; its place must be a number."""

    @property
    @abstractmethod
    def further_dimensions(self) -> Mapping[str, float]:
        """Its dimensions besides roller and place."""

    @property
    def given(self) -> float:
        """Its place where it is a number."""
        low, high = ends(self.place)
        if low != high:
            raise ValueError("the place of the counter roller is still free")
        return low

    def flanks(self, trace: TracePoint, roller_radius: float) -> tuple[Flank, ...]:
        return (
            Flank("main", 1, roller_radius, "main", trace),
            Flank("counter", 1, self.roller_radius_mm, "counter", self.counter(trace)),
        )

    def counter_dimensions(self) -> Mapping[str, tuple[str, float | Range | None]]:
        return {f"closure/{self.field}": (self.dimension, self.place)}

    def with_free_counter(self) -> Closure:
        return self.model_copy(update={self.field: None})

    def without_free_counter(self) -> Closure:
        low, high = ends(self.place)
        return self if low == high else Force()

    def counter_only(self, values: Mapping[str, float]) -> Closure:
        return CounterCamOnly(pair=self.with_counter(values))

    def with_counter(self, values: Mapping[str, float]) -> Self:
        return self.model_copy(update={self.field: values[self.dimension]})

    def dimensions(self, roller_radius: float) -> Mapping[str, float]:
        return {
            self.dimension: self.given,
            "counter_roller_radius_mm": self.roller_radius_mm,
            **self.further_dimensions,
        }

    def motion_dimensions(
        self, trace: TracePoint, motion: Motion, z: tuple[float, ...]
    ) -> Mapping[str, float]:
        highest = max(max(s.s_start, s.s_end) for s in motion.segments)
        (x, y), *_ = self.counter(trace).position((highest, 0.0, 0.0, 0.0), z)
        prime = math.hypot(x, y)
        return {
            "counter_prime_radius_mm": prime,
            "counter_base_radius_mm": prime - self.roller_radius_mm,
        }


class ConjugateSlide(Conjugate):
    """Main and counter cam, two rollers on one slide, the second beyond the cam's axis."""

    title: ClassVar[str] = "Main and counter cam, two rollers on one slide"
    field: ClassVar[str] = "distance_mm"
    dimension: ClassVar[str] = "counter_distance_mm"
    offset_mm: Annotated[
        float,
        Field(
            ge=-1e6,
            le=1e6,
            description="Offset of the counter roller, to the same side as the follower's.",
        ),
    ] = 0.0
    distance_mm: Dimension = None

    @property
    def place(self) -> float | Range | None:
        return self.distance_mm

    def counter(self, trace: TracePoint) -> TracePoint:
        return CounterSlide(self.offset_mm, self.given)

    def contact_points(
        self, at: Vector2, pivot: Vector2 | None, turn: int, degree: Any
    ) -> tuple[Tip, ...]:
        below = at[1] - self.given
        return Tip("main", at), Tip("counter", (self.offset_mm + 0.0 * below, below), -1)

    def counter_range(
        self, trace: TracePoint, z: tuple[float, ...], s_max: float
    ) -> CounterRollerRange:
        (_, height), *_ = trace.position((s_max, 0.0, 0.0, 0.0), z)
        return CounterRollerRange(float(height), float(height) + FARTHEST * s_max, True)

    @property
    def further_dimensions(self) -> Mapping[str, float]:
        return {"counter_offset_mm": self.offset_mm}


class ConjugateArm(Conjugate):
    """Main and counter cam, two arms at one pivot, which take the shaft between them."""

    title: ClassVar[str] = "Main and counter cam, two arms at one pivot"
    field: ClassVar[str] = "angle_deg"
    dimension: ClassVar[str] = "counter_angle_deg"
    arm_mm: Annotated[float, Field(gt=0.0, le=1e6, description="Length of the counter arm.")]
    angle_deg: Annotated[
        float | Range | None,
        Field(
            description="Angle between the two arms, the cam's axis inside. A number fixes it; "
            "{min, max} leaves it free in between; left out, it is the least that works."
        ),
    ] = None

    @property
    def place(self) -> float | Range | None:
        return self.angle_deg

    def counter(self, trace: TracePoint) -> TracePoint:
        assert isinstance(trace, ArmPoint)
        return trace.second_arm(self.arm_mm, self.given * DEGREE)

    def contact_points(
        self, at: Vector2, pivot: Vector2 | None, turn: int, degree: Any
    ) -> tuple[Tip, ...]:
        # the main arm turned back over the line to the axis, by the angle between the two
        assert pivot is not None
        x, y, angle = at[0] - pivot[0], at[1] - pivot[1], self.given * degree
        ratio = self.arm_mm / (x * x + y * y) ** 0.5
        cos, sin = ratio * np.cos(angle), -turn * ratio * np.sin(angle)
        there = pivot[0] + cos * x - sin * y, pivot[1] + sin * x + cos * y
        return Tip("main", at), Tip("counter", there, -1)

    def counter_range(
        self, trace: TracePoint, z: tuple[float, ...], s_max: float
    ) -> CounterRollerRange:
        assert isinstance(trace, ArmPoint)
        return CounterRollerRange(trace.arm_angle(s_max, z) / DEGREE, 180.0, False)

    @property
    def further_dimensions(self) -> Mapping[str, float]:
        return {"counter_arm_mm": self.arm_mm}


class CounterCamOnly(Closure):
    """The counter cam of a pair, looked at by itself."""

    kind: Literal["counter_alone"] = "counter_alone"
    title: ClassVar[str] = "Counter cam alone"
    counter_paths: ClassVar[tuple[str, ...]] = ("counter",)
    pair: Conjugate

    def flanks(self, trace: TracePoint, roller_radius: float) -> tuple[Flank, ...]:
        return self.pair.flanks(trace, roller_radius)[1:]

    def contact_points(
        self, at: Vector2, pivot: Vector2 | None, turn: int, degree: Any
    ) -> tuple[Tip, ...]:
        return self.pair.contact_points(at, pivot, turn, degree)[1:]
