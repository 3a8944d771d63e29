"""A share of the random specs, chosen by a fixed stride; ``make hard`` runs all of them."""

from __future__ import annotations

import json

import pytest

from tests.hard.random_specs import COUNT, FOLLOWERS, random_spec
from tests.hard.run import outcome

STRIDE, BATCHES = 240, 2
BUDGET_S = 1.5  # one in fifty is late by then: it is judged too
SHARE = range(1, COUNT, STRIDE)


@pytest.mark.slow
@pytest.mark.usefixtures("short_diagnosis")
@pytest.mark.parametrize("batch", range(BATCHES))
def test_every_claim_is_confirmed(batch: int) -> None:
    """No false claim, no crash, no hang, no refusal that a cam of the verifier's own refutes."""
    specs = [random_spec(number) | {"time_budget_s": BUDGET_S} for number in SHARE[batch::BATCHES]]
    found = [
        outcome(number, spec) for number, spec in zip(SHARE[batch::BATCHES], specs, strict=True)
    ]
    wrong = {one.number: (one.status, one.complaints) for one in found if one.complaints}
    assert not wrong, wrong


def test_specs_are_the_same_at_every_call_and_all_different() -> None:
    first, again = ([json.dumps(random_spec(n)) for n in range(40)] for _ in range(2))
    assert first == again
    assert len(set(first)) == len(first)


def test_every_follower_is_among_the_share() -> None:
    kinds = {random_spec(number)["follower"]["kind"] for number in SHARE}
    assert kinds == {make.__name__ for make, *_ in FOLLOWERS}
