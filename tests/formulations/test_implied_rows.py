"""Rows that a bound on curvature implies inside a box, and the bound that they raise."""

from copy import deepcopy
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from synthesis import DesignSpec, synthesise
from synthesis.followers.pitch_curvature import PitchCurvature
from synthesis.formulations.candidate import settle
from synthesis.formulations.closing import Known, explored, narrowed, near_to_binding
from synthesis.formulations.convex import formulate, with_rows
from synthesis.formulations.grid import over
from synthesis.formulations.nonlinear import improve
from synthesis.formulations.problem import pose
from synthesis.formulations.refine import search
from synthesis.formulations.rows import Drawn
from synthesis.terms import Within


def box(seed: int, width: float) -> tuple[Within, np.random.Generator]:
    draw = np.random.default_rng(seed)
    low, slow = draw.uniform(3.0, 40.0, 5), draw.uniform(-30.0, 25.0, 5)
    sizes = ((e := draw.uniform(-20.0, 15.0), e + width * 6.0), (s0 := 17.3, s0 + width * 4.0))
    high = low + width * draw.uniform(0.1, 8.0, 5)
    fast = slow + width * draw.uniform(0.1, 14.0, 5)
    return Within(low, high, slow, fast, sizes), draw


def sharpest(s: np.ndarray, v: np.ndarray, e: float, s0: float, limit: PitchCurvature):
    """s'' at which side · κ = most: by the textbook's formula for κ, solved for s''."""
    x, u = s + s0, v - e
    flat = limit.side * limit.most * (x * x + u * u) ** 1.5
    return (x * x + u * (2.0 * v - e) - flat) / x


@settings(max_examples=120)
@given(st.integers(0, 10**6), st.sampled_from([1, -1]), st.floats(0.002, 0.3), st.floats(1e-3, 1.0))
def test_no_motion_and_size_inside_the_box_is_cut_off(seed, side, most, width):
    within, draw = box(seed, width)
    limit = PitchCurvature("", side, most)
    inside = [draw.uniform(a, b, (60, 5)) for a, b in
              ((within.low, within.high), (within.slow, within.fast))]  # fmt: skip
    about = np.stack([0.4 * within.low + 0.6 * within.high, within.slow])
    z = tuple(0.3 * a + 0.7 * b for a, b in within.sizes)
    for place in (None, (about, z)):
        (cuts,) = limit.cuts(within, place)
        for s, v in zip(*inside, strict=True):
            e, s0 = (draw.choice([a, b, draw.uniform(a, b)]) for a, b in within.sizes)
            a = sharpest(s, v, e, s0, limit) + limit.side * draw.exponential(3.0, 5)
            left = cuts.coefficients[:3] * np.stack([s, v, a])
            total = left.sum(axis=0) + cuts.size[0] * e + cuts.size[1] * s0
            scale = np.max(np.abs(left), axis=0) + np.abs(cuts.upper) + 1.0
            assert np.all(total <= cuts.upper + 1e-11 * scale)


@given(st.integers(0, 10**6), st.sampled_from([1, -1]), st.floats(0.005, 0.2))
def test_what_a_row_loses_shrinks_with_the_square_of_the_box(seed, side, most):
    limit, lost = PitchCurvature("", side, most), []
    for width in (0.02, 0.01):
        within, _ = box(seed, width)
        (cuts,) = limit.cuts(within, None)
        s, v = 0.5 * (within.low + within.high), 0.5 * (within.slow + within.fast)
        e, s0 = (0.5 * (a + b) for a, b in within.sizes)
        a = sharpest(s, v, e, s0, limit)
        rest = cuts.upper - cuts.size[0] * e - cuts.size[1] * s0
        lost.append(rest - (cuts.coefficients[:3] * np.stack([s, v, a])).sum(axis=0))
    assert np.all(lost[1] >= -1e-9)
    assert np.max(lost[1]) <= 0.3 * np.max(lost[0]) + 1e-9


def test_no_rows_where_the_box_reaches_the_axis_or_is_open():
    within, _ = box(7, 0.5)
    limit = PitchCurvature("", 1, 0.05)
    reaching = Within(within.low - 60.0, within.high, within.slow, within.fast, within.sizes)
    assert limit.cuts(reaching, None) == ()
    open_ = Within(within.low, within.high, within.slow, within.fast + np.inf, within.sizes)
    assert limit.cuts(open_, None) == ()


SCENE = {
    "speed_rpm": 95.49296585513721,
    "program": [
        {"kind": "rise", "angle_deg": 61.0, "lift_mm": 29.3},
        {"kind": "dwell", "angle_deg": 31.0},
        {"kind": "return", "angle_deg": 63.0, "lift_mm": 29.3},
        {"kind": "dwell", "angle_deg": 205.0},
    ],
    "follower": {
        "kind": "translating_roller",
        "roller_radius_mm": 9.7,
        "offset_mm": {"min": -24.0, "max": 26.0},
    },
    "base_radius_mm": {"min": 20.0, "max": 120.0},
    "limits": [
        {"kind": "pressure_angle", "rise_deg": 30.0, "return_deg": 45.0},
        {"kind": "jerk", "max_mm_per_s3": 1.2e6},
        {"kind": "profile_radius", "min_mm": 12.1},
    ],
    "tolerance": 5e-3,
}


