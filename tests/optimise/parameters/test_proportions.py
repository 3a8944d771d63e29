"""What the search over free angles stands on: knots that follow windows, values that are smooth."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from synthesis.optimise.driver import estimate
from synthesis.optimise.parameters.value_function import mesh_like
from synthesis.optimise.problem.grid import uniform_grid
from synthesis.optimise.problem.problem import Problem, formulate_problem
from synthesis.spec.design_spec import DesignSpec

WINDOW = {"from_deg": 21.7, "to_deg": 36.3, "velocity_mm_per_s": 130.0}
POINT = {"angle_deg": 51.9, "travel_mm": 17.3}


def question(up: float, objective: str = "peak_jerk", **more: Any) -> Problem:
    body = {
        "speed_rpm": 88.8,
        "program": [
            {"kind": "rise", "angle_deg": up, "lift_mm": 22.1, "windows": [WINDOW],
             "points": [POINT]},
            {"kind": "dwell", "angle_deg": 33.0},
            {"kind": "return", "angle_deg": 240.0 - up, "lift_mm": 22.1},
            {"kind": "dwell", "angle_deg": 87.0},
        ],
        "follower": {"kind": "translating_roller", "roller_radius_mm": 7.3},
        "base_radius_mm": 70.0,
        "objective": {"kind": objective},
    }  # fmt: skip
    spec = DesignSpec.model_validate(body | more)
    return formulate_problem(spec, spec.objectives()[0])


def test_knots_follow_the_windows() -> None:
    here, there = question(83.0), question(101.0)
    mesh = mesh_like(here, [uniform_grid(segment, 17) for segment in here.free])
    first, second = mesh(there)
    for degrees in (21.7, 36.3, 51.9):
        assert np.min(np.abs(first.space.breaks - degrees / 101.0)) < 1e-15
    own = uniform_grid(here.free[1], 17).space.breaks
    np.testing.assert_allclose(second.space.breaks, own, atol=1e-15)
    assert len(first.space.breaks) == len(mesh(here)[0].space.breaks)


@pytest.mark.parametrize("objective", ["peak_jerk", "rms_jerk", "peak_pressure_angle"])
def test_the_estimate_is_smooth_in_the_angles(objective: str) -> None:
    """Differences over a step of 1e-4° agree with those over one ten times as long."""
    more: dict[str, Any] = {}
    if objective == "peak_pressure_angle":
        more["limits"] = [{"kind": "jerk", "max_mm_per_s3": 2.0e6}]
    here = question(97.1, objective, **more)
    mesh = mesh_like(here, [uniform_grid(segment, 17) for segment in here.free])

    def value(up: float) -> float:
        problem = question(up, objective, **more)
        found = estimate(problem, mesh(problem))
        assert found is not None
        return found

    short, long = ((value(97.1 + d) - value(97.1)) / d for d in (1e-4, 1e-3))
    assert short == pytest.approx(long, rel=2e-2)
    assert abs(short) > 0.0


def test_the_estimate_is_the_optimum_on_the_grid_where_all_is_convex() -> None:
    from tests.optimise.scenes import direct

    here = question(97.1)
    grids = [uniform_grid(segment, 17) for segment in here.free]
    assert estimate(here, grids) == pytest.approx(direct(here, grids).value, rel=1e-5)
