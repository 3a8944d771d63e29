"""A finer tolerance has no wider gap than a rougher one, with the same budget of programs."""

from __future__ import annotations

from dataclasses import replace

import pytest

from synthesis.optimise import driver
from synthesis.optimise.driver import optimise
from synthesis.optimise.problem.problem import Problem
from synthesis.optimise.recovery.candidate import Candidate
from synthesis.optimise.state import QUICK, THOROUGH, ProofBudget, SolveState
from synthesis.optimise.strategy.coarser_tolerance import retry_at_coarser_tolerance
from synthesis.spec.design_spec import DesignSpec
from tests.hard.families import random_scene
from tests.optimise.scenes import problem

SHORT = ProofBudget(6.0, 1.0)
ROUGH, FINE = 5e-3, 1e-3


@pytest.fixture(scope="module")
def question() -> Problem:
    """Its proof in boxes has weaker rows at the finer tolerance."""
    return problem(DesignSpec.model_validate(random_scene("slide, profile radius", 7)))


@pytest.fixture(scope="module")
def fine(question: Problem) -> SolveState:
    return optimise(question, FINE, proof=SHORT)


def gap(state: SolveState) -> float:
    return state.gap_between(state.incumbent, state.lower)


def best(state: SolveState) -> Candidate:
    assert state.incumbent is not None
    return state.incumbent


def test_a_finer_tolerance_has_no_wider_gap(
    question: Problem, fine: SolveState, monkeypatch: pytest.MonkeyPatch
) -> None:
    rough = optimise(question, ROUGH, proof=SHORT)
    assert gap(rough) > ROUGH  # the budget has ended it
    assert gap(fine) <= gap(rough)
    assert best(fine).value <= best(rough).value
    assert fine.valid_for == rough.valid_for
    assert [stage.exit for stage in fine.stages if stage.exit] == [driver.BUDGET]
    # alone it has: without that the test shows nothing
    monkeypatch.setattr(driver, "retry_at_coarser_tolerance", lambda state, *_: state)
    assert gap(optimise(question, FINE, proof=SHORT)) > gap(rough)


@pytest.mark.parametrize(
    "case",
    [
        "quick",
        "in time",
        "goes on",
        "no time",
        "near",
        "rough",
        "sufficient",
        "sufficient bound",
        "laws given",
        "searched",
    ],
)
def test_nothing_is_tried_where_it_would_say_nothing(
    fine: SolveState, case: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def never(*_: object, **__: object) -> SolveState:
        raise AssertionError("tried")

    pairs = zip(fine.problem.free, best(fine).laws, strict=True)
    given = fine.problem.with_laws([segment.with_law(law.curve()) for segment, law in pairs])
    state = {
        "goes on": replace(fine, last_program=float("inf")),
        "no time": replace(fine, deadline=0.0),
        "near": replace(fine, lower=best(fine).value * (1.0 - 1e-3)),
        "rough": replace(fine, tolerance=ROUGH),
        "sufficient": replace(fine, sufficient=1e9),
        "sufficient bound": replace(fine, sufficient_bound=1e-9),
        "laws given": replace(fine, problem=given),
    }.get(case, fine)
    with pytest.raises(AssertionError):
        retry_at_coarser_tolerance(fine, SHORT, never)
    if case == "searched":
        kind = type(fine.problem.machine.follower)
        monkeypatch.setattr(kind, "fixable_dimension", lambda _: object())
    proof = {"quick": QUICK, "in time": THOROUGH}.get(case, SHORT)
    assert retry_at_coarser_tolerance(state, proof, never) is state


def test_a_bound_over_a_family_of_splines_is_left_where_it_is(fine: SolveState) -> None:
    higher = best(fine).value * (1.0 - 1e-4)
    family = replace(fine, lower=higher, covers_all_laws=False)
    assert retry_at_coarser_tolerance(fine, SHORT, lambda *_, **__: family).lower == fine.lower
    proven = replace(family, covers_all_laws=True)
    assert retry_at_coarser_tolerance(fine, SHORT, lambda *_, **__: proven).lower == higher
