"""What a sweep asks for: which items there are, and what is in them."""

from __future__ import annotations

import copy
import itertools
import json
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from service.contract.examples import examples
from service.wire.errors import ServiceError
from service.wire.validation import validate
from synthesis.spec.design_spec import DesignSpec
from synthesis.studies.sweeps import SweepSpec

BASE: dict[str, Any] = {
    "name": "base",
    "speed_rpm": 83.7,
    "program": [
        {"kind": "rise", "angle_deg": 67.0, "lift_mm": 13.7, "law": {"kind": "cycloidal"}},
        {"kind": "dwell", "angle_deg": 31.0},
        {"kind": "return", "angle_deg": 58.5, "lift_mm": 13.7, "law": {"kind": "cycloidal"}},
        {"kind": "dwell", "angle_deg": 203.5},
    ],
    "follower": {"kind": "translating_roller", "roller_radius_mm": 7.3},
    "limits": [{"kind": "pressure_angle", "rise_deg": 29.0, "return_deg": 41.0}],
}
ANGLE = {"kind": "range", "pointer": "/limits/0/rise_deg", "start": 21.5, "stop": 33.5, "count": 7}
SPEED = {"kind": "log_range", "pointer": "/speed_rpm", "start": 12.5, "stop": 200.0, "count": 5}
TURN = {"kind": "list", "pointer": "/rotation", "values": ["ccw", "cw"]}


def sweep(*axes: dict[str, Any], **more: Any) -> SweepSpec:
    return SweepSpec.model_validate({"base": BASE, "axes": list(axes), **more})


def test_a_grid_has_every_combination_once_the_last_axis_fastest() -> None:
    spec = sweep(ANGLE, SPEED, TURN)
    found = [tuple(spec.item_values(number)) for number in range(spec.size)]
    angles = np.linspace(21.5, 33.5, 7)
    speeds = np.geomspace(12.5, 200.0, 5)
    expected = list(itertools.product(angles, speeds, ("ccw", "cw")))
    assert len(found) == len(expected) == len(set(found)) == 70
    for (angle, speed, turn), (angle_0, speed_0, turn_0) in zip(found, expected, strict=True):
        assert turn == turn_0
        np.testing.assert_allclose([angle, speed], [angle_0, speed_0], rtol=1e-11)
    assert found[0][:2] == (21.5, 12.5)
    assert found[-1][:2] == (33.5, 200.0)


def test_a_base_that_leaves_its_proof_out_is_proven_quickly() -> None:
    spec = sweep(ANGLE)
    assert spec.item(spec.item_values(3))["proof"] == "quick"
    again = SweepSpec.model_validate_json(spec.model_dump_json())
    assert again.document == spec.document
    for proof in ("auto", "quick", "thorough"):
        reported = SweepSpec.model_validate({"base": BASE | {"proof": proof}, "axes": [ANGLE]})
        assert reported.document["proof"] == proof
    single = DesignSpec.model_validate(BASE)
    assert SweepSpec.model_validate({"base": single, "axes": [ANGLE]}).base.proof == "quick"


def test_rows_go_side_by_side() -> None:
    five = {**ANGLE, "count": 5}
    spec = sweep(five, SPEED, plan={"kind": "rows"})
    assert spec.size == 5
    assert spec.item_values(2) == [27.5, 50.0]


def test_a_latin_hypercube_uses_each_part_of_each_axis_once_and_its_seed_decides() -> None:
    plan = {"kind": "latin_hypercube", "count": 23, "seed": 5}
    loose = [{k: v for k, v in axis.items() if k != "count"} for axis in (ANGLE, SPEED)]
    spec = sweep(*loose, TURN, plan=plan)
    found = [spec.item_values(number) for number in range(spec.size)]
    angle, speed, turn = zip(*found, strict=True)
    for share in ((np.array(angle) - 21.5) / 12.0, np.log(np.array(speed) / 12.5) / np.log(16.0)):
        assert sorted(np.floor(share * 23).astype(int)) == list(range(23))
    assert abs(turn.count("cw") - turn.count("ccw")) <= 1
    again = sweep(*loose, TURN, plan=plan)
    assert [again.item_values(number) for number in range(23)] == found
    other = sweep(*loose, TURN, plan={**plan, "seed": 6})
    assert [other.item_values(number) for number in range(23)] != found


