"""The lower bound of a size under a cap on rms jerk: over all laws, whatever the multipliers."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from synthesis.catalogue.objectives import RmsJerk
from synthesis.numerics.piecewise import Array
from synthesis.numerics.solvers.clarabel import solve
from synthesis.optimise.conic.control import capped_controls, mean_square_caps, weighed_controls
from synthesis.optimise.conic.linear_rows import LinearBlock
from synthesis.optimise.conic.program import ConicModel, formulate, with_rows
from synthesis.optimise.dual_bound.bound import (
    _control_integrals,
    dual_bound,
    unknown_initial_values,
)
from synthesis.optimise.problem.grid import uniform_grid
from synthesis.optimise.problem.problem import NoObjective, ObjectiveCap, Problem
from synthesis.optimise.propagation.law_tightening import initial_law_bounds, tighten_law
from synthesis.spec.design_spec import DesignSpec
from tests.optimise.scenes import Direct, angles, direct, dwell, fall, problem, rise, scene

SCENES: dict[str, DesignSpec] = {
    "between dwells": scene(
        (rise(71.7), dwell(23.9), fall(71.7), dwell(192.7)), angles(33.0, 44.0)
    ),
    "laws meet": scene((rise(71.7), fall(71.7), dwell(216.6)), angles(29.0, 37.0)),
    "all free": scene((rise(160.0), fall(200.0)), angles(23.0, 33.0), offset=4.7),
    "beside a named law": scene(
        (rise(71.7), dwell(23.9), fall(91.7, law="cycloidal"), dwell(172.7)), angles(33.0, 44.0)
    ),
}
ALLOWED = 1.2  # of the least rms jerk


def on(question: Problem, intervals: int) -> Direct:
    return direct(question, [uniform_grid(segment, intervals) for segment in question.free])


@pytest.fixture(params=SCENES)
def question(request: pytest.FixtureRequest) -> Problem:
    """The least base radius with the rms jerk capped."""
    spec = SCENES[request.param]
    jerk = RmsJerk()
    least = on(problem(spec.model_copy(update={"objective": jerk})), 64).value
    return problem(spec, (ObjectiveCap(jerk, ALLOWED * least),))


def test_the_bound_covers_all_laws_and_closes_with_knots(question: Problem) -> None:
    fine, gaps = on(question, 160).value, list[float]()
    for intervals in (12, 48, 160):
        answer = on(question, intervals)
        lower = dual_bound(answer.model, answer.solution)
        assert lower.valid_for == "all motion laws with a bounded jerk"
        assert lower.value <= fine * (1.0 + 1e-9)
        gaps.append(1.0 - lower.value / answer.value)
    assert gaps[1] < 0.1 * gaps[0]
    assert gaps[2] < 5e-4


def test_laws_and_sizes_of_a_capped_mean_square_lie_in_their_bounds(question: Problem) -> None:
    """Against the extremes that splines reach: never inside of them, and not far from them."""
    grids = [uniform_grid(segment, 20) for segment in question.free]
    model = formulate(replace(question, objective=NoObjective()), grids)
    controls = capped_controls(model)
    assert controls is not None
    nodes, names = np.array([0.0, 0.23, 0.52, 0.81, 1.0]), range(len(grids))
    for k, control in zip(names, controls, strict=True):
        known = initial_law_bounds(model, k, control, nodes)
        bounds = tighten_law(model, k, known)
        for order, (low, high) in enumerate(
            ((bounds.low, bounds.high), (bounds.low_speed, bounds.high_speed))
        ):
            reached = np.array([_reached(model, k, x, order) for x in nodes[1:-1]])
            assert np.all(low[1:-1] <= reached[:, 0] + 1e-7)
            assert np.all(high[1:-1] >= reached[:, 1] - 1e-7)
            assert np.all(high[1:-1] - low[1:-1] <= 1.3 * (reached[:, 1] - reached[:, 0]) + 0.01)


def _reached(model: ConicModel, law: int, x: float, order: int) -> tuple[float, float]:
    """Least and largest value at a point of any spline of the mesh under the model's rows."""
    row, ends = model.grids[law].space.basis(np.array([x]), order), list[float]()
    for sign in (1.0, -1.0):
        level = LinearBlock(
            "point", law, sign * row, np.array([x]), sign * np.eye(4)[order], np.zeros(0), -1.0,
            np.zeros(1), "level",
        )  # fmt: skip
        extended = with_rows(model, [level])
        solution = solve(extended.program)
        laws, _ = extended.recover(solution.x)
        ends.append(float(laws[law].curve()(np.array([x]), order)[0]))
    return ends[0], ends[1]


def test_perturbed_multipliers_give_a_bound_too(question: Problem) -> None:
    """Weak duality: the bound may be useless, but it is never wrong."""
    fine, answer = on(question, 96).value, on(question, 10)
    z, rng = answer.solution.multipliers, np.random.default_rng(7)

    def bound(wrong: Array) -> float:
        return dual_bound(answer.model, replace(answer.solution, multipliers=wrong)).value

    for magnitude in (-4.0, -2.0, -1.0, 0.0):
        noise = rng.standard_normal(len(z)) * 10.0**magnitude
        for wrong in (z * np.exp(noise), z + noise * np.abs(z).max(), z * 10.0**-magnitude):
            assert bound(wrong) <= fine * (1.0 + 1e-9)


def test_the_multiplier_is_the_slope_of_the_optimum(question: Problem) -> None:
    """A little more room for the mean square makes the size smaller by the multiplier times it."""
    grids = [uniform_grid(segment, 24) for segment in question.free]
    (cap,), step = question.objective_caps, 1e-3
    answer = direct(question, grids)
    (own,) = mean_square_caps(answer.model, answer.solution.multipliers)
    wider = replace(question, objective_caps=(replace(cap, value=cap.value * (1.0 + step)),))
    room = next(c.room for c in formulate(wider, grids).cone_blocks if c.energy is not None)
    unit = answer.model.scales.size
    gained = (answer.value - direct(wider, grids).value) / unit
    assert gained == pytest.approx(own.multiplier * (room - own.room), rel=5e-3)


def test_the_cap_bounds_what_unknown_initial_values_may_gain(question: Problem) -> None:
    """By Taylor's formula ∫ (x−τ)²/2 g''' dτ is what a law's state at 0 does not tell of g(x)."""
    answer, x = on(question, 12), np.array([0.5, 1.0])
    model, solution = answer.model, answer.solution
    controls = weighed_controls(model, mean_square_caps(model, solution.multipliers))
    assert controls is not None
    most = _control_integrals(model, solution, controls)
    for law, bound in zip(model.recover(solution.x)[0], most, strict=True):
        start = law.curve().derivatives(np.zeros(1), 2, "right")[:, 0]
        told = start[0] + start[1] * x + 0.5 * start[2] * x**2
        assert 0.0 < np.max(np.abs(law.curve()(x) - told)) <= bound
    # a residual of the initial values costs by it
    lagrangian = SimpleNamespace(count=1, model=model,
                                 initial_costates=np.full((1, len(most), 2), 1e-9))  # fmt: skip
    cost = unknown_initial_values(cast(Any, lagrangian), most)[0]
    assert cost > unknown_initial_values(cast(Any, lagrangian), [0.0] * len(most))[0] > 0.0
