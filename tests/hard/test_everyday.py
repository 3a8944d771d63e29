"""A sample of everyday cams: no caution that is wrong. All: python -m tests.hard.everyday."""

from __future__ import annotations

import json

import pytest

from synthesis import DesignSpec, synthesise
from tests.hard.everyday import EACH, JUDGED, TRADES, scenes

SLOW = (
    "heavy",
    "pusher",
    "calm_pusher",
    "assembly",
    "free_arm",
)  # tenths of a second each: one of them
SAMPLE = [
    (trade, number, body)
    for trade, number, body in scenes(3)
    if trade not in SLOW or (trade == "assembly" and number == 0)
]


@pytest.mark.parametrize(("trade", "number", "body"), SAMPLE, ids=lambda each: str(each)[:12])
def test_no_wrong_caution(trade: str, number: int, body: dict) -> None:
    design = synthesise(DesignSpec.model_validate(body))
    assert design.certificate.certified
    severe = {one.code for one in design.warnings if one.severity != "note"}
    assert severe <= {JUDGED.get((trade, number))}, design.warnings


def test_there_are_three_hundred_scenes_and_each_is_its_own() -> None:
    bodies = [json.dumps(body) for _, _, body in scenes()]
    assert len(set(bodies)) == len(bodies) == EACH * len(TRADES) == 300
    assert bodies == [json.dumps(body) for _, _, body in scenes()]
