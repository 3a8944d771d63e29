"""What bounds a slab, as something that is drawn by whoever can."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Protocol

from synthesis.exporters.curves.exact import ExactCurve

Place = tuple[float, float]


class Pen(Protocol):
    """Draws strokes that follow one another, in a plane across the axis [mm]."""

    def circle(self, radius: float) -> None:
        """About the axis."""

    def arc(self, radius: float, start: Place, end: Place) -> None:
        """About the axis, counter-clockwise."""

    def line(self, start: Place, end: Place) -> None:
        """Straight."""

    def spline(self, curve: ExactCurve) -> None:
        """Closed."""


class Outline(ABC):
    """A closed line around the axis."""

    @property
    @abstractmethod
    def area(self) -> float:
        """Within it [mm²]."""

    @abstractmethod
    def draw(self, pen: Pen) -> None:
        """All of its strokes."""


@dataclass(frozen=True)
class Circle(Outline):
    """A circle about the axis [mm]."""

    radius: float

    @property
    def area(self) -> float:
        return math.pi * self.radius**2

    def draw(self, pen: Pen) -> None:
        pen.circle(self.radius)
