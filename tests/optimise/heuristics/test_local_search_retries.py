"""What a local search repeats: with points where rows are missed, with rows drawn in; and when
not."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from math import inf
from typing import Any

import pytest

from synthesis.optimise.branching import traced_node
from synthesis.optimise.conic.linear_rows import Tightening
from synthesis.optimise.conic.program import formulate
from synthesis.optimise.driver import optimise
from synthesis.optimise.heuristics import local_search
from synthesis.optimise.heuristics.scp import ScpResult, solve_scp
from synthesis.optimise.problem.nondimensional import NondimensionalSpec
from synthesis.optimise.problem.problem import Problem, formulate_problem
from synthesis.optimise.refinement.row_violations import ALLOWED, exact_excess
from synthesis.optimise.state import QUICK, THOROUGH, ProofBudget, SolveState
from synthesis.spec.design_spec import DesignSpec
from tests.hard.families import random_scene

TOLERANCE = 5e-3
MISSED = 1e-6  # relative: of a cap on the jerk, by how much a cam exceeds it
COSTLY = 2e-4  # relative: of the prime radius, what rows may cost more than at their points


def searched(family: str, proof: ProofBudget) -> SolveState:
    spec = NondimensionalSpec.of(DesignSpec.model_validate(random_scene(family, 100))).scaled
    return optimise(formulate_problem(spec, spec.objectives()[0]), TOLERANCE, proof=proof)


@pytest.fixture
def results(monkeypatch: pytest.MonkeyPatch) -> list[ScpResult]:
    """The sequential searches as they come."""
    found = list[ScpResult]()

    def noted(*given: Any) -> ScpResult:
        found.append(solve_scp(*given))
        return found[-1]

    monkeypatch.setattr(local_search, "solve_scp", noted)
    return found


@pytest.mark.parametrize("family", ["slide, acceleration", "slide, splines of class C4"])
def test_rows_missed_between_points_get_points_there(family: str, results: list[ScpResult]):
    """The size that the laws need all along is no larger than the one they need at points."""
    state = searched(family, QUICK)
    first, *_ = results
    assert first.cam is not None
    assert state.incumbent is not None
    assert state.incumbent.value <= (1.0 + COSTLY) * first.cam.value
    assert not any(stage.stage == "nonlinear" for stage in state.stages)


def test_rows_that_the_solver_misses_are_drawn_in(
    results: list[ScpResult], monkeypatch: pytest.MonkeyPatch
):
    """On short intervals the jerk of a law has more rounding than its coefficients have.

    Here the first program's rows are let out in its place.
    """
    drawn_in = list[float]()

    def let_out(problem: Problem, grids: Any, level: float, by: Tightening, *region: Any) -> Any:
        if region:
            drawn_in.append(by.every_row)
            by = replace(by, every_row=-MISSED) if len(drawn_in) == 1 else by
        return formulate(problem, grids, level, by, *region)

    monkeypatch.setattr(local_search, "formulate", let_out)
    state = searched("slide, splines of class C4", THOROUGH)
    cams = [result.cam for result in results if result.cam is not None]
    broken = [exact_excess(state, cam) > ALLOWED for cam in cams]
    assert broken[:2] == [True, False]
    assert drawn_in[1] - drawn_in[0] >= MISSED
    assert state.is_good_enough
    assert not any(stage.stage == "nonlinear" for stage in state.stages)


def test_a_search_that_found_nothing_better_is_not_made_again(monkeypatch: pytest.MonkeyPatch):
    better, improve = list[bool](), traced_node._improve_incumbent

    def noted(state: SolveState, node: Any) -> Any:
        found = improve(state, node)
        better.append(found[0].incumbent is not state.incumbent)
        return found

    monkeypatch.setattr(traced_node, "_improve_incumbent", noted)
    # only the first node searches, between its rounds of tightening: its halves are not looked at
    monkeypatch.setattr(traced_node.TracedNode, "branch", lambda _, state: (state, ()))
    searched("slide, acceleration", ProofBudget(150.0, 1.0))
    assert better == [False]


@pytest.mark.parametrize("programs", [0.0, 40.0])
def test_bounds_of_a_node_end_with_the_budget_of_the_proof(
    monkeypatch: pytest.MonkeyPatch, programs: float
):
    ends, tighten = list[float](), traced_node.tighten_bounds

    def noted(*given: Any, **more: Any) -> Any:
        ends.append(given[-1])
        return tighten(*given, **more)

    monkeypatch.setattr(traced_node, "tighten_bounds", noted)
    state = searched("slide, Hertz pressure", ProofBudget(programs, 1.0))
    assert ends
    assert set(ends) == {state.last_program if programs else inf}


@pytest.mark.parametrize("times", [20.0, 3e3])
def test_caps_are_tightened_as_far_as_a_law_keeps_them(times: float, monkeypatch: Any) -> None:
    """However loose they are: a local optimum under wide caps may be the worse one."""
    labels = list[str]()

    def noted(state: SolveState, _laws: Any, _size: Any, label: str = "tangents") -> Any:
        labels.append(label)
        return state, False

    monkeypatch.setattr(local_search, "scp_search", noted)
    monkeypatch.setattr(local_search, "improve_from", lambda state, _start: state)
    body = random_scene("slide, splines of class C4", 104)
    rise, _, fall, _ = body["program"]
    speed = 6.0 * body["speed_rpm"]  # deg/s
    least = max(32.0 * s["lift_mm"] * (speed / s["angle_deg"]) ** 3 for s in (rise, fall))
    (cap,) = (limit for limit in body["limits"] if limit["kind"] == "jerk")
    cap["max_mm_per_s3"] = times * least
    spec = NondimensionalSpec.of(DesignSpec.model_validate(body)).scaled
    optimise(formulate_problem(spec, spec.objectives()[0]), TOLERANCE, proof=QUICK)
    shares = [float(label.split(" ")[1]) for label in labels if label.endswith("of the caps")]
    assert 1.0 <= shares[0] * times < 1.05 / local_search.SHARE_STEP
    assert shares[-1] == 1.0
    for share, wider in pairwise(shares):
        assert wider == pytest.approx(share / local_search.SHARE_STEP, rel=0.05)


def test_the_series_ends_where_a_law_keeps_every_share(monkeypatch: pytest.MonkeyPatch) -> None:
    """As a straight one does, between two straight segments."""
    labels, solve_relaxation, kept = list[str](), local_search._relaxed_cam, list[Any]()

    def noted(state: SolveState, _laws: Any, _size: Any, label: str = "tangents") -> Any:
        labels.append(label)
        return state, False

    def any_share(state: SolveState) -> Any:
        kept.extend([] if kept else [solve_relaxation(state)])
        return kept[0]

    monkeypatch.setattr(local_search, "scp_search", noted)
    monkeypatch.setattr(local_search, "improve_from", lambda state, _start: state)
    monkeypatch.setattr(local_search, "_relaxed_cam", any_share)
    body = random_scene("slide, splines of class C4", 104)
    (cap,) = (limit for limit in body["limits"] if limit["kind"] == "jerk")
    cap["max_mm_per_s3"] *= 20.0
    spec = NondimensionalSpec.of(DesignSpec.model_validate(body)).scaled
    optimise(formulate_problem(spec, spec.objectives()[0]), TOLERANCE, proof=QUICK)
    assert kept[0] is not None
    assert 0 < sum(label.endswith("of the caps") for label in labels) < 20
