"""The table of words leads to fields and kinds that exist, and units are changed rightly."""

from __future__ import annotations

import json
import math
from typing import Any

import pytest
from pydantic import ValidationError

from service.resources.records import RESOURCES
from synthesis.errors.quantities import (
    field_unit,
    in_field,
    joined,
    read_quantity,
    tables,
    words_of,
)
from synthesis.errors.schema import all_names, kinds_of, schemas_in
from synthesis.errors.violations import find_causes, pointer_to
from synthesis.errors.wrong_names import answer_name
from synthesis.exporters.options import form
from synthesis.spec.design_spec import DesignSpec
from synthesis.studies.sweeps.spec import SweepSpec

MODELS = [*(each.spec for each in RESOURCES.values()), SweepSpec]
OPTIONS = [form(file.format.options) for each in RESOURCES.values() for file in each.files]
FIELDS = {name for model in [*MODELS, *OPTIONS] for name in all_names(model) or ()}


def test_every_field_of_the_table_exists() -> None:
    known = {joined(name) for name in FIELDS} | {field_unit(name)[0] for name in FIELDS}
    assert [name for name in tables()["fields"] if joined(name) not in known] == []
    beside = {name for entry in tables()["sentences"] for name in entry["beside"]}
    assert beside <= FIELDS


def test_every_kind_of_the_table_exists() -> None:
    words = {word for model in MODELS for word in kinds_of(list(schemas_in(model)))} | {"cw", "ccw"}
    assert [kind for kind in tables()["kinds"] if kind not in words] == []


def test_units_of_fields_are_known() -> None:
    """Those without a unit: a name that the table of units does not take apart."""
    assert field_unit("base_radius_mm") == ("baseradius", "mm")
    for name in FIELDS:
        if name.endswith(("_mm", "_deg", "_rpm", "_kg", "_mpa", "_n", "_per_s", "_per_s2")):
            assert field_unit(name)[1], name


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("baseCircleRadius_mm", "base circle radius mm"), ("Roller-Ø", "roller diameter"),
        ("RPM", "rpm"), ("centerDistance", "centre distance"), ("α_max", "alpha max"),
        ("max_mm_per_s2", "max mm per s 2"), ("levée", "levee"),
        ("Exzentrizität", "exzentrizitaet"),
    ],
)  # fmt: skip
def test_names_are_parted_into_words(name: str, words: str) -> None:
    assert " ".join(words_of(name)) == words


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("45 mm", "mm", 45.0), ('3/4"', "mm", 19.05), ("1,5 in", "mm", 38.1), ("2.5cm", "mm", 25.0),
        ("30°", "deg", 30.0), ("0.5236 rad", "deg", 30.0), ("90 Grad", "deg", 90.0),
        ("3.5 Hz", "rpm", 210.0), ("20.94 rad/s", "rpm", 200.0), ("200 1/min", "rpm", 200.0),
        ("50 m/s²", "mm per s 2", 50e3), ("5 g", "mm per s 2", 49033.25), ("5 g", "kg", 5e-3),
        ("1 ksi", "mpa", 6.894757), ("10 lbf", "n", 44.48222), ("10 kg", "mm", None),
        ("1 3/4 in", "mm", 44.45), ("-1-1/2 mm", "mm", -1.5), ("1,045.5", "mm", 1045.5),
        ("1,000,000.0 mm", "mm", 1e6),
    ],
)  # fmt: skip
def test_quantities_are_changed_into_a_fields_unit(
    text: str, unit: str, value: float | None
) -> None:
    quantity = read_quantity(text)
    assert quantity is not None
    found = in_field(quantity[0], quantity[1], unit)
    assert found == value if value is None else math.isclose(found or 0.0, value, rel_tol=1e-9)


@pytest.mark.parametrize(
    "text", ["", "fast", "1/0", "10 parsecs", "9" * 500, "1e999", "--3", "1,000", "2,500,000 mm"]
)
def test_what_is_no_quantity(text: str) -> None:
    assert read_quantity(text) is None


@pytest.mark.parametrize(
    ("name", "remedy"),
    [
        ("shaft_dia_mm", 'Write "shaft_diameter_mm": 10.'),
        ("bore_d_mm", 'Write "shaft_diameter_mm": 10.'),
        ("bore_radius_mm", 'Write "shaft_diameter_mm": 20, twice the radius.'),
        ("hub_dia_mm", 'Write "hub_diameter_mm": 10.'),  # and no "hub", which is a lift in German
        ("base_circle_dia", 'Write "base_radius_mm": 5, half of the diameter.'),
    ],
)
def test_a_diameter_is_halved_for_a_radius_alone(name: str, remedy: str) -> None:
    assert answer_name((name,), {name: 10}, DesignSpec).remedy == remedy


@pytest.mark.parametrize(
    ("path", "said"),
    [
        (("follower", "face_width_mm"), '"limits": [{"kind": "face_width", …}]'),
        (("base", "follower", "face_width_mm"), '"limits": [{"kind": "face_width", …}]'),
        (("follower", "outer_radius_mm"), '"limits": [{"kind": "outer_radius", …}]'),
        (("follower", "peak_jerk"), '"objective": {"kind": "peak_jerk", …}'),
        # What is a field somewhere, and a kind too, is meant as the field.
        (("follower", "base_radius"), '"base_radius_mm": 40'),
        (("load", "contact", "face_width_mm"), '"width_mm": 40'),
    ],
)
def test_the_kind_of_a_limit_is_known_from_within_the_follower(
    path: tuple[str, ...], said: str
) -> None:
    body: dict[str, Any] = {path[-1]: 40}
    for name in reversed(path[:-1]):
        body = {name: {**body, **({"kind": "translating_flat_face"} if name == "follower" else {})}}
    model = SweepSpec if path[0] == "base" else DesignSpec
    assert said in answer_name(path, body, model).remedy


@pytest.mark.parametrize(
    ("lift", "said"),
    [
        ({"min": 1, "max": "2 cm"}, {("/program/0/lift_mm/max", "must be a number")}),
        ([10, 5], {("/program/0/lift_mm", "must be a number or a range")}),
    ],
)
def test_a_wrong_end_of_a_range_is_told_by_itself(lift: Any, said: set[tuple[str, str]]) -> None:
    body = {"program": [{"kind": "rise", "angle_deg": 360, "lift_mm": lift}]}
    body |= {"speed_rpm": 60, "follower": {"kind": "translating_roller", "roller_radius_mm": 8}}
    with pytest.raises(ValidationError) as refused:
        DesignSpec.__pydantic_validator__.validate_json(json.dumps(body))
    found = find_causes(refused.value.errors(), body, DesignSpec)[0]
    assert {(pointer_to(each.path), each.rule) for each in found} == said
    assert all("5" not in each.remedy or '"min": 5, "max": 10' in each.remedy for each in found)
