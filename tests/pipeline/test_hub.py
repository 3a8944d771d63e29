"""A shaft: the base circle leaves room for its hub, and the cam's files have its bore."""

from __future__ import annotations

import io
from math import pi
from typing import Any

import ezdxf
import pytest
from pydantic import ValidationError

from synthesis import Design, DesignSpec, confirm, sensitivities, synthesise
from synthesis.certify import certify_size
from synthesis.errors import InputError
from synthesis.exporters import PROFILE_FORMATS
from synthesis.exporters.curves.dxf import DrawingOptions
from synthesis.exporters.solids.blank import SolidOptions, blank
from synthesis.pipeline.proof_file.claims import proof_file
from synthesis.pipeline.relaxable import relaxable_numbers, without
from tests.pipeline import scenes

SHAFT = 33.0
HUB = 1.75 * SHAFT + 6.35  # eq. 6.21 of the handbook: 1 3/4 shaft diameters + 1/4 in
PRESSURE = {"kind": "pressure_angle", "rise_deg": 33.0, "return_deg": 41.0}
JERK = {"kind": "jerk", "max_mm_per_s3": 9e5}


def spec(**changes: Any) -> DesignSpec:
    body = {
        "speed_rpm": 90.0,
        "program": scenes.program(lift=23.0, angles=(97.0, 43.0, 113.0, 107.0)),
        "follower": {"kind": "translating_roller", "roller_radius_mm": 9.5},
        "limits": [PRESSURE, JERK],
    }
    return DesignSpec.model_validate(body | changes)


@pytest.fixture(scope="module")
def answer() -> Design:
    return synthesise(spec(shaft_diameter_mm=SHAFT, keyway=True))


def line(design: Design, field: str) -> Any:
    (found,) = (extreme for extreme in design.extremes if extreme.field == field)
    return found


def test_the_base_circle_is_the_hub(answer: Design) -> None:
    smaller = synthesise(spec(proof="quick", tolerance=0.1))
    assert smaller.dimensions["base_radius_mm"] < 0.8 * HUB / 2.0
    assert answer.dimensions["base_radius_mm"] == pytest.approx(HUB / 2.0, rel=1e-6)
    assert answer.certificate.lower_bound == pytest.approx(HUB / 2.0, rel=1e-9)
    assert answer.status == "optimal"
    extreme = line(answer, "shaft_diameter_mm")
    assert extreme.holds
    assert extreme.bound == SHAFT
    assert extreme.value == pytest.approx(SHAFT, rel=1e-6)
    assert "64.1 mm across" in extreme.evidence
    assert "eq. 6.21" in extreme.evidence


def test_a_cam_without_that_room_is_refused(answer: Design) -> None:
    """The same cam, judged for a shaft a hundredth thicker."""
    thicker = answer.spec.model_copy(update={"shaft_diameter_mm": 1.01 * SHAFT})
    found = {line.field: line for line in certify_size(thicker, tuple(answer.size))}
    assert not found["shaft_diameter_mm"].holds
    assert found["shaft_diameter_mm"].margin == pytest.approx(-0.01 * SHAFT, rel=1e-4)


def test_the_second_judge_agrees(answer: Design) -> None:
    lines = {each.field: each for each in confirm(answer).lines}
    assert lines["shaft_diameter_mm"].agrees


def test_where_the_hub_decides_the_jerk_is_the_least() -> None:
    """The quarter that rms jerk is allowed would buy nothing."""
    question = {"limits": [PRESSURE], "shaft_diameter_mm": 60.0}
    design, fixed = (
        synthesise(spec(**question)),
        synthesise(spec(**question, objective={"kind": "rms_jerk"})),
    )
    (jerk,) = design.certificate.other_objectives
    assert design.status == "optimal"
    assert jerk.value == pytest.approx(fixed.certificate.value, rel=2e-3)
    assert jerk.gap is not None
    assert jerk.gap < 3e-2
    assert design.dimensions["base_radius_mm"] == pytest.approx(55.675, rel=1e-3)


def test_a_larger_shaft_costs_its_share(answer: Design) -> None:
    costs = {each.field: each.per_unit for each in sensitivities(answer).sensitivities}
    assert costs["/shaft_diameter_mm"] == pytest.approx(0.875, rel=1e-6)


def test_a_hub_that_is_given_counts_instead() -> None:
    design = synthesise(spec(shaft_diameter_mm=SHAFT, hub_diameter_mm=51.0))
    assert design.dimensions["base_radius_mm"] == pytest.approx(25.5, rel=1e-6)
    assert line(design, "hub_diameter_mm").holds
    assert not [extreme for extreme in design.extremes if extreme.field == "shaft_diameter_mm"]


FOLLOWERS: dict[str, dict[str, Any]] = {
    "groove": {
        "kind": "translating_roller", "roller_radius_mm": 9.5,
        "closure": {"kind": "groove", "clearance_mm": 0.1, "rim_mm": 5.0},
    },
    "flat face": {"kind": "translating_flat_face"},
    "conjugate": {
        "kind": "translating_roller", "roller_radius_mm": 9.5, "offset_mm": 0.0,
        "closure": {"kind": "conjugate", "roller_radius_mm": 9.5},
    },
}  # fmt: skip


