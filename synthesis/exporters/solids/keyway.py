"""A keyway in a bore: its size by DIN 6885-1 (as ISO 773) where none is given, and its area."""

from __future__ import annotations

import math
from dataclasses import dataclass

from synthesis.errors import InputError
from synthesis.exporters.solids.outline import Outline, Pen, Place

# Bores over … up to … [mm], width of the key, depth of the keyway in the hub beyond the bore.
STANDARD = (
    (6.0, 8.0, 2.0, 1.0), (8.0, 10.0, 3.0, 1.4), (10.0, 12.0, 4.0, 1.8), (12.0, 17.0, 5.0, 2.3),
    (17.0, 22.0, 6.0, 2.8), (22.0, 30.0, 8.0, 3.3), (30.0, 38.0, 10.0, 3.3),
    (38.0, 44.0, 12.0, 3.3), (44.0, 50.0, 14.0, 3.8), (50.0, 58.0, 16.0, 4.3),
    (58.0, 65.0, 18.0, 4.4), (65.0, 75.0, 20.0, 4.9), (75.0, 85.0, 22.0, 5.4),
    (85.0, 95.0, 25.0, 5.4), (95.0, 110.0, 28.0, 6.4), (110.0, 130.0, 32.0, 7.4),
    (130.0, 150.0, 36.0, 8.4), (150.0, 170.0, 40.0, 9.4), (170.0, 200.0, 45.0, 10.4),
    (200.0, 230.0, 50.0, 11.4),
)  # fmt: skip


@dataclass(frozen=True)
class Bore(Outline):
    """A bore around the axis, with or without a keyway.

    Attributes:
        radius: [mm]. width: of the keyway, 0 without one. depth: beyond the bore's radius.
        direction: in which it lies from the axis [rad].
    """

    radius: float
    width: float = 0.0
    depth: float = 0.0
    direction: float = 0.0

    @property
    def reach(self) -> float:
        """Largest distance from the axis [mm]."""
        return math.hypot(0.5 * self.width, self.radius + self.depth) if self.width else self.radius

    @property
    def area(self) -> float:
        # the circle, and the keyway less what of it is the circle's
        r, half = self.radius, 0.5 * self.width
        within = half * self._shoulder + r * r * math.asin(half / r)
        return math.pi * r * r + (self.width * (r + self.depth) - within if half else 0.0)

    @property
    def _shoulder(self) -> float:
        """How far from the axis the keyway's sides begin, along it [mm]."""
        return math.sqrt(self.radius**2 - 0.25 * self.width**2)

    def draw(self, pen: Pen) -> None:
        if not self.width:
            pen.circle(self.radius)
            return
        half, top = 0.5 * self.width, self.radius + self.depth
        left, right = self._at(self._shoulder, half), self._at(self._shoulder, -half)
        pen.arc(self.radius, left, right)
        pen.line(right, self._at(top, -half))
        pen.line(self._at(top, -half), self._at(top, half))
        pen.line(self._at(top, half), left)

    def _at(self, along: float, across: float) -> Place:
        cos, sin = math.cos(self.direction), math.sin(self.direction)
        return cos * along - sin * across, sin * along + cos * across


def bore_of(
    diameter: float, keyed: bool, width: float | None, depth: float | None, direction_deg: float
) -> Bore:
    """A bore [mm], its keyway by the standard where no size is given."""
    if not keyed:
        return Bore(0.5 * diameter)
    if width is None or depth is None:
        found = [row[2:] for row in STANDARD if row[0] < diameter <= row[1]]
        if not found:
            raise InputError(
                "/bore_mm",
                diameter,
                "DIN 6885-1 has keys for bores above 6 and up to 230 mm.",
                "Give keyway_width_mm and keyway_depth_mm.",
            )
        width, depth = width or found[0][0], depth or found[0][1]
    if width >= diameter:
        raise InputError(
            "/keyway_width_mm",
            width,
            f"The keyway must be narrower than the bore, {diameter:g} mm.",
            "Make it narrower, or the bore wider.",
        )
    return Bore(0.5 * diameter, width, depth, math.radians(direction_deg))
