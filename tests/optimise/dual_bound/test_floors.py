"""Lower bounds of many quantities at once: against the single bound, cams, and plain quadrature."""

from dataclasses import replace

import numpy as np
import pytest

from synthesis import DesignSpec
from synthesis.numerics.solvers.clarabel import solve
from synthesis.numerics.solvers.highs import LinearRows, minimise_each
from synthesis.numerics.solvers.statuses import StopReason
from synthesis.optimise.conic.control import law_controls
from synthesis.optimise.conic.linear_rows import LinearBlock
from synthesis.optimise.conic.program import formulate, with_rows
from synthesis.optimise.dual_bound import batch
from synthesis.optimise.dual_bound.batch import Quantities, dual_bounds, solve_boundary_costates
from synthesis.optimise.dual_bound.bound import dual_bound
from synthesis.optimise.dual_bound.multiplier_density import (
    MultiplierDensity,
    PointRuns,
    _sum_between,
)
from synthesis.optimise.dual_bound.switching import mean_absolute, switching_pieces
from synthesis.optimise.problem.grid import Grid, uniform_grid
from synthesis.optimise.problem.problem import NoObjective, ObjectiveCap, formulate_problem

EACH = 7

PROGRAMS = {
    "dwells between": (("rise", 61.0, 23.0), ("dwell", 30.0, 0.0), ("return", 55.0, 23.0)),
    "rise meets return": (("rise", 61.0, 23.0), ("return", 72.0, 23.0)),
}


def body(name: str) -> dict:
    segments = [
        {"kind": kind, "angle_deg": angle, **({"lift_mm": lift} if lift else {})}
        for kind, angle, lift in PROGRAMS[name]
    ]
    rest = 360.0 - sum(angle for _, angle, _ in PROGRAMS[name])
    return {
        "speed_rpm": 95.5,
        "program": [*segments, {"kind": "dwell", "angle_deg": rest}],
        "follower": {"kind": "translating_roller", "roller_radius_mm": 9.0},
        "base_radius_mm": {"min": 12.0, "max": 90.0},
        "limits": [
            {"kind": "pressure_angle", "rise_deg": 31.0, "return_deg": 43.0},
            {"kind": "jerk", "max_mm_per_s3": 1.4e6},
            *([{"kind": "acceleration", "max_mm_per_s2": 1.6e4}] if len(segments) > 2 else []),
        ],
    }


@pytest.fixture(scope="module", params=sorted(PROGRAMS))
def model(request):
    """Rows that cams keep whose prime radius is no more than 3 % above the least."""
    spec = DesignSpec.model_validate(body(request.param))
    problem = formulate_problem(spec, spec.objectives()[0])
    grids = tuple(
        Grid(g.space, g.space.breaks) for g in (uniform_grid(s, 26) for s in problem.free)
    )
    first = formulate(problem, grids)
    value = np.hypot(*first.recover(solve(first.program).x)[1])
    question = replace(
        problem,
        objective=NoObjective(),
        objective_caps=(ObjectiveCap(problem.objective, 1.03 * value),),
    )
    return formulate(question, grids)


def some(model, seed: int, count: int = 12) -> Quantities:
    """Random quantities: g, g' or g'' at random points, with shares of the size."""
    draw = np.random.default_rng(seed)
    alpha = np.zeros((count, 3))
    alpha[np.arange(count), draw.integers(0, 3, count)] = draw.choice([1.0, -1.0], count)
    alpha[0] = 0.0
    size = draw.uniform(-1.0, 1.0, (count, 2)) * draw.integers(0, 2, (count, 1))
    size[0] = (0.6, 0.8)
    return Quantities(
        draw.integers(0, len(model.grids), count), draw.uniform(0.03, 0.97, count), alpha, size
    )


def single(model, wanted: Quantities, k: int):
    """The model that pushes one quantity down, by a row of its own, and its solution."""
    position, x, alpha = int(wanted.law[k]), wanted.x[k : k + 1], wanted.alpha[k]
    space = model.grids[position].space
    laws = sum(a * space.basis(x, order) for order, a in enumerate(alpha))
    motion = (position, laws) if np.any(alpha) else (None, None)
    kind = "point" if np.any(alpha) else "size"
    row = LinearBlock(
        kind, *motion, x, np.append(alpha, 0.0), wanted.size[k], -1.0, np.zeros(1), "quantity"
    )
    question = with_rows(model, [row])
    return question, solve(question.program)


