"""Rows spread over the points between theirs: a block's points ascend, and its bound is valid."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from synthesis.optimise.dual_bound.batch import MultiplierDensity
from synthesis.optimise.dual_bound.bound import dual_bound
from synthesis.optimise.dual_bound.costates import boundary_multipliers
from synthesis.optimise.dual_bound.row_functionals import row_functionals
from tests.optimise.scenes import TURNING as TURN
from tests.optimise.scenes import acceleration, angles, direct, even, jerk, problem, scene, uneven

EACH = 8
# the acceleration binds at the top of the stroke, where one law ends and the next begins
SCENE = scene(TURN, acceleration(7.0, 97.3), jerk(80.0, 97.3), angles(30.0, 30.0))


@pytest.mark.parametrize("seed", range(3))
def test_any_multipliers_of_spread_rows_give_a_bound(seed: int) -> None:
    """Those of the last point of a law too: its interval to the next point ran backwards."""
    question = problem(SCENE)
    answer = direct(question, uneven(question, seed))
    between = MultiplierDensity.of(answer.model, [], EACH)
    ends = boundary_multipliers(answer.model, answer.solution, 3)
    own = between.distribute_single(answer.solution.multipliers, ends)
    shaken = own * np.random.default_rng(seed).uniform(0.5, 1.5, len(own))
    values = [
        dual_bound(between.model, replace(answer.solution, multipliers=z), ends).value
        for z in (own, shaken)
    ]
    fine = direct(question, even(question, 100)).value
    assert max(values) <= fine * (1.0 + 1e-9)
    assert values[0] > dual_bound(answer.model, answer.solution).value - 0.01 * fine


def test_densities_lie_between_points_that_ascend() -> None:
    question = problem(SCENE)
    model = MultiplierDensity.of(direct(question, uneven(question, 0)).model, [], EACH).model
    steered = [one for one in row_functionals(model, 3) if one.block.kind == "point"]
    assert any(one.uniform and one.jumps for one in steered)
    assert all(np.all(np.diff(one.block.x) > 0.0) for one in steered)
    # of the program's blocks those with a second derivative alone highest, at points in order
    model = direct(question, uneven(question, 0)).model
    spread = MultiplierDensity.of(model, [], EACH).point_runs
    assert [runs is not None for runs in spread] == [
        bool(b.kind == "point" and b.alpha[2] and not b.alpha[3]) for b in model.blocks
    ]
    assert any(runs is not None for runs in spread)
    for change in ({"kind": "control"}, {}):
        still = tuple(replace(b, x=np.zeros_like(b.x), **change) for b in model.blocks)
        assert not any(MultiplierDensity.of(replace(model, blocks=still), [], EACH).point_runs)
    model = MultiplierDensity.of(model, [], EACH).model
    # points in any other order have no neighbours: their rows are taken at the points alone
    mixed = [replace(block, x=block.x[::-1]) for block in model.blocks]
    backwards = replace(model, blocks=tuple(mixed))
    assert not any(one.uniform for one in row_functionals(backwards, 3))
