"""Sets of unspecial size: cams given in full, so that they are finished in milliseconds."""

from __future__ import annotations

from typing import Any

from synthesis import CamSetSpec

INLET: dict[str, Any] = {
    "program": [
        {"kind": "rise", "angle_deg": 71.3, "lift_mm": 13.7, "law": {"kind": "cycloidal"}},
        {"kind": "dwell", "angle_deg": 24.6},
        {"kind": "return", "angle_deg": 88.4, "lift_mm": 13.7, "law": {"kind": "modified_sine"}},
        {"kind": "dwell", "angle_deg": 175.7},
    ],
    "follower": {"kind": "translating_roller", "roller_radius_mm": 9.1, "offset_mm": 6.7},
    "base_radius_mm": 41.9,
}
PRESS: dict[str, Any] = {
    "program": [
        {"kind": "dwell", "angle_deg": 33.1},
        {"kind": "rise", "angle_deg": 101.9, "lift_mm": 8.3, "law": {"kind": "modified_trapezoid"}},
        {"kind": "return", "angle_deg": 120.0, "lift_mm": 8.3, "law": {"kind": "cycloidal"}},
        {"kind": "dwell", "angle_deg": 105.0},
    ],
    "follower": {"kind": "translating_roller", "roller_radius_mm": 7.3, "offset_mm": -4.1},
    "base_radius_mm": 33.3,
}


def body(**changes: Any) -> dict[str, Any]:
    """Two cams, both turned: the second's follower does not stand upwards."""
    return {
        "name": "inlet and press",
        "speed_rpm": 143.7,
        "rotation": "ccw",
        "cams": [
            {"name": "inlet", "phase_deg": 37.9, "axial_mm": 12.5, "spec": INLET},
            {
                "name": "press",
                "phase_deg": -143.2,
                "axial_mm": -31.25,
                "follower_direction_deg": 208.6,
                "spec": PRESS,
            },
        ],
        **changes,
    }


def question(**changes: Any) -> CamSetSpec:
    return CamSetSpec.model_validate(body(**changes))
