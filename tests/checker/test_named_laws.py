"""The checker's own named laws: those of the catalogue, enclosed; what they break is refused."""

from fractions import Fraction
from itertools import pairwise
from typing import Any

import pytest

from synthesis.catalogue.laws.rest_to_rest import Polynomial, Scca
from synthesis.pipeline.proof_file.checker import checker
from tests.checker.run import verdict
from tests.checker.test_checker import proof_of

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
