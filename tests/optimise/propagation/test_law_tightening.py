"""Bounds of laws and sizes with the pivot free, against the extremes that splines reach."""

from __future__ import annotations

import numpy as np
import pytest

from synthesis import DesignSpec
from synthesis.catalogue.objectives import BaseRadius
from synthesis.numerics.piecewise import Array
from synthesis.numerics.solvers import clarabel
from synthesis.optimise.conic.control import capped_controls
from synthesis.optimise.conic.program import ConicModel, formulate
from synthesis.optimise.driver import optimise
from synthesis.optimise.problem.grid import uniform_grid
from synthesis.optimise.problem.nondimensional import NondimensionalSpec
from synthesis.optimise.problem.problem import formulate_problem
from synthesis.optimise.propagation.law_tightening import (
    initial_law_bounds,
    size_bounds,
    tighten_law,
    with_value_cap,
)
from synthesis.optimise.state import CAM_ONLY
from tests.hard.families import random_scene

NODES = np.array([0.0, 0.19, 0.47, 0.83, 1.0])


@pytest.fixture(scope="module", params=[("arm, pivot free", 10), ("arm, pivot in a range", 3)])
def model(request: pytest.FixtureRequest) -> ConicModel:
    """Rows of every cam that is no more than a tenth larger than the best one known."""
    spec = DesignSpec.model_validate(random_scene(*request.param))
    scaled = NondimensionalSpec.of(spec).scaled
    problem = formulate_problem(scaled, BaseRadius(), (), tuple(scaled.placed_segments()))
    best = optimise(problem, 0.05, proof=CAM_ONLY).incumbent
    assert best is not None
    grids = [uniform_grid(segment, 20) for segment in problem.free]
    return formulate(with_value_cap(problem, 1.1 * best.value), grids)


def reached(model: ConicModel, objective: Array) -> tuple[float, float]:
    """Least and largest value of a linear function over the cone program's points."""
    low, high = clarabel.minimise_each(model.program, [objective, -objective])
    return float(objective @ low.x), float(objective @ high.x)


def test_sizes_lie_in_their_bounds_which_are_next_to_what_is_reached(model: ConicModel) -> None:
    controls, known = capped_controls(model), model.problem.sizing.bounds
    assert controls is not None
    for axis, (low, high) in enumerate(size_bounds(model, controls, known)):
        objective = np.zeros(model.program.matrix.shape[1])
        objective[model.size.start + axis] = model.scales.size
        least, most = reached(model, objective)
        width = most - least
        assert low <= least + 1e-6 * width
        assert high >= most - 1e-6 * width
        # a circle's tangents lie little outside of it
        assert high - low <= 1.03 * width
        assert known[axis] == pytest.approx((low, high)) or high - low < np.ptp(known[axis])


def test_laws_lie_in_their_bounds_which_are_next_to_what_is_reached(model: ConicModel) -> None:
    controls, sizes = capped_controls(model), model.problem.sizing.bounds
    assert controls is not None
    for k, control in enumerate(controls):
        known = initial_law_bounds(model, k, control, NODES)
        bounds = tighten_law(model, controls, sizes, k, known)
        for order, low, high in (
            (0, bounds.low, bounds.high), (1, bounds.low_speed, bounds.high_speed)
        ):  # fmt: skip
            for x, least_known, most_known in list(zip(NODES, low, high, strict=True))[1:-1]:
                row = model.grids[k].space.basis(np.array([x]), order)
                objective = np.zeros(model.program.matrix.shape[1])
                objective[model.columns[k]], constant = model.boundary_states[k].split(row)
                least, most = (float(each + constant[0]) for each in reached(model, objective))
                assert least_known <= least + 1e-6
                assert most_known >= most - 1e-6
                assert most_known - least_known <= 1.3 * (most - least) + 0.01
