"""Local optima by tangents: against IPOPT's, and against curvature measured on the pitch curve."""

from __future__ import annotations

from dataclasses import replace
from math import inf
from typing import Any

import numpy as np
import pytest

from synthesis.catalogue.objectives import RmsJerk
from synthesis.numerics.bspline import SplineSpace
from synthesis.numerics.solvers.clarabel import solve
from synthesis.optimise.conic.program import formulate
from synthesis.optimise.conic.tangent_cuts import Region
from synthesis.optimise.heuristics.ipopt_search import solve_ipopt
from synthesis.optimise.heuristics.scp import ScpResult, ScpTarget, _slopes, solve_scp
from synthesis.optimise.problem.grid import SplineLaw, grid_through, uniform_grid
from synthesis.optimise.recovery.candidate import recover_cam
from synthesis.optimise.recovery.smooth_limits import constraint_samples
from synthesis.spec.design_spec import DesignSpec
from tests.optimise.arms import body
from tests.optimise.arms import jerk as jerk_of_arm
from tests.optimise.heuristics.test_nonlinear import cutter, excess, radius
from tests.optimise.scenes import PLAIN, angles, dwell, fall, jerk, problem, rise, scene

CLOSE = 1e-4
SCENES: dict[str, DesignSpec] = {
    "radius": scene(PLAIN, angles(31.0, 43.0), jerk(52.0, 71.7), radius(11.0), roller=9.3),
    "cutter": scene(PLAIN, angles(41.0, 43.0), jerk(90.0, 71.7), cutter(57.0), roller=5.3),
    "return given": scene(
        (rise(71.7), dwell(23.9), fall(83.3, law="modified_sine"), dwell(181.1)),
        angles(29.0, 47.0), jerk(62.0, 71.7), radius(13.0), roller=9.3,
    ),
    "radius given on an arm": DesignSpec.model_validate(
        body(angles(33.0, 41.0), jerk_of_arm(1.9), radius(14.0), distance=101.9)
    ),
}  # fmt: skip


def tangents(spec: DesignSpec, close: float = CLOSE, intervals: int = 14) -> tuple[ScpResult, Any]:
    """From the law of least mean square jerk, on the size that the relaxation likes."""
    question = problem(spec)
    grids = [uniform_grid(segment, intervals) for segment in question.free]
    quiet = formulate(replace(question, objective=RmsJerk()), grids)
    model = formulate(question, grids, region=Region())
    start = recover_cam(question, *quiet.recover(solve(quiet.program).x))
    return solve_scp(model, start.laws, start.size, inf, ScpTarget(close, 1e-6)), model


@pytest.mark.parametrize("name", SCENES)
def test_as_good_as_the_local_optimum_of_a_nonlinear_program(name: str) -> None:
    found, model = tangents(SCENES[name])
    assert found.converged
    assert found.cam is not None
    nearby = solve_ipopt(model, model.point(found.cam.laws, found.cam.size), tighten=1e-6)
    best = recover_cam(model.problem, *model.recover(nearby.x), keep_size=True).value
    assert found.cam.value == pytest.approx(best, rel=2.0 * CLOSE)


@pytest.mark.parametrize("name", ["radius", "cutter", "return given"])
def test_every_limit_holds_on_the_pitch_curve_as_measured(name: str) -> None:
    found, model = tangents(SCENES[name])
    assert found.cam is not None
    x = model.point(found.cam.laws, found.cam.size)
    broken = excess(SCENES[name], model, x)
    assert -1e-3 < float(np.max(broken)) < 1e-6


@pytest.mark.parametrize(("name", "aside"), [("radius", -0.5), ("cutter", 0.2)])
def test_from_an_offset_far_aside_it_comes_to_the_same_cam(name: str, aside: float) -> None:
    """The cutter's third cam keeps all limits, and its tangents allow none that is smaller: 0.44 %
    above the best, which new tangents tell.
    """
    near, model = tangents(SCENES[name])
    assert near.cam is not None
    e, s0 = near.cam.size
    far = solve_scp(model, near.cam.laws, (e + aside * s0, 1.3 * s0), inf, ScpTarget(CLOSE, 1e-6))
    assert far.converged
    assert far.cam is not None
    assert far.cam.value == pytest.approx(near.cam.value, rel=2.0 * CLOSE)


def test_time_that_is_over_leaves_the_cam_it_began_at() -> None:
    near, model = tangents(SCENES["radius"])
    assert near.cam is not None
    laws, (e, s0) = near.cam.laws, near.cam.size
    found = solve_scp(model, laws, (e, 1.1 * s0), 0.0, ScpTarget(CLOSE, 1e-6))
    assert (found.converged, found.programs) == (False, 0)
    assert found.cam is not None
    assert found.cam.size == pytest.approx((e, 1.1 * s0))


@pytest.mark.parametrize("smoothness", [1, 2, 3, 4])
def test_a_law_is_the_same_on_finer_knots(smoothness: int) -> None:
    rng = np.random.default_rng(7)
    coarse = SplineSpace(smoothness + 1, np.array([0.0, 0.11, 0.37, 0.62, 0.9, 1.0]))
    program = rise(71.7, smoothness=smoothness), fall(83.3), dwell(205.0)
    segment, _ = problem(scene(program, angles(31.0))).free
    fine = grid_through(segment, np.union1d(coarse.breaks, np.linspace(0.0, 1.0, 60))).space
    law = SplineLaw(coarse, rng.normal(size=coarse.size))
    x = np.linspace(0.0, 1.0, 977)
    assert SplineLaw(fine, law.on(fine)).curve()(x) == pytest.approx(law.curve()(x), abs=1e-12)


def test_a_limit_without_a_tangent_asks_for_nothing() -> None:
    """The curvature of a traced point that stands still is 0/0."""
    question = problem(scene(PLAIN, radius(11.0), roller=9.3))
    quiet = formulate(
        replace(question, objective=RmsJerk()), [uniform_grid(each, 14) for each in question.free]
    )
    cam = recover_cam(question, *quiet.recover(solve(quiet.program).x))
    samples = constraint_samples(cam.problem, cam.size, -inf, inf)[0]
    moving = _slopes(cam.problem, samples, cam.size)
    at_rest = samples.s.copy()
    at_rest[:, 0] = -cam.size[-1], 0.0, 0.0, 0.0  # the traced point lies on the axis
    value, by_motion, by_size = _slopes(cam.problem, replace(samples, s=at_rest), cam.size)
    assert value[0, 0] == -1.0
    assert not by_motion[0, :, 0].any()
    assert not by_size[0, :, 0].any()
    for still, before in zip((value, by_motion, by_size), moving, strict=True):
        np.testing.assert_array_equal(still[..., 1:], before[..., 1:])
