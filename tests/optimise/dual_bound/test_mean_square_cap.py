"""The lower bound of a size under a cap on rms jerk: over all laws, whatever the multipliers."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from synthesis.catalogue.objectives import RmsJerk
from synthesis.numerics import clock
from synthesis.numerics.piecewise import Array
from synthesis.numerics.solvers.clarabel import minimise_each, solve
from synthesis.optimise.conic.control import capped_controls, mean_square_caps, weighed_controls
from synthesis.optimise.conic.linear_rows import LinearBlock
from synthesis.optimise.conic.program import ConicModel, formulate, with_rows
from synthesis.optimise.conic.subprogram import submodel
from synthesis.optimise.dual_bound.batch import Quantities, dual_bounds, solve_boundary_costates
from synthesis.optimise.dual_bound.bound import (
    _control_integrals,
    dual_bound,
    unknown_initial_values,
)
from synthesis.optimise.problem.grid import uniform_grid
from synthesis.optimise.problem.mean_square import least_between
from synthesis.optimise.problem.problem import NoObjective, ObjectiveCap, Problem
from synthesis.optimise.propagation.improving_region import initial_region
from synthesis.optimise.propagation.law_tightening import initial_law_bounds, tighten_law
from synthesis.optimise.propagation.quantity_bounds import bound_quantities
from synthesis.spec.design_spec import DesignSpec
from tests.hard.families import random_scene
from tests.optimise.scenes import (
    PLAIN,
    Direct,
    angles,
    direct,
    dwell,
    fall,
    jerk,
    problem,
    rise,
    scene,
)

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
        bounds = tighten_law(model, controls, question.sizing.bounds, k, known)
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


def test_without_a_spline_no_quantity_is_bounded(question: Problem) -> None:
    """Of cone programs too: no size keeps a row, or no time is left to find a spline."""
    grids = [uniform_grid(segment, 12) for segment in question.free]
    model = formulate(replace(question, objective=NoObjective()), grids)
    controls, sizes = capped_controls(model), question.sizing.bounds
    assert controls is not None
    none, wanted = LinearBlock.of_size(np.zeros(len(sizes)), np.array([-1.0]), ""), _wanted(model)
    assert bound_quantities(with_rows(model, [none]), controls, sizes, wanted) is None
    assert bound_quantities(model, controls, sizes, wanted, until=clock.now() - 1.0) is None
    assert bound_quantities(model, controls, sizes, wanted) is not None


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


@pytest.mark.parametrize("objective", ["base_radius", "rms_jerk"])
def test_only_a_limit_caps_a_control(objective: str) -> None:
    """A cap j of the jerk is one of j β³/h on a law; a mean square that is made least is none."""
    limit, cap = angles(33.0, 44.0), jerk(71.0, 71.7)
    free = problem(scene(PLAIN, limit, objective=objective))
    assert capped_controls(on(free, 8).model) is None
    capped = problem(scene(PLAIN, limit, cap, objective=objective))
    controls = capped_controls(on(capped, 8).model)
    assert controls is not None
    for control, segment in zip(controls, capped.free, strict=True):
        assert control.cap == pytest.approx(71.0 * (segment.angle / capped.free[0].angle) ** 3)


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


def _wanted(model: ConicModel) -> Quantities:
    """g and g' of every law at a point from both sides, and the last size from below."""
    count, sizes = len(model.grids), len(model.problem.sizing.bounds)
    rows = [
        (law, x, order, sign)
        for law in range(count)
        for x, order in ((0.37, 0), (0.61, 1))
        for sign in (1.7, -1.7)
    ]
    law, x, order, sign = (np.array([*each, last]) for each, last in zip(
        zip(*rows, strict=True), (0, 0.0, 0, 0.0), strict=True
    ))  # fmt: skip
    size = np.zeros((len(law), sizes))
    size[-1, -1] = 0.9
    return Quantities(law, x, sign[:, None] * np.eye(3)[order], size)


def _values(model: ConicModel, wanted: Quantities, points: Array) -> Array:
    """Each quantity at a point of the program of its own."""
    result = np.einsum("qn,qn->q", wanted.size, points[:, model.size])
    for q, point in enumerate(points):
        laws, _ = model.recover(point)
        jet = laws[wanted.law[q]].curve().derivatives(wanted.x[q : q + 1], 2)[:, 0]
        result[q] += wanted.alpha[q] @ jet[:3]
    return result


def test_bounds_of_many_quantities_meet_what_splines_reach(question: Problem) -> None:
    """Never above it, and on fine knots next to it: then the mean square's share is as it is."""
    model = formulate(
        replace(question, objective=NoObjective()), [uniform_grid(s, 40) for s in question.free]
    )
    controls, wanted = capped_controls(model), _wanted(model)
    assert controls is not None
    found = minimise_each(model.program, wanted.objectives(model)[0])
    assert len(found) == len(wanted.x)
    z = np.stack([each.multipliers for each in found])
    ends = solve_boundary_costates(model, wanted, z, 3)
    sizes = question.sizing.bounds
    bounds = dual_bounds(model, controls, sizes, wanted, z, ends)
    reached = _values(model, wanted, np.stack([each.x for each in found]))
    assert np.all(bounds <= reached + 1e-6 * np.abs(reached))
    assert np.all(bounds >= reached - 5e-3 * np.maximum(np.abs(reached), 1.0))
    # any other multipliers: no bound is above what a better one says
    wrong = z * np.exp(np.random.default_rng(3).normal(size=z.shape))
    assert np.all(dual_bounds(model, controls, sizes, wanted, wrong, ends) <= reached + 1e-6)


