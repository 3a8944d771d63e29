"""Searches for a cam alone: no part of the domain is divided for a bound that nobody asks for."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import inf
from types import SimpleNamespace
from typing import Any

import pytest

from synthesis import DesignSpec
from synthesis.catalogue.objectives import BaseRadius
from synthesis.numerics import clock
from synthesis.optimise import root_node
from synthesis.optimise.driver import optimise
from synthesis.optimise.problem.nondimensional import NondimensionalSpec
from synthesis.optimise.problem.problem import Problem, formulate_problem
from synthesis.optimise.root_node import RootNode
from synthesis.optimise.state import CAM_ONLY, QUICK, THOROUGH, ProofBudget, SolveState
from synthesis.optimise.strategy import dimension_search
from synthesis.pipeline import conflict, largest_radius, oracle, outwards
from synthesis.pipeline.attempt import prepare, solve_and_certify
from synthesis.pipeline.boundary import Boundary
from synthesis.pipeline.goal import Goal
from synthesis.pipeline.largest_radius import compare
from synthesis.pipeline.oracle import Oracle, Trial
from synthesis.pipeline.relaxable import relaxable_numbers
from tests.hard.families import random_scene

TOLERANCE = 5e-3


def spec_of(family: str, number: int, **changes: Any) -> DesignSpec:
    return DesignSpec.model_validate({**random_scene(family, number), **changes})


def problem_of(family: str, number: int) -> Problem:
    scaled = NondimensionalSpec.of(spec_of(family, number)).scaled
    return formulate_problem(scaled, BaseRadius(), (), tuple(scaled.placed_segments()))


@pytest.mark.parametrize(
    ("family", "number"), [("arm, pivot in a range", 10), ("slide, Hertz pressure", 1)]
)
def test_no_part_of_the_domain_is_divided(family: str, number: int) -> None:
    problem = problem_of(family, number)
    alone, quick = (optimise(problem, TOLERANCE, proof=proof) for proof in (CAM_ONLY, QUICK))
    nodes = [sum(stage.nodes for stage in state.stages) for state in (alone, quick)]
    assert nodes[0] == 0 < nodes[1]
    assert alone.lower <= quick.lower
    # and the cam is as good, but for what nodes have found on the way
    assert alone.incumbent is not None
    assert quick.incumbent is not None
    assert alone.incumbent.value <= 1.02 * quick.incumbent.value


def test_a_quick_proof_is_made_whatever_it_takes_and_none_whatever_there_is() -> None:
    problem = problem_of("slide, centred", 5)
    now = clock.now()
    for budget, alone in ((CAM_ONLY, True), (QUICK, False), (ProofBudget(0.0, 1e-9), False)):
        for deadline in (inf, now + 600.0):
            assert optimise(problem, 0.5, deadline, proof=budget).cam_only is alone
    # what follows from a search for a cam alone is one too; not where the time of a proof is over
    alone, quick = (optimise(problem, 0.5, now + 600.0, proof=each) for each in (CAM_ONLY, QUICK))
    assert alone.proof_budget.cam_only
    over = replace(quick, proof_deadline=now - 1.0).proof_budget
    assert over.share == 0.0
    assert not over.cam_only


def test_a_dimension_that_is_fixed_needs_no_bound() -> None:
    """It would hold for this value of the dimension alone."""
    budgets, problem = list[ProofBudget](), problem_of("arm, pivot in a range", 10)
    dimension = problem.machine.follower.fixable_dimension()
    assert dimension is not None

    def noted(*args: Any, **more: Any) -> SolveState:
        budgets.append(more["proof"])
        return optimise(*args, **more)

    fixed = dimension_search._FixedDimension(problem, dimension)
    state, cost = SolveState(problem, TOLERANCE, inf, 1e-7), dimension_search._Cost()
    value = 0.5 * (dimension.low + dimension.high)
    found, _, _ = dimension_search._solve_at(state, cost, fixed, noted, value, TOLERANCE)
    assert found.incumbent is not None
    assert budgets == [CAM_ONLY]


@pytest.fixture
def goals(monkeypatch: pytest.MonkeyPatch) -> list[Goal]:
    """Of all questions that an oracle puts."""
    found = list[Goal]()

    def noted(spec: DesignSpec, goal: Goal, stages: list[Any], **more: Any) -> Any:
        found.append(goal)
        return compare(spec, goal, stages, **more)

    monkeypatch.setattr(oracle, "compare", noted)
    return found


QUESTION = spec_of("slide, centred", 5, base_radius_mm={"max": 6.5})


@pytest.mark.parametrize(
    ("ask", "alone"),
    [
        (lambda o, n: o.relaxed(n, 1.1 * n.tightest, 1e-3, exactly=False), True),
        (lambda o, n: o.relaxed(n, 1.1 * n.tightest, 1e-3, exactly=True), False),
        (lambda o, n: o.relaxed(n, 1.1 * n.tightest, 1e-3, exactly=False, proof="auto"), False),
        (lambda o, n: o.ask_as_it_stands(n, 1.1 * n.tightest, "quick", cam_only=True), True),
        (lambda o, n: o.ask_as_it_stands(n, 1.1 * n.tightest, "quick"), False),
        (lambda o, n: o.ask_as_it_stands(n, 1.1 * n.tightest, "auto"), False),
        (lambda o, n: o.without([n]), True),
        (lambda o, _: o.ask(QUESTION), False),
    ],
)
def test_questions_for_values_that_suffice(
    ask: Callable[[Oracle, Any], Trial], alone: bool, goals: list[Goal]
) -> None:
    number = next(n for n in relaxable_numbers(QUESTION) if n.name == "jerk")
    ask(Oracle(QUESTION, QUESTION, inf), number)
    assert [goal.cam_only for goal in goals] == [alone]


@pytest.mark.parametrize(
    ("excess", "asked"), [(-1e-7, [True, False]), (-1e-5, [True]), (None, [True])]
)
def test_a_cam_that_just_keeps_a_maximum_is_sought_with_a_bound_too(
    excess: float | None, asked: list[bool], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A search for a bound ends elsewhere: it is that of anyone who sends the value."""
    found = list[bool]()

    def noted(_spec: DesignSpec, goal: Goal, _stages: list[Any], **_: Any) -> Any:
        found.append(goal.cam_only)
        return ()

    def trial(*_: Any) -> SimpleNamespace:
        return SimpleNamespace(certified=found[-1], excess=excess, bound_excess=None)

    monkeypatch.setattr(oracle, "compare", noted)
    monkeypatch.setattr(Oracle, "_trial", trial)
    number = next(each for each in relaxable_numbers(QUESTION) if each.minimised)
    answer = Oracle(QUESTION, QUESTION, inf).ask_as_it_stands(number, 7.0, "quick", cam_only=True)
    assert found == asked
    assert answer.certified == (len(asked) == 1)