@pytest.mark.parametrize("name", FOLLOWERS)
def test_other_followers_and_both_cams_of_a_pair(name: str) -> None:
    question = {"follower": FOLLOWERS[name], "tolerance": 0.02, "shaft_diameter_mm": SHAFT}
    limits = [JERK] if name == "flat face" else [PRESSURE, JERK]
    design = synthesise(spec(**question, limits=limits, proof="quick"))
    radii = [value for key, value in design.dimensions.items() if key.endswith("base_radius_mm")]
    assert len(radii) == (2 if name == "conjugate" else 1)
    assert min(radii) >= HUB / 2.0 * (1.0 - 1e-9)
    assert min(radii) <= HUB / 2.0 * 1.02


def test_an_arm_too() -> None:
    program = spec().model_dump(mode="json", exclude_none=True)["program"]
    for segment in program:
        if segment.pop("lift_mm", None):
            segment["lift_deg"] = 14.0
    arm = {"kind": "oscillating_roller", "roller_radius_mm": 9.5, "arm_mm": 110.0,
           "centre_distance_mm": {"min": 90.0, "max": 190.0}}  # fmt: skip
    question = spec(program=program, follower=arm, limits=[PRESSURE], shaft_diameter_mm=SHAFT)
    design = synthesise(question.model_copy(update={"tolerance": 0.05, "proof": "quick"}))
    assert line(design, "shaft_diameter_mm").holds
    assert design.dimensions["base_radius_mm"] >= HUB / 2.0 * (1.0 - 1e-9)


def test_a_conflict_names_the_shaft() -> None:
    """A flank without offset reaches base radius and stroke; 49 mm leave 26 for the hub."""
    roller = {"kind": "translating_roller", "roller_radius_mm": 9.5, "offset_mm": 0.0}
    limits = [{**PRESSURE, "rise_deg": 50.0, "return_deg": 50.0},
              {"kind": "outer_radius", "max_mm": 49.0}]  # fmt: skip
    program = spec().model_dump(mode="json", exclude_none=True)["program"]
    for segment in program[0], program[2]:
        segment["law"] = {"kind": "cycloidal"}
    question = {"program": program, "follower": roller, "limits": limits, "proof": "quick"}
    design = synthesise(spec(**question, shaft_diameter_mm=SHAFT))
    assert design.conflict is not None
    known = {each.field: each for each in design.conflict.relaxations}
    shaft = known["shaft_diameter_mm"]
    assert shaft.requested == SHAFT
    assert shaft.needed == pytest.approx((2.0 * 26.0 - 6.35) / 1.75, rel=1e-2)


def test_without_room_for_a_hub_the_shaft_gives_no_other_one() -> None:
    """By the rule that would be a larger one than is given: a tighter question, not a looser."""
    asked = spec(shaft_diameter_mm=SHAFT, hub_diameter_mm=45.0)
    (room,) = (number for number in relaxable_numbers(asked) if number.name == "room for hub")
    assert without(asked, [room]).hub is None


WRONG: dict[str, tuple[dict[str, Any], str]] = {
    "a maximum inside the hub": ({"base_radius_mm": {"max": 30.0}}, "radius is 32.05 mm"),
    "no room for the key": ({"hub_diameter_mm": 38.0, "keyway": True}, "round the keyway"),
    "no key so small": ({"shaft_diameter_mm": 5.0, "keyway": True}, "above 6 and up to 230 mm"),
    "a ring": (
        {"follower": {"kind": "translating_roller", "roller_radius_mm": 9.5,
                      "closure": {"kind": "force", "contact": "inside"}}},
        "no material round its axis",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", WRONG)
def test_what_does_not_fit_is_refused(name: str) -> None:
    changes, words = WRONG[name]
    with pytest.raises(ValidationError, match=words):
        spec(**{"shaft_diameter_mm": SHAFT} | changes)
    with pytest.raises(ValidationError, match="no shaft"):
        spec(keyway=True)


def test_files_have_the_bore_of_the_shaft(answer: Design) -> None:
    told = SolidOptions(bore_mm=SHAFT, keyway=True, hub_diameter_mm=HUB, hub_length_mm=4.0)
    with pytest.raises(InputError, match="hub must stay within"):
        blank(answer, told)
    body, hub = blank(answer, SolidOptions(hub_length_mm=4.0)).slabs
    assert hub.outside.radii[1] == pytest.approx(0.999 * HUB / 2.0, rel=1e-6)
    assert hub.holes == body.holes
    plain = blank(answer, SolidOptions(thickness_mm=8.0))
    (slab,), (same,) = (each.slabs for each in (plain, blank(
        answer, SolidOptions(thickness_mm=8.0, bore_mm=SHAFT, keyway=True)
    )))  # fmt: skip
    assert slab.holes == same.holes
    assert plain.volume < blank(answer, SolidOptions(thickness_mm=8.0, bore_mm=1.0)).volume
    text = PROFILE_FORMATS["dxf"].write(answer, DrawingOptions()).decode()
    bore = ezdxf.read(io.StringIO(text)).modelspace().query('CIRCLE[layer=="BORE"]')
    assert [circle.dxf.radius for circle in bore] == [SHAFT / 2.0]
    assert pi * (SHAFT / 2.0) ** 2 * 8.0 < plain.slabs[0].outside.area * 8.0 - plain.volume


def test_the_proof_file_says_it_as_a_radius(answer: Design) -> None:
    file = proof_file(answer)
    assert file["question"]["base_radius_mm"]["min"] == HUB / 2.0
    assert {each["place"] for each in file["claims"] if each["proven"]} >= {"size", "limits/0"}
