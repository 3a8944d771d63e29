"""Proof files of the tests are of the form that the schema states."""

import json
from pathlib import Path

from synthesis.pipeline.proof_file.checker import checker_path
from tests.checker.schema import conforms
from tests.checker.test_arms import ANGLE, GROOVE, arm
from tests.checker.test_closures import TRUE
from tests.checker.test_holes import JERK, MEAN, SLOW, SMOOTH, bound, document, moves


def test_files_that_other_tests_find_accepted_are_as_the_schema_says() -> None:
    schema = json.loads(checker_path().with_name("proof.schema.json").read_text("utf-8"))
    found = [*TRUE.values(), arm(ANGLE), arm(ANGLE, closure=GROOVE)]
    found += [document("motion", moves(), [SMOOTH] * 2)]
    found += [document("infeasible", moves(18), None, SLOW, JERK, witness=bound(0, MEAN))]
    rounds = json.loads((Path(__file__).parent / "rounds.json").read_text("utf-8"))
    claim = {"place": "objective/0", "proven": True, **rounds["claim"]}
    first = {key: claim[key] for key in claim if key != "multipliers"}
    last = {"multipliers": claim["multipliers"]}
    cases = {**first, "of": "s0", "value": 20, "cases": [last, last]}
    found += [{**found[0], "claims": [each]} for each in (claim, cases)]
    assert [each for each in found if not conforms(each, schema, schema)] == []
    for wrong in ({**cases, "of": "X"}, {**cases, "cases": [last]}, {**claim, "rounds": [{}]}):
        assert not conforms({**found[0], "claims": [wrong]}, schema, schema)
