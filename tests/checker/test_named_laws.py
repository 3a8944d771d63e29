"""The checker's own named laws: those of the catalogue, enclosed; what they break is refused."""

import json
from fractions import Fraction
from itertools import pairwise
from typing import Any

import pytest

from synthesis import DesignSpec
from synthesis.catalogue.laws.rest_to_rest import Polynomial, Scca
from synthesis.pipeline.proof_file.checker import checker
from tests.checker.run import verdict
from tests.checker.test_checker import EXAMPLES, proof_of
from tests.checker.test_holes import JERK, VELOCITY, document, move, moves

LAWS = [(family, kind) for family in (Polynomial, Scca) for kind in family.entries]
COVERED = [each for each in LAWS if each[1] != "trapezoidal_acceleration"]


@pytest.mark.parametrize(("family", "kind"), COVERED)
def test_a_law_and_its_derivatives_are_those_of_the_catalogue(family: Any, kind: str) -> None:
    curve, judge = family(kind=kind).curve("rise"), checker()
    for x in (Fraction(0), Fraction(1, 3), Fraction(17, 31), Fraction(1)):
        for order in range(4):
            low, high = judge.given(kind, order, x)
            assert type(low) is type(high) is Fraction
            assert 0 <= high - low < Fraction(1, 10**18)
            inside = 0 < x < 1 or order < 2  # derivatives may jump to those of a dwell
            if inside or x == 0:
                assert float(low) == pytest.approx(float(curve(float(x), order)), abs=1e-11)
    parts = judge.parts_of(kind)
    assert sum(width for _, width, _ in parts) == 1
    for (_, _, before), (start, _, after) in pairwise(parts):
        for order in range(3 if kind not in ("parabolic", "simple_harmonic") else 2):
            assert abs(before[order][-1][0] - after[order][0][0]) < judge.UNIT >> 60, start


def test_a_law_that_breaks_a_limit_leaves_no_cam() -> None:
    jerk = {"kind": "jerk", "max_mm_per_s3": 1e5}
    document = proof_of("fixed-laws", limits=[jerk])
    assert document["cam"] is None
    assert document["claims"][0]["proven"]
    code, text = verdict(document)
    assert code == 0, text
    # a limit that the law keeps excludes nothing, wherever the multiplier is
    document["question"]["limits"][0]["max_mm_per_s3"] = 1e9
    assert verdict(document)[0] == 1


def test_another_law_than_that_of_the_answer_is_another_question() -> None:
    document = proof_of("fixed-laws")
    assert verdict(document)[0] == 0
    document["question"]["program"][0]["law"]["kind"] = "modified_sine"
    assert verdict(document)[0] == 1


def test_a_jump_inside_a_given_law_is_a_jump() -> None:
    """A spline that takes over the third derivative of a law, which jumps inside the law."""
    taken = checker().given("cv50_half_sine", 3, Fraction(0))[0]
    back = float(-taken / 270)  # the third derivative at both ends is 270 times as large
    fall = {"degree": 5, "knots": [0, 1 / 3, 2 / 3, 1],
            "coefficients": [0, 0, 0, back, 1 - back, 1, 1, 1]}  # fmt: skip
    law = {"kind": "cv50_half_sine", "inflection": 0.5}
    program = [{**move("rise", 180, 10), "law": law},
               move("return", 180, 10, smoothness=3, overshoot=True)]  # fmt: skip
    for continuity, code in ((None, 0), (2, 0), (3, 1)):
        found = document("motion", program, [None, fall], continuity=continuity)
        assert verdict(found)[0] == code, continuity
    jerk = document("limits/0", program, [None, fall], JERK)
    assert verdict(jerk)[0] == 0


def test_places_on_given_laws_are_work(monkeypatch: pytest.MonkeyPatch) -> None:
    law = {"kind": "cv50_modified_trapezoid", "inflection": 0.5}
    program = [{**each, "law": law} for each in moves()]
    row = {"limit": "limits/0", "side": 1, "multipliers": [[1e-50, 1]]}
    witness = {"multipliers": {"order": 3, "segments": [{"segment": 0, "rows": [row], "ends": []}]}}
    found = document("infeasible", program, None, VELOCITY, witness=witness)
    assert verdict(found)[0] == 1
    monkeypatch.setitem(checker().MOST, "coefficients", checker().spent["coefficients"] - 1)
    assert verdict(found)[0] == 2


def test_what_a_series_leaves_out_is_in_its_remainder() -> None:
    judge = checker()
    for order in range(5):  # at u = 1, where the terms are largest
        ((low, high),) = sum(judge.sine(order))
        ((least, most),) = sum(judge.sine(order, 60))
        assert low < least <= most < high


def test_a_wider_enclosure_of_a_law_beside_a_free_one_weakens_the_half_plane(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    program = [
        {"kind": "rise", "angle_deg": 90.0, "lift_mm": 20.0},
        {"kind": "return", "angle_deg": 90.0, "lift_mm": 20.0, "law": {"kind": "cubic_2_3"}},
        {"kind": "dwell", "angle_deg": 180.0},
    ]
    body = json.loads((EXAMPLES / "example-13-6-sized.json").read_text("utf-8"))["value"]
    asked = DesignSpec.model_validate({**body, "program": program}).model_dump_json()
    judge = checker()
    judge.spent.clear()
    question = judge.Question(judge.read(asked.encode()))
    ends = {"segment": 0, "rows": [], "ends": [0, 0, 1]}  # a multiple of the free law's g''(1)
    witness = judge.read(json.dumps({"order": 3, "segments": [ends]}).encode())
    constant, _ = judge.half_plane(question, witness)
    given = judge.given

    def wider(law: str, order: int, x: Any) -> tuple[Any, Any]:
        low, high = given(law, order, x)
        return (low - 1, high + 1) if law == "cubic_2_3" else (low, high)

    monkeypatch.setattr(judge, "given", wider)
    weaker, _ = judge.half_plane(question, witness)
    assert weaker < constant