@pytest.fixture(scope="module")
def spec() -> DesignSpec:
    return DesignSpec.model_validate(SCENE)


@pytest.fixture(scope="module")
def thorough(spec: DesignSpec):
    return synthesise(spec.model_copy(update={"proof": "thorough"}))


def test_the_gap_that_curvature_leaves_is_closed(spec: DesignSpec, thorough):
    quick = synthesise(spec)
    assert quick.status == "feasible"
    assert quick.certificate.gap > 0.02
    assert thorough.status == "optimal"
    assert thorough.certificate.gap <= 5e-3
    assert thorough.certificate.bound_over == "all motion laws with a bounded jerk"
    assert thorough.objectives["base_radius_mm"] <= quick.objectives["base_radius_mm"] * (1 + 1e-9)


@pytest.fixture(scope="module")
def found(spec: DesignSpec):
    search_ = search(pose(spec, spec.objectives()[0]), 5e-3)
    assert search_.best is not None
    return search_


@pytest.fixture(scope="module")
def finer(found):
    """A better cam: a local optimum on four times as many knots."""
    problem = found.problem
    grids = tuple(
        over(stretch, np.union1d(grid.space.breaks, np.linspace(0.0, 1.0, 81)))
        for stretch, grid in zip(problem.free, found.grids, strict=True)
    )
    plan = formulate(problem, grids, 0.0, Drawn(1e-7))
    better = improve(plan, plan.point(found.best.laws, found.best.size), None, 1e-6)
    laws, size = plan.recover(better.x)
    return settle(problem, laws, size, keep_hint=True)


def test_the_bound_is_below_local_optima_on_much_finer_knots(thorough, found, finer):
    assert finer.value < found.best.value
    assert thorough.certificate.lower_bound + 9.7 < finer.value


def test_a_better_cam_lies_where_better_cams_are_said_to_lie(found, finer):
    near = {k: near_to_binding(found.best, s) for k, s in enumerate(found.problem.free)}
    known = narrowed(found, found.best, near, Known(found.problem, found.lower, "", found.grids))
    known = narrowed(found, found.best, near, known)  # now with the rows that the first one gave
    for (low, high), value in zip(known.sizes, finer.size, strict=True):
        assert low <= value <= high
        assert high - low < 5.0
    for position, tube in known.tubes.items():
        law = finer.laws[position].curve()
        x = np.linspace(tube.nodes[0], tube.nodes[-1], 333)
        for (low, high), values in ((tube.positions(x), law(x)), (tube.speeds(x), law(x, 1))):
            assert np.all(values >= low - 1e-9)
            assert np.all(values <= high + 1e-9)
    assert len(known.tubes) == 2


def test_hollow_flanks_that_a_cutter_must_fit():
    scene = {**deepcopy(SCENE), "tolerance": 0.2}
    scene["limits"][2] = {"kind": "cutter_radius", "radius_mm": 70.0}
    scene["limits"].append({"kind": "profile_radius", "min_mm": 2.0})
    quick = synthesise(DesignSpec.model_validate(scene))
    close = synthesise(DesignSpec.model_validate({**scene, "proof": "thorough"}))
    assert quick.certificate.gap > 0.24
    assert close.certificate.gap <= 0.2
    assert close.certificate.lower_bound <= quick.objectives["base_radius_mm"]


def test_a_ring_s_outer_flank_too():
    scene = {**deepcopy(SCENE), "tolerance": 0.02}
    scene["follower"]["closure"] = {"kind": "force", "contact": "inside"}
    quick = synthesise(DesignSpec.model_validate(scene))
    close = synthesise(DesignSpec.model_validate({**scene, "proof": "thorough"}))
    assert close.certificate.gap <= quick.certificate.gap
    assert close.certificate.lower_bound <= quick.objectives["base_radius_mm"]


def test_thorough_changes_nothing_where_curvature_does_not_bind(spec: DesignSpec):
    loose = spec.model_copy(update={"limits": list(spec.limits[:2])})
    quick, close = synthesise(loose), synthesise(loose.model_copy(update={"proof": "thorough"}))
    assert quick.status == close.status == "optimal"
    assert quick.size == close.size
    assert quick.certificate == close.certificate


def test_no_further_rows_leave_a_plan_as_it_is(found):
    plan = formulate(found.problem, found.grids)
    assert with_rows(plan, []) is plan


def test_the_bound_is_never_above_the_cam_it_is_about(found):
    near = {k: near_to_binding(found.best, s) for k, s in enumerate(found.problem.free)}
    known = Known(found.problem, found.lower, "", found.grids)
    # far on the wrong side: no better cam has its offset there
    (_, high), *rest = found.problem.sizing.bounds
    there = replace(found.problem.sizing, bounds=((high - 4.0, high), *rest))
    known = replace(known, problem=replace(found.problem, sizing=there))
    assert explored(found, found.best, near, known).lower <= found.best.value
