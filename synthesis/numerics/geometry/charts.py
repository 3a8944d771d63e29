"""Coordinates that suit a cam's blank: turn, depth and place across.

The cam's frame has z along the cam's axis and x, at cam angle 0, towards the follower. In a chart
a groove's wall is a graph, place across over turn and depth, and a surface turned on a lathe has
one depth all over.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from synthesis.numerics.piecewise import Array
from synthesis.units import FULL_TURN


class Chart(ABC):
    """Turn φ about the cam's axis [rad], depth into the cam [mm], place across the blank.

    Attributes:
        parts: flat ones, in which a line across at one depth is drawn.
    """

    parts: ClassVar[int]

    @abstractmethod
    def meridian(self, depth: Array, across: Array) -> tuple[Array, Array]:
        """Distance from the cam's axis and height along it [mm]."""

    @abstractmethod
    def from_meridian(self, radius: Array, height: Array) -> tuple[Array, Array]:
        """Depth and place across of points in a half-plane through the cam's axis."""

    @abstractmethod
    def depth_of_place(self, value: Array) -> Array:
        """Depth of a place ρ on a roller that stands square to the blank; and back [mm]."""

    @abstractmethod
    def unwrap(self, across: Array, place: Array) -> Array:
        """The same places across as they lie beside others: angles of any turn."""

    @abstractmethod
    def across_at_height(self, depth: Array, height: float) -> Array:
        """Places across that lie at a height along the cam's axis [mm]."""

    @abstractmethod
    def sag(self, depth: Array, width: Array) -> Array:
        """How far lines across of these widths are from their parts' chords [mm]."""

    @abstractmethod
    def torus_radii(self, depth: float) -> tuple[float, float] | None:
        """Radii of the torus that a depth is, of its middle circle and tube; None: a cylinder."""

    def points(self, turn: Array, depth: Array, across: Array) -> Array:
        """Points (3, …) of the cam's frame [mm]."""
        radius, height = self.meridian(depth, across)
        x, y = radius * np.cos(turn), radius * np.sin(turn)
        return np.stack(np.broadcast_arrays(x, y, height))


@dataclass(frozen=True)
class Torus(Chart):
    """Round a turret whose centre is ``distance`` off the cam's axis [mm].

    Depth is the distance from the turret's axis [mm], across the turret's angle [rad].
    """

    parts: ClassVar[int] = 12
    distance: float

    def meridian(self, depth: Array, across: Array) -> tuple[Array, Array]:
        return self.distance - depth * np.cos(across), depth * np.sin(across)

    def from_meridian(self, radius: Array, height: Array) -> tuple[Array, Array]:
        inward = self.distance - radius
        return np.hypot(inward, height), np.arctan2(height, inward)

    def depth_of_place(self, value: Array) -> Array:
        return value

    def unwrap(self, across: Array, place: Array) -> Array:
        return np.asarray(across + FULL_TURN * np.round((place - across) / FULL_TURN))

    def across_at_height(self, depth: Array, height: float) -> Array:
        return np.arcsin(np.clip(height / depth, -1.0, 1.0))

    def sag(self, depth: Array, width: Array) -> Array:
        return np.asarray(depth * (1.0 - np.cos(0.5 * width / self.parts)))

    def torus_radii(self, depth: float) -> tuple[float, float] | None:
        return self.distance, depth


@dataclass(frozen=True)
class Drum(Chart):
    """A cylinder: depth is minus the distance from the cam's axis [mm], across the height [mm]."""

    parts: ClassVar[int] = 1

    def meridian(self, depth: Array, across: Array) -> tuple[Array, Array]:
        return -depth, across

    def from_meridian(self, radius: Array, height: Array) -> tuple[Array, Array]:
        return -radius, height

    def depth_of_place(self, value: Array) -> Array:
        return -value

    def across_at_height(self, depth: Array, height: float) -> Array:
        return np.full_like(depth, height)

    def unwrap(self, across: Array, place: Array) -> Array:
        return across

    def sag(self, depth: Array, width: Array) -> Array:
        return 0.0 * depth

    def torus_radii(self, depth: float) -> tuple[float, float] | None:
        return None
