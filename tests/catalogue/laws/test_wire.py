"""Laws as JSON."""

import json
from typing import Any

import pytest
from pydantic import TypeAdapter, ValidationError

from synthesis.catalogue.laws import LAWS, AnyLaw, SplineLaw

WIRE: TypeAdapter[Any] = TypeAdapter(AnyLaw)


@pytest.mark.parametrize("kind", sorted(LAWS))
def test_round_trip(kind: str) -> None:
    law = WIRE.validate_python({"kind": kind})
    assert law == LAWS[kind]
    assert WIRE.validate_json(WIRE.dump_json(law)) == law
    assert law.curve("rise") is LAWS[kind].curve("rise")


@pytest.mark.parametrize(
    "body",
    [
        {"kind": "cycloidal", "inflection": 0.4},
        {"kind": "scca", "b": 0.3, "c": 0.2, "d": 0.1, "inflection": 0.6},
        {"kind": "double_harmonic", "turn": "bottom"},
        {"kind": "spline", "smoothness": 3, "overshoot": True},
    ],
)
def test_round_trip_with_parameters(body: dict[str, Any]) -> None:
    law = WIRE.validate_json(json.dumps(body))
    assert json.loads(WIRE.dump_json(law)) == body


def test_every_law_and_the_spline_are_in_the_schema() -> None:
    mapping = WIRE.json_schema()["discriminator"]["mapping"]
    assert set(mapping) == set(LAWS) | {"spline"}
    assert isinstance(WIRE.validate_python({"kind": "spline"}), SplineLaw)


@pytest.mark.parametrize(
    "body",
    [
        {"kind": "cycloid"},
        {"kind": "Cycloidal"},
        {},
        {"kind": "cycloidal", "inflection": 0.04},
        {"kind": "cycloidal", "inflection": 0.96},
        {"kind": "cycloidal", "inflection": float("nan")},
        {"kind": "cycloidal", "turn": "top"},
        {"kind": "cycloidal", "b": 0.5},
        {"kind": "double_harmonic", "inflection": 0.5},
        {"kind": "double_harmonic", "turn": "left"},
    ],
    ids=str,
)
def test_what_makes_no_sense_is_refused(body: dict[str, Any]) -> None:
    with pytest.raises(ValidationError):
        WIRE.validate_python(body)


def test_an_unknown_law_is_answered_with_the_known_ones() -> None:
    with pytest.raises(ValidationError, match="modified_sine"):
        WIRE.validate_python({"kind": "modified_sin"})
