"""One or more given cams of every follower family, at sizes where nothing is special."""

from __future__ import annotations

from typing import Any

from synthesis.spec import DesignSpec

SLIDE = {"kind": "translating_roller", "roller_radius_mm": 9.3, "offset_mm": 7.1}
ARM = {"kind": "oscillating_roller", "arm_mm": 81.3, "roller_radius_mm": 17.9}
FACE = {"kind": "oscillating_flat_face", "face_offset_mm": 4.3}
RING = {"closure": {"kind": "force", "contact": "inside"}}
GROOVE = {"closure": {"kind": "groove", "clearance_mm": 0.21}}
PAIR = {
    "closure": {
        "kind": "conjugate", "roller_radius_mm": 6.7, "offset_mm": -2.9, "distance_mm": 148.3,
    }
}  # fmt: skip
LEVER = {
    "closure": {"kind": "conjugate", "roller_radius_mm": 8.3, "arm_mm": 66.1, "angle_deg": 118.7}
}
# family: followers and their base radii
SAMPLES: dict[str, list[tuple[dict[str, Any], float]]] = {
    "translating_roller": [
        (SLIDE, 41.9),
        (SLIDE | {"roller_radius_mm": 0.0, "offset_mm": -3.7}, 52.3),
        (SLIDE | RING, 74.9),
        (SLIDE | GROOVE, 58.7),
        (SLIDE | PAIR, 44.3),
    ],
    "translating_flat_face": [
        ({"kind": "translating_flat_face"}, 97.7),
        ({"kind": "translating_flat_face", "tilt_deg": -6.7, "offset_mm": 3.1}, 91.3),
    ],
    "oscillating_roller": [
        (ARM | {"centre_distance_mm": 107.9, "pivot_direction_deg": 23.0}, 71.7),
        (ARM | {"centre_distance_mm": 93.1, "sense": "same", "pivot_direction_deg": -61.0}, 64.3),
        (ARM | RING | {"centre_distance_mm": 111.7, "pivot_direction_deg": 17.0}, 97.9),
        (ARM | RING | {"centre_distance_mm": 119.3, "sense": "same"}, 101.3),
        (ARM | GROOVE | {"centre_distance_mm": 107.9, "pivot_direction_deg": 23.0}, 62.9),
        (ARM | GROOVE | {"centre_distance_mm": 109.1, "sense": "same"}, 66.7),
        (ARM | LEVER | {"centre_distance_mm": 107.9, "pivot_direction_deg": 23.0}, 54.1),
        (ARM | LEVER | {"centre_distance_mm": 103.7, "sense": "same"}, 49.9),
    ],
    "oscillating_flat_face": [
        (FACE | {"centre_distance_mm": 103.9, "pivot_direction_deg": -37.0}, 63.7),
        (FACE | {"centre_distance_mm": 131.1, "sense": "same", "face_offset_mm": -5.9}, 97.3),
    ],
}  # fmt: skip
LIFTS = {
    "translating_roller": 19.7, "translating_flat_face": 19.7,
    "oscillating_roller": 23.3, "oscillating_flat_face": 13.7,
}  # fmt: skip
"""In the unit of the family's travel: faces on pivots are undercut by larger swings."""
CASES = [(kind, i) for kind, samples in SAMPLES.items() for i in range(len(samples))]


def spec(
    kind: str, sample: int = 0, laws: tuple[str, str] = ("polynomial_4_5_6_7", "cycloidal"),
    **changes: Any,
) -> DesignSpec:  # fmt: skip
    """A given cam of a family, with its laws up and down."""
    follower, base = SAMPLES[kind][sample]
    unit = "deg" if "oscillating" in kind else "mm"
    lift = {f"lift_{unit}": LIFTS[kind]}
    body = {
        "name": f"{kind} {sample}",
        "speed_rpm": 137.0,
        "program": [
            {"kind": "rise", "angle_deg": 97.3, "law": {"kind": laws[0]}} | lift,
            {"kind": "dwell", "angle_deg": 41.2},
            {"kind": "return", "angle_deg": 118.9, "law": {"kind": laws[1]}} | lift,
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
