"""The best multipliers of limits on residual vibration, found together with those of the rows."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from synthesis.numerics.solvers.clarabel import solve
from synthesis.optimise.conic.control import law_controls
from synthesis.optimise.driver import optimise
from synthesis.optimise.dual_bound.bound import dual_bound
from synthesis.optimise.dual_bound.dual_ascent import _DualProgram, improve_multipliers
from synthesis.optimise.problem import residual_vibration
from synthesis.spec.design_spec import DesignSpec
from tests.optimise.scenes import direct, even, problem

MOST = {"a little": 0.0635, "none": 0.0}  # mm, of vibration that may be left
FREE, GIVEN = {"kind": "spline"}, {"kind": "cycloidal"}


def move(kind: str, angle: float, lift: float = 20.4, law: dict[str, str] = FREE) -> dict[str, Any]:
    return {"kind": kind, "angle_deg": angle, "lift_mm": lift, "law": law}


def dwell(angle: float) -> dict[str, Any]:
    return {"kind": "dwell", "angle_deg": angle}


PROGRAMS = {
    "between dwells": [move("rise", 119.0), dwell(36.1), move("return", 119.0), dwell(85.9)],
    "with a turn": [move("rise", 119.0), move("return", 131.0), dwell(110.0)],
    "with a given law": [
        move("rise", 119.0, 12.1, GIVEN), move("rise", 70.0, 8.3), move("return", 119.0),
        dwell(52.0),
    ],
}  # fmt: skip


def spec(most: float, program: str = "between dwells", **more: Any) -> DesignSpec:
    """Vibration and jerk cap the speed."""
    body = {
        "speed_rpm": 106.0,
        "program": PROGRAMS[program],
        "follower": {"kind": "translating_roller", "roller_radius_mm": 9.94},
        "limits": [
            {"kind": "pressure_angle", "rise_deg": 38.1, "return_deg": 42.9},
            {"kind": "jerk", "max_mm_per_s3": 152731.0},
            {"kind": "residual_vibration", "natural_frequency_hz": 15.9, "max_mm": most},
        ],
        "objective": {"kind": "base_radius"},
    }
    return DesignSpec.model_validate(body | more)


@pytest.mark.parametrize("program", PROGRAMS)
@pytest.mark.parametrize("most", MOST.values(), ids=MOST)
def test_they_leave_a_small_part_of_the_gap(most: float, program: str) -> None:
    question = problem(spec(most, program))
    answer = direct(question, even(question, 60))
    known = dual_bound(answer.model, answer.solution)
    better = improve_multipliers(answer.model, answer.solution, known, lambda _: False, 30.0)
    fine = direct(question, even(question, 400)).value
    assert known.value < better.value <= fine * (1.0 + 1e-9)
    assert fine - better.value < 0.06 * (fine - known.value)


@pytest.mark.parametrize("most", MOST.values(), ids=MOST)
def test_any_multipliers_give_a_bound(most: float) -> None:
    """By Cauchy and Schwarz those of a vibration cost the limit times their length."""
    question, random = problem(spec(most)), np.random.default_rng(5)
    answer = direct(question, even(question, 60))
    fine = direct(question, even(question, 400)).value
    task = _DualProgram.of(answer.model, answer.solution, law_controls(answer.model))
    x = solve(task._program([np.zeros(0) for _ in answer.model.grids]), 10.0, project=False).x
    best = task.bound(x).value
    assert 0.98 * fine < best <= fine * (1.0 + 1e-9)
    assert len(task.vibrations) == 2
    for _ in range(20):
        shaken = x.copy()
        for _, at in task.vibrations:
            shaken[at : at + 2] *= random.uniform(-1.0, 3.0, 2)
        assert -np.inf < task.bound(shaken).value <= fine * (1.0 + 1e-9)


def test_what_coarse_pieces_of_a_wave_miss_is_paid_for(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(residual_vibration, "FINE", 4.0)
    question = problem(spec(MOST["a little"]))
    answer = direct(question, even(question, 60))
    known = dual_bound(answer.model, answer.solution)
    better = improve_multipliers(answer.model, answer.solution, known, lambda _: False, 30.0)
    fine = direct(question, even(question, 400)).value
    assert better.value <= fine * (1.0 + 1e-9)


def test_the_gap_of_a_convex_question_closes_at_its_tolerance() -> None:
    """Also where the tolerance is no fine one, and meshes alone leave more."""
    limits = spec(0.0408).model_dump(exclude_unset=True)["limits"]
    limits[0]["rise_deg"] = 38.2953
    state = optimise(problem(spec(0.0408, limits=limits)), 5e-3)
    assert state.incumbent is not None
    assert state.is_good_enough
    assert state.covers_all_laws
