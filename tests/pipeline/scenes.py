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


def program(law: dict[str, Any] | None = None, lift: float = LIFT) -> list[dict[str, Any]]:
    """P1's motion: rise 60°, dwell 30°, return 60°, dwell 210°."""
    free = law or {"kind": "spline"}
    return [
        {"kind": "rise", "angle_deg": 60.0, "lift_mm": lift, "law": free},
        {"kind": "dwell", "angle_deg": 30.0},
        {"kind": "return", "angle_deg": 60.0, "lift_mm": lift, "law": free},
        {"kind": "dwell", "angle_deg": 210.0},
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
