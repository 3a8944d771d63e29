"""Rows that a bound on curvature implies inside a box, and the bound that they raise."""

from copy import deepcopy
from dataclasses import replace
from itertools import product
from math import inf

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from synthesis import DesignSpec, synthesise
from synthesis.catalogue.constraints import SlideCoordinates
from synthesis.catalogue.followers.curvature_bound import CurvatureBound
from synthesis.numerics.solvers import clarabel
from synthesis.optimise.branching.node import BindingLimits, BoundTask
from synthesis.optimise.branching.traced_node import TracedNode, solve_relaxation
from synthesis.optimise.conic.control import law_controls
from synthesis.optimise.conic.linear_rows import Tightening
from synthesis.optimise.conic.program import formulate
from synthesis.optimise.conic.tangent_cuts import Region, TangentPoint
from synthesis.optimise.driver import optimise
from synthesis.optimise.heuristics.ipopt_search import solve_ipopt
from synthesis.optimise.problem.grid import Grid, grid_through, uniform_grid
from synthesis.optimise.problem.problem import formulate_problem
from synthesis.optimise.propagation.bound_tightening import tighten_bounds
from synthesis.optimise.propagation.improving_region import initial_region
from synthesis.optimise.propagation.law_tightening import with_value_cap
from synthesis.optimise.recovery.candidate import recover_cam

ROLLER = SlideCoordinates(1, (0.0, 0.0, 0.0), ((0.0, 1.0), (-1.0, 0.0), (1.0, 0.0)))
COUNTER = SlideCoordinates(-1, (140.0, 3.7, -3.7), ((0.0, -1.0), (0.0, 0.0), (0.0, 0.0)))


def box(seed: int, width: float) -> tuple[np.ndarray, np.ndarray, np.random.Generator]:
    """Ranges of X, u and e at five points."""
    draw = np.random.default_rng(seed)
    low = np.stack([draw.uniform(a, b, 5) for a, b in ((20, 60), (-40, 30), (-20, 15))])
    span = np.stack([draw.uniform(0.1, most, 5) for most in (9.0, 14.0, 6.0)])
    return low, low + width * span, draw


def sharpest(x: np.ndarray, u: np.ndarray, e: np.ndarray, limit: CurvatureBound) -> np.ndarray:
    """X'' at which side · κ = most: by the textbook's formula for κ, solved for X''."""
    flat = limit.side * limit.most * (x * x + u * u) ** 1.5
    return (x * x + u * (2.0 * (u + e) - e) - flat) / x


@settings(max_examples=18)
@given(st.integers(0, 10**6), st.sampled_from([1, -1]), st.floats(0.002, 0.3), st.floats(1e-3, 1.0))
def test_no_motion_and_size_inside_the_box_is_cut_off(seed, side, most, width):
    low, high, draw = box(seed, width)
    free = SlideCoordinates(1, (0.0, 0.0, 0.0), ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))
    limit = CurvatureBound("", free, side, most)
    for place in (None, 0.3 * low + 0.7 * high):
        (cuts,) = limit.linear_relaxation(low, high, place)
        for _ in range(25):
            corner = draw.random((3, 5)).round() if draw.random() < 0.3 else draw.random((3, 5))
            at = low + corner * (high - low)
            a = sharpest(*at, limit) + side * draw.exponential(3.0, 5)
            # with s = s' = 0 the size says it all
            total = cuts.coefficients[2] * a + np.sum(cuts.size * at, axis=0)
            scale = np.max(np.abs(cuts.size * at), axis=0) + np.abs(a) + np.abs(cuts.upper) + 1.0
            assert np.all(total <= cuts.upper + 1e-11 * scale)


