"""Loads that make no sense are refused with the reason and the way out."""

from __future__ import annotations

from typing import Any

import pytest
from pydantic import ValidationError

from synthesis import DesignSpec
from synthesis.errors.places import PLACES
from tests.catalogue.followers.samples import spec
from tests.catalogue.forces.loads import ARM, SLIDE
from tests.catalogue.forces.test_limited import BODY

GROOVE = {"kind": "groove", "clearance_mm": 0.1}
GUIDED = {"coefficient": 0.1, "overhang_mm": 12.0, "bearing_length_mm": 50.0}


def refused(kind: str, load: dict[str, Any] | None, **changes: Any) -> tuple[str, str]:
    with pytest.raises(ValidationError) as caught:
        spec(kind, 0, load=load, **changes)
    (error,) = caught.value.errors()
    return error["type"], error["msg"]


@pytest.mark.parametrize(
    ("kind", "load", "changes", "wanted", "words"),
    [
        ("translating_roller", ARM, {}, "load_does_not_suit", "kind slide"),
        ("oscillating_roller", SLIDE, {}, "load_does_not_suit", "kind arm"),
        (
            "translating_roller",
            {"kind": "slide", "moving_mass_kg": 1.0, "process": [{"angle_deg": 0, "force_n": -3}]},
            {}, "nothing_presses_follower", "load/spring",
        ),
        ("translating_flat_face", SLIDE | {"friction": GUIDED}, {}, "friction_does_not_suit",
         "Leave it out"),
        ("translating_roller", SLIDE | {"friction": GUIDED}, {}, "overhang_too_short", "stroke"),
        ("translating_roller", None, {"limits": [{"kind": "contact_force", "min_n": 0}]},
         "limit_needs_load", "Give load"),
        (
            "translating_roller",
            {name: value for name, value in SLIDE.items() if name != "contact"},
            {"limits": [{"kind": "hertz_pressure", "max_mpa": 900}]}, "limit_needs_contact",
            "width_mm",
        ),
        (
            "translating_roller", SLIDE,
            {"limits": [{"kind": "hertz_pressure", "max_mpa": 900}],
             "follower": {"kind": "translating_roller", "roller_radius_mm": 0, "offset_mm": 1}},
            "edge_has_no_pressure", "radius",
        ),
        (
            "translating_roller", SLIDE,
            {"limits": [{"kind": "contact_force", "min_n": 0}],
             "follower": {"kind": "translating_roller", "roller_radius_mm": 9, "offset_mm": 1,
                          "closure": GROOVE}},
            "never_floats", "both ways",
        ),
    ],
)  # fmt: skip
def test_what_does_not_fit_together(
    kind: str, load: dict[str, Any] | None, changes: dict[str, Any], wanted: str, words: str
) -> None:
    name, message = refused(kind, load, **changes)
    assert name == wanted
    assert words in message
    assert wanted in PLACES


def test_friction_asks_for_one_sense() -> None:
    body = BODY | {"load": BODY["load"] | {"friction": GUIDED | {"overhang_mm": 70.0}}}
    program = [dict(segment) for segment in BODY["program"]]
    program[0]["law"] = {"kind": "spline", "overshoot": True}
    with pytest.raises(ValidationError, match="may move both ways"):
        DesignSpec.model_validate(body | {"program": program})


@pytest.mark.parametrize(
    ("load", "words"),
    [
        ({"moving_mass_kg": -2.0}, "at least 0"),
        ({"spring": {"rate_n_per_mm": -4.0}}, "pulls the follower off its cam"),
        ({"spring": {"preload_n": {"min": -5.0, "max": 3.0}}}, "pulls the follower off its cam"),
        ({"process": [{"angle_deg": 30, "force_n": 1}, {"angle_deg": 20, "force_n": 1}]}, "order"),
        ({"process": [{"angle_deg": 5, "force_n": k} for k in range(3)]}, "Two make a jump"),
        ({"speeds": {"min_rpm": 50, "max_rpm": 40}}, "Exchange"),
    ],
)
def test_numbers_that_no_machine_has(load: dict[str, Any], words: str) -> None:
    _, message = refused("translating_roller", SLIDE | load)
    assert words in message


@pytest.mark.parametrize(
    ("limit", "words"),
    [
        ({"kind": "contact_force"}, "gives no limit"),
        ({"kind": "contact_force", "min_n": 5, "max_n": 5}, "Exchange the two"),
    ],
)
def test_limits_that_say_nothing(limit: dict[str, Any], words: str) -> None:
    _, message = refused("translating_roller", SLIDE, limits=[limit])
    assert words in message
