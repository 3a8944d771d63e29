"""A proof that is to exclude a maximum of the base radius ends when its bound lies above it."""

from __future__ import annotations

from dataclasses import replace
from math import inf
from types import SimpleNamespace
from typing import Any

import pytest

from synthesis.catalogue.objectives import BaseRadius
from synthesis.certify import SELF_CROSSING
from synthesis.pipeline import attempt as attempt_module
from synthesis.pipeline import largest_radius, oracle, radius_search
from synthesis.pipeline.attempt import Attempt, prepare, solve_and_certify
from synthesis.pipeline.goal import Goal
from synthesis.pipeline.largest_radius import Smallest, above, compare, first_question
from synthesis.pipeline.oracle import Oracle
from synthesis.pipeline.radius_search import enlarge_until_simple
from synthesis.pipeline.relaxable import relaxable_numbers
from synthesis.spec.design_spec import DesignSpec
from tests.hard.families import random_scene

LEAST = 6.9709  # mm, a little below the smallest base radius of the scene
SCENE = {
    **random_scene("slide, centred", 5), "base_radius_mm": {"max": LEAST}, "tolerance": 1e-5,
    "proof": "thorough",
}  # fmt: skip


def question(**changes: Any) -> DesignSpec:
    return DesignSpec.model_validate({**SCENE, **changes})


def smallest_of(spec: DesignSpec, goal: Goal) -> tuple[Attempt, Smallest | None]:
    return compare(spec.model_copy(update={"objective": BaseRadius()}), goal, [])


def test_it_is_a_length_of_the_question() -> None:
    """Not of the scaled one that is solved."""
    attempt, smallest = smallest_of(question(), Goal(inf, sufficient_bound=above(LEAST)))
    assert attempt.searches[0].stages[-1].exit == "sufficient"
    assert smallest is not None
    assert smallest.excludes
    assert LEAST < smallest.lower < LEAST * (1.0 + 1e-7)
    assert smallest.radius > smallest.lower * (1.0 + 1e-5)  # the gap is open


@pytest.mark.parametrize(("most", "searches"), [(0.98 * LEAST, 1), (1.02 * LEAST, 2)])
def test_what_it_excludes_is_made_no_better_by_a_later_objective(
    most: float, searches: int
) -> None:
    objectives = [{"kind": "base_radius"}, {"kind": "rms_jerk"}]
    spec = question(
        base_radius_mm={"max": most}, objective=objectives, proof="quick", tolerance=5e-3
    )
    attempt, smallest = compare(spec, Goal(inf), [])
    assert smallest is not None
    assert smallest.excludes == (searches == 1)
    assert attempt.certified == (searches == 2)
    assert len(attempt.searches) == searches
    assert [each.objective.kind for each in attempt.bounds[1:]] == ["rms_jerk"][: searches - 1]


def test_a_bound_of_splines_alone_excludes_nothing() -> None:
    first, goal = first_question(question(proof="quick", tolerance=5e-3)), Goal(inf)
    state = solve_and_certify(prepare(first, goal, []), goal, []).searches[0]
    excluding = state.problem.objective.to_wire(state.lower, state.problem.machine)
    assert attempt_module._has_no_cam(state, excluding)
    assert not attempt_module._has_no_cam(state, excluding * (1.0 + 1e-9))
    assert not attempt_module._has_no_cam(replace(state, covers_all_laws=False), excluding)


def test_later_objectives_have_none() -> None:
    spec = question(
        base_radius_mm=None, proof="quick", tolerance=5e-3,
        objective=[{"kind": "base_radius"}, {"kind": "rms_jerk"}],
    )  # fmt: skip
    goal = Goal(inf, sufficient_bound=1e-3)
    attempt = solve_and_certify(prepare(first_question(spec), goal, []), goal, [])
    first, second = attempt.searches
    assert first.sufficient_bound == pytest.approx(1e-3 / attempt.question.units.length)
    assert second.sufficient_bound == inf


