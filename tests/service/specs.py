"""Specs for the fake core: the name says what it does."""

from __future__ import annotations

import itertools
from copy import deepcopy
from typing import Any

_counter = itertools.count()


CAM: dict[str, Any] = {
    "program": [
        {"kind": "rise", "angle_deg": 60, "lift_mm": 30, "law": {"kind": "cycloidal"}},
        {"kind": "dwell", "angle_deg": 30},
        {"kind": "return", "angle_deg": 60, "lift_mm": 30, "law": {"kind": "cycloidal"}},
        {"kind": "dwell", "angle_deg": 210},
    ],
    "follower": {"kind": "translating_roller", "roller_radius_mm": 10},
    "limits": [{"kind": "pressure_angle", "rise_deg": 30, "return_deg": 45}],
}


def spec(word: str = "", **changes: Any) -> dict[str, Any]:
    """A valid spec that no other test has posted, unless ``speed_rpm`` is given."""
    return {"name": word, "speed_rpm": 100.0 + next(_counter), **deepcopy(CAM), **changes}
