"""A tolerance of the base radius, as a share of the prime radius."""

from __future__ import annotations

from math import inf

import pytest

from synthesis.optimise.state import SolveState
from tests.optimise.scenes import PLAIN, angles, jerk, problem, scene

ROLLER, TOLERANCE = 9.1, 5e-3


@pytest.mark.parametrize("base", [0.2, 30.0])
def test_it_is_the_wire_s_tolerance_in_the_problem_s_unit(base: float) -> None:
    question = problem(scene(PLAIN, angles(31.0, 43.0), jerk(60.0, 71.7), roller=ROLLER))
    state = SolveState(question, TOLERANCE, inf, 0.0)
    expected = TOLERANCE * base / (base + ROLLER)
    assert state.problem_tolerance(base + ROLLER) == pytest.approx(expected, rel=1e-9)
