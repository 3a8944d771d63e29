"""Given cams at sizes where nothing is special, and their textbook formulas on a grid."""

from __future__ import annotations

from typing import Any

import numpy as np

from synthesis import DesignSpec
from synthesis.catalogue.motion import Motion

PRESSURE = {"kind": "pressure_angle", "rise_deg": 31.7, "return_deg": 43.1}


def program(rise: str = "modified_sine", back: str = "cycloidal") -> list[dict[str, Any]]:
    return [
        {"kind": "rise", "angle_deg": 73.3, "lift_mm": 23.7, "law": {"kind": rise}},
        {"kind": "dwell", "angle_deg": 41.2},
        {"kind": "return", "angle_deg": 88.9, "lift_mm": 23.7, "law": {"kind": back}},
        {"kind": "dwell", "angle_deg": 156.6},
    ]


def spec(**changes: Any) -> DesignSpec:
    body: dict[str, Any] = {
        "speed_rpm": 137.0,
        "program": program(),
        "follower": {"kind": "translating_roller", "roller_radius_mm": 9.3, "offset_mm": 7.1},
        "base_radius_mm": 21.9,
        "limits": [PRESSURE],
    }
    return DesignSpec.model_validate(body | changes)


def roller(radius: float, offset: float = 7.1) -> dict[str, Any]:
    return {"kind": "translating_roller", "roller_radius_mm": radius, "offset_mm": offset}


class Textbook:
    """s to s''', pressure angle [deg] and pitch curvature by the formulas of the literature."""

    def __init__(self, question: DesignSpec, points: int = 400_001) -> None:
        self.degrees = np.linspace(0.0, 360.0, points)
        theta = np.radians(self.degrees)
        motion = Motion.of(question.placed_segments())
        e, roller_radius = question.follower.offset_mm, question.follower.roller_radius_mm
        prime = question.base_radius_mm + roller_radius
        self.s = s = motion.derivatives(theta, 3)
        x, u = s[0] + np.sqrt(prime**2 - e**2), s[1] - e
        self.alpha = np.degrees(np.arctan(u / x))
        self.curvature = (x**2 + u * (u + s[1]) - x * s[2]) / (x**2 + u**2) ** 1.5
