"""A thorough proof that finds a better cam on its way, where one return is quick and steep."""

import numpy as np
import pytest

from synthesis.formulations.cone.convex import formulate
from synthesis.formulations.cone.cuts import Region
from synthesis.formulations.cone.rows import Drawn
from synthesis.formulations.ladder.refine import search
from synthesis.formulations.nonconvex.nonlinear import improve
from synthesis.formulations.question.grid import uniform
from synthesis.formulations.question.problem import pose
from synthesis.formulations.rounds.search import Search
from tests.formulations.scenes import angles, dwell, fall, jerk, rise, scene

TOLERANCE = 5e-3
LIFT, BACK = 25.7, 55.4
SPEC = scene(
    [rise(82.3, LIFT), dwell(24.6), fall(BACK, LIFT), dwell(197.7)],
    angles(26.3, 47.6), jerk(70.4, BACK, LIFT), {"kind": "profile_radius", "min_mm": 9.1},
    roller=13.8,
)  # fmt: skip


def searched(*, thorough: bool) -> Search:
    return search(pose(SPEC, SPEC.objectives()[0]), TOLERANCE, thorough=thorough)


@pytest.fixture(scope="module")
def close() -> Search:
    return searched(thorough=True)


def test_the_gap_is_closed_by_a_better_cam_and_a_better_bound(close: Search):
    quick = searched(thorough=False)
    assert close.best is not None
    assert quick.best is not None
    assert close.gap_of(close.best) <= TOLERANCE
    assert close.best.value < 0.9992 * quick.best.value
    assert close.lower > quick.lower
    # that bound alone would not have shown it of the first cam
    assert close.gap_of(quick.best) > TOLERANCE


def test_few_boxes_do(close: Search):
    (stage,) = (stage for stage in close.stages if stage.stage == "implied rows")
    assert stage.model in {f"linear and cone programs in {count} boxes" for count in (1, 3)}


def test_no_local_search_on_even_knots_ends_below_the_bound(close: Search):
    assert close.relaxed is not None
    grids = tuple(uniform(stretch, 80) for stretch in close.problem.free)
    plan = formulate(close.problem, grids, 0.0, Drawn(1e-7), Region())
    for e in (-7.0, 9.0):
        found = improve(plan, plan.point(close.relaxed.laws, (e, 39.0)), None, 1e-6)
        prime = float(np.hypot(*plan.recover(found.x)[1]))
        assert close.lower < prime < 1.004 * close.lower
