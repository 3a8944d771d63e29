"""The triangle of an arm: two sides that meet at the pivot, and the third one."""

from __future__ import annotations

import math


def third_side(a: float, b: float, angle: float) -> float:
    """Side opposite to ``angle`` [rad], which the sides a and b enclose.

    R² = (a − b)² + 4ab sin²(angle/2): the law of cosines, without its cancellation.
    """
    return math.hypot(a - b, 2.0 * math.sqrt(a * b) * math.sin(0.5 * angle))


def enclosed_angle(a: float, b: float, opposite: float) -> float:
    """Angle that the sides a and b enclose [rad].

    0 where the opposite side is too short for a triangle, π where it is too long.
    """
    difference = (opposite - abs(a - b)) * (opposite + abs(a - b))
    total = (a + b - opposite) * (a + b + opposite)
    return 2.0 * math.atan2(math.sqrt(max(difference, 0.0)), math.sqrt(max(total, 0.0)))