def test_each_is_what_the_bound_of_a_program_of_its_own_says(model):
    wanted = some(model, 3)
    rows = model.program.equalities + model.program.inequalities
    for k in range(len(wanted.x)):
        if wanted.alpha[k, 2]:
            continue  # there the single one spreads the quantity itself
        question, solution = single(model, wanted, k)
        alone = dual_bound(question, solution)
        one = Quantities(wanted.law[k : k + 1], wanted.x[k : k + 1], wanted.alpha[k : k + 1],
                     wanted.size[k : k + 1])  # fmt: skip
        z = np.delete(solution.multipliers / solution.multipliers[rows], rows)
        # the cones' multipliers as those of one tangent each: the row that they say
        at, tangents, prices = rows, [], []
        for ball in model.cone_blocks:
            v = z[at + 1 : at + 1 + len(ball.shift)]
            prices.append(np.linalg.norm(v))
            tangents.append(tangent_of(model, ball, -v / max(prices[-1], 1e-300)))
            at += 1 + len(ball.shift)
        full, z = with_rows(model, tangents), np.append(z[:rows], prices)[None]
        ends = solve_boundary_costates(full, one, z, 3)
        value = dual_bounds(full, law_controls(model), model.problem.sizing.bounds, one, z, ends)[0]
        if any(limit.kind == "acceleration" for limit in model.problem.limits):
            # the single one spreads multipliers of accelerations by itself
            assert alone.value - 0.15 < value < alone.value
        else:
            assert value == pytest.approx(alone.value, rel=1e-7, abs=1e-7)


def tangent_of(model, ball, y) -> LinearBlock:
    """y · (M ζ + m) ≤ radius, for a unit vector."""
    return LinearBlock(
        "size", None, None, np.zeros(1), np.zeros(4), y @ ball.matrix[:, model.size], 0.0,
        np.array([ball.radius - y @ ball.shift]), "tangent",
    )  # fmt: skip


def rows_of(model) -> LinearRows:
    """Its linear rows, and the size in its ranges."""
    count = model.program.equalities + model.program.inequalities
    bounds = np.array(model.problem.sizing.bounds) / model.scales.size
    low, high = np.full((2, model.program.matrix.shape[1]), np.inf)
    low = -low
    low[model.size], high[model.size] = bounds.T
    return LinearRows(
        model.program.matrix[:count], model.program.rhs[:count], model.program.equalities, low, high
    )


def test_no_cam_that_keeps_the_rows_is_below_whatever_the_multipliers_are(model):
    """Cams at corners of what is allowed, multipliers good and spoilt."""
    draw, wanted = np.random.default_rng(11), some(model, 7, 24)
    solved = minimise_each(rows_of(model), wanted.objectives(model)[0])
    good = np.stack([each.multipliers for each in solved])
    for spoilt in (1.0, draw.uniform(0.7, 1.3, good.shape), draw.uniform(0.0, 3.0, good.shape)):
        z = good * spoilt
        value = dual_bounds(
            model, law_controls(model), model.problem.sizing.bounds, wanted, z,
            solve_boundary_costates(model, wanted, z, 3),
        )  # fmt: skip
        for each in solved:
            laws, _ = model.recover(each.x)
            for k, floor in enumerate(value):
                law, x = laws[wanted.law[k]].curve(), wanted.x[k : k + 1]
                reached = sum(a * law(x, order)[0] for order, a in enumerate(wanted.alpha[k]))
                assert floor <= reached + wanted.size[k] @ each.x[model.size] + 1e-7
    unknown = dual_bounds(
        model, law_controls(model), model.problem.sizing.bounds, wanted, np.nan * good,
        solve_boundary_costates(model, wanted, good, 3),
    )  # fmt: skip
    assert np.all(unknown == -np.inf)
    spread = good[:, model.program.equalities :]
    assert np.all(spread >= -1e-7)


def test_without_a_solution_the_list_ends_there():
    from scipy import sparse

    matrix = sparse.csc_matrix([[1.0], [-1.0]])
    rows = LinearRows(matrix, np.array([1.0, -2.0]), 0, np.array([-9.0]), np.array([9.0]))
    (only,) = minimise_each(rows, [np.ones(1), -np.ones(1)])
    assert only.stopped is StopReason.INFEASIBLE
    both = minimise_each(replace(rows, rhs=np.array([1.0, -0.5])), [np.ones(1), -np.ones(1)])
    assert [each.x[0] for each in both] == [0.5, 1.0]
    assert both[0].multipliers.tolist() == [0.0, 1.0]
    assert both[1].multipliers.tolist() == [1.0, 0.0]


