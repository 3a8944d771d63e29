"""Schemathesis sends what the schema allows, and what it forbids; answers must be as documented."""

from __future__ import annotations

import copy
import json
import os
from collections import Counter
from typing import TYPE_CHECKING, Any

import pytest
from hypothesis import HealthCheck, settings

from service.openapi import TARGET
from synthesis.machines.linkages.shaper.spec import LENGTHS
from tests.service.conftest import Running
from tests.service.contract.test_openapi import statuses
from tests.service.specs import spec

if TYPE_CHECKING:  # imported in the functions: collecting tests does without it
    import schemathesis
    from schemathesis.schemas import APIOperation


def document() -> dict[str, Any]:
    """The document; what a sweep, a cam set and a train hold a whole spec in is given.

    Designs are gone through under their own address: once more for analyses or inside of cams of a
    set they take most of the time that it takes to think of all cases. So do returns, which have
    the fields of rises: of them the kind alone is told, to questions and of answers. Shapers are
    given in full: to search for one takes seconds where chance has chosen the ranges. Of the worked
    examples, all of which are sent elsewhere, a few stay: each is sent with parameters made up.
    """
    served = json.loads(TARGET.read_text(encoding="utf-8"))  # which is what is served
    known = served["components"]["schemas"]
    sweep, cams, cam = (copy.deepcopy(known[n]) for n in ("SweepSpec", "CamSetSpec", "CamOnShaft"))
    sweep["properties"]["base"] = {"enum": [spec("swept")]}
    shared = {name: value for name, value in spec("on a shaft").items() if name != "speed_rpm"}
    cam["properties"]["spec"] = {"enum": [shared]}
    cams["properties"]["cams"]["items"] = cam
    kind = {"kind": {"const": "return"}}
    known["Return"] = {"type": "object", "properties": kind, "required": ["kind"]}
    shaper = copy.deepcopy(known["ShaperSpec"])
    for field in LENGTHS:
        shaper["properties"][field] = shaper["properties"][field]["anyOf"][0]
    train = copy.deepcopy(known["TrainSpec"])
    train["properties"]["cam"] = {"enum": [spec("driven")]}
    bodies = {
        "analyses": {"enum": [spec("analysed")]},
        "train-responses": train,
        "sweeps": sweep,
        "cam-sets": cams,
        "linkages/six-bar-shapers": shaper,
    }
    for name, body in bodies.items():
        path = f"/v1/{name}"
        content = served["paths"][path]["post"]["requestBody"]["content"]
        content["application/json"]["schema"] = body
    for methods in served["paths"].values():
        for operation in methods.values():
            for content in operation.get("requestBody", {}).get("content", {}).values():
                content["examples"] = dict(list(content.get("examples", {}).items())[:EXAMPLES])
    return served


STRIDE, EXAMPLES = 31, 2
THOROUGH = os.environ.get("HYPOTHESIS_PROFILE") == "thorough"
# Cases that chance makes: of the first of those operations that are alike, and of the others.
CASES = (40, 10) if THOROUGH else (2, 1)
# What an operation has in common with others: its list of parameters, or else its path.
ALIKE = {
    f"{method.upper()} {path}": f"{method} {each.get('parameters') if method != 'post' else path}"
    for path, methods in json.loads(TARGET.read_text(encoding="utf-8"))["paths"].items()
    for method, each in methods.items()
}
# The first of those that are alike is sent more cases that chance has made than the others.
MORE = {like: label for label, like in reversed(ALIKE.items())}


def operation_of(label: str) -> dict[str, Any]:
    """What the contract says of an operation."""
    method, path = label.split(" ", 1)
    return json.loads(TARGET.read_text(encoding="utf-8"))["paths"][path][method.lower()]


@pytest.fixture(scope="module")
def operations() -> dict[str, APIOperation]:
    """The operations by label. Made when tests run: to collect them takes the labels only."""
    import schemathesis
    from schemathesis.generation.meta import coverage_scenario

    served = document()
    schema = schemathesis.openapi.from_dict(served)
    seen = Counter[tuple[str, str]]()

    @schema.hook("filter_case")
    def is_sent(context: schemathesis.HookContext, case: schemathesis.Case) -> bool:
        """Of cases that differ in the field alone: the first, and every thirty-first.

        Every kind of fault (a wrong type, a number beyond its end, ...) is sent for every list of
        parameters, which files of one kind have in common. There are 15 000, most of them of some
        field's wrong type, which one validator finds for all; 31 is in step with no number of
        wrong types. HYPOTHESIS_PROFILE=thorough sends them all.
        """
        kind = coverage_scenario(case)
        if kind is None or THOROUGH:
            return True
        like = ALIKE[case.operation.label]
        number = seen[like, kind.value]
        seen[like, kind.value] += 1
        return number % STRIDE == 0

    each = (operation.ok() for operation in schema.get_all_operations())
    return {operation.label: operation for operation in each}


@pytest.mark.parametrize("label", ALIKE)
def test_answers_are_as_documented(
    label: str, operations: dict[str, APIOperation], service: Running
) -> None:
    from schemathesis.checks import CHECKS, load_all_checks
    from schemathesis.generation.feedback import FeedbackSources
    from schemathesis.pytest._test_builder import build_operation_test

    load_all_checks()
    # A program that does not close fits the schema and is refused all the same.
    not_asked = CHECKS.get_by_names(["positive_data_acceptance"])
    no_fault = CHECKS.get_by_names(["not_a_server_error"])

    @settings(
        max_examples=CASES[MORE[ALIKE[label]] != label], deadline=None, derandomize=True,
        database=None, suppress_health_check=list(HealthCheck),
    )  # fmt: skip
    def send(case: schemathesis.Case) -> None:
        answer = case.call(base_url=service.url)
        late = no_fault if answer.status_code == 504 and allows_itself_a_time(case) else []
        case.validate_response(answer, excluded_checks=[*not_asked, *late])
        if case.method == operation.method.upper():  # and not one that is not there
            assert answer.status_code in allowed

    operation, allowed = operations[label], statuses(operation_of(label))
    config = operation.schema.config
    build_operation_test(
        config=config,
        operation=operation,
        test_func=send,
        given_kwargs={},
        feedback=FeedbackSources(),
    )()


def allows_itself_a_time(case: schemathesis.Case) -> bool:
    """Whether the body sets its own time budget: of next to none, 504 is the right answer."""
    return isinstance(case.body, dict) and "time_budget_s" in case.body
