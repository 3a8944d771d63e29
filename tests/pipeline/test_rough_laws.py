"""Splines whose acceleration may jump, with every family: certified, and confirmed in balls."""

from __future__ import annotations

from typing import Any

import pytest

from synthesis import DesignSpec, confirm, synthesise

ROUGH = {"kind": "spline", "smoothness": 1}
ROLLER = {"kind": "translating_roller", "roller_radius_mm": 5.3}
FOLLOWERS: dict[str, tuple[str, dict[str, Any], list[dict[str, Any]]]] = {
    "roller": ("mm", ROLLER, [{"kind": "pressure_angle", "rise_deg": 31.0, "return_deg": 37.0}]),
    "face": (
        "mm", {"kind": "translating_flat_face"}, [{"kind": "profile_radius", "min_mm": 5.3}],
    ),
    "arm": (
        "deg",
        {"kind": "oscillating_roller", "arm_mm": 61.3, "centre_distance_mm": 73.9,
         "roller_radius_mm": 6.1},
        [{"kind": "pressure_angle", "rise_deg": 41.0, "return_deg": 41.0}],
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", FOLLOWERS)
def test_every_family(name: str) -> None:
    unit, follower, limits = FOLLOWERS[name]
    move = {f"lift_{unit}": 11.3, "law": ROUGH}
    # 4.7 h/β² of the rise: the least there is is 4
    peak = 4.7 * 11.3 * (6.0 * 60.0 / 91.7) ** 2
    limits = [*limits, {"kind": "acceleration", f"max_{unit}_per_s2": peak}]
    spec = DesignSpec.model_validate({
        "speed_rpm": 60.0,
        "program": [
            {"kind": "rise", "angle_deg": 91.7} | move, {"kind": "dwell", "angle_deg": 21.3},
            {"kind": "return", "angle_deg": 103.9} | move, {"kind": "dwell", "angle_deg": 143.1},
        ],
        "follower": follower, "limits": limits, "tolerance": 2e-2,
    })  # fmt: skip
    design = synthesise(spec)
    assert design.certificate.certified
    assert {m.spline.degree for m in design.motion if m.spline is not None} == {2}
    assert max(e.value for e in design.extremes if e.limit == "acceleration_jump") > 0.0
    assert confirm(design).verdict == "confirmed"
