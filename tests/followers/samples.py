"""One or more given cams of every follower family, at sizes where nothing is special."""

from __future__ import annotations

from typing import Any

from synthesis.spec import DesignSpec

ARM = {"kind": "oscillating_roller", "arm_mm": 81.3, "roller_radius_mm": 17.9}
# family: follower, base radius, and what it may not exceed
SAMPLES: dict[str, list[tuple[dict[str, Any], float]]] = {
    "translating_roller": [
        ({"kind": "translating_roller", "roller_radius_mm": 9.3, "offset_mm": 7.1}, 41.9),
        ({"kind": "translating_roller", "roller_radius_mm": 0.0, "offset_mm": -3.7}, 52.3),
    ],
    "translating_flat_face": [({"kind": "translating_flat_face"}, 97.7)],
    "oscillating_roller": [
        (ARM | {"centre_distance_mm": 107.9, "pivot_direction_deg": 23.0}, 71.7),
        (ARM | {"centre_distance_mm": 93.1, "sense": "same", "pivot_direction_deg": -61.0}, 64.3),
    ],
}  # fmt: skip
LIFTS = {"mm": 19.7, "deg": 23.3}
CASES = [(kind, i) for kind, samples in SAMPLES.items() for i in range(len(samples))]


def spec(kind: str, sample: int = 0, **changes: Any) -> DesignSpec:
    """A given cam of a family: 4-5-6-7 up, cycloidal down."""
    follower, base = SAMPLES[kind][sample]
    unit = "deg" if "arm_mm" in follower else "mm"
    lift = {f"lift_{unit}": LIFTS[unit]}
    body = {
        "name": f"{kind} {sample}",
        "speed_rpm": 137.0,
        "program": [
            {"kind": "rise", "angle_deg": 97.3, "law": {"kind": "polynomial_4_5_6_7"}} | lift,
            {"kind": "dwell", "angle_deg": 41.2},
            {"kind": "return", "angle_deg": 118.9, "law": {"kind": "cycloidal"}} | lift,
            {"kind": "dwell", "angle_deg": 102.6},
        ],
        "follower": follower,
        "base_radius_mm": base,
        "limits": [
            {"kind": "velocity", f"max_{unit}_per_s": 1e4},
            {"kind": "acceleration", f"max_{unit}_per_s2": 1e6},
            {"kind": "jerk", f"max_{unit}_per_s3": 1e8},
        ],
    }
    return DesignSpec.model_validate(body | changes)