@pytest.mark.parametrize("seen", [ROLLER, COUNTER])
def test_a_point_is_seen_as_its_curvature_sees_it(seen):
    """Rows in s, s', s'' and z are those in X, u, X'' and e."""
    draw = np.random.default_rng(5)
    s, v, a = draw.uniform(0, 30, 5), draw.uniform(-20, 20, 5), draw.uniform(-90, 90, 5)
    z = (8.3, 41.9)
    x, u, e = seen.evaluate((s, v), z)
    assert np.allclose(x, s + 41.9 if seen is ROLLER else 140.0 - 41.9 - s)
    assert np.allclose(u, v - 8.3 if seen is ROLLER else 3.7 - v)
    assert np.allclose(e, 8.3 if seen is ROLLER else -3.7)
    at = np.stack([x, u, e + 0.0 * x])
    limit = CurvatureBound("", seen, 1, 0.04)
    (cuts,) = limit.linear_relaxation(at, at, None)  # of no width: nothing is lost
    needed = sharpest(*at, limit)
    total = cuts.coefficients[:3] * np.stack([s, v, a])
    left = cuts.upper - total.sum(axis=0) - cuts.size[0] * z[0] - cuts.size[1] * z[1]
    assert np.allclose(left, seen.sign * a - needed, atol=1e-9 * np.abs(needed).max())


@given(st.integers(0, 10**6), st.sampled_from([1, -1]), st.floats(0.005, 0.2))
def test_what_a_row_loses_shrinks_with_the_square_of_the_box(seed, side, most):
    free = SlideCoordinates(1, (0.0, 0.0, 0.0), ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))
    limit, lost = CurvatureBound("", free, side, most), []
    for width in (0.02, 0.01):
        low, high, _ = box(seed, width)
        (cuts,), middle = limit.linear_relaxation(low, high, None), 0.5 * (low + high)
        a = sharpest(*middle, limit)
        lost.append(cuts.upper - np.sum(cuts.size * middle, axis=0) - cuts.coefficients[2] * a)
    assert np.all(lost[1] >= -1e-9)
    assert np.max(lost[1]) <= 0.3 * np.max(lost[0]) + 1e-9


def test_no_rows_where_the_box_reaches_the_axis_or_is_open():
    low, high, _ = box(7, 0.5)
    limit = CurvatureBound("", ROLLER, 1, 0.05)
    assert not limit.linear_relaxation(low - np.array([[70.0], [0.0], [0.0]]), high, None)
    assert not limit.linear_relaxation(low, high + np.array([[0.0], [np.inf], [0.0]]), None)


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
    "proof": "quick",
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
    assert thorough.certificate.bound_valid_for == "all motion laws with a bounded jerk"
    assert thorough.objectives["base_radius_mm"] <= quick.objectives["base_radius_mm"] * (1 + 1e-9)


@pytest.fixture(scope="module")
def found(spec: DesignSpec):
    search_ = optimise(formulate_problem(spec, spec.objectives()[0]), 5e-3)
    assert search_.incumbent is not None
    return search_


@pytest.fixture(scope="module")
def finer(found):
    """A better cam: a local optimum on four times as many knots."""
    problem = found.problem
    grids = tuple(
        grid_through(segment, np.union1d(grid.space.breaks, np.linspace(0.0, 1.0, 81)))
        for segment, grid in zip(problem.free, found.grids, strict=True)
    )
    model = formulate(problem, grids, 0.0, Tightening(1e-7))
    better = solve_ipopt(model, model.point(found.incumbent.laws, found.incumbent.size), None, 1e-6)
    laws, size = model.recover(better.x)
    return recover_cam(problem, laws, size, keep_size=True)


def test_the_bound_is_below_local_optima_on_much_finer_knots(thorough, found, finer):
    assert finer.value < found.incumbent.value
    assert thorough.certificate.lower_bound + 9.7 < finer.value


