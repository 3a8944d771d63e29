"""Limits that are not convex, looked at where a law's pieces begin: far is said of no near one."""

from collections.abc import Mapping
from dataclasses import replace
from math import inf
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from synthesis.formulations.cams.candidate import Candidate, grow, settle
from synthesis.formulations.cams.smooth import NEAR, _far, peaks, sample, violation
from synthesis.formulations.cone.convex import formulate
from synthesis.formulations.question.grid import uniform
from synthesis.formulations.question.problem import Problem
from synthesis.formulations.rounds.search import Search
from synthesis.solvers.clarabel import solve
from tests.formulations.scenes import acceleration, angles, dwell, fall, jerk, problem, rise, scene

RADIUS = {"kind": "profile_radius", "min_mm": 7.3}
CUTTER = {"kind": "cutter_radius", "radius_mm": 23.7}
DWELLS = rise(71.7), dwell(23.9), fall(83.3), dwell(181.1)
TURNS = rise(131.7), fall(97.3), dwell(131.0)
JUMPS = rise(71.7, smoothness=1), dwell(23.9), fall(83.3, smoothness=1), dwell(181.1)
SCENES: dict[str, tuple[tuple[Mapping[str, Any], ...], Mapping[str, Any]]] = {
    "dwells": (DWELLS, jerk(57.0, 71.7)),
    "turns": (TURNS, jerk(57.0, 71.7)),
    "acceleration jumps": (JUMPS, acceleration(5.9, 71.7)),
}


def cam(name: str) -> tuple[Problem, Candidate]:
    """The question, and the relaxation's cam."""
    program, steering = SCENES[name]
    asked = problem(scene(program, angles(31.0, 39.0), steering, RADIUS, CUTTER))
    plan = formulate(asked, [uniform(stretch, 37) for stretch in asked.free])
    return asked, settle(asked, *plan.recover(solve(plan.program).x))


@pytest.mark.parametrize("name", SCENES)
def test_what_is_far_is_far_everywhere(name: str) -> None:
    _, found = cam(name)
    asked, (e, s0) = found.problem, found.size
    dense, seen = sample(asked), set()

    def worst(raised: float) -> float:
        size = (e, raised)
        return violation(asked, [*dense, *peaks(asked, dense, size)], size)

    for raised in np.geomspace(0.02, 6.0, 31) * s0:
        far, value = _far(asked, (e, raised)), worst(raised)
        assert not far or value <= NEAR
        seen.add((far, value <= NEAR))
        if far:
            same = replace(found, size=(e, raised))
            assert grow(same) is grow(same, closely=True) is same
    assert {(True, True), (False, False)} <= seen
    just_near = brentq(lambda raised: worst(raised) - NEAR - 1e-6, 0.02 * s0, 6.0 * s0, xtol=1e-9)
    assert not _far(asked, (e, just_near))


def test_a_law_of_few_pieces_is_sampled() -> None:
    given = (rise(71.7, law="cycloidal"), dwell(23.9), fall(83.3), dwell(181.1))
    whole = problem(scene(given, angles(31.0, 39.0), jerk(57.0, 71.7), RADIUS))
    plan = formulate(whole, [uniform(stretch, 37) for stretch in whole.free])
    found = settle(whole, *plan.recover(solve(plan.program).x))
    assert not _far(found.problem, (found.size[0], 50.0 * found.size[1]))


def test_once_a_cam_was_refused_they_are_sampled(monkeypatch: pytest.MonkeyPatch) -> None:
    asked, found = cam("turns")
    found = replace(found, size=(found.size[0], 0.3 * found.size[1]))
    monkeypatch.setattr("synthesis.formulations.cams.smooth._far", lambda *_: True)
    sizes = []
    for tighten in (1e-7, 1e-6):
        state = Search(asked, 1e-2, inf, tighten)
        state.finish(found)
        assert state.best is not None
        sizes.append(state.best.size)
    assert sizes[0] == found.size
    assert sizes[1][1] > 1.1 * found.size[1]
