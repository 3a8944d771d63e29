"""A share of the random specs with a load; ``make hard ARGS=loaded`` runs all of them."""

from __future__ import annotations

import json

import pytest

from tests.hard.loaded_specs import FOLLOWERS, loaded_spec
from tests.hard.run import outcome

pytestmark = pytest.mark.usefixtures("short_diagnosis")

# of every follower, answered and refused, each in a tenth of a second or a few
QUICK = (
    6, 17, 20, 22, 23, 33, 50, 69, 78, 79, 88, 93, 98, 106, 107, 109, 126, 128, 160, 169, 183,
    197, 200, 241, 247, 307,
)  # fmt: skip
# number and time budget [s]: all of them raised ValueError
RAISED = [
    # a density between points of a block that went back
    (61, 0.6), (190, 0.6),
    # a free spring, several objectives, and no cam
    (456, 1.0),
]  # fmt: skip


@pytest.mark.parametrize("number", QUICK)
def test_a_load_raises_nothing_but_documented_errors(number: int) -> None:
    judged = outcome(number, family="loaded")
    assert judged.complaints == ()


@pytest.mark.parametrize(("number", "budget"), RAISED)
def test_what_raised_once_stays_mended(number: int, budget: float) -> None:
    judged = outcome(number, loaded_spec(number) | {"time_budget_s": budget})
    assert judged.complaints == ()


def test_specs_are_the_same_at_every_call_and_of_every_kind() -> None:
    specs = [loaded_spec(number) for number in range(60)]
    assert json.dumps(specs) == json.dumps([loaded_spec(number) for number in range(60)])
    assert len({json.dumps(spec) for spec in specs}) == len(specs)
    followers = {spec["follower"]["kind"] for spec in specs}
    assert len(followers) == len(FOLLOWERS)
    assert {spec["rotation"] for spec in specs} == {"cw", "ccw"}
    assert {spec["proof"] for spec in specs} == {"quick", "thorough"}
    kinds = {limit["kind"] for spec in specs for limit in spec["limits"]}
    assert kinds >= {"contact_force", "hertz_pressure", "camshaft_torque"}