def test_no_start_of_a_local_search_ends_below_the_bound(thorough, found):
    problem = found.problem
    grids = tuple(uniform_grid(segment, 40) for segment in problem.free)
    model = formulate(problem, grids, 0.0, Tightening(1e-7), Region())
    values = []
    starts = ((found.relaxed, 2.0), (found.incumbent, 25.0))
    for cam, offset in starts:
        better = solve_ipopt(model, model.point(cam.laws, (offset, 40.0)), None, 1e-6)
        values.append(np.hypot(*model.recover(better.x)[1]))
    assert min(values) < 1.005 * found.incumbent.value  # they do find something
    assert min(values) > thorough.certificate.lower_bound + 9.7


def keeps(domain, problem, cam) -> None:
    """A cam's size and what draws its curves are where the lair says."""
    for (low, high), value in zip(domain.sizes, cam.size, strict=True):
        assert low <= value <= high
    for (position, seen), hull in domain.point_bounds.items():
        law, segment = cam.laws[position].curve(), problem.free[position]
        for first, last in hull.parts:
            x = np.linspace(first, last, 200)
            s = segment.s_start + segment.lift * law(x)
            at = seen.evaluate((s, segment.lift / segment.angle * law(x, 1)), cam.size)
            low, high = hull.at(x)
            for value, least, most in zip(at, low, high, strict=True):
                assert np.all(value >= least - 1e-7)
                assert np.all(value <= most + 1e-7)


def test_a_better_cam_lies_where_better_cams_are_said_to_lie(found, finer):
    parts = BindingLimits.on((found.incumbent, found.relaxed)).parts
    task = BoundTask.of(found, found.incumbent, inf)
    domain = initial_region(task.problem, task.controls, parts)
    better = with_value_cap(
        task.problem, found.incumbent.value * (1 + 1e-9)
    )  # than the best, not than the target
    grids = tuple(Grid(g.space, g.space.breaks) for g in (uniform_grid(s, 45) for s in better.free))
    model = formulate(better, grids)
    for _ in range(2):  # the second time with the rows that the first one gave
        domain, stuck = tighten_bounds(model, task.controls, domain, range(len(grids)))
        assert not stuck
        assert not domain.is_empty
        keeps(domain, found.problem, finer)
    assert all(high - low < 3.0 for low, high in domain.sizes)
    assert len(domain.point_bounds) == 2


def scene_on_twelve_intervals(**changes):
    """The problem of the scene with changes, and a region with nodes amid both laws."""
    spec = DesignSpec.model_validate({**deepcopy(SCENE), **changes})
    problem = formulate_problem(spec, *spec.objectives())
    model = formulate(problem, [uniform_grid(s, 12) for s in problem.free])
    controls = law_controls(model)
    assert controls is not None
    parts = dict.fromkeys(range(2), ((0.4, 0.6),))
    return model, controls, initial_region(problem, controls, parts)


def test_nothing_that_the_sizes_allow_is_excluded_at_first():
    """Of a follower that hardly moves X and −u are s0 and e, up to 10^11 strokes."""
    program = [
        {**segment, "lift_mm": 1e-6} if "lift_mm" in segment else segment
        for segment in SCENE["program"]
    ]
    follower = {**SCENE["follower"], "offset_mm": {"min": 0.0, "max": 1e5}}
    radius = {"min": 20.0, "max": 1e5}
    model, _, region = scene_on_twelve_intervals(
        program=program, follower=follower, base_radius_mm=radius
    )
    assert len(region.point_bounds) == 2
    for size in product(*model.problem.sizing.bounds):
        for (position, seen), bounds in region.point_bounds.items():
            segment = model.problem.free[position]
            x, u, _ = seen.evaluate((segment.s_start, 0.0), size)
            assert np.all(bounds.low[0] <= x)
            assert np.all(bounds.high[0] >= x)
            assert np.all(bounds.low[1] <= u)
            assert np.all(bounds.high[1] >= u)