def test_a_part_has_the_room_that_others_leave(question: Problem) -> None:
    """Its cone holds for every law of the whole, and is no wider than that says."""
    answer = on(question, 24)
    whole, laws = answer.model, answer.model.recover(answer.solution.x)[0]
    ((energy, room),) = ((c.energy, c.room) for c in whole.cone_blocks if c.energy is not None)
    shares = [float(np.sum((f @ law.coefficients) ** 2))
              for f, law in zip(energy.factors, laws, strict=True)]  # fmt: skip
    assert sum(shares) == pytest.approx(room, rel=1e-6)
    assert np.all(energy.least <= np.array(shares) * (1.0 + 1e-12))
    controls = weighed_controls(whole, mean_square_caps(whole, answer.solution.multipliers))
    assert controls is not None
    for k, own in enumerate(shares):
        # of one law alone
        most = (room - sum(energy.least) + energy.least[k]) / energy.weights[k]
        assert controls[k].square == pytest.approx(most)
        part = submodel(whole, (k,))
        (cone,) = (c for c in part.cone_blocks if c.energy is not None)
        assert own <= cone.room * (1.0 + 1e-6)
        assert cone.room < room or len(shares) == 1
        assert cone.room == pytest.approx(room - sum(energy.least) + energy.least[k])
        x = answer.solution.x[np.r_[whole.columns[k], whole.size]]
        assert np.sum((cone.matrix @ x + cone.shift) ** 2) == pytest.approx(own / cone.room)
        # the rows of its program say the same
        rows = part.program.rhs - part.program.matrix @ x
        first = len(rows) - len(cone.shift)
        assert rows[first - 1] == pytest.approx(1.0)
        assert np.sum(rows[first:] ** 2) == pytest.approx(own / cone.room)


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("ends", [(3, 3), (3, 1), (1, 3), (2, 2), (1, 1), (2, 3)])
def test_the_least_mean_square_between_known_ends(ends: tuple[int, int], order: int) -> None:
    random = np.random.default_rng(17)
    poly = np.polynomial.Polynomial(random.normal(size=9))
    start, end = (
        np.array([poly.deriv(k)(at) for k in range(count)])
        for at, count in zip((0.0, 1.0), ends, strict=True)
    )
    least = least_between(start, end, order)
    # 1. Another way: coefficients of a polynomial of degree 2 order − 1 that keeps to the ends.
    count = 2 * order
    powers = [np.polynomial.Polynomial.basis(j) for j in range(count)]
    form = np.array(
        [[(a.deriv(order) * b.deriv(order)).integ()(1.0) for a in powers] for b in powers]
    )
    rows = [
        [p.deriv(k)(at) for p in powers]
        for at, known in ((0.0, start), (1.0, end))
        for k in range(min(len(known), order))
    ]
    known = [*start[:order], *end[:order]]
    system = np.block([[form, np.array(rows).T], [np.array(rows), np.zeros((len(rows),) * 2)]])
    c = np.linalg.lstsq(system, np.append(np.zeros(count), known), rcond=None)[0][:count]
    assert least == pytest.approx(c @ form @ c, rel=1e-7, abs=1e-9)
    assert least <= c @ form @ c
    # 2. No function with these ends has less.
    assert least < (poly.deriv(order) ** 2).integ()(1.0)


def test_the_least_mean_square_of_a_move_from_rest_to_rest() -> None:
    rest = np.zeros(3), np.array([1.0, 0.0, 0.0])
    assert least_between(*rest, 3) == pytest.approx(720.0)
    assert least_between(*rest, 2) == pytest.approx(12.0)


def test_the_cap_of_a_traced_point_is_that_of_its_motion() -> None:
    """What a motion has of ∫ (jerk)² dθ relates to its cap as its law's ∫ dx to the law's own."""
    spec = DesignSpec.model_validate(random_scene("no objective, swinging face", 1))
    question = problem(spec, (ObjectiveCap(RmsJerk(), 47.0),))
    model = formulate(
        replace(question, objective=NoObjective()), [uniform_grid(s, 12) for s in question.free]
    )
    controls = capped_controls(model)
    assert controls is not None
    region = initial_region(question, controls, dict.fromkeys(range(2), ((0.2, 0.8),)))
    assert len(region.point_bounds) == 2
    x = np.linspace(0.0, 1.0, 4001)
    third = 60.0 - 360.0 * x + 360.0 * x**2  # of 10 x³ − 15 x⁴ + 6 x⁵
    for (k, _), bounds in region.point_bounds.items():
        segment = question.free[k]
        jerk = segment.lift * third / segment.angle**3
        share = np.trapezoid(jerk**2, segment.angle * x) / bounds.square
        assert bounds.cap == np.inf
        assert share == pytest.approx(720.0 / controls[k].square, rel=1e-5)
