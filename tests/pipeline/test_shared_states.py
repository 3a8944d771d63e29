"""What is asked on one side of a joint of two free laws holds on both."""

from __future__ import annotations

from typing import Any

import pytest

from synthesis import DesignSpec


@pytest.mark.parametrize(("segment", "end"), [(0, "end"), (1, "start")])
def test_a_velocity_asked_on_one_side_is_that_of_both(segment: int, end: str) -> None:
    program: list[dict[str, Any]] = [
        {"kind": "rise", "angle_deg": 67.3, "lift_mm": 17.9},
        {"kind": "rise", "angle_deg": 59.1, "lift_mm": 14.3},
        {"kind": "return", "angle_deg": 101.7, "lift_mm": 32.2},
        {"kind": "dwell", "angle_deg": 131.9},
    ]
    program[segment] |= {end: {"velocity_mm_per_s": 83.1}}
    body = {
        "speed_rpm": 71.3,
        "program": program,
        "follower": {"kind": "translating_roller", "roller_radius_mm": 8.3},
        "limits": [{"kind": "pressure_angle", "rise_deg": 35.0}],
    }
    first, second, *_ = DesignSpec.model_validate(body).placed_segments()
    assert first.end_state.velocity is not None, "the end of the first knows of no velocity"
    assert first.end_state.velocity == second.start_state.velocity
    assert second.end_state.velocity is None
