"""Two cams on one shaft, each with a roller on the same slide: what one lifts, the other lowers."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from synthesis.followers.closures.base import Closure
from synthesis.followers.closures.counter_slide import CounterSlide
from synthesis.followers.closures.force import Force
from synthesis.followers.flank import Flank, Trace
from synthesis.motion import Motion
from synthesis.ranges import Dimension, Range, ends


class ConjugateSlide(Closure):
    """A second roller on the same slide, beyond the cam's axis, on a counter cam of its own.

    Its centre stays ``distance_mm`` below the main roller's, along the slide. The further away,
    the larger the counter cam, the smaller its pressure angle and the gentler its curvature: left
    free, the distance is the smallest at which the counter cam keeps every limit.
    """

    kind: Literal["conjugate"] = "conjugate"
    title: ClassVar[str] = "Main and counter cam, two rollers on one slide"
    companions: ClassVar[tuple[str, ...]] = ("counter",)
    roller_radius_mm: Annotated[
        float, Field(ge=0.0, le=1e6, description="Radius of the counter cam's roller.")
    ]
    offset_mm: Annotated[
        float,
        Field(
            ge=-1e6,
            le=1e6,
            description="Offset of the counter roller, on the same side as the follower's.",
        ),
    ] = 0.0
    distance_mm: Dimension = None

    @property
    def counter(self) -> CounterSlide:
        """The counter roller; its distance must be a number."""
        low, high = ends(self.distance_mm)
        if low != high:
            raise ValueError("the distance of the counter roller is still free")
        return CounterSlide(self.offset_mm, low)

    def flanks(self, trace: Trace, roller_radius: float) -> tuple[Flank, ...]:
        return (
            Flank("main", 1, roller_radius, "main", trace),
            Flank("counter", 1, self.roller_radius_mm, "counter", self.counter),
        )

    def companion_ranges(self) -> Mapping[str, tuple[str, float | Range | None]]:
        return {"closure/distance_mm": ("counter_distance_mm", self.distance_mm)}

    def alone(self) -> Closure:
        low, high = ends(self.distance_mm)
        return self if low == high else Force()

    def companion(self, values: Mapping[str, float]) -> Closure:
        return CounterAlone(pair=self.completed(values))

    def completed(self, values: Mapping[str, float]) -> ConjugateSlide:
        return self.model_copy(update={"distance_mm": values["counter_distance_mm"]})

    def dimensions(self, roller_radius: float) -> Mapping[str, float]:
        return {
            "counter_distance_mm": self.counter.distance,
            "counter_offset_mm": self.offset_mm,
            "counter_roller_radius_mm": self.roller_radius_mm,
        }

    def motion_dimensions(self, motion: Motion, z: tuple[float, ...]) -> Mapping[str, float]:
        highest = max(max(s.s_start, s.s_end) for s in motion.stretches)
        (x, y), *_ = self.counter.traced_point((highest, 0.0, 0.0, 0.0), z)
        prime = math.hypot(x, y)
        return {
            "counter_prime_radius_mm": prime,
            "counter_base_radius_mm": prime - self.roller_radius_mm,
        }


class CounterAlone(Closure):
    """The counter cam of a pair, looked at by itself."""

    kind: Literal["counter_alone"] = "counter_alone"
    title: ClassVar[str] = "Counter cam alone"
    companions: ClassVar[tuple[str, ...]] = ("counter",)
    pair: ConjugateSlide

    def flanks(self, trace: Trace, roller_radius: float) -> tuple[Flank, ...]:
        return self.pair.flanks(trace, roller_radius)[1:]
