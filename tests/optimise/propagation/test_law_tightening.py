"""Bounds of laws and sizes with the pivot free, against the extremes that splines reach."""

from __future__ import annotations

from dataclasses import replace
from math import inf
from typing import Any

import numpy as np
import pytest

from synthesis import DesignSpec
from synthesis.catalogue.objectives import BaseRadius, Objective, PeakAcceleration
from synthesis.numerics.piecewise import Array
from synthesis.numerics.solvers import clarabel, highs
from synthesis.numerics.solvers.statuses import StopReason
from synthesis.optimise.branching.pivot_node import PivotNode, tighten_node
from synthesis.optimise.conic.control import capped_controls
from synthesis.optimise.conic.linear_rows import LinearBlock
from synthesis.optimise.conic.program import ConicModel, formulate, with_rows
from synthesis.optimise.driver import optimise
from synthesis.optimise.problem.grid import uniform_grid
from synthesis.optimise.problem.nondimensional import NondimensionalSpec
from synthesis.optimise.problem.problem import Problem, formulate_problem
from synthesis.optimise.propagation import quantity_bounds
from synthesis.optimise.propagation.law_tightening import (
    initial_law_bounds,
    size_bounds,
    tighten_law,
    with_value_cap,
)
from synthesis.optimise.recovery.candidate import Candidate
from synthesis.optimise.state import CAM_ONLY, SolveState
from tests.hard.families import random_scene

NODES = np.array([0.0, 0.19, 0.5, 0.83, 1.0])


def problem_of(family: str, number: int, objective: Objective) -> tuple[Problem, Candidate]:
    """A scene's problem with an objective, and the best cam known."""
    scaled = NondimensionalSpec.of(DesignSpec.model_validate(random_scene(family, number))).scaled
    problem = formulate_problem(scaled, objective, (), tuple(scaled.placed_segments()))
    best = optimise(problem, 0.05, proof=CAM_ONLY).incumbent
    assert best is not None
    return problem, best


def rows_of(problem: Problem, best: Candidate) -> ConicModel:
    """Of every cam whose value is no more than a tenth above the best one's."""
    grids = [uniform_grid(segment, 20) for segment in problem.free]
    return formulate(with_value_cap(problem, 1.1 * best.value), grids)


@pytest.fixture(scope="module", params=[("arm, pivot free", 10), ("arm, pivot in a range", 3)])
def model(request: pytest.FixtureRequest) -> ConicModel:
    return rows_of(*problem_of(*request.param, BaseRadius()))


def reached(model: ConicModel, objective: Array) -> tuple[float, float]:
    """Least and largest value of a linear function over the cone program's points."""
    low, high = clarabel.minimise_each(model.program, [objective, -objective])
    return float(objective @ low.x), float(objective @ high.x)


def value_of_law(model: ConicModel, law: int, x: float, order: int) -> tuple[Array, float]:
    """g or g' of a law at x: an objective, and what is to be added."""
    row = model.grids[law].space.basis(np.array([x]), order)
    objective = np.zeros(model.program.matrix.shape[1])
    objective[model.columns[law]], constant = model.boundary_states[law].split(row)
    return objective, float(constant[0])


@pytest.mark.parametrize("reason", [StopReason.OUT_OF_TIME, StopReason.FAILED])
def test_what_is_known_stays_where_a_program_fails(
    model: ConicModel, reason: StopReason, monkeypatch: pytest.MonkeyPatch
) -> None:
    controls, sizes = capped_controls(model), model.problem.sizing.bounds
    assert controls is not None
    solve = highs.minimise_each

    def ended(*args: Any, **more: Any) -> list[highs.LinearMinimum]:
        found = solve(*args, **more)
        found[3:] = [replace(found[3], stopped=reason)]
        return found

    known = initial_law_bounds(model, 0, controls[0], NODES)
    whole = tighten_law(model, controls, sizes, 0, known)
    monkeypatch.setattr(quantity_bounds.highs, "minimise_each", ended)
    part = tighten_law(model, controls, sizes, 0, known)
    # g' from below is bounded first, node by node
    assert part.low_speed[:3] == pytest.approx(whole.low_speed[:3])
    assert np.any(part.high_speed[1:-1] > whole.high_speed[1:-1] + 1e-3)


