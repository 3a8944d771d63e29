"""What a design's report says of each stage: its time, its nodes, the gap after it, and the end."""

from __future__ import annotations

from itertools import pairwise

import pytest

from synthesis import synthesise
from synthesis.design.design import Design
from synthesis.numerics import clock
from synthesis.optimise.driver import optimise
from synthesis.optimise.problem.problem import formulate_problem
from synthesis.optimise.state import solvers_of
from synthesis.pipeline import goal
from tests.optimise.arms import scene
from tests.pipeline.scenes import PRESSURE, jerk, spec
from tests.pipeline.test_auto_proof import EASY, HARD

LEAST_MEAN = {"kind": "rms_acceleration"}  # C2 splines pay for ramps at the ends of the best law


def exits(design: Design) -> list[str]:
    return [each.exit for each in design.report.stages if each.exit]


@pytest.fixture(scope="module")
def bent() -> Design:
    """An answer with everything in it: a relaxation, local searches, a proof without its end."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(goal, "AUTO_PROGRAMS", 50)
        return synthesise(HARD.model_copy(update={"tolerance": 3e-6}))


def test_each_stage_says_which_gap_it_has_left(bent: Design) -> None:
    gaps = [each.gap for each in bent.report.stages if each.gap is not None]
    assert len(gaps) > 2
    assert all(later <= sooner for sooner, later in pairwise(gaps))
    assert gaps[0] > 0.03
    assert gaps[-1] == pytest.approx(bent.certificate.gap, rel=1e-6)


def test_no_second_counts_twice(bent: Design) -> None:
    """The branch and bound looks for better cams on its way: stages inside a stage."""
    stages = bent.report.stages
    assert stages[-1].stage == "implied rows"
    assert [each.stage for each in stages].count("tangents") > 1
    assert 0.5 * bent.report.seconds < sum(each.seconds for each in stages) < bent.report.seconds


def test_nodes_are_those_of_the_branch_and_bound(bent: Design) -> None:
    *before, last = bent.report.stages
    assert not any(each.nodes for each in before)
    assert f"in {last.nodes} boxes" in last.model


def test_the_end_is_named(monkeypatch: pytest.MonkeyPatch, bent: Design) -> None:
    assert exits(bent) == ["budget of the proof"]
    assert exits(synthesise(EASY)) == ["tolerance"]
    rough = {"limits": [PRESSURE], "objective": LEAST_MEAN, "base_radius_mm": 60.0}
    assert exits(synthesise(spec(**rough, tolerance=1e-6))) == ["the lowest node is not divided"]
    monkeypatch.setattr(goal, "THOROUGH_PROGRAMS", 50)
    sharp = HARD.model_copy(update={"proof": "thorough", "tolerance": 3e-6})
    assert exits(synthesise(sharp)) == ["budget of the proof"]


def test_every_objective_has_an_end_of_its_own() -> None:
    in_order = [{"kind": "base_radius"}, {"kind": "rms_jerk"}]
    both = spec(limits=[PRESSURE, jerk(51.3)], objective=in_order)
    design = synthesise(both)
    assert len(exits(design)) == 2
    assert design.report.stages[-1].exit


def test_time_that_runs_out_is_named() -> None:
    problem = formulate_problem(EASY, EASY.objectives()[0])
    stages = optimise(problem, 1e-6, clock.now()).stages
    assert [each.exit for each in stages] == ["time"]


def test_a_search_around_whole_problems_names_their_solvers() -> None:
    given = scene(law="cycloidal", distance=101.9, objective={"kind": "peak_pressure_angle"})
    (stage,) = (e for e in synthesise(given).report.stages if e.stage == "peak pressure angle")
    assert stage.solver == "none"  # closed forms
    solved = optimise(formulate_problem(EASY, EASY.objectives()[0]), 1e-3)
    assert solvers_of(solved, ("IPOPT",)) == ("IPOPT", "Clarabel")
    assert solvers_of(solved, solvers_of(solved)) == ("Clarabel",)
