"""Caps on lower derivatives that a cam keeps by itself are left out of search and proof."""

from __future__ import annotations

from dataclasses import replace
from math import inf

import pytest

from synthesis.numerics import clock
from synthesis.optimise.branching.traced_node import TracedNode
from synthesis.optimise.driver import optimise
from synthesis.optimise.problem.derivative_caps import without_lower_caps
from synthesis.optimise.problem.problem import Problem
from synthesis.optimise.state import THOROUGH, SolveState
from synthesis.optimise.strategy import idle_caps
from synthesis.optimise.strategy.idle_caps import search_without_idle_caps
from synthesis.spec.design_spec import DesignSpec
from tests.hard.families import random_scene
from tests.optimise.scenes import PLAIN, acceleration, angles, jerk, problem, scene, velocity

LIMITS = (angles(29.3, 41.7), jerk(47.0, 71.7))
IDLE, BINDING = (velocity(3.0, 71.7), acceleration(9.0, 71.7)), (velocity(1.6, 71.7),)


def kinds(question: Problem) -> set[str]:
    return {limit.kind for limit in question.limits}


def begun(question: Problem, monkeypatch: pytest.MonkeyPatch) -> SolveState:
    """A state with time for a proof; the search with all caps leaves it as it is."""
    monkeypatch.setattr(idle_caps, "local_search", lambda state: state)
    state = replace(optimise(question, 1e-2), programs=inf, proof_deadline=inf)
    return state.with_proof_begun()


def test_caps_below_the_highest_are_those_left_out() -> None:
    question = problem(scene(PLAIN, *LIMITS, *IDLE))
    wider = without_lower_caps(question)
    assert wider is not None
    assert kinds(question) - kinds(wider) == {"velocity", "acceleration"}
    assert without_lower_caps(wider) is None
    # under a face on a pivot a profile radius has rows on the velocity, and says more than these
    face = DesignSpec.model_validate(random_scene("swinging face, laws free", 1))
    assert without_lower_caps(problem(face)) is None


@pytest.mark.parametrize(("caps", "left_out"), [(IDLE, True), (BINDING, False)])
def test_a_search_is_without_the_caps_that_its_cam_keeps(
    caps: tuple[dict[str, float]], left_out: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    question = problem(scene(PLAIN, *LIMITS, *caps))
    found = search_without_idle_caps(begun(question, monkeypatch), optimise)
    assert ("velocity" not in kinds(found.problem)) is left_out
    assert found.thorough
    assert not left_out or found.stages[-1].exit == ""  # it goes on
    home = idle_caps.for_problem(found, question)
    assert home.problem is question
    assert home.incumbent is not None
    assert kinds(home.incumbent.problem) == kinds(question)


def test_the_search_takes_none_of_the_proof_s_programs(monkeypatch: pytest.MonkeyPatch) -> None:
    """So the proof has as many as that of the question without these caps."""
    question = problem(scene(PLAIN, *LIMITS, *IDLE))
    state = replace(begun(question, monkeypatch), programs=2.0).with_proof_begun()
    state = replace(state, sufficient_bound=1e9)
    found = search_without_idle_caps(state, optimise)
    assert found.sufficient_bound == 1e9  # the proof goes on from there
    assert found.last_program == clock.programs_solved() + 2.0 > state.last_program


def test_a_quick_proof_searches_with_all_caps_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    question = problem(scene(PLAIN, *LIMITS, *IDLE))
    quick = replace(begun(question, monkeypatch), last_program=-inf)
    assert search_without_idle_caps(quick, optimise).problem is question


def test_caps_that_do_not_bind_change_no_cam(monkeypatch: pytest.MonkeyPatch) -> None:
    """With a profile radius that binds; without the boxes of the proof."""
    monkeypatch.setattr(TracedNode, "root", lambda _: None)
    tight = (angles(35.0, 35.0), jerk(90.0, 71.7), {"kind": "profile_radius", "min_mm": 6.0})
    far = (velocity(5.0, 71.7), acceleration(40.0, 71.7))
    free, capped = (
        optimise(problem(scene(PLAIN, *tight, *caps)), 1e-2, proof=THOROUGH) for caps in ((), far)
    )
    assert free.incumbent is not None
    assert capped.incumbent is not None
    assert any(stage.stage == "tangents" for stage in free.stages)
    assert kinds(capped.problem) >= {"velocity", "acceleration"}
    assert capped.incumbent.value == free.incumbent.value
