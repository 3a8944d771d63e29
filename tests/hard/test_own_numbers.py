"""A sample of the questions that an answer satisfies; ``make hard ARGS=own`` asks all of them."""

from __future__ import annotations

import json

import pytest

from synthesis import DesignSpec
from tests.hard.families import DEFAULT_OBJECTIVES, FAMILIES, random_scene
from tests.hard.own_numbers import ask, questions, solved

# one question each, of another kind from family to family: a pivot left free costs seconds
SLOW = ("pivot free", "pivot in a range", "lifts free", "arm, conjugate", "length free", "arm, p")
SAMPLE = [family for family in FAMILIES if not any(word in family for word in SLOW)]


@pytest.mark.parametrize("family", SAMPLE)
def test_an_answers_own_numbers_are_feasible_as_limits(family: str) -> None:
    number = 2 if "then rms" in family else 1  # the first of these takes longer than all others
    body = random_scene(family, number) | {"proof": "quick"}
    _, answer, seconds = solved(body)
    assert answer is not None
    assert answer.certificate.certified
    known = list(questions(family, number, body, answer))
    one = known[SAMPLE.index(family) % len(known)]
    outcome = ask(one, seconds)
    assert outcome.status in ("optimal", "feasible"), (one.kind, one.body)


def test_there_are_as_many_families_as_promised_and_each_scene_is_its_own() -> None:
    assert len(FAMILIES) >= 35
    scenes = [json.dumps(random_scene(family, n)) for family in FAMILIES for n in range(3)]
    assert len(set(scenes)) == len(scenes)
    assert scenes == [json.dumps(random_scene(f, n)) for f in FAMILIES for n in range(3)]


def test_scenes_without_an_objective_leave_it_and_the_jerk_open() -> None:
    assert not set(DEFAULT_OBJECTIVES) & set(FAMILIES)  # which are numbered in turn
    for family in DEFAULT_OBJECTIVES:
        body = random_scene(family, 1)
        assert "objective" not in body
        assert not {"acceleration", "jerk"} & {limit["kind"] for limit in body["limits"]}
        assert len(DesignSpec.model_validate(body).objectives()) == 2
