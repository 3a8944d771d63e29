"""Caps on the jerk are left out of a proof where the acceleration swings at once below them."""

from __future__ import annotations

import pytest

from synthesis.optimise.problem.derivative_caps import SWIFT, without_swift_caps
from tests.optimise.scenes import (
    PLAIN,
    acceleration,
    angles,
    dwell,
    fall,
    jerk,
    problem,
    rise,
    scene,
)

LIMITS = (angles(29.3, 41.7), acceleration(6.3, 71.7))
PER_LAW = (
    2.0 * 6.3 / SWIFT
)  # of the jerk, over lift and angle³: a swing takes this share of the law


@pytest.mark.parametrize(("times", "left_out"), [(0.99, False), (1.01, True)])
def test_a_swing_takes_its_share_of_the_shortest_law(times: float, left_out: bool) -> None:
    question = problem(scene(PLAIN, *LIMITS, jerk(times * PER_LAW, 71.7)))
    found = without_swift_caps(question)
    assert (found is not None) is left_out
    if found is not None:
        assert "jerk" not in {one.kind for one in found.limits}
        assert len(found.limits) == len(question.limits) - 1


def test_the_law_in_which_it_takes_longest_decides() -> None:
    program = (rise(71.7), dwell(23.9), fall(35.9), dwell(228.5))
    assert without_swift_caps(problem(scene(program, *LIMITS, jerk(1.5 * PER_LAW, 71.7)))) is None
    assert without_swift_caps(problem(scene(program, *LIMITS, jerk(2.5 * PER_LAW, 71.7))))


def test_without_a_cap_on_the_acceleration_the_jerk_stays() -> None:
    assert without_swift_caps(problem(scene(PLAIN, angles(29.3, 41.7), jerk(1e9, 71.7)))) is None
