"""Oscillating roller follower: a roller on an arm that swings about a fixed pivot.

Symbols: l arm; d distance of the pivot from the cam's axis; ψ angle at the pivot between the line
to the axis and the arm, ψ0 at the lowest position; φ = ψ − ψ0 swing; σ = +1 where the lifting arm
turns against a ccw cam, −1 where it turns with it. The displacement is the arc s = lφ of the
roller's centre. With A = l + σs' − d cosψ and B = d sinψ

    R² = d² + l² − 2dl cosψ,  tan α = σA / B,  κ = [A² + B² + σ (s'/l) A (l + σs') − B s''] / W³,

W² = A² + B². All follow from the tangent T = σ (A g − B u) of the pitch curve in the basis u along
the arm and g, in which the centre is driven; see Norton ch. 7 for the pressure angle.

The size is what fixes d and ψ0. Where d is a number z = (lψ0,); where it is not,
z = (p, q) = d (cosψ0, sinψ0), in which d cosψ, d sinψ are linear at every φ.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, ClassVar, Literal

import numpy as np
from pydantic import Field
from pydantic_core import PydanticCustomError

from synthesis.catalogue.box_bounds import BoxBounds
from synthesis.catalogue.constraints import (
    AffineNorm,
    Ends,
    NonconvexConstraints,
    NormBounds,
    PressureTerm,
    SizeDomain,
    SlideCoordinates,
    Vector,
)
from synthesis.catalogue.fields import ArmLength, Dimension, Number, Range, ends
from synthesis.catalogue.followers.arm_curvature import ArmCurvatureBound
from synthesis.catalogue.followers.arm_pressure_angle import (
    FixedPivotPressureAngle,
    FreePivotPressureAngle,
)
from synthesis.catalogue.followers.arm_workspace import ArmGeometry, feasible_arm_lengths
from synthesis.catalogue.followers.base import FixableDimension, Follower, RollerFollower, base_gap
from synthesis.catalogue.followers.closures import Force
from synthesis.catalogue.followers.conjugate import ArmClosure
from synthesis.catalogue.followers.kinematics import Link, Vector2, edge_offset
from synthesis.catalogue.followers.pivot import PivotDirection, PivotedFollower, PivotSense
from synthesis.catalogue.motion import Motion, Segments
from synthesis.numerics.geometry.plane import enclosed_angle, third_side
from synthesis.numerics.maxima import maximise
from synthesis.units import DEGREE

ANGLE_ROUNDING = 1e-12  # rad: a tenth or less of what the certificate allows a dimension


class OscillatingRoller(RollerFollower, PivotedFollower):
    """A roller on an arm that swings about a pivot; the lift is the angle of its swing."""

    kind: Literal["oscillating_roller"] = "oscillating_roller"
    title: ClassVar[str] = "Oscillating roller, on an arm (radius 0: knife edge)"
    size_charts: ClassVar[tuple[tuple[str, ...], ...]] = (("arc",), ("p", "q"))
    swing_range: ClassVar[tuple[float, float]] = (0.0, math.pi)
    redundant_fields: ClassVar[tuple[str, ...]] = ("initial_angle_deg",)

    arm_mm: ArmLength
    centre_distance_mm: Dimension = None
    roller_radius_mm: float = Field(
        ge=0.0, le=1e6, description="Radius of the roller; 0 is a knife edge."
    )
    initial_angle_deg: Number | Range | None = Field(
        None,
        description="Angle at the pivot between the line to the cam's axis and the arm, at "
        "the lowest position. Usually left out: it follows from the base radius.",
    )
    sense: PivotSense = Field(
        "opposite", description="Whether the lifting arm turns against the cam or with it."
    )
    pivot_direction_deg: PivotDirection = 0.0

    closure: ArmClosure = Force()

    @property
    def reference(self) -> float:
        return ends(self.arm_mm)[0]  # the arm's length, the smallest one while it is left free

    def searched_dimensions(self, base_radius: Ends) -> Mapping[str, tuple[float | Range, Ends]]:
        low, high = ends(self.arm_mm)
        prime = base_radius[0] + base_gap(self), base_radius[1] + base_gap(self)
        least = max(low, self.roller_radius_mm)
        reached = feasible_arm_lengths((least, high), ends(self.centre_distance_mm), prime)
        return {"arm_mm": (self.arm_mm, reached)}

    @property
    def reason_without_minimum(self) -> str:
        (low, high), (short, long) = ends(self.centre_distance_mm), ends(self.arm_mm)
        given = self.distance is not None or self.initial_angle_deg is not None
        never = low > long or high < short or base_gap(self) < 0.0
        if given or never or self.closure.counter_paths:
            return ""
        return "the pivot may be as far from the cam's axis as the arm is long"

    def adjustable_dimensions(self) -> Mapping[str, float | Range | None]:
        return {"centre_distance_mm": self.centre_distance_mm}

    def check_dimensions(self, base_radius: Ends, segments: Segments) -> None:
        self.closure.check(self.roller_radius_mm, base_radius[1], base_gap(self))
        self._arm.check(self.prime_radii(base_radius), segments)
        if self.reference <= self.roller_radius_mm:
            raise PydanticCustomError(
                "roller_on_pivot",
                "arm_mm = {arm} is not longer than roller_radius_mm = {roller}: the roller would "
                "lie over its own pivot. Take a longer arm or a smaller roller.",
                {"arm": self.reference, "roller": self.roller_radius_mm},
            )

    def feasible_base_radii(self, base_radius: Ends, stroke: float) -> Ends:
        prime = self.prime_radii(base_radius)
        kept = zip(base_radius, prime, self._arm.prime_radii_for(prime, stroke), strict=True)
        low, high = (base if now == was else now - base_gap(self) for base, was, now in kept)
        return low, high

    def searched_norm(self, base_radius: Ends) -> float:
        norm, arm = super().searched_norm(base_radius), self._arm
        if arm.pivot is None:
            return norm
        _, most = arm.angles(self.prime_radii(base_radius))
        return max(norm, self.reference * min(arm.least_angle, most))

    @property
    def _arm(self) -> ArmGeometry:
        low, high = ends(self.initial_angle_deg)
        angle = low * DEGREE, high * DEGREE
        return ArmGeometry(self.reference, ends(self.centre_distance_mm), angle, base_gap(self))

    def size_domain(self, base_radius: Ends) -> SizeDomain:
        prime, arm, l = self.prime_radii(base_radius), self._arm, self.reference
        if arm.pivot is not None:
            low, high = arm.angles(prime)
            return SizeDomain(((l * low, l * high),), (), 0.0)  # the bounds say it all
        farthest = min(arm.distance[1], l + prime[1])
        cones = [NormBounds(self.radius_norm(), prime[1], "base_radius")]
        nearest = max(arm.distance[0], 0.0)
        if nearest > 0.0 or arm.distance[1] < math.inf:
            centred = AffineNorm(((1.0, 0.0), (0.0, 1.0)), (0.0, 0.0))
            cones.append(NormBounds(centred, farthest, "centre_distance", nearest))
        across = max(l - prime[1], -farthest), min(l + prime[1], farthest)
        # the roller is no nearer to the axis than arm and distance differ
        least = max(prime[0], nearest - l, l - farthest, arm.least_radius)
        return SizeDomain((across, (0.0, min(prime[1], farthest))), tuple(cones), least)

    def allows(self, z: Vector) -> bool:
        low, high = self._arm.angle
        near = ANGLE_ROUNDING if self.distance is None else math.inf
        return low - near <= self.initial_angle(z) <= high + near

    def _radius(self, z: Vector, s: float) -> float:
        """Distance of the roller's centre from the axis at a displacement [mm]."""
        return self.radius_from_norm(self.outer_radius_norm(s).value(z))

    def radius_from_norm(self, value: float) -> float:
        if self.distance is None:
            return value
        angle = min(max(value / self.reference, 0.0), math.pi)
        return third_side(self.reference, self.distance, angle)

    def norm_from_radius(self, radius: float) -> float:
        if self.distance is None:
            return radius
        return self.reference * enclosed_angle(self.reference, self.distance, radius)

    def fixable_dimension(self) -> FixableDimension | None:
        if self.distance is not None:
            return None
        low, high = ends(self.centre_distance_mm)

        def at(distance: float) -> Follower:
            return self.model_copy(update={"centre_distance_mm": distance})

        def whole(distance: float, z: Vector) -> Vector:
            angle = z[0] / self.reference
            return distance * math.cos(angle), distance * math.sin(angle)

        return FixableDimension(
            name="centre distance", low=max(low, 0.0), high=high, unit=self.reference,
            value_in=lambda z: math.hypot(*z), fixed_at=at, full_size=whole,
            needed=self.initial_angle_deg is not None,  # a bound of ψ0 itself, not of (p, q)
        )  # fmt: skip

    def outer_radius_norm(self, s_max: float) -> AffineNorm:
        # R grows with ψ: at the highest lift it is the length of (l − d cosψ, d sinψ)
        if self.distance is not None:
            return AffineNorm(((1.0,),), (s_max,))  # lψ, with which R grows
        cos, sin = math.cos(s_max / self.reference), math.sin(s_max / self.reference)
        return AffineNorm(((-cos, sin), (sin, cos)), (self.reference, 0.0))

    def pressure_angle_constraints(self, slope: float) -> NonconvexConstraints:
        arm, sigma = self.reference, self.sigma
        if self.distance is None:
            return (FreePivotPressureAngle("pressure_angle", arm, sigma, slope),)
        return (FixedPivotPressureAngle("pressure_angle", arm, self.distance, sigma, slope),)

    def pivot(self, z: Any) -> Vector2:
        if self.distance is None:
            p, q = z
            return p, q
        angle = z[0] / self.reference
        return self.distance * np.cos(angle), self.distance * np.sin(angle)

    def initial_angle(self, z: Vector) -> float:
        return z[0] / self.reference if self.distance is not None else math.atan2(z[1], z[0])

    def position(self, s: Any, z: Any) -> tuple[Vector2, ...]:
        l, (u, g), (_, (x, y)) = self.reference, self.frame(s, z), self.pivot_position(z)
        turn = s[1] / l
        along, driven = -s[1] * turn, s[2]  # u' = (s'/l) g, g' = −(s'/l) u
        further, jerked = -3.0 * s[2] * turn, s[3] - s[1] * turn * turn
        return (
            (x + l * u[0], y + l * u[1]),
            (s[1] * g[0], s[1] * g[1]),
            (driven * g[0] + along * u[0], driven * g[1] + along * u[1]),
            (jerked * g[0] + further * u[0], jerked * g[1] + further * u[1]),
        )

    def link(self, z: Any, degree: Any) -> Link:
        (pivot, arm), turn = self.link_frame(*self.pivot(z), degree), -int(self.sigma)
        tip = pivot[0] + self.arm_mm * arm[0], pivot[1] + self.arm_mm * arm[1]
        return Link(self.closure.contact_points(tip, pivot, turn, degree), pivot=pivot, turn=turn)

    def pose(self, point: Any, normal: Any) -> tuple[Any, Any]:
        # the triangle of axis, pivot and centre gives ψ; the position is the arc lψ
        (x, y), l, (d, _) = point, self.reference, ends(self.centre_distance_mm)
        cos = d * d + l * l - x * x - y * y  # 2dl cosψ
        with np.errstate(invalid="ignore"):
            sin = np.sqrt(4.0 * d * d * l * l - cos * cos) if d > 0.0 else np.nan * cos
        arc = l * np.arctan2(sin, cos)
        (px, py), *_ = self.position((0.0, 0.0, 0.0, 0.0), (arc,))
        return np.arctan2(py, px) - np.arctan2(y, x), arc

    def size_at_lowest(self, position: float) -> Vector:
        return (position,)

    def drive_direction(self, s: Any, z: Any) -> tuple[Vector2, Vector2]:
        u, g = self.frame(s, z)
        turn = s[1] / self.reference
        return g, (-turn * u[0], -turn * u[1])

    def curvature_terms(self, s: Any, z: Any) -> tuple[Any, Any]:
        l, sigma = self.reference, self.sigma
        along, across = self.axis_from_pivot(s, z)
        ahead = l + sigma * s[1]
        lever = ahead - along
        speed_squared = lever * lever + across * across
        bend = sigma * (s[1] / l) * lever * ahead - across * s[2]
        return speed_squared + bend, speed_squared

    def curvature_bounds(
        self, side: int, most: float, thrust: PressureTerm | None = None
    ) -> BoxBounds:
        if thrust is not None:
            return ()
        l, d = self.reference, self.distance
        seen = SlideCoordinates.of_motion(2)
        if d is not None:  # X = lψ = s + z
            seen = SlideCoordinates(1, (0.0, 0.0, 0.0), ((1.0,), (0.0,), (0.0,)))
        return (ArmCurvatureBound("", seen, l, self.sigma, d, side, most, l),)

    def dimensions(self, z: Vector) -> Mapping[str, float]:
        prime = self._radius(z, 0.0)
        return {
            "base_radius_mm": prime - base_gap(self),
            "prime_radius_mm": prime,
            "roller_radius_mm": self.roller_radius_mm,
            "arm_mm": self.reference,
            "centre_distance_mm": float(self.pivot_position(z)[0]),
            "initial_angle_deg": self.initial_angle(z) / DEGREE,
            **self.closure.dimensions(self.roller_radius_mm),
        }

    def motion_dimensions(self, motion: Motion, z: Vector) -> Mapping[str, float]:
        """Farthest point of the profile, and what is left from there to the pivot [mm].

        A negative clearance: the cam sweeps past the pivot, so that arm and bearing have to stand
        beside the cam's plane.
        """
        flanks = self.without_free_counter().flanks
        highest, _ = maximise(motion.curve, (1.0, 0.0, 0.0, 0.0))
        outer = self._radius(z, highest) - edge_offset(flanks, flanks[0].path)
        return {
            "outer_radius_mm": outer,
            "pivot_clearance_mm": float(self.pivot_position(z)[0]) - outer,
            **self.closure.motion_dimensions(self, motion, z),
        }
