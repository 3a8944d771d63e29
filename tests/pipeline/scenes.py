"""Specs for the pipeline's tests."""

from __future__ import annotations

from math import pi
from typing import Any

from synthesis import DesignSpec

OMEGA = 10.0  # rad/s
LIFT, BETA = 30.0, pi / 3.0
CYCLOIDAL = {"kind": "cycloidal"}
PRESSURE = {"kind": "pressure_angle", "rise_deg": 30.0, "return_deg": 45.0}


def jerk(factor: float, lift: float = LIFT, beta: float = BETA, omega: float = OMEGA) -> dict:
    """A jerk limit of ``factor`` h/β³."""
    return {"kind": "jerk", "max_mm_per_s3": factor * lift / beta**3 * omega**3}


def program(
    law: dict[str, Any] | None = None,
    lift: float = LIFT,
    angles: tuple[float, float, float, float] = (60.0, 30.0, 60.0, 210.0),
) -> list[dict[str, Any]]:
    """Rise, dwell, return, dwell; left out, P1's motion."""
    free = law or {"kind": "spline"}
    rise, above, back, below = angles
    return [
        {"kind": "rise", "angle_deg": rise, "lift_mm": lift, "law": free},
        {"kind": "dwell", "angle_deg": above},
        {"kind": "return", "angle_deg": back, "lift_mm": lift, "law": free},
        {"kind": "dwell", "angle_deg": below},
    ]


def spec(**changes: Any) -> DesignSpec:
    """P1's motion as a scene with free laws, changed as asked."""
    body: dict[str, Any] = {
        "speed_rpm": OMEGA * 30.0 / pi,
        "program": program(),
        "follower": {"kind": "translating_roller", "roller_radius_mm": 10.0},
        "limits": [PRESSURE, jerk(48.0)],
        "tolerance": 5e-3,
        "proof": "quick",
    }
    return DesignSpec.model_validate(body | changes)
