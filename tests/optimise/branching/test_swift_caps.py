"""Caps on the jerk are left out of a proof where the acceleration swings at once below them."""

from __future__ import annotations

from dataclasses import replace
from math import inf
from typing import Any

import pytest

from synthesis.numerics import clock
from synthesis.optimise.branching.traced_node import TracedNode
from synthesis.optimise.driver import optimise
from synthesis.optimise.problem.derivative_caps import SWIFT, without_swift_caps
from synthesis.optimise.root_node import RootNode
from synthesis.optimise.state import ProofBudget, SolveState
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


def test_where_a_dimension_was_searched_the_proof_goes_on(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its values were problems of their own: none of the whole without the cap was solved."""
    question = problem(scene(PLAIN, *LIMITS, jerk(2.0 * PER_LAW, 71.7)))
    state = replace(optimise(question, 1e-2), tolerance=1e-15)
    child: Any = object()
    monkeypatch.setattr(TracedNode, "root", lambda _: child)
    node = RootNode(optimise, presolved=False, processed=True, dimension_searched=True)
    assert node.branch(state)[1] == [child]


def test_the_proof_without_it_ends_when_the_whole_one_does() -> None:
    question = problem(scene(PLAIN, *LIMITS, jerk(2.0 * PER_LAW, 71.7)))
    found = optimise(question, 1e-2)
    now, budgets = clock.now(), list[ProofBudget]()
    state = replace(found, tolerance=1e-15, deadline=now + 1e3, proof_deadline=now + 4e2)

    def noted(*given: Any, proof: ProofBudget) -> SolveState:
        budgets.append(proof)
        return found

    RootNode(noted, presolved=False)._bound_without_highest_caps(state)
    (budget,) = budgets
    assert 0.0 < budget.share <= 0.4
    without_end = replace(state, deadline=inf, proof_deadline=inf)
    assert without_end.proof_budget.share == 1.0
