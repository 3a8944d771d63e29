"""A thorough proof that finds a better cam on its way, where one return is quick and steep."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from synthesis.numerics import clock
from synthesis.optimise.branching.pivot_node import PivotNode
from synthesis.optimise.branching.traced_node import TracedNode
from synthesis.optimise.conic.linear_rows import Tightening
from synthesis.optimise.conic.program import formulate
from synthesis.optimise.conic.tangent_cuts import Region
from synthesis.optimise.driver import optimise
from synthesis.optimise.heuristics.ipopt_search import solve_ipopt
from synthesis.optimise.problem.grid import uniform_grid
from synthesis.optimise.problem.problem import formulate_problem
from synthesis.optimise.state import QUICK, THOROUGH, ProofBudget, SolveState
from tests.optimise.scenes import angles, dwell, fall, jerk, rise, scene

TOLERANCE = 5e-3
LIFT, BACK = 25.7, 55.4
SPEC = scene(
    [rise(82.3, LIFT), dwell(24.6), fall(BACK, LIFT), dwell(197.7)],
    angles(26.3, 47.6), jerk(70.4, BACK, LIFT), {"kind": "profile_radius", "min_mm": 9.1},
    roller=13.8,
)  # fmt: skip


def searched(proof: ProofBudget) -> SolveState:
    return optimise(formulate_problem(SPEC, SPEC.objectives()[0]), TOLERANCE, proof=proof)


@pytest.fixture(scope="module")
def close() -> SolveState:
    return searched(THOROUGH)


def test_the_gap_is_closed_by_a_better_cam_and_a_better_bound(close: SolveState):
    quick = searched(QUICK)
    assert close.incumbent is not None
    assert quick.incumbent is not None
    assert close.gap_between(close.incumbent, close.lower) <= TOLERANCE
    # on the bound's own knots, which are a quarter as many, 0.9985
    assert close.incumbent.value < 0.9983 * quick.incumbent.value
    assert close.lower > quick.lower
    # that bound alone would not have shown it of the first cam
    assert close.gap_between(quick.incumbent, close.lower) > TOLERANCE


def test_the_proof_ends_with_the_first_cam_that_suffices(close: SolveState) -> None:
    """It is found on the way to a bound, as here; no bound is asked for then."""
    problem, before = close.problem, clock.programs_solved()
    assert close.incumbent is not None
    enough = problem.objective.to_wire(1.0005 * close.incumbent.value, problem.machine)
    found = optimise(problem, 0.01 * TOLERANCE, proof=ProofBudget(300, 1.0), sufficient=enough)
    assert found.is_sufficient
    assert found.stages[-1].exit == "sufficient"
    assert found.gap_between(found.incumbent, found.lower) > 2e-3
    assert clock.programs_solved() - before < 120


@pytest.mark.parametrize("kind", [TracedNode, PivotNode])
@pytest.mark.parametrize("suffices", [True, False])
def test_no_node_is_left_to_process_where_a_cam_suffices(
    kind: type[TracedNode | PivotNode], suffices: bool
) -> None:
    state: Any = SimpleNamespace(suffices=suffices, incumbent=None, is_close=lambda *_: False)
    node: Any = SimpleNamespace(is_first=False, lower=1.0, task=SimpleNamespace(target=2.0))
    assert kind.is_pruned(node, state) is suffices


def test_few_boxes_do(close: SolveState):
    (stage,) = (stage for stage in close.stages if stage.stage == "implied rows")
    assert stage.model in {f"linear and cone programs in {count} boxes" for count in (1, 3)}


def test_no_local_search_on_even_knots_ends_below_the_bound(close: SolveState):
    assert close.relaxed is not None
    grids = tuple(uniform_grid(segment, 80) for segment in close.problem.free)
    model = formulate(close.problem, grids, 0.0, Tightening(1e-7), Region())
    for e in (-7.0, 9.0):
        found = solve_ipopt(model, model.point(close.relaxed.laws, (e, 39.0)), None, 1e-6)
        prime = float(np.hypot(*model.recover(found.x)[1]))
        assert close.lower < prime < 1.004 * close.lower
