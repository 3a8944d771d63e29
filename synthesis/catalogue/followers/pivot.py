"""Followers that swing about a fixed pivot: their fields, and the kinematics that they share.

Symbols: d distance of the pivot from the cam's axis; ψ angle at the pivot between the line to the
axis and the follower, ψ0 at the lowest position; φ = ψ − ψ0 = s/l swing, l the core's length per
radian; σ = +1 where the lifting follower turns against a ccw cam, −1 where it turns with it;
p = d cosψ0, q = d sinψ0; γ direction of the pivot as seen from the axis.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from synthesis.catalogue.constraints import Vector
from synthesis.catalogue.fields import Range, ends
from synthesis.catalogue.followers.base import Follower
from synthesis.catalogue.followers.kinematics import Vector2
from synthesis.units import DEGREE, Travel

PivotSense = Literal["opposite", "same"]
PivotDirection = Annotated[
    float,
    Field(
        ge=-360.0,
        le=360.0,
        description="Direction of the pivot as seen from the cam's axis, 0 to the right, "
        "counter-clockwise (on a cw cam mirrored, as everything is).",
    ),
]


class PivotedFollower(Follower, ABC):
    """A follower on a pivot; a lift is an angle. It lifts while ψ is in the ``swing_range`` [rad].

    Its ``size_charts`` are those of a given and of a free centre distance, in this order.
    """

    swing_range: ClassVar[tuple[float, float]]

    if TYPE_CHECKING:  # declared by the families, each at its place among the fields of the wire
        centre_distance_mm: float | Range | None
        sense: PivotSense
        pivot_direction_deg: float

    @property
    @abstractmethod
    def reference(self) -> float:
        """The core's mm per radian of swing."""

    @property
    def travel(self) -> Travel:
        return Travel("deg", self.reference * DEGREE)

    @property
    def sigma(self) -> float:
        """+1 where the lifting follower turns against a ccw cam, −1 where it turns with it."""
        return {"opposite": 1.0, "same": -1.0}[self.sense]

    @property
    def distance(self) -> float | None:
        """d where it is a number."""
        low, high = ends(self.centre_distance_mm)
        return low if low == high else None

    @property
    def size_names(self) -> tuple[str, ...]:
        return self.size_charts[0 if self.distance is not None else 1]

    def displacement_range(self, z: Vector) -> tuple[float, float, Callable[[float], float]]:
        l, start, (low, high) = self.reference, self.initial_angle(z), self.swing_range
        lowest = l * (low - start)  # where the wire's value is the range's end without rounding
        return lowest, l * (high - start), lambda s: (low + (s - lowest) / l) / DEGREE

    @abstractmethod
    def pivot(self, z: Any) -> Vector2:
        """p and q [mm]."""

    def initial_angle(self, z: Vector) -> float:
        """ψ0 [rad]."""
        p, q = self.pivot(z)
        return math.atan2(q, p)

    def pivot_position(self, z: Any) -> tuple[Any, Vector2]:
        """d, and the pivot in the machine frame [mm]."""
        d, gamma = self.distance, self.pivot_direction_deg * DEGREE
        if d is None:
            p, q = self.pivot(z)
            d = (p * p + q * q) ** 0.5
        return d, (d * math.cos(gamma), d * math.sin(gamma))

    def axis_from_pivot(self, s: Any, z: Any) -> Vector2:
        """d cosψ and d sinψ: the axis as seen from the pivot, along and across the follower."""
        (p, q), swing = self.pivot(z), s[0] / self.reference
        cos, sin = np.cos(swing), np.sin(swing)
        return p * cos - q * sin, q * cos + p * sin

    def frame(self, s: Any, z: Any) -> tuple[Vector2, Vector2]:
        """u along the follower, away from the pivot, and n in which its end is driven.

        u is the direction from the pivot to the axis, turned by −σψ; n is u turned by −90° σ. So
        u' = φ' n and n' = −φ' u.
        """
        (along, across), (d, _) = self.axis_from_pivot(s, z), self.pivot_position(z)
        gamma = self.pivot_direction_deg * DEGREE
        x, y = math.cos(gamma), math.sin(gamma)
        cos, sin = along / d, self.sigma * across / d
        u = -x * cos - y * sin, x * sin - y * cos
        return u, (self.sigma * u[1], -self.sigma * u[0])

    def link_frame(self, p: Any, q: Any, degree: Any) -> tuple[Vector2, Vector2]:
        """The pivot, and u at displacement 0, in the arithmetic of p, q and π/180."""
        gamma, d = self.pivot_direction_deg * degree, (p * p + q * q) ** 0.5
        cos, sin = np.cos(gamma), np.sin(gamma)
        # from the pivot to the axis and square to it, turned by −σψ0
        x, y = -p / d, self.sigma * q / d
        return (d * cos, d * sin), (x * cos - y * sin, y * cos + x * sin)