def test_an_item_is_the_base_with_its_values_and_nothing_else_changed() -> None:
    spec = sweep(ANGLE, TURN)
    item = spec.item([25.5, "cw"])
    base = DesignSpec.model_validate(BASE | {"proof": "quick"}).model_dump(mode="json")
    expected = copy.deepcopy(base)
    expected["limits"][0]["rise_deg"], expected["rotation"] = 25.5, "cw"
    assert item == expected
    assert spec.without_values().item([25.5, "cw"]) == item
    assert spec.item([29.0, "ccw"]) == base


def test_what_goes_along_and_what_gives_way() -> None:
    spec = sweep(
        {"kind": "list", "pointer": "/program/0/angle_deg",
         "linked_pointers": ["/program/2/angle_deg"],
         "balance_pointer": "/program/3/angle_deg", "values": [61.25, 70.5]}
    )  # fmt: skip
    for value in (61.25, 70.5):
        angles = [each["angle_deg"] for each in spec.item([value])["program"]]
        assert angles[:3] == [value, 31.0, value]
        assert sum(angles) == pytest.approx(360.0, abs=1e-9)


def test_a_whole_law_can_be_a_value() -> None:
    law = {"kind": "modified_sine"}
    spec = sweep({"kind": "list", "pointer": "/program/0/law", "values": [law]})
    assert DesignSpec.model_validate(spec.item([law])).program[0].law_name == "modified_sine"


WRONG: dict[str, tuple[dict[str, Any], str, str]] = {
    "no such field": ({"axes": [{**ANGLE, "pointer": "/limits/0/rise"}]},
                      "/axes/0/pointer", "rise_deg"),
    "no such entry": ({"axes": [TURN, {**ANGLE, "pointer": "/limits/3/rise_deg"}]},
                      "/axes/1/pointer", "0 to 0"),
    "inside a number": ({"axes": [{**ANGLE, "pointer": "/speed_rpm/min"}]},
                        "/axes/0/pointer", "83.7"),
    "along": ({"axes": [{**ANGLE, "linked_pointers": ["/limits/0/nothing"]}]},
              "/axes/0/linked_pointers", "return_deg"),
    "set twice": ({"axes": [ANGLE, {**ANGLE, "start": 1.0}]}, "/axes/1/pointer", "axes/0"),
    "inside of another": (
        {"axes": [{"kind": "list", "pointer": "/limits", "values": [[]]}, ANGLE]},
        "/axes/1/pointer", "axes/0",
    ),
    "nothing to balance": ({"axes": [{**TURN, "balance_pointer": "/program/3/angle_deg"}]},
                           "/axes/0/pointer", "not a number"),
    "through zero": ({"axes": [{**SPEED, "start": -1.0}]}, "/axes/0", "zero"),
    "without a count": ({"axes": [{k: v for k, v in SPEED.items() if k != "count"}]},
                        "/axes/0", "count"),
    "uneven rows": ({"axes": [TURN, SPEED], "plan": {"kind": "rows"}}, "/axes/1", "5"),
    "the base itself": ({"base": {**BASE, "program": BASE["program"][:3]}, "axes": [TURN]},
                        "/base/program", "156.5"),
}  # fmt: skip


@pytest.mark.parametrize("case", WRONG)
def test_what_makes_no_sense_is_pointed_at(case: str) -> None:
    change, pointer, word = WRONG[case]
    with pytest.raises(ServiceError) as raised:
        validate(json.dumps({"base": BASE, **change}).encode(), SweepSpec)
    (found,) = raised.value.violations
    assert found["pointer"] == pointer
    assert word in found["rule"]
    assert found["remedy"]


def test_a_field_replaced_by_an_axis_is_no_place_for_another() -> None:
    with pytest.raises(ValidationError, match="limits"):
        sweep({"kind": "list", "pointer": "/limits/0", "values": [None]}, ANGLE)


@pytest.mark.parametrize("name", examples("sweeps"))
def test_worked_examples_are_sound(name: str) -> None:
    example = examples("sweeps")[name]
    assert set(example) == {"summary", "description", "value"}
    spec = validate(json.dumps(example["value"]).encode(), SweepSpec)
    for number in range(spec.size):
        DesignSpec.model_validate(spec.item(spec.item_values(number)))