@pytest.mark.parametrize(
    ("changes", "proof", "expected"),
    [
        ({}, "thorough", above(LEAST)),
        ({}, "quick", inf),
        ({"base_radius_mm": {"min": 3.0}}, "thorough", inf),
        ({"base_radius_mm": LEAST}, "thorough", inf),  # another objective is made small
    ],
)
def test_trials_by_longer_proofs_have_one(
    changes: dict[str, Any], proof: str, expected: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    goals = list[Goal]()

    def noted(_spec: DesignSpec, goal: Goal, _stages: list[Any]) -> tuple[Any, None]:
        goals.append(goal)
        raise TimeoutError

    monkeypatch.setattr(oracle, "compare", noted)
    spec = question(**changes)
    with pytest.raises(TimeoutError):
        Oracle(spec, spec, inf).ask(spec, 1e-3, exactly=True, proof=proof)
    assert [goal.sufficient_bound for goal in goals] == [expected]


@pytest.mark.parametrize(
    ("changes", "proof", "expected"),
    [
        ({}, "auto", (LEAST, above(LEAST))),
        ({}, "quick", (LEAST, inf)),
        ({"base_radius_mm": {"min": 3.0}}, "auto", (-inf, inf)),
        ({"base_radius_mm": LEAST}, "auto", (-inf, inf)),  # another objective is made small
        (
            {"objective": [{"kind": "base_radius"}, {"kind": "rms_jerk"}]},
            "auto",
            (-inf, above(LEAST)),
        ),
    ],
)
def test_a_question_as_it_stands_ends_with_a_cam_that_is_small_enough(
    changes: dict[str, Any], proof: str, expected: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Or with the proof that there is none."""
    goals = list[Goal]()

    def noted(_spec: DesignSpec, goal: Goal, _stages: list[Any], **_: Any) -> tuple[Any, None]:
        goals.append(goal)
        raise TimeoutError

    monkeypatch.setattr(oracle, "compare", noted)
    spec = question(**changes)
    jerk = next(number for number in relaxable_numbers(spec) if number.name == "jerk")
    with pytest.raises(TimeoutError):
        Oracle(spec, spec, inf).ask_as_it_stands(jerk, 1.1 * jerk.tightest, proof)
    assert [(goal.sufficient, goal.sufficient_bound) for goal in goals] == [expected]


@pytest.mark.parametrize(
    ("budget", "stop", "proof", "given"),
    [(40.0, inf, "thorough", 20.0), (40.0, 7.0, "thorough", 7.0), (None, inf, "auto", inf)],
)
def test_the_spec_s_own_proof_has_its_part_of_the_spec_s_time_and_no_more(
    budget: float | None, stop: float, proof: str, given: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """That of another's question: half of it is for the proof. Here all of what is given is."""
    asked = list[tuple[str, float]]()

    def noted(spec: DesignSpec, goal: Goal, _stages: list[Any], **_: Any) -> tuple[Any, None]:
        asked.append((spec.proof, goal.stop))
        raise TimeoutError

    monkeypatch.setattr(oracle, "compare", noted)
    monkeypatch.setattr(oracle.clock, "now", lambda: 1000.0)
    spec = question(time_budget_s=budget, proof="auto")
    jerk = next(number for number in relaxable_numbers(spec) if number.name == "jerk")
    with pytest.raises(TimeoutError):
        Oracle(spec, spec, 1000.0 + stop).ask_as_it_stands(jerk, 1.1 * jerk.tightest, "auto")
    assert asked == [(proof, 1000.0 + given)]


def test_the_spec_s_own_proof_of_a_maximum_has_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nodes have closed the gap to the spec's tolerance: its own proof follows at finer ones."""
    goals, tolerances, solve = list[Goal](), list[float](), largest_radius.solve_spec

    def noted(spec: DesignSpec, goal: Goal, stages: list[Any]) -> Attempt:
        assert spec.proof == "auto"
        goals.append(goal)
        tolerances.append(spec.tolerance)
        return solve(spec, goal, stages)

    monkeypatch.setattr(largest_radius, "solve_spec", noted)
    spec = question(tolerance=5e-3, proof="auto", time_budget_s=600.0)
    _, smallest = compare(spec, Goal(inf), [], finer=True)
    assert smallest is not None
    assert smallest.excludes
    assert tolerances == pytest.approx([5e-4, 5e-5])
    assert {goal.sufficient_bound for goal in goals} == {above(LEAST)}
    assert {goal.excluding_bound for goal in goals} == {above(LEAST)}


def test_a_larger_cam_that_does_not_cross_itself_has_none(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every bound of a raised minimum would be enough for it: any cam would do."""
    goals = list[Goal]()

    def noted(_prepared: Attempt, goal: Goal, _stages: list[Any]) -> Any:
        goals.append(goal)
        raise TimeoutError

    found, _ = smallest_of(question(tolerance=5e-3, proof="quick"), Goal(inf))
    crossing: Any = SimpleNamespace(limit=SELF_CROSSING, holds=False)
    monkeypatch.setattr(radius_search, "solve_and_certify", noted)
    goal = Goal(inf, sufficient_bound=above(LEAST), excluding_bound=above(LEAST))
    with pytest.raises(TimeoutError):
        enlarge_until_simple(replace(found, extremes=[crossing]), goal, [])
    assert [(goal.sufficient_bound, goal.excluding_bound) for goal in goals] == [(inf, inf)]
