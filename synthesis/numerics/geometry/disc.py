"""Plane curves drawn on a turning disc, from a point that moves in the machine frame.

A point p(θ) fixed to the machine traces on a cam that turns counter-clockwise the curve
R(−θ) p(θ). Its derivatives, seen in the machine frame, follow from D = d/dθ + J with
J (x, y) = (y, −x). So every disc cam is measured by one rule, whatever moves its follower.
"""

from __future__ import annotations

import numpy as np

from synthesis.numerics.piecewise import Array


def to_cam(theta: Array, x: Array, y: Array) -> tuple[Array, Array]:
    """Turn vectors of the machine frame into the frame of a ccw cam at angle θ [rad].

    Args:
        theta, x, y: (n,).

    Returns:
        x and y in the cam frame, (n,) each.
    """
    cos, sin = np.cos(theta), np.sin(theta)
    return x * cos + y * sin, y * cos - x * sin
