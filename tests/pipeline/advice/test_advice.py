"""Bad cams get the right word first; a good one, and a limit set on purpose, none."""

from __future__ import annotations

import pytest

from synthesis import DesignSpec, synthesise
from synthesis.design.design import Design
from synthesis.design.warnings import SEVERITIES
from synthesis.pipeline.advice import RULES
from tests.pipeline.advice.bad_cams import FIRST, GOOD, angles, slide
from tests.pipeline.advice.page import TARGET, page


def designed(body: dict) -> Design:
    return synthesise(DesignSpec.model_validate(body))


def said(body: dict) -> list[tuple[str, str]]:
    return [(one.code, one.severity) for one in designed(body).warnings]


@pytest.mark.parametrize("name", FIRST)
def test_a_bad_cam_gets_the_right_word_first(name: str) -> None:
    code, severity, body = FIRST[name]
    design = designed(body)
    first = design.warnings[0]
    assert (first.code, first.severity) == (code, severity), design.warnings
    assert design.severity == severity
    ranks = [SEVERITIES.index(one.severity) for one in design.warnings]
    assert ranks == sorted(ranks, reverse=True)
    for one in design.warnings:  # read aloud: sentences, with a value and what to change
        assert one.sentence.endswith(".")
        assert one.remedy.endswith(".")
        assert one.source


def test_nothing_is_said_of_a_good_cam() -> None:
    design = designed(GOOD)
    assert (design.warnings, design.severity) == ([], "none")


SILENCED: list[tuple[str, str, dict]] = [
    ("sharp_nose", "a nose that is a point",
     {"limits": [*angles(60.0), {"kind": "profile_radius", "min_mm": 0.05}]}),
    ("hub", "a hub without room", {"base_radius_mm": {"min": 1.0}}),
    ("jumps", "a harmonic at 300 rpm", {"continuity": 1}),
    ("rough_motion", "a motion that nothing but size limits",
     {"objective": [{"kind": "rms_jerk"}, {"kind": "base_radius"}]}),
    ("pressure_angle", "a steep arm",
     {"limits": [{"kind": "pressure_angle", "rise_deg": 80.0, "return_deg": 80.0}]}),
    ("unit_suspicion", "pressure angles in radians", {"limits": angles(1.7)}),
    ("spring_solid", "a spring beyond solid", {"load": slide(1.0, 5.0, 100.0)}),
    ("contact_force", "hardly no float",
     {"limits": [{"kind": "contact_force", "min_n": 1.0}]}),
    ("contact_pressure", "a pressure that dents bearings",
     {"limits": [{"kind": "hertz_pressure", "max_mpa": 1e5}], "proof": "quick"}),
    ("contact_pressure", "a contact wider than the cam",
     {"body": {"thickness_mm": 15.0, "bore_mm": 20.0}}),
    ("knife_edge", "a knife edge",
     {"follower": {"kind": "translating_roller", "roller_radius_mm": 1.0, "offset_mm": 0.0}}),
    ("rough_motion", "a motion that nothing but size limits",
     {"limits": [*angles(30.0), {"kind": "profile_radius", "min_mm": 10.0},
                 {"kind": "jerk", "max_mm_per_s3": 1e6}]}),
]  # fmt: skip


@pytest.mark.parametrize(("code", "name", "changes"), SILENCED, ids=lambda each: str(each)[:20])
def test_what_is_set_on_purpose_silences_the_rule(code: str, name: str, changes: dict) -> None:
    """The limit binds no more than before, or hardly: the rule would speak of the same value."""
    _, _, body = FIRST[name]
    design = designed(body | changes)
    assert code not in {one.code for one in design.warnings}


def test_the_page_is_made_of_the_rules() -> None:
    assert TARGET.read_text("utf-8") == page()
    assert len({rule.code for rule in RULES}) == len(RULES)
