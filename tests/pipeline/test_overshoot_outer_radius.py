"""The largest radius where a free law goes beyond the ends of its segment."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from synthesis import Design, DesignSpec, synthesise

LIFT, RPM = 20.3, 91.7
BASE, BEYOND = 41.9, 1.7
FOLLOWERS: dict[str, dict[str, Any]] = {
    "roller": {"kind": "translating_roller", "roller_radius_mm": 6.7, "offset_mm": 0.0},
    "roller beside": {"kind": "translating_roller", "roller_radius_mm": 6.7, "offset_mm": 7.9},
    "flat face": {"kind": "translating_flat_face", "tilt_deg": 11.3},
}


def scene(follower: dict[str, Any], *limits: dict[str, Any]) -> Design:
    up = {"kind": "rise", "angle_deg": 121.7, "lift_mm": LIFT,
          "law": {"kind": "spline", "overshoot": True},
          "points": [{"angle_deg": 63.3, "travel_mm": LIFT + BEYOND}]}  # fmt: skip
    down = {"kind": "return", "angle_deg": 107.9, "lift_mm": LIFT}
    body = {
        "speed_rpm": RPM, "program": [up, down, {"kind": "dwell", "angle_deg": 130.4}],
        "follower": follower, "base_radius_mm": BASE, "limits": list(limits),
        "objective": {"kind": "peak_jerk"}, "tolerance": 0.05, "proof": "quick",
    }  # fmt: skip
    return synthesise(DesignSpec.model_validate(body))


def highest(design: Design) -> float:
    return float(np.max(design.curve.derivatives(np.linspace(0.0, 6.283, 20_011), 0)))


def radius(name: str, s: float) -> float:
    """Of the profile where it is touched at its highest, by plain geometry."""
    follower = FOLLOWERS[name]
    if "tilt_deg" in follower:
        return BASE + s * float(np.cos(np.radians(follower["tilt_deg"])))
    e, roller = follower["offset_mm"], follower["roller_radius_mm"]
    return float(np.hypot(e, np.sqrt((BASE + roller) ** 2 - e * e) + s)) - roller


@pytest.mark.parametrize("name", FOLLOWERS)
def test_it_holds_where_the_law_is_highest(name: str) -> None:
    free = scene(FOLLOWERS[name])
    assert free.certificate.certified
    passed = LIFT + BEYOND
    most = radius(name, passed + 0.4 * (highest(free) - passed))
    held = scene(FOLLOWERS[name], {"kind": "outer_radius", "max_mm": most})
    assert held.certificate.certified
    (extreme,) = [one for one in held.extremes if one.limit == "outer_radius"]
    assert extreme.value == pytest.approx(radius(name, highest(held)), rel=1e-6)
    assert extreme.value == pytest.approx(most, rel=1e-3)  # it bites
    assert held.objectives["peak_jerk_mm_per_s3"] > 1.001 * free.objectives["peak_jerk_mm_per_s3"]