def test_the_switching_function_s_integral_by_plain_quadrature():
    draw = np.random.default_rng(2)
    x, weights = draw.random(9), draw.normal(size=(4, 9, 3)) * np.array([9.0, 3.0, 1.0])
    breaks, poly = switching_pieces(x, weights)
    found = mean_absolute(poly.reshape(-1, 3), exact=True).reshape(4, -1) @ np.diff(breaks)
    tau = (np.arange(400_000) + 0.5) / 400_000
    behind = x[:, None] > tau
    reach = np.maximum(x[:, None] - tau, 0.0)
    for k in range(4):
        psi = sum(
            weights[k, i, 0] * reach[i] ** 2 / 2 + weights[k, i, 1] * reach[i]
            + weights[k, i, 2] * behind[i]
            for i in range(9)
        )  # fmt: skip
        assert found[k] == pytest.approx(np.mean(np.abs(psi)), rel=2e-5)


def test_spreading_keeps_masses_and_stays_between_the_rows():
    x = np.array([0.1, 0.13, 0.2, 0.24, 0.6, 0.66])
    arcs = PointRuns.of(x, ((0.05, 0.3), (0.55, 0.7)), EACH)
    assert arcs.left.tolist() == [0, 1, 2, 4]
    assert np.all(np.diff(arcs.points) > 0.0)
    assert arcs.points[arcs.rows].tolist() == x.tolist()
    between = arcs.points[arcs.inner]
    assert np.all((between > x[arcs.left, None]) & (between < x[arcs.left + 1, None]))
    z = np.array([[1.0, 2.0, 0.0, 3.0, 0.5, 4.0], [0.0, 0.0, 5.0, 0.0, 0.0, 1.0]])
    for chosen in (np.ones(4), np.array([0.0, 1.0, 1.0, 0.0])):
        masses = arcs.distribute(z, chosen)
        assert np.all(masses >= -1e-15)
        assert masses.sum(axis=1) == pytest.approx(z.sum(axis=1))
    assert np.allclose(arcs.distribute(z, np.zeros(4))[:, arcs.rows], z)
    # of a law with even rows whose multipliers are even the density is even
    even = PointRuns.of(np.linspace(0.2, 0.6, 9), ((0.1, 0.7),), EACH)
    masses = even.distribute(np.ones((1, 9)), np.ones(8))[0]
    assert np.allclose(masses[even.inner][1:-1], 1.0 / EACH)
    assert np.allclose(masses[even.rows], 0.0)


def test_what_lies_between_rows_is_summed_there():
    arcs = PointRuns.of(np.array([0.25, 0.5, 0.8]), ((0.0, 1.0),), EACH)
    breaks = np.array([0.0, 0.25, 0.4, 0.5, 0.8, 1.0])
    amounts = np.array([[1.0, 2.0, 4.0, 8.0, 16.0]])
    assert _sum_between(breaks, amounts, arcs.ends(np.arange(2))).tolist() == [[6.0, 8.0]]


@pytest.mark.parametrize("together", [1, 5, 1000])
def test_bounds_do_not_depend_on_what_is_worked_out_together(model, together, monkeypatch):
    """Of points without a multiplier in a batch nothing is said, and where densities are chosen."""
    wanted, controls = some(model, 5, 23), law_controls(model)
    solved = minimise_each(rows_of(model), wanted.objectives(model)[0])
    z = np.stack([each.multipliers for each in solved])
    ends = solve_boundary_costates(model, wanted, z, 3)
    between = MultiplierDensity.of(model, [], 6, 3)
    masses = between.distribute(wanted, z, ends)
    values = dual_bounds(between.model, controls, model.problem.sizing.bounds, wanted, masses, ends)
    monkeypatch.setattr(batch, "BATCH", together)
    again = between.distribute(wanted, z, ends)
    np.testing.assert_allclose(again, masses, atol=1e-12)
    other = dual_bounds(between.model, controls, model.problem.sizing.bounds, wanted, again, ends)
    np.testing.assert_allclose(other, values, rtol=1e-9, atol=1e-9)
    assert not len(
        dual_bounds(
            model, controls, model.problem.sizing.bounds, wanted.select(slice(0)), z[:0], ends[:0]
        )
    )


def test_only_intervals_beside_rows_with_multipliers_are_looked_at():
    runs = PointRuns.of(np.array([0.1, 0.2, 0.4, 0.5, 0.9]), ((0.0, 0.6), (0.8, 1.0)), EACH)
    z = np.array([[0.0, 0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 3.0]])
    assert runs.multiplied(z).tolist() == [1, 2]  # the last row has no neighbour in its part
    assert runs.multiplied(0.0 * z).tolist() == []
    assert runs.ends(np.array([1, 2])).tolist() == [[0.2, 0.4], [0.4, 0.5]]
