"""States, straight lines and tables of followers on arms: degrees in, degrees out."""

from __future__ import annotations

from math import pi
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from synthesis import DesignSpec, analyse
from synthesis.catalogue.laws import LAWS
from synthesis.catalogue.motion import Motion

OMEGA = 83.0 * pi / 30.0
ARM = 85.0
FOLLOWER = {"kind": "oscillating_roller", "arm_mm": ARM, "centre_distance_mm": 104.3,
            "roller_radius_mm": 11.7}  # fmt: skip
QUINTIC = {"kind": "polynomial_5"}


def spec(program: list[dict[str, Any]], **changes: Any) -> DesignSpec:
    body: dict[str, Any] = {
        "speed_rpm": 83.0, "program": program, "follower": FOLLOWER, "base_radius_mm": 41.2,
    }  # fmt: skip
    return DesignSpec.model_validate(body | changes)


def program(**end: float) -> list[dict[str, Any]]:
    return [
        {"kind": "rise", "angle_deg": 88.7, "lift_deg": 12.4, "law": QUINTIC, "end": end or None},
        {"kind": "constant_velocity", "angle_deg": 31.1, "lift_deg": 5.2},
        {"kind": "rise", "angle_deg": 70.4, "lift_deg": 6.7, "law": QUINTIC},
        {"kind": "return", "angle_deg": 169.8, "lift_deg": 24.3, "law": {"kind": "cycloidal"}},
    ]


def test_a_straight_line_in_degrees_is_picked_up() -> None:
    question = spec(program(), continuity=2)
    found = analyse(question)
    assert found.holds, found.violated
    velocity = 5.2 / 31.1 * OMEGA / pi * 180.0  # deg/s
    by_speed = program()
    by_speed[1] = {"kind": "constant_velocity", "angle_deg": 31.1, "velocity_deg_per_s": velocity}
    assert spec(by_speed).lifts() == pytest.approx(question.lifts(), rel=1e-14)
    motion = Motion.of(question.placed_segments())
    s, v = motion.derivatives(np.radians([100.0]), 1)[:, 0]
    assert v == pytest.approx(ARM * 5.2 / 31.1, rel=1e-13)  # of the roller's arc, per radian
    assert s == pytest.approx(ARM * np.radians(12.4 + 5.2 * 11.3 / 31.1), rel=1e-12)


def test_states_in_degrees_are_met_and_told_in_degrees() -> None:
    velocity = 5.2 / 31.1 * OMEGA / pi * 180.0
    found = analyse(spec(program(velocity_deg_per_s=velocity, acceleration_deg_per_s2=-40.0)))
    extremes = {extreme.limit: extreme for extreme in found.extremes}
    assert extremes["velocity_required"].unit == "deg/s"
    assert extremes["acceleration_required"].holds
    (jump,) = [j for j in found.jumps if j.curve == "acceleration" and j.angle_deg < 100.0]
    assert jump.angle_deg == pytest.approx(88.7)
    assert (jump.before, jump.after) == pytest.approx((-40.0, 0.0), abs=1e-8)


def test_a_wrong_velocity_is_refused_in_degrees() -> None:
    with pytest.raises(ValidationError, match=r"^(?s:.*)7.0 deg/s at the end of program/0"):
        spec(program(velocity_deg_per_s=7.0))
    with pytest.raises(ValidationError, match="all in deg"):
        spec(program(velocity_mm_per_s=7.0))


def test_a_table_in_degrees() -> None:
    rng = np.random.default_rng(8)
    x = np.sort(np.concatenate([[0.0, 1.0], rng.uniform(0.0, 1.0, 97)]))
    swing = 24.3 * LAWS["modified_sine"].curve("rise")(x) + rng.uniform(-3e-5, 3e-5, 99)
    table = {"kind": "table", "angle_deg": 121.2, "tolerance_deg": 5e-5, "lift_deg": 24.3,
             "points": np.stack([121.2 * x, swing], axis=1).tolist()}  # fmt: skip
    back = {"kind": "return", "angle_deg": 238.8, "lift_deg": 24.3, "law": {"kind": "cycloidal"}}
    found = analyse(spec([table, back], continuity=2))
    assert found.holds, found.violated
    (deviation,) = [e for e in found.extremes if e.limit == "table_deviation"]
    assert (deviation.unit, deviation.field) == ("deg", "program/0/tolerance_deg")
    assert 2e-5 <= deviation.value <= 5e-5
    assert deviation.bound == pytest.approx(5e-5, rel=1e-12)
