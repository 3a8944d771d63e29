"""Answers of related questions are related; ``make hard ARGS=transformed`` asks many more."""

from __future__ import annotations

import numpy as np
import pytest

from tests.hard.families import random_scene
from tests.hard.transformed import Answer, Transformed, faults, mirrored, pairs, scaled

QUICK = (
    "slide, laws given",
    "face, laws given",
    "slide, offset given",
    "swinging face, laws given",
)
ASKED = {"tolerance": 1e-3}
FIRST = Answer("optimal", 50.0, 49.97, 6e-4, 0.0)


@pytest.mark.parametrize("family", QUICK)
def test_related_questions_have_related_answers(family: str) -> None:
    found = list(pairs(family, 3))
    assert len(found) >= 6
    assert [(other.kind, wrong) for other, _, wrong in found if wrong] == []


@pytest.mark.parametrize(
    ("second", "looser", "fault"),
    [
        (Answer("optimal", 50.04, 49.98, 1e-3, 0.0), True, ""),
        (Answer("optimal", 50.06, 50.01, 1e-3, 0.0), True, "worse"),
        (Answer("feasible", 50.9, 40.0, 0.21, 0.0), True, ""),
        (Answer("feasible", 51.1, 40.0, 0.22, 0.0), True, "worse"),
        (Answer("unsolved", None, None, None, 0.0), True, "lost"),
        (Answer("optimal", 31.0, 30.99, 3e-4, 0.0), True, ""),
        (Answer("optimal", 31.0, 30.99, 3e-4, 0.0), False, "below"),
        (Answer("feasible", 31.0, 30.0, 0.03, 0.0), False, "partner is worse"),
        (Answer("optimal", 50.04, 50.01, 6e-4, 0.0), True, "above"),
        (Answer("feasible", 50.0, None, None, 0.0), False, "gap"),
        (Answer("feasible", 50.0, 49.0, 0.02, 0.0), False, "gap"),
        (Answer("optimal", 50.0, 49.96, 8e-4, 0.0), False, ""),
    ],
)
def test_what_is_wrong_between_two_answers_is_seen(
    second: Answer, looser: bool, fault: str
) -> None:
    other = Transformed("", {}, looser=looser, more=not looser)
    found = list(faults(ASKED, FIRST, other, second))
    assert bool(found) == bool(fault), found
    assert not found or any(fault in text for text in found)


def test_a_factor_is_that_of_values() -> None:
    other = Transformed("", {}, factor=1e-2)
    assert not list(faults(ASKED, FIRST, other, Answer("optimal", 0.5, 0.4997, 6e-4, 0.0)))


def test_ranges_are_scaled_with_their_unit_and_mirrored_with_their_side() -> None:
    body = random_scene("slide, offset in a range", 0)
    question = body["follower"]["offset_mm"]
    larger, _ = scaled(body, np.random.default_rng(4))
    factor = larger.factor
    assert larger.body["follower"]["offset_mm"]["max"] == pytest.approx(factor * question["max"])
    assert larger.body["program"][0]["angle_deg"] == body["program"][0]["angle_deg"]
    (back,) = mirrored(body)
    assert back.body["follower"]["offset_mm"] == {"min": -question["max"], "max": -question["min"]}
