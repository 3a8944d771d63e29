"""Conjugate cams: two cams on one shaft, each with a roller on the same follower.

What one cam lifts, the other lowers. Seen from the counter cam, the counter roller is a follower
of the main one's family, at another size and moving the other way (``CounterRoller``). On a slide,
with L its distance below the main roller and e2 its offset, the machine is turned upside down:

    s2 = −s,  offset −e2,  height L − s0

On an arm, with l2 the second arm, γ the fixed angle between the two, l and ψ those of the main arm,
the second arm lies beyond the line to the axis at ψ2 = γ − ψ, and swings in the other sense:

    s2 = −(l2/l) s,  ψ0 of the second arm γ − ψ0
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, replace
from operator import add, mul
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field

from synthesis.catalogue.box_bounds import BoxBounds
from synthesis.catalogue.constraints import AffineNorm, Ends, LinearInequality, PressureTerm, Vector
from synthesis.catalogue.fields import Dimension, Number, Range, ends
from synthesis.catalogue.followers.arm_curvature import ArmCurvatureBound
from synthesis.catalogue.followers.closures import Closure, Force, Groove
from synthesis.catalogue.followers.kinematics import Flank, Tip, TracePoint, Vector2
from synthesis.catalogue.followers.pivot import PivotedFollower
from synthesis.catalogue.motion import Motion
from synthesis.units import DEGREE

FARTHEST = 1e4  # strokes: upper end of the search for the distance; no machine is so long


@dataclass(frozen=True)
class CounterRoller(TracePoint):
    """The counter roller, by the formulas of a main one; the size z is the main follower's.

    Attributes:
        seen: the follower that it is as seen from the counter cam.
        ratio: −s2/s.
        matrix, shift: the size variables of ``seen`` as an affine map of z.
        upside_down: whether ``seen`` stands in a machine turned by half a turn.
    """

    seen: TracePoint
    ratio: float
    matrix: tuple[Vector, ...]
    shift: Vector
    upside_down: bool = False

    def _map(self, s: Any, z: Any) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
        """s2 to s2''' and the size of ``seen``."""
        return tuple(-self.ratio * value for value in s), tuple(
            sum((a * v for a, v in zip(row, z, strict=True)), m)
            for row, m in zip(self.matrix, self.shift, strict=True)
        )

    def _through(self, row: Vector) -> tuple[Vector, float]:
        """A linear form of the size of ``seen``, as a linear form of z and a constant."""
        columns = zip(*self.matrix, strict=True)
        return tuple(sum(map(mul, row, c)) for c in columns), sum(map(mul, row, self.shift))

    def _turned(self, vectors: tuple[Vector2, ...]) -> tuple[Vector2, ...]:
        return tuple((-x, -y) for x, y in vectors) if self.upside_down else vectors

    def position(self, s: Any, z: Any) -> tuple[Vector2, ...]:
        return self._turned(self.seen.position(*self._map(s, z)))

    def drive_direction(self, s: Any, z: Any) -> tuple[Vector2, Vector2]:
        direction, rate = self._turned(self.seen.drive_direction(*self._map(s, z)))
        return direction, rate

    def lever(self, s: Any, z: Any) -> Any:
        return -self.ratio  # as s grows it follows the other way

    def curvature_terms(self, s: Any, z: Any) -> tuple[Any, Any]:
        return self.seen.curvature_terms(*self._map(s, z))

    def curvature_bounds(
        self, side: int, most: float, thrust: PressureTerm | None = None
    ) -> BoxBounds:
        # On a slide |ratio| = 1: coordinates of s2 and z2 become those of s and z.
        return tuple(
            replace(bound, coordinates=bound.coordinates.through(self._through))
            for bound in self.seen.curvature_bounds(side, most, thrust)
        )

    def pressure_angle_rows(self, slope: float) -> tuple[LinearInequality, ...]:
        return tuple(self._row(row) for row in self.seen.pressure_angle_rows(slope))

    def _row(self, row: LinearInequality) -> LinearInequality:
        """A row on s2 and z2 as one on s and z."""
        motion = tuple(-self.ratio * each for each in row.coefficients)
        size, constant = self._through(row.size)
        return replace(row, coefficients=motion, size=size, upper=row.upper - constant)

    def radius_rows(self, least: float) -> tuple[LinearInequality, ...]:
        if not self.upside_down:
            return ()
        # L − s0 − s ≥ √(least² − e2²), beyond the axis
        offset, distance = self.shift
        height = math.sqrt(max(least**2 - offset**2, 0.0))
        return (LinearInequality((1.0, 0.0, 0.0, 0.0), (0.0, 1.0), distance - height),)

    def outer_radius_norm(self, s_max: float) -> AffineNorm:
        # The counter roller is farthest out where the main one is lowest.
        own = self.seen.outer_radius_norm(0.0)
        assert own is not None  # a follower with a roller has one
        rows, constants = zip(*map(self._through, own.matrix), strict=True)
        return AffineNorm(rows, tuple(map(add, own.shift, constants)))

    def norm_from_radius(self, radius: float) -> float:
        return self.seen.norm_from_radius(radius)

    def nearest_displacement(self, s_max: float) -> float:
        return s_max


@dataclass(frozen=True)
class CounterArm(CounterRoller):
    """The counter roller of an arm; ``angle``: γ, between the two arms [rad]."""

    angle: float = 0.0

    def curvature_bounds(
        self, side: int, most: float, thrust: PressureTerm | None = None
    ) -> BoxBounds:
        return tuple(
            replace(bound, reference=bound.arm / self.ratio, sense=-bound.sense, angle=self.angle)
            for bound in self.seen.curvature_bounds(side, most, thrust)
            if isinstance(bound, ArmCurvatureBound)
        )


class Conjugate(Closure, ABC):
    """A second roller beyond the cam's axis, on a counter cam of its own, rigidly connected.

    The farther away it is, the larger the counter cam, the smaller its pressure angle and the
    gentler its curvature: left free, its place is the nearest at which the counter cam keeps
    every limit.
    """

    kind: Literal["conjugate"] = "conjugate"
    counter_paths: ClassVar[tuple[str, ...]] = ("counter",)
    field: ClassVar[str]  # of its place
    given_field: ClassVar[str]  # a further dimension, which is always given
    roller_radius_mm: float = Field(
        ge=0.0, le=1e6, description="Radius of the counter cam's roller."
    )

    @abstractmethod
    def counter(self, trace: TracePoint) -> TracePoint:
        """The counter roller beside the main one; its place must be a number."""

    @property
    def given(self) -> float:
        """Its place where it is a number."""
        low, high = ends(getattr(self, self.field))
        if low != high:
            raise ValueError("the place of the counter roller is still free")
        return low

    def flanks(self, trace: TracePoint, roller_radius: float) -> tuple[Flank, ...]:
        return (
            Flank("main", 1, roller_radius, "main", trace),
            Flank("counter", 1, self.roller_radius_mm, "counter", self.counter(trace)),
        )

    def counter_dimensions(self) -> Mapping[str, tuple[str, float | Range | None]]:
        return {f"closure/{self.field}": (f"counter_{self.field}", getattr(self, self.field))}

    def without_free_counter(self) -> Closure:
        low, high = ends(getattr(self, self.field))
        return self if low == high else Force()

    def counter_only(self, values: Mapping[str, float]) -> Closure:
        return CounterCamOnly(pair=self.with_counter(values))

    def with_counter(self, values: Mapping[str, float]) -> Self:
        return self.model_copy(update={self.field: values[f"counter_{self.field}"]})

    def dimensions(self, roller_radius: float) -> Mapping[str, float]:
        return {
            f"counter_{self.field}": self.given,
            "counter_roller_radius_mm": self.roller_radius_mm,
            f"counter_{self.given_field}": getattr(self, self.given_field),
        }

    def motion_dimensions(
        self, trace: TracePoint, motion: Motion, z: Vector
    ) -> Mapping[str, float]:
        highest = max(max(s.s_start, s.s_end) for s in motion.segments)
        (x, y), *_ = self.counter(trace).position((highest, 0.0, 0.0, 0.0), z)
        prime, base = math.hypot(x, y), math.hypot(x, y) - self.roller_radius_mm
        return {"counter_prime_radius_mm": prime, "counter_base_radius_mm": base}


class ConjugateSlide(Conjugate):
    """Main and counter cam, two rollers on one slide, the second beyond the cam's axis."""

    title: ClassVar[str] = "Main and counter cam, two rollers on one slide"
    field: ClassVar[str] = "distance_mm"
    given_field: ClassVar[str] = "offset_mm"
    offset_mm: float = Field(
        0.0,
        ge=-1e6,
        le=1e6,
        description="Offset of the counter roller, to the same side as the follower's.",
    )
    distance_mm: Dimension = None

    def counter(self, trace: TracePoint) -> TracePoint:
        size = (-self.offset_mm, self.given)
        return CounterRoller(trace, 1.0, ((0.0, 0.0), (0.0, -1.0)), size, upside_down=True)

    def contact_points(
        self, at: Vector2, pivot: Vector2 | None, turn: int, degree: Any
    ) -> tuple[Tip, ...]:
        below = at[1] - self.given
        return Tip("main", at), Tip("counter", (self.offset_mm + 0.0 * below, below), -1)

    def counter_range(self, trace: TracePoint, z: Vector, s_max: float) -> Ends:
        (_, height), *_ = trace.position((s_max, 0.0, 0.0, 0.0), z)
        return float(height), float(height) + FARTHEST * s_max


class ConjugateArm(Conjugate):
    """Main and counter cam, two arms at one pivot, which take the shaft between them."""

    title: ClassVar[str] = "Main and counter cam, two arms at one pivot"
    field: ClassVar[str] = "angle_deg"
    given_field: ClassVar[str] = "arm_mm"
    eased_by_distance: ClassVar[bool] = False
    arm_mm: float = Field(gt=0.0, le=1e6, description="Length of the counter arm.")
    angle_deg: Number | Range | None = Field(
        None,
        description="Angle between the two arms, the cam's axis inside. A number fixes it; "
        "{min, max} leaves it free in between; left out, it is the least that works.",
    )

    def counter(self, trace: TracePoint) -> TracePoint:
        assert isinstance(trace, PivotedFollower)
        ratio, angle = self.arm_mm / trace.reference, self.given * DEGREE
        sense = {"opposite": "same", "same": "opposite"}[trace.sense]
        changes = {"arm_mm": self.arm_mm, "sense": sense, "closure": Force()}
        seen = trace.model_copy(update=changes)
        if trace.distance is not None:
            return CounterArm(seen, ratio, ((-ratio,),), (self.arm_mm * angle,), angle=angle)
        # d cos(γ − ψ0), d sin(γ − ψ0)
        cos, sin = math.cos(angle), math.sin(angle)
        return CounterArm(seen, ratio, ((cos, sin), (sin, -cos)), (0.0, 0.0), angle=angle)

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

    def counter_range(self, trace: TracePoint, z: Vector, s_max: float) -> Ends:
        assert isinstance(trace, PivotedFollower)
        angle = trace.initial_angle(z) + s_max / trace.reference
        return angle / DEGREE, 180.0


class CounterCamOnly(Closure):
    """The counter cam of a pair, looked at by itself."""

    kind: Literal["counter_alone"] = "counter_alone"
    counter_paths: ClassVar[tuple[str, ...]] = ("counter",)
    pair: Conjugate

    def flanks(self, trace: TracePoint, roller_radius: float) -> tuple[Flank, ...]:
        return self.pair.flanks(trace, roller_radius)[1:]

    def contact_points(
        self, at: Vector2, pivot: Vector2 | None, turn: int, degree: Any
    ) -> tuple[Tip, ...]:
        return self.pair.contact_points(at, pivot, turn, degree)[1:]


SlideClosure = Annotated[
    Force | Groove | ConjugateSlide,
    Field(discriminator="kind", description="What keeps the roller on the cam."),
]
ArmClosure = Annotated[
    Force | Groove | ConjugateArm,
    Field(discriminator="kind", description="What keeps the roller on the cam."),
]