def test_no_program_of_a_mesh_without_a_spline_bounds_anything(model: ConicModel) -> None:
    controls, sizes = capped_controls(model), model.problem.sizing.bounds
    assert controls is not None
    none = LinearBlock.of_size(np.zeros(len(sizes)), np.array([-1.0]), "no size keeps it")
    known = initial_law_bounds(model, 0, controls[0], NODES)
    bounds = tighten_law(with_rows(model, [none]), controls, sizes, 0, known)
    assert np.array_equal(bounds.low_speed, known.low_speed)
    assert size_bounds(with_rows(model, [none]), controls, sizes) == sizes


def test_bounds_of_every_size_rest_on_no_end_of_a_search() -> None:
    """The laws of larger cams lie in them, though these rows alone do not exclude such cams."""
    problem, best = problem_of("arm, pivot in a range", 3, PeakAcceleration())
    assert problem.for_every_size
    model, sizes = rows_of(problem, best), problem.sizing.bounds
    controls = capped_controls(model)
    assert controls is not None
    assert np.array(size_bounds(model, controls, sizes)) == pytest.approx(np.array(sizes))
    # with twice the range the same: what a law may be depends on no size
    twice = tuple((2.0 * low, 2.0 * high) for low, high in sizes)
    larger = rows_of(replace(problem, sizing=replace(problem.sizing, bounds=twice)), best)
    known = initial_law_bounds(model, 0, controls[0], NODES)
    bounds = tighten_law(model, controls, sizes, 0, known)
    for order, low, high in (
        (0, bounds.low, bounds.high),
        (1, bounds.low_speed, bounds.high_speed),
    ):
        for x, least_known, most_known in list(zip(NODES, low, high, strict=True))[1:-1]:
            objective, constant = value_of_law(larger, 0, x, order)
            least, most = (each + constant for each in reached(larger, objective))
            assert least_known <= least + 1e-6
            assert most_known >= most - 1e-6


def test_no_box_of_a_tree_holds_every_size() -> None:
    problem, best = problem_of("arm, pivot in a range", 3, PeakAcceleration())
    for every, bounded in ((False, True), (True, False)):
        of_sizes = replace(problem, for_every_size=every)
        node = PivotNode(of_sizes, {0: (0.0, 1.0)}, ())
        state = SolveState(of_sizes, 5e-3, inf, 1e-7)
        tighter = tighten_node(state, best, node)
        assert tighter is not None
        assert bool(tighter.tubes) is bounded


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
    assert_next_to_what_is_reached(model, 1.3)


def test_caps_that_bind_along_arcs_have_densities() -> None:
    """An acceleration under a cap on the jerk: by multipliers at points g is 2.3 times as open."""
    model = rows_of(*problem_of("arm, pivot free", 10, PeakAcceleration()))
    assert_next_to_what_is_reached(model, 2.0)


def assert_next_to_what_is_reached(model: ConicModel, times: float) -> None:
    controls, sizes = capped_controls(model), model.problem.sizing.bounds
    assert controls is not None
    for k, control in enumerate(controls):
        known = initial_law_bounds(model, k, control, NODES)
        bounds = tighten_law(model, controls, sizes, k, known)
        for order, low, high in (
            (0, bounds.low, bounds.high), (1, bounds.low_speed, bounds.high_speed)
        ):  # fmt: skip
            for x, least_known, most_known in list(zip(NODES, low, high, strict=True))[1:-1]:
                objective, constant = value_of_law(model, k, x, order)
                least, most = (each + constant for each in reached(model, objective))
                assert least_known <= least + 1e-6
                assert most_known >= most - 1e-6
                assert most_known - least_known <= times * (most - least) + 0.01
