"""Profiles of known cams as if they had been measured."""

from __future__ import annotations

from typing import Any

import numpy as np

from synthesis import DesignSpec
from synthesis.catalogue.motion import Motion
from synthesis.catalogue.profile import cam_profile
from synthesis.studies.analyse import given_cam
from synthesis.studies.measured import MeasuredCam, ProfileAnalysis, read_back

TURN = 2.0 * np.pi
ROLLER = {"kind": "translating_roller", "roller_radius_mm": 9.3, "offset_mm": 7.1}
EDGE = {"kind": "translating_roller", "roller_radius_mm": 0.0, "offset_mm": -5.1}
FACE = {"kind": "translating_flat_face"}
ARM = {
    "kind": "oscillating_roller", "arm_mm": 85.0, "centre_distance_mm": 100.0,
    "roller_radius_mm": 9.3, "pivot_direction_deg": 31.0,
}  # fmt: skip
SPEED = 97.0
VALLEY = [
    {"kind": "return", "angle_deg": 31.3, "lift_mm": 13.7, "law": {"kind": "cycloidal"}},
    {"kind": "rise", "angle_deg": 37.7, "lift_mm": 13.7, "law": {"kind": "modified_sine"}},
    {"kind": "dwell", "angle_deg": 291.0},
]


def spec(follower: dict[str, Any], **changes: Any) -> DesignSpec:
    """A cam given in full: rise 73.3°, dwell 41.2°, return 88.9°, dwell 156.6°."""
    swings = follower["kind"] == "oscillating_roller"
    lift = {"lift_deg": 16.1} if swings else {"lift_mm": 23.7}
    body = {
        "speed_rpm": SPEED,
        "program": [
            {"kind": "rise", "angle_deg": 73.3, "law": {"kind": "modified_sine"}, **lift},
            {"kind": "dwell", "angle_deg": 41.2},
            {"kind": "return", "angle_deg": 88.9, "law": {"kind": "polynomial_4_5_6_7"}, **lift},
            {"kind": "dwell", "angle_deg": 156.6},
        ],
        "follower": follower,
        "base_radius_mm": 147.3 if follower["kind"] == "translating_flat_face" else 41.3,
    }
    return DesignSpec.model_validate(body | changes)


def profile(question: DesignSpec, count: int = 900, uneven: float = 0.0) -> np.ndarray:
    """Profile points (count, 2); ``uneven`` shakes their cam angles by that part of a step."""
    cam = given_cam(question)
    steps = np.arange(count) + uneven * np.random.default_rng(11).uniform(-0.5, 0.5, count)
    at = cam_profile(
        cam.motion, question.follower, cam.size, question.rotation, TURN * steps / count
    )
    return np.stack([at.x, at.y], axis=1)


def motion_of(question: DesignSpec) -> Motion:
    return given_cam(question).motion


def read(points: np.ndarray, follower: dict[str, Any], **more: Any) -> ProfileAnalysis:
    body = {"speed_rpm": SPEED, "points_mm": points.tolist(), "follower": follower}
    return read_back(MeasuredCam.model_validate(body | more))
