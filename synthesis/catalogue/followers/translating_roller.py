"""Translating roller follower, offset; with roller radius 0 a knife edge.

Symbols: e offset (positive to the right of an upward follower on a ccw cam), s0 = √(Rp² − e²)
height of the roller's centre at the lowest position, X = s0 + s, u = s' − e.
tan α = u / X;  κ = [X² + u (2s' − e) − X s''] / (X² + u²)^{3/2}   (Rothbart; Norton ch. 7).
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
    LinearInequality,
    NormBounds,
    PressureTerm,
    SizeDomain,
    SlideCoordinates,
    Vector,
)
from synthesis.catalogue.fields import Dimension, Range, ends
from synthesis.catalogue.followers.base import RollerFollower, base_gap
from synthesis.catalogue.followers.closures import Force
from synthesis.catalogue.followers.conjugate import SlideClosure
from synthesis.catalogue.followers.curvature_bound import CurvatureBound
from synthesis.catalogue.followers.kinematics import Link, Vector2
from synthesis.catalogue.motion import Motion, Segments

# of z = (e, s0)
ROLLER = SlideCoordinates(1, (0.0, 0.0, 0.0), ((0.0, 1.0), (-1.0, 0.0), (1.0, 0.0)))


class TranslatingRoller(RollerFollower):
    """A roller on a slide that moves in a straight line past the cam's axis."""

    kind: Literal["translating_roller"] = "translating_roller"
    title: ClassVar[str] = "Translating roller (radius 0: knife edge)"
    size_charts: ClassVar[tuple[tuple[str, ...], ...]] = (("offset", "s0"),)

    roller_radius_mm: float = Field(
        ge=0.0, le=1e6, description="Radius of the roller; 0 is a knife edge."
    )
    offset_mm: Dimension = None
    closure: SlideClosure = Force()

    def check_dimensions(self, base_radius: Ends, segments: Segments) -> None:
        largest, gap = base_radius[1], base_gap(self)
        self.closure.check(self.roller_radius_mm, largest, gap)
        e_min, e_max = ends(self.offset_mm)
        nearest, prime = max(e_min, -e_max, 0.0), largest + gap
        if nearest >= prime:
            raise PydanticCustomError(
                "offset_beyond_prime_radius",
                "offset_mm = {offset} is not inside the prime radius {prime} mm "
                "(base radius {word} roller radius): the follower would miss the pitch circle. "
                "Take a smaller offset or a larger base radius.",
                {"offset": nearest, "prime": prime, "word": "plus" if gap >= 0.0 else "less"},
            )

    @property
    def reason_without_minimum(self) -> str:
        low, high = ends(self.offset_mm)
        alone = base_gap(self) >= 0.0 and not self.closure.counter_paths
        return "its offset may be 0" if alone and low <= 0.0 <= high else ""

    def adjustable_dimensions(self) -> Mapping[str, float | Range | None]:
        return {"offset_mm": self.offset_mm}

    def size_domain(self, base_radius: Ends) -> SizeDomain:
        least, largest = self.prime_radii(base_radius)
        e_min, e_max = ends(self.offset_mm)
        e_min, e_max = max(e_min, -largest), min(e_max, largest)
        nearest, farthest = max(e_min, -e_max, 0.0), max(-e_min, e_max)
        # s0 = √(Rp² − e²): exact where e or Rp leaves no choice, otherwise what is convex of it
        s0_max = math.sqrt(max(largest**2 - nearest**2, 0.0))
        s0_min = math.sqrt(max(least**2 - farthest**2, 0.0))
        cones = () if e_min == e_max else (NormBounds(self.radius_norm(), largest, "base_radius"),)
        return SizeDomain(((e_min, e_max), (s0_min, s0_max)), cones, least)

    def outer_radius_norm(self, s_max: float) -> AffineNorm:
        return AffineNorm(((1.0, 0.0), (0.0, 1.0)), (0.0, s_max))

    def pressure_angle_rows(self, slope: float) -> tuple[LinearInequality, ...]:
        # −slope (s0 + s) ≤ s' − e ≤ slope (s0 + s)
        return tuple(
            LinearInequality((-slope, sign, 0.0, 0.0), (-sign, -slope), 0.0) for sign in (1.0, -1.0)
        )

    def position(self, s: Any, z: Any) -> tuple[Vector2, ...]:
        e, s0 = z
        zero = 0.0 * s[0]
        return ((zero + e, s[0] + s0), (zero, s[1]), (zero, s[2]), (zero, s[3]))

    def link(self, z: Any, degree: Any) -> Link:
        tips = self.closure.contact_points((z[0], z[1]), None, 1, degree)
        return Link(tips, slide=(0.0 * z[1], 1.0 + 0.0 * z[1]))

    def pose(self, point: Any, normal: Any) -> tuple[Any, Any]:
        # the cam turns the centre (e, X) to (e + iX) exp(−iθ)
        (x, y), (e, _) = point, ends(self.offset_mm)
        with np.errstate(invalid="ignore"):
            height = np.sqrt(x * x + y * y - e * e)
        return np.arctan2(height, e) - np.arctan2(y, x), height

    def size_at_lowest(self, position: float) -> Vector:
        return ends(self.offset_mm)[0], position

    def curvature_terms(self, s: Any, z: Any) -> tuple[Any, Any]:
        e, s0 = z
        x, u = s[0] + s0, s[1] - e
        return x * x + u * (2.0 * s[1] - e) - x * s[2], x * x + u * u

    def curvature_bounds(
        self, side: int, most: float, thrust: PressureTerm | None = None
    ) -> BoxBounds:
        return (CurvatureBound("", ROLLER, side, most, thrust),)

    def dimensions(self, z: Vector) -> Mapping[str, float]:
        e, s0 = z
        prime = float(np.hypot(e, s0))
        return {
            "base_radius_mm": prime - base_gap(self),
            "prime_radius_mm": prime,
            "roller_radius_mm": self.roller_radius_mm,
            "offset_mm": e,
            "s0_mm": s0,
            **self.closure.dimensions(self.roller_radius_mm),
        }

    def motion_dimensions(self, motion: Motion, z: Vector) -> Mapping[str, float]:
        return self.closure.motion_dimensions(self, motion, z)
