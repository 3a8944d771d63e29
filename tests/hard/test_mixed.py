"""A few of the questions of mixed units and sizes; ``make hard ARGS=mixed`` asks all of them."""

from __future__ import annotations

import json

import pytest

from tests.hard.mixed_specs import MACHINES, least_peak, mixed_spec
from tests.hard.run import outcome
from tests.hard.witnesses import below_least_peak, contradictions

# each in a few tenths of a second
QUICK = (4, 7, 10, 14, 15, 17, 18, 20)

pytestmark = pytest.mark.usefixtures("short_diagnosis")


def test_questions_are_the_same_at_every_call_and_of_every_kind() -> None:
    specs = [mixed_spec(number) for number in range(200)]
    assert json.dumps(specs) == json.dumps([mixed_spec(number) for number in range(200)])
    assert len({json.dumps(spec) for spec in specs}) == len(specs)
    assert len({spec["follower"]["kind"] for spec in specs}) == len(MACHINES)
    assert {len(spec["program"]) for spec in specs} == set(range(2, 13))
    kinds = {limit["kind"] for spec in specs for limit in spec["limits"]}
    assert kinds >= {"velocity", "acceleration", "jerk", "pressure_angle", "profile_radius",
                     "cutter_radius", "outer_radius", "face_width", "contact_force"}  # fmt: skip
    lifts = [s["lift_mm"] for spec in specs for s in spec["program"] if "lift_mm" in s]
    lengths = [lift for lift in lifts if not isinstance(lift, dict)]
    assert min(lengths) < 1e-3
    assert max(lengths) > 1e3


@pytest.mark.parametrize("number", QUICK)
def test_every_claim_is_confirmed(number: int) -> None:
    judged = outcome(number, family="mixed")
    assert judged.complaints == ()


@pytest.mark.parametrize("kind", ["velocity", "acceleration", "jerk"])
def test_a_peak_below_the_least_is_known_to_be_impossible(kind: str) -> None:
    move = {"kind": "rise", "angle_deg": 77.0, "lift_mm": 3.7, "law": {"kind": "spline"}}
    back = {**move, "kind": "return", "angle_deg": 91.0}
    rest = {"kind": "dwell", "angle_deg": 96.0}
    order = {"velocity": 1, "acceleration": 2, "jerk": 3}[kind]
    program = [move, rest, back, rest]
    least = least_peak(program, "mm", order, 123.0)
    name = f"max_mm_per_s{order if order > 1 else ''}"
    question = {"speed_rpm": 123.0, "program": program,
                "follower": {"kind": "translating_flat_face"}}  # fmt: skip
    for factor, impossible in ((0.999, kind), (1.0, ""), (1.001, "")):
        request = {**question, "limits": [{"kind": kind, name: least * factor}]}
        assert below_least_peak(request) == impossible
        if impossible:
            said = {"certificate": {"certified": True}}
            assert contradictions(request, said)
