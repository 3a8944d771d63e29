"""Rows of windows and points: they hold for what is inside, and for nothing beyond."""

import json
from fractions import Fraction

import pytest

from synthesis.pipeline.proof_file.checker import checker
from tests.checker.test_holes import document, move


@pytest.mark.parametrize("kind", ["rise", "return"])
def test_rows_of_a_window_are_what_it_asks(kind: str) -> None:
    window = {"from_deg": 45.0, "to_deg": 90.0, "travel_mm": {"min": 2.0, "max": 6.0},
              "velocity_mm_per_s": {"min": None, "max": 30.0}}  # fmt: skip
    program = [move("rise", 180, 15), move("return", 180, 15)]
    index = [each["kind"] for each in program].index(kind)
    program[index]["windows"] = [window]
    judge = checker()
    judge.spent.clear()
    question = judge.Question(
        judge.read(json.dumps(document("", program, None)["question"]).encode())
    )
    segment, other = question.program[index], question.program[1 - index]
    travel = question.limits[f"program/{index}/windows/0/0"]
    assert (travel["from"], travel["to"]) == (Fraction(1, 4), Fraction(1, 2))
    for t in (1.9, 2.1, 5.9, 6.1):  # mm since the start, in the sense of the move
        s = t if kind == "rise" else 15.0 - t
        rows = (question.row(segment, travel, side) for side in (1, -1))
        held = all(float(row[0][0]) * s <= float(row[2]) for row in rows)
        assert held == (2.0 < t < 6.0)
    assert question.row(other, travel, 1) is None
    speed = question.limits[f"program/{index}/windows/0/1"]
    assert question.row(segment, speed, -1) is None
    alpha, _, most = question.row(segment, speed, 1)
    assert (alpha[1], most) == (1, 30 / question.rate)
    # of the limits that its name says: no other number, no derivative without a bound
    found = [name for name in question.limits if name.startswith("program/")]
    assert found == [f"program/{index}/windows/0/{k}" for k in (0, 1)]


def test_a_window_beyond_its_segment_is_refused() -> None:
    """What it asks there would be dropped without a word."""
    judge = checker()
    window = {"from_deg": 80.0, "travel_mm": {"min": 9.5, "max": None}}
    for end, valid in ((90.0, True), (90.0 * (1.0 + 1e-14), True), (90.001, False), (250, False)):
        program = [move("rise", 90, 10), move("return", 270, 10)]
        program[0]["windows"] = [{**window, "to_deg": end}]
        question = json.dumps(document("", program, None)["question"]).encode()
        judge.spent.clear()
        if valid:
            limits = judge.Question(judge.read(question)).limits
            assert limits["program/0/windows/0/0"]["to"] == 1
        else:
            with pytest.raises(judge.Failure, match="beyond the segment"):
                judge.Question(judge.read(question))
