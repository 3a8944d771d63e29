"""Limits that are not convex, looked at where a law's pieces begin: far is said of no near one."""

from collections.abc import Mapping
from dataclasses import replace
from math import inf
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from synthesis.numerics.solvers.clarabel import solve
from synthesis.optimise.conic.program import formulate
from synthesis.optimise.problem.grid import uniform_grid
from synthesis.optimise.problem.problem import Problem
from synthesis.optimise.recovery.candidate import Candidate, enlarge_until_feasible, recover_cam
from synthesis.optimise.recovery.smooth_limits import (
    NEAR,
    _is_far_from_binding,
    peaks,
    sample,
    violation,
)
from synthesis.optimise.state import SolveState
from tests.optimise.scenes import acceleration, angles, dwell, fall, jerk, problem, rise, scene

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
    question = problem(scene(program, angles(31.0, 39.0), steering, RADIUS, CUTTER))
    model = formulate(question, [uniform_grid(segment, 37) for segment in question.free])
    return question, recover_cam(question, *model.recover(solve(model.program).x))


@pytest.mark.parametrize("name", SCENES)
def test_what_is_far_is_far_everywhere(name: str) -> None:
    _, found = cam(name)
    question, (e, s0) = found.problem, found.size
    dense, seen = sample(question), set()

    def worst(raised: float) -> float:
        size = (e, raised)
        return violation(question, [*dense, *peaks(question, dense, size)], size)

    for raised in np.geomspace(0.02, 6.0, 31) * s0:
        far, value = _is_far_from_binding(question, (e, raised)), worst(raised)
        assert not far or value <= NEAR
        seen.add((far, value <= NEAR))
        if far:
            same = replace(found, size=(e, raised))
            assert (
                enlarge_until_feasible(same) is enlarge_until_feasible(same, densely=True) is same
            )
    assert {(True, True), (False, False)} <= seen
    just_near = brentq(lambda raised: worst(raised) - NEAR - 1e-6, 0.02 * s0, 6.0 * s0, xtol=1e-9)
    assert not _is_far_from_binding(question, (e, just_near))


def test_a_law_of_few_pieces_is_sampled() -> None:
    given = (rise(71.7, law="cycloidal"), dwell(23.9), fall(83.3), dwell(181.1))
    whole = problem(scene(given, angles(31.0, 39.0), jerk(57.0, 71.7), RADIUS))
    model = formulate(whole, [uniform_grid(segment, 37) for segment in whole.free])
    found = recover_cam(whole, *model.recover(solve(model.program).x))
    assert not _is_far_from_binding(found.problem, (found.size[0], 50.0 * found.size[1]))


def test_once_a_cam_was_refused_they_are_sampled(monkeypatch: pytest.MonkeyPatch) -> None:
    question, found = cam("turns")
    found = replace(found, size=(found.size[0], 0.3 * found.size[1]))
    monkeypatch.setattr(
        "synthesis.optimise.recovery.smooth_limits._is_far_from_binding", lambda *_: True
    )
    sizes = []
    for tighten in (1e-7, 1e-6):
        state = SolveState(question, 1e-2, inf, tighten).with_incumbent(found)
        assert state.incumbent is not None
        sizes.append(state.incumbent.size)
    assert sizes[0] == found.size
    assert sizes[1][1] > 1.1 * found.size[1]