def test_where_no_size_is_left_no_law_is_said_to_have_no_spline():
    """Such laws would be tried again on finer knots, and that nothing is left would be lost."""
    model, controls, region = scene_on_twelve_intervals()
    capped = formulate(with_value_cap(model.problem, 60.0), model.grids)
    radius = np.zeros(capped.program.matrix.shape[1])
    radius[capped.size.stop - 1] = capped.scales.size
    (least,) = clarabel.minimise_each(capped.program, [radius])
    offsets, (low, _) = region.sizes
    below = region.restrict((offsets, (low, 0.9 * float(radius @ least.x))))
    tighter, stuck = tighten_bounds(capped, controls, below, range(2))
    assert tighter.is_empty
    assert not stuck


def test_sizes_alone_are_bounded_as_with_the_laws():
    model, controls, region = scene_on_twelve_intervals()
    capped = formulate(with_value_cap(model.problem, 60.0), model.grids)
    both, alone = (
        tighten_bounds(capped, controls, region, range(2), laws=laws)[0] for laws in (True, False)
    )
    assert alone.sizes == both.sizes != region.sizes
    for key, bounds in region.point_bounds.items():
        np.testing.assert_array_equal(alone.point_bounds[key].low, bounds.low)
        assert np.all(both.point_bounds[key].low > bounds.low)


def test_half_a_box_without_the_best_offset_has_no_better_cam(found):
    parts = BindingLimits.on((found.incumbent, found.relaxed)).parts
    task = BoundTask.of(found, found.incumbent, inf)
    region = initial_region(task.problem, task.controls, parts)
    start = TracedNode(task, region, lower=found.lower, valid_for=found.valid_for)
    _, (left, right) = solve_relaxation(found, start).branch(found)
    (_, middle), _ = left.region.sizes
    e, _ = found.incumbent.size
    other = left if e > middle else right
    _, processed = other.process(found)
    assert processed.lower >= task.target


def test_a_box_is_not_split_across_the_size_in_which_a_cam_grows(found):
    parts = BindingLimits.on((found.incumbent, found.relaxed)).parts
    task = BoundTask.of(found, found.incumbent, inf)
    domain = initial_region(task.problem, task.controls, parts)
    flat = replace(domain, sizes=((1.3, 2.9), (31.0, 58.0)))
    _, (left, right) = TracedNode(task, flat, lower=task.target).branch(found)
    assert left.region.sizes == ((1.3, 2.1), (31.0, 58.0))
    assert right.region.sizes == ((2.1, 2.9), (31.0, 58.0))
    given = replace(domain, sizes=((2.9, 2.9), (31.0, 58.0)))
    _, (left, right) = TracedNode(task, given, lower=task.target).branch(found)
    assert (left.region.sizes[1], right.region.sizes[1]) == ((31.0, 44.5), (44.5, 58.0))


def test_rows_at_the_guess_alone_are_one_a_knot_and_hold_there(found):
    parts = BindingLimits.on((found.incumbent, found.relaxed)).parts
    task = BoundTask.of(found, found.incumbent, inf)
    grids = tuple(
        Grid(g.space, g.space.breaks) for g in (uniform_grid(s, 45) for s in task.problem.free)
    )
    model = formulate(with_value_cap(task.problem, found.incumbent.value * (1 + 1e-9)), grids)
    open_ = initial_region(task.problem, task.controls, parts)
    domain, stuck = tighten_bounds(model, task.controls, open_, range(len(grids)))
    assert not stuck
    best = found.incumbent
    point = TangentPoint(tuple(law.curve() for law in best.laws), best.size)
    guessed = replace(domain, reference=point)
    without, all_rows, sparing = (
        domain.rows(model, 2),
        guessed.rows(model, 2),
        guessed.rows(model, 2, sparing=True),
    )
    assert len(sparing) == len(without) == len(all_rows) // 2
    assert len(domain.rows(model, 2, sparing=True)) == len(without)
    for block, denser, runs in sparing:
        # between the knots there are more, at them the same
        assert len(denser.x) > 2 * len(block.x)
        assert np.array_equal(denser.alpha[:, runs.rows], block.alpha)
        assert np.array_equal(denser.rhs[runs.rows], block.rhs)
        law = found.incumbent.laws[block.segment].curve()
        said = sum(block.alpha[k] * law(block.x, k) for k in range(3))
        said += block.size @ np.array(found.incumbent.size) / model.scales.size
        assert np.all(
            said <= block.rhs + 1e-3
        )  # drawn in by less than that: the cam is a local best