def test_a_goal_s_searches_are_for_a_cam_alone() -> None:
    spec = spec_of("slide, centred", 5)
    for goal, alone in ((Goal(inf), False), (Goal(inf, cam_only=True), True)):
        attempt = solve_and_certify(prepare(spec, goal, []), goal, [])
        assert [search.cam_only for search in attempt.searches] == [alone]


def test_the_smallest_cam_for_another_objective_is_sought_so_too(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    goals = list[Goal]()

    def noted(_spec: DesignSpec, goal: Goal, _stages: list[Any]) -> Any:
        goals.append(goal)
        raise TimeoutError

    monkeypatch.setattr(largest_radius, "solve_spec", noted)
    # next to the smallest cam, 10.941 mm, where the linear rows alone exclude nothing
    question = {"objective": {"kind": "rms_jerk"}, "base_radius_mm": {"max": 10.919}}
    spec = spec_of("slide, profile radius", 1, proof="quick", **question)
    for alone in (True, False):
        with pytest.raises(TimeoutError):
            compare(spec, Goal(inf, cam_only=alone), [])
        (goal,) = goals
        assert goal.sufficient == 10.919
        assert goal.cam_only is alone
        goals.clear()


@pytest.mark.parametrize("budget", [CAM_ONLY, THOROUGH])
def test_the_problem_without_its_highest_caps_is_solved_so_too(
    budget: ProofBudget, monkeypatch: pytest.MonkeyPatch
) -> None:
    budgets = list[ProofBudget]()
    state = optimise(problem_of("slide, centred", 5), 0.5, proof=budget)

    def noted(*_: Any, proof: ProofBudget, **__: Any) -> SolveState:
        budgets.append(proof)
        return state

    monkeypatch.setattr(root_node, "without_swift_caps", lambda _: None)
    monkeypatch.setattr(root_node, "without_highest_caps", lambda problem: problem)
    monkeypatch.setattr(root_node, "WIDE_GAP", -inf)
    RootNode(noted, presolved=False)._bound_without_highest_caps(state)
    ((programs, cam_only),) = ((each.programs, each.cam_only) for each in budgets)
    assert programs == 0.0  # a quick proof at most
    assert cam_only is budget.cam_only


@pytest.mark.parametrize("proof", ["quick", "auto"])
def test_what_has_no_cam_is_proven_by_the_spec_s_own_proof(
    proof: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = list[tuple[str, bool]]()
    none = SimpleNamespace(certified=False, proof="", smallest=None, excess=None, on_time=True)
    shown = SimpleNamespace(**vars(none) | {"proof": "proven"})

    def answer(self: Oracle, spec: DesignSpec, *_: Any, **more: Any) -> Any:
        asked.append((more.get("proof", "quick"), more.get("cam_only", False)))
        return none if more.get("cam_only") else shown

    monkeypatch.setattr(Oracle, "ask", answer)
    spec = QUESTION.model_copy(update={"proof": proof})
    number = relaxable_numbers(spec)[0]
    assert Oracle(spec, spec, inf).proven_without([number]).proof
    assert asked == [("quick", True), (proof, False)]


def test_the_value_on_the_smallest_cam_needs_no_bound(goals: list[Goal]) -> None:
    spec = spec_of("arm, pivot in a range", 10, base_radius_mm={"max": 9.0})
    first = Trial(*compare(spec, Goal(inf, cam_only=True), []), True)
    number = next(n for n in relaxable_numbers(spec) if n.dimension and not n.minimised)
    outwards._leave_out(Boundary(Oracle(spec, spec, inf), number, first))
    assert goals
    assert all(goal.cam_only for goal in goals)


@pytest.mark.parametrize(("budget", "parts"), [(None, 2.0), (60.0, 8.0)])
def test_changes_of_the_program_leave_time_to_longer_proofs(
    budget: float | None, parts: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    shares = list[float]()

    def noted(_: Oracle, share: float) -> Oracle:
        shares.append(share)
        raise TimeoutError

    monkeypatch.setattr(Oracle, "share", noted)
    # what comes before the changes takes no share
    monkeypatch.setattr(conflict, "relaxable_numbers", lambda _: [])
    spec = QUESTION.model_copy(update={"time_budget_s": budget})
    attempt, smallest = compare(spec, Goal(inf), [])
    with pytest.raises(TimeoutError):
        conflict.explain(spec, attempt, smallest, clock.now() + 600.0)
    assert shares == [parts]
