"""Bounds of the motion alone, where the cam may be as large as one likes, hold for every size."""

from dataclasses import replace

import pytest

from synthesis import DesignSpec, synthesise
from synthesis.numerics.solvers.clarabel import solve
from synthesis.optimise.conic.program import formulate
from synthesis.optimise.dual_bound.bound import dual_bound
from synthesis.optimise.problem.grid import uniform_grid
from synthesis.optimise.problem.problem import Problem, formulate_problem

ROLLER = {"kind": "translating_roller", "roller_radius_mm": 15.0}
FACE = {"kind": "translating_flat_face"}


def spec(follower: dict, limit: dict, objective: str, **more: object) -> DesignSpec:
    move = {"lift_mm": 7.7}
    return DesignSpec.model_validate({
        "program": [
            {"kind": "rise", "angle_deg": 101.0, **move}, {"kind": "dwell", "angle_deg": 20.0},
            {"kind": "return", "angle_deg": 93.0, **move}, {"kind": "dwell", "angle_deg": 146.0},
        ],
        "follower": follower, "limits": [limit], "objective": {"kind": objective}, **more,
    })  # fmt: skip


def value_and_bound(problem: Problem) -> tuple[float, float]:
    """Optimum of the splines and the bound, both as the program's objective."""
    model = formulate(problem, [uniform_grid(segment, 24) for segment in problem.free])
    solution = solve(model.program)
    unit = model.scales.level if model.energy is None else 1.0
    value = model.program.value(solution.x) * unit
    if model.energy is not None:
        value = (value * model.energy.unit + model.energy.constant) ** 0.5
    return value, dual_bound(model, solution).value


@pytest.mark.parametrize("objective", ["peak_acceleration", "peak_jerk", "rms_jerk"])
@pytest.mark.parametrize(
    ("follower", "limit", "largest"),
    [
        (ROLLER, {"kind": "pressure_angle", "rise_deg": 16.0, "return_deg": 16.0}, 16.5),
        (FACE, {"kind": "profile_radius", "min_mm": 3.0}, 7.0),
    ],
)
def test_the_largest_size_searched_is_not_in_the_bound(
    follower: dict, limit: dict, largest: float, objective: str
) -> None:
    question = spec(follower, limit, objective)
    problem = formulate_problem(question, question.objectives()[0])
    least, _ = value_and_bound(problem)
    sizing = question.follower.size_domain((0.0, largest - question.follower.roller_radius_mm))
    value, bound = value_and_bound(replace(problem, sizing=sizing))
    assert value > 1.02 * least  # so small an end would bind
    assert bound <= least * (1.0 + 1e-9)


def test_a_largest_radius_asked_for_is() -> None:
    limit = {"kind": "pressure_angle", "rise_deg": 16.0, "return_deg": 16.0}
    more = {"proof": "quick", "tolerance": 2e-2}
    one = synthesise(spec(ROLLER, limit, "peak_jerk", **more)).certificate
    smaller = spec(ROLLER, limit, "peak_jerk", base_radius_mm={"max": 1.5}, **more)
    other = synthesise(smaller).certificate
    assert one.value is not None
    assert other.lower_bound is not None
    assert other.lower_bound > 1.02 * one.value
