"""Models that are made in Python are refused in the words of the service."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import pytest
from pydantic import ValidationError

from synthesis.spec.design_spec import DesignSpec

WRONG: dict[str, Any] = {
    "rpm": 200,
    "segments": [
        {"kind": "rise", "beta": 120, "stroke": 45, "law": "mod_sine"},
        {"kind": "dwell", "angle_deg": 60},
        {"kind": "fall", "angle_deg": 100, "lift_mm": 45},
        {"kind": "dwell", "angle_deg": 60},
    ],
    "follower": {"kind": "translating_roller", "roller_diameter_mm": 32},
}
MAKE: list[Callable[[dict[str, Any]], DesignSpec]] = [
    lambda body: DesignSpec(**body),
    DesignSpec.model_validate,
    lambda body: DesignSpec.model_validate_json(json.dumps(body)),
]


@pytest.mark.parametrize("make", MAKE, ids=["call", "dictionary", "JSON"])
def test_all_is_told_at_once(make: Callable[[dict[str, Any]], DesignSpec]) -> None:
    with pytest.raises(ValidationError) as refused:
        make(WRONG)
    told = [("/".join(map(str, each["loc"])), each["msg"]) for each in refused.value.errors()]
    assert set(told) == {
        ("rpm", 'is not a field here. Write "speed_rpm": 200.'),
        ("segments", 'is not a field here. Write "program" instead of "segments".'),
        ("segments/0/beta", 'is not a field here. Write "angle_deg": 120.'),
        ("segments/0/stroke", 'is not a field here. Write "lift_mm": 45.'),
        ("segments/0/law", 'must be an object. Write {"kind": "modified_sine"}, with further '
         "fields if it has any."),
        ("segments/2/kind", "must be one of rise, dwell, return, constant_velocity, table. "
         'Write "return".'),
        ("follower/roller_diameter_mm", 'is not a field here. Write "roller_radius_mm": 16, '
         "half of the diameter."),
        ("segments", "The angles of program sum to 340°, not 360°. Add 20°: write 80 instead of 60 "
         'at program/3/angle_deg, or add {"kind": "dwell", "angle_deg": 20}.'),
    }  # fmt: skip


def test_errors_of_the_core_stay_as_they_are() -> None:
    body = {**WRONG, "program": WRONG["segments"][1:2], "speed_rpm": 60}
    del body["rpm"], body["segments"]
    body["follower"] = {"kind": "translating_roller", "roller_radius_mm": 16}
    with pytest.raises(ValidationError) as refused:
        DesignSpec.model_validate(body)
    (error,) = refused.value.errors()
    assert error["type"] == "program_angles"
    assert error["ctx"]["value"] == 60.0
    assert error["loc"] == ()


def test_what_is_no_json_is_said_by_its_reader() -> None:
    with pytest.raises(ValidationError, match="Invalid JSON"):
        DesignSpec.model_validate_json("{")
