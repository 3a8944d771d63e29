"""Bodies made to cost time: reading them is linear in their size, and the answer stays small."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from typing import Any

import httpx2
import pytest

from service.resources.records import RESOURCES
from service.wire.errors import ServiceError
from service.wire.validation import MAX_ITEMISED, validate
from synthesis.design.design import Design
from synthesis.errors.schema import all_names
from synthesis.errors.violations import MAX_LISTED
from synthesis.spec.design_spec import DesignSpec
from synthesis.studies.sweeps.spec import SweepSpec
from tests.service.specs import spec


def names(count: int) -> dict[str, int]:
    return {f"name_{i}": 1 for i in range(count)}


def first_segment(**fields: Any) -> str:
    body = spec()
    body["program"][0] |= fields
    return json.dumps(body)


def table(points: list[Any]) -> str:
    segment = {"kind": "table", "angle_deg": 60, "tolerance_mm": 0.01, "points": points}
    return json.dumps({**spec(), "program": [segment]})


# a body of about n entries of some kind
BODIES: dict[str, Callable[[int], str]] = {
    "a name twice": lambda n: "{" + ",".join(f'"name_{i}":1' for i in [*range(n), n - 1]) + "}",
    "unknown names": lambda n: json.dumps({**spec(), **names(n)}),
    "unknown names inside": lambda n: first_segment(**names(n)),
    "unknown names in many objects": lambda n: json.dumps(
        {**spec(), "program": [{"kind": "dwell", "angle_deg": 1, **names(n // 100)}] * 100}
    ),
    "NaN": lambda n: '{"a":[' + ",".join(["NaN"] * n) + "]}",
    "NaN by name": lambda n: json.dumps(dict.fromkeys(names(n), float("nan"))),
    "NaN far down": lambda n: '{"a":' + "[" * 500 + ",".join(["NaN"] * n) + "]" * 501 + "}",
    "wrong points": lambda n: table([["a", "b"]] * n),
    "short points": lambda n: table([[1]] * n),
    "wrong limits": lambda n: json.dumps({**spec(), "limits": [{"kind": "x"}] * n}),
    "a list for a number": lambda n: json.dumps({**spec(), "speed_rpm": list(range(n))}),
    "a long text": lambda n: json.dumps({**spec(), "objective": {"kind": "kind" * n}}),
    "a long name": lambda n: json.dumps({**spec(), "name" * n: 1}),
    "long numbers": lambda n: '{"a":[' + ",".join(["9" * 4000] * (n // 400)) + "]}",
    "a number of many digits": lambda n: '{"speed_rpm":' + "9" * 8 * n + "}",
    "a fraction of many digits": lambda n: '{"speed_rpm":0.' + "9" * 8 * n + "}",
    "nested lists": lambda n: "[" * n + "]" * n,
    "nested objects": lambda n: '{"a":' * n + "1" + "}" * n,
    "lone surrogates": lambda n: '{"name":"' + "\\ud800" * n + '"}',
}


def refused(body: bytes) -> ServiceError:
    with pytest.raises(ServiceError) as raised:
        validate(body, DesignSpec)
    return raised.value


def cpu_s(body: bytes) -> float:
    """The least CPU time of three that it takes to refuse a body."""
    best = float("inf")
    for _ in range(3):
        started = time.process_time()
        refused(body)
        best = min(best, time.process_time() - started)
    return best


@pytest.mark.parametrize("make", BODIES.values(), ids=BODIES.keys())
def test_the_cost_of_a_wrong_body_is_linear_in_its_size(make: Callable[[int], str]) -> None:
    """Sixteen times the size: linear is 16 times the time, quadratic 256 times.

    2 ms are allowed on top, for what is too short to be measured.
    """
    small, large = (make(n).encode() for n in (2000, 32_000))
    refused(small)  # schemas are built on first use
    assert cpu_s(large) < 64.0 * (cpu_s(small) + 2e-3)


@pytest.mark.parametrize("make", BODIES.values(), ids=BODIES.keys())
def test_few_of_many_errors_are_listed(client: httpx2.Client, make: Callable[[int], str]) -> None:
    headers = {"Content-Type": "application/json"}
    answer = client.post("/v1/designs", content=make(20_000).encode(), headers=headers)
    assert answer.status_code in (400, 422), answer.text
    assert len(answer.json().get("errors", [])) <= MAX_LISTED
    assert len(answer.content) < 64_000


@pytest.mark.parametrize("count", [MAX_LISTED - 1, MAX_LISTED + 1, MAX_ITEMISED, 5000])
def test_how_many_errors_there_are_is_said(count: int) -> None:
    error = refused(json.dumps({**spec(), **names(count)}).encode())
    assert error.violations
    assert len(error.violations) == min(count, MAX_LISTED)
    assert all(each["rule"] == "is not a field here" for each in error.violations)
    pointers = [each["pointer"] for each in error.violations]
    assert pointers == [f"/name_{i}" for i in range(len(pointers))]
    if count > MAX_LISTED:
        assert f"{count} errors in all; the first {MAX_LISTED} are under errors" in str(error)
    else:
        assert f"({count - 1} more under errors)" in str(error)


def test_known_names_at_the_wrong_places_are_counted() -> None:
    """Errors that only pydantic sees are not itemised either where there are too many."""
    wrong = dict.fromkeys(all_names(DesignSpec) or (), 1) | {"kind": "dwell", "angle_deg": 1}
    error = refused(json.dumps({**spec(), "program": [wrong] * 100}).encode())
    assert error.violations
    assert len(error.violations) == 1
    assert "too many to list" in str(error)


def test_no_name_in_a_body_is_the_callers_choice() -> None:
    """Otherwise unknown names cannot be counted before validation, and ``all_names`` is None."""
    models = {kind.spec for kind in RESOURCES.values()} | {SweepSpec}
    assert all(all_names(model) for model in models)
    assert all_names(Design) is None  # dimensions by name: not a body of a request


def test_values_of_a_sweep_may_be_objects() -> None:
    """Of which the schema does not say what they are: their names are those of a design."""
    laws = [{"kind": "scca", "b": 0.2, "c": 0.1 + 1e-5 * i, "d": 0.2} for i in range(2000)]
    axes = [{"kind": "list", "pointer": "/program/0/law", "values": laws}]
    body = json.dumps({"base": spec(), "axes": axes}).encode()
    assert len(validate(body, SweepSpec).axes[0].values) == 2000  # type: ignore[union-attr]
