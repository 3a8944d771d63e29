"""The best multipliers: the bound comes to the closed forms from below, to a ten-millionth."""

from __future__ import annotations

from math import sqrt
from typing import Any

import numpy as np
import pytest

from synthesis.optimise.driver import optimise
from synthesis.optimise.dual_bound.bound import Bound
from synthesis.optimise.dual_bound.dual_ascent import improve_multipliers
from synthesis.spec.design_spec import DesignSpec
from tests.optimise.dual_bound.test_bound import BETA, SYMMETRIC, TURN, turn_share
from tests.optimise.scenes import LIFT, acceleration, jerk, problem, scene

J = 57.3
ROOT = J / 4.0 * (1.0 - sqrt(1.0 - 32.0 / J))
TAU = (1.0 - sqrt(1.0 - 24.0 / J)) / 2.0
NEAR = 1e-7
# scenes and their exact optima
EXACT: dict[str, tuple[DesignSpec, float]] = {
    "peak jerk": (scene(SYMMETRIC, objective="peak_jerk"), 32.0 * LIFT / BETA**3),
    "peak acceleration, jerk capped": (
        scene(SYMMETRIC, jerk(J, 71.7), objective="peak_acceleration"), ROOT * LIFT / BETA**2
    ),
    # the same forms read backwards: the least jerk cap that leaves so much acceleration
    "peak jerk, acceleration capped": (
        scene(SYMMETRIC, acceleration(ROOT, 71.7), objective="peak_jerk"), J * LIFT / BETA**3
    ),
    "dwell to turn": (scene(TURN, objective="peak_jerk"), 6.0 * (2.0 + sqrt(2.0)) * LIFT / BETA**3),
    "rms acceleration, jerk capped": (
        scene(SYMMETRIC, jerk(J, 71.7), objective="rms_acceleration"),
        turn_share((J * TAU) ** 2 / 3.0) / BETA**2,
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", EXACT)
def test_the_bound_meets_the_closed_form_from_below(name: str) -> None:
    spec, exact = EXACT[name]
    state = optimise(problem(spec), 1e-7)
    assert state.incumbent is not None
    assert exact * (1.0 - NEAR) <= state.incumbent.value <= exact * (1.0 + 20.0 * NEAR)
    assert exact * (1.0 - NEAR) <= state.lower <= exact * (1.0 + 1e-10)
    assert "all motion laws" in state.valid_for


def test_a_bound_that_is_known_is_never_given_up() -> None:
    state = optimise(problem(EXACT["peak jerk"][0]), 1e-4)
    assert state.relaxation is not None
    model, solution, lower = state.relaxation
    known = Bound(2.0 * lower.value, "told", lower.switching, lower.controls)
    question: list[Any] = []

    def enough(found: Bound) -> bool:
        question.append(found)
        return False

    assert improve_multipliers(model, solution, known, enough, 10.0) is known
    assert len(question) > 0
    # and a better one is found, below the optimum
    better = improve_multipliers(model, solution, lower, lambda _: False, 10.0)
    assert lower.value < better.value <= EXACT["peak jerk"][1] * (1.0 + 1e-10)
    assert np.isfinite(better.value)


def test_no_time_no_program() -> None:
    state = optimise(problem(EXACT["peak jerk"][0]), 1e-4)
    assert state.relaxation is not None
    model, solution, lower = state.relaxation
    assert improve_multipliers(model, solution, lower, lambda _: False, 0.0).value >= lower.value
