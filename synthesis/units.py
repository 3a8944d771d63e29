"""Conversions between the wire (deg, rpm) and the core (rad, rad/s); lengths are mm in both."""

from __future__ import annotations

import math

DEGREE = math.pi / 180.0
FULL_TURN = 2.0 * math.pi


def rad_per_s(speed_rpm: float) -> float:
    """Angular speed ω in rad/s of a shaft turning at ``speed_rpm``."""
    return speed_rpm * FULL_TURN / 60.0