def test_hollow_flanks_that_a_cutter_must_fit():
    scene = {**deepcopy(SCENE), "tolerance": 0.03}
    scene["limits"][2] = {"kind": "cutter_radius", "radius_mm": 70.0}
    scene["limits"].append({"kind": "profile_radius", "min_mm": 2.0})
    quick = synthesise(DesignSpec.model_validate(scene))
    close = synthesise(DesignSpec.model_validate({**scene, "proof": "thorough"}))
    assert quick.certificate.gap > 0.15
    assert close.certificate.gap <= 0.03
    assert close.certificate.lower_bound <= quick.objectives["base_radius_mm"]


def test_rows_of_the_control_hold_between_the_first_node_and_the_last() -> None:
    """Beyond the nodes nothing is known: an interval that reaches farther has no row."""
    scene = deepcopy(SCENE)
    scene["limits"][1] = {"kind": "acceleration", "max_mm_per_s2": 2.5e4}
    spec = DesignSpec.model_validate(scene)
    problem = formulate_problem(spec, *spec.objectives())
    grids = [grid_through(s, np.linspace(0.0, 1.0, 21)) for s in problem.free]
    model = formulate(problem, grids)
    controls = law_controls(model)
    assert controls is not None
    assert {control.order for control in controls} == {2}
    part = (0.151, 0.449)  # no knots there
    sizes = ((0.0, 0.0), (40.0, 45.0))
    region = initial_region(problem, controls, {0: (part,)}).restrict(sizes)
    known = {
        key: replace(bounds, low=np.array([[45.0], [-20.0]]) + 0.0 * bounds.low,
                     high=np.array([[60.0], [20.0]]) + 0.0 * bounds.high)
        for key, bounds in region.point_bounds.items()
    }  # fmt: skip
    blocks = [row for row, _, _ in replace(region, point_bounds=known).rows(model, 0)]
    assert blocks
    for block in blocks:
        assert block.kind == "mean"
        assert block.spans is not None
        np.testing.assert_allclose(block.spans[0, 0], 0.2)
        np.testing.assert_allclose(block.spans[-1, 1], 0.4)


def test_with_the_acceleration_capped_alone_curvature_is_in_the_bound_too():
    """Its rows are of the control itself: means over the intervals between knots."""
    scene = {**deepcopy(SCENE), "tolerance": 0.018}
    scene["limits"][1] = {"kind": "acceleration", "max_mm_per_s2": 2.5e4}
    quick = synthesise(DesignSpec.model_validate({**scene, "proof": "quick"})).certificate
    # nor does a cap on the jerk keep it out that lets the acceleration swing at once
    scene["limits"].append({"kind": "jerk", "max_mm_per_s3": 1e10})
    close = synthesise(DesignSpec.model_validate({**scene, "proof": "auto"})).certificate
    start = "all motion laws with a bounded acceleration"
    assert quick.gap > 0.1
    assert quick.bound_valid_for.endswith(
        "; not wholly in it: profile_radius, which a thorough proof takes in where every "
        "free law has a limit on jerk or acceleration"
    )
    assert close.gap < 0.02
    assert close.bound_valid_for == start
    assert close.value <= quick.value


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


def test_the_bound_is_never_above_the_target(found):
    parts = BindingLimits.on((found.incumbent, found.relaxed)).parts
    task = BoundTask.of(found, found.incumbent, inf)
    domain = initial_region(task.problem, task.controls, parts)
    # far on the wrong side: no better cam has its offset there
    (_, high), *rest = domain.sizes
    there = replace(domain, sizes=((high - 4.0, high), *rest))
    assert solve_relaxation(found, TracedNode(task, there, lower=found.lower)).lower >= task.target
