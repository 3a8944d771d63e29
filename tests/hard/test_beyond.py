"""How the judge of conflicts leaves members out."""

from __future__ import annotations

from synthesis import DesignSpec, synthesise
from tests.hard.beyond import FLOOR, put, questions, without_each
from tests.hard.families import random_scene

BODY = {
    "speed_rpm": 60,
    "program": [
        {"kind": "rise", "angle_deg": 90, "lift_mm": 10},
        {"kind": "return", "angle_deg": 270, "lift_mm": 10},
    ],
    "follower": {"kind": "translating_roller", "roller_radius_mm": 8, "offset_mm": 0},
    "limits": [
        {"kind": "pressure_angle", "rise_deg": 30, "return_deg": 35},
        {"kind": "jerk", "max_mm_per_s3": 1e6},
    ],
    "base_radius_mm": {"max": 20},
}


def test_the_others_alone_are_asked_without_a_member() -> None:
    """What is no member is left out too: with it there may be another conflict."""
    members = {"pressure_angle_rise", "base_radius", "offset"}
    others = dict(without_each(BODY, members))
    assert set(others) == members
    for member, body in others.items():
        assert ("max" in (body.get("base_radius_mm") or {})) is (member != "base_radius")
        assert ("offset_mm" in body["follower"]) is (member != "offset")
        angles = [] if member == "pressure_angle_rise" else [("pressure_angle", 30.0)]
        assert [(x["kind"], x.get("rise_deg")) for x in body["limits"]] == angles
        assert all("return_deg" not in limit for limit in body["limits"])
        DesignSpec.model_validate(body)  # without a pressure angle no cam is the smallest


def test_a_value_is_put_at_its_path() -> None:
    assert put(BODY, "limits/0/rise_deg", 33.0)["limits"][0]["rise_deg"] == 33.0
    assert put(BODY, "base_radius_mm/max", 25.0)["base_radius_mm"] == {"max": 25.0}
    assert put(BODY, "speed_rpm", 50.0)["speed_rpm"] == 50.0
    # a dimension that is given may then be anywhere up to the value
    assert put(BODY, "follower/offset_mm", 2.0)["follower"]["offset_mm"] == {"min": 0, "max": 2.0}
    assert put(BODY, "follower/arm_mm", 2.0)["follower"]["arm_mm"] == 2.0


def test_the_end_of_a_search_is_no_number_of_a_question() -> None:
    """The smallest cam of this scene is as small as any that is sought: 1e-7 mm."""
    (found,) = questions("slide, residual vibration", 10)
    assert found.kind == "jerk"
    spec = DesignSpec.model_validate(found.body)
    assert spec.base_radius_range()[1] == FLOOR * spec.stroke()


def test_a_bound_at_chosen_numbers_is_no_bound_of_a_question() -> None:
    """There may be smaller cams on arms of another length."""
    body = random_scene("arm, length free", 601)
    valid_for = synthesise(DesignSpec.model_validate(body)).certificate.bound_valid_for
    assert valid_for.endswith("at the chosen numbers alone")
    assert not list(questions("arm, length free", 601))
