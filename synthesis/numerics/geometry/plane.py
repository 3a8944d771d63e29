"""Plane geometry of a turning disc: frames of machine and cam, and the triangle of an arm.

A point p(θ) fixed to the machine traces on a cam that turns counter-clockwise the curve
R(−θ) p(θ). Its derivatives, seen in the machine frame, follow from D = d/dθ + J with
J (x, y) = (y, −x). So every disc cam is measured by one rule, whatever moves its follower.
"""

from __future__ import annotations

import math

import numpy as np

from synthesis.numerics.piecewise import Array


def to_cam(theta: Array, x: Array, y: Array) -> tuple[Array, Array]:
    """Turn vectors (n,) of the machine frame into the frame of a ccw cam at angles θ (n,) [rad]."""
    cos, sin = np.cos(theta), np.sin(theta)
    return x * cos + y * sin, y * cos - x * sin


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
