"""Lower bounds of many quantities at once: against the single bound, cams, and plain quadrature."""

from dataclasses import replace

import numpy as np
import pytest

from synthesis import DesignSpec
from synthesis.formulations.bounds.bound import bound
from synthesis.formulations.bounds.floors import Wanted, floors, integrals, pieces, solved_prices
from synthesis.formulations.bounds.spreading import Arcs
from synthesis.formulations.cone.control import controls
from synthesis.formulations.cone.convex import formulate, with_rows
from synthesis.formulations.cone.rows import Block
from synthesis.formulations.question.grid import Grid, uniform
from synthesis.formulations.question.problem import Held, Nothing, pose
from synthesis.solvers.clarabel import solve
from synthesis.solvers.highs import LinearRows, least
from synthesis.solvers.statuses import Stopped

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
def plan(request):
    """Rows that cams keep whose prime radius is no more than 3 % above the least."""
    spec = DesignSpec.model_validate(body(request.param))
    problem = pose(spec, spec.objectives()[0])
    grids = tuple(Grid(g.space, g.space.breaks) for g in (uniform(s, 26) for s in problem.free))
    first = formulate(problem, grids)
    value = np.hypot(*first.recover(solve(first.program).x)[1])
    asked = replace(problem, objective=Nothing(), held=(Held(problem.objective, 1.03 * value),))
    return formulate(asked, grids)


def some(plan, seed: int, count: int = 12) -> Wanted:
    """Random quantities: g, g' or g'' at random points, with shares of the size."""
    draw = np.random.default_rng(seed)
    alpha = np.zeros((count, 3))
    alpha[np.arange(count), draw.integers(0, 3, count)] = draw.choice([1.0, -1.0], count)
    alpha[0] = 0.0
    size = draw.uniform(-1.0, 1.0, (count, 2)) * draw.integers(0, 2, (count, 1))
    size[0] = (0.6, 0.8)
    return Wanted(
        draw.integers(0, len(plan.grids), count), draw.uniform(0.03, 0.97, count), alpha, size
    )


def single(plan, wanted: Wanted, k: int):
    """The plan that pushes one quantity down, by a row of its own, and its solution."""
    position, x, alpha = int(wanted.law[k]), wanted.x[k : k + 1], wanted.alpha[k]
    space = plan.grids[position].space
    laws = sum(a * space.basis(x, order) for order, a in enumerate(alpha))
    motion = (position, laws) if np.any(alpha) else (None, None)
    kind = "point" if np.any(alpha) else "size"
    row = Block(
        kind, *motion, x, np.append(alpha, 0.0), wanted.size[k], -1.0, np.zeros(1), "quantity"
    )
    asked = with_rows(plan, [row])
    return asked, solve(asked.program)


def test_each_is_what_the_bound_of_a_program_of_its_own_says(plan):
    wanted = some(plan, 3)
    rows = plan.program.equalities + plan.program.inequalities
    for k in range(len(wanted.x)):
        if wanted.alpha[k, 2]:
            continue  # there the single one spreads the quantity itself
        asked, solution = single(plan, wanted, k)
        alone = bound(asked, solution)
        one = Wanted(wanted.law[k : k + 1], wanted.x[k : k + 1], wanted.alpha[k : k + 1],
                     wanted.size[k : k + 1])  # fmt: skip
        z = np.delete(solution.multipliers / solution.multipliers[rows], rows)
        # the cones' multipliers as those of one tangent each: the row that they say
        at, tangents, prices = rows, [], []
        for ball in plan.balls:
            v = z[at + 1 : at + 1 + len(ball.shift)]
            prices.append(np.linalg.norm(v))
            tangents.append(tangent_of(plan, ball, -v / max(prices[-1], 1e-300)))
            at += 1 + len(ball.shift)
        full, z = with_rows(plan, tangents), np.append(z[:rows], prices)[None]
        ends = solved_prices(full, one, z)
        value = floors(full, controls(plan), plan.problem.sizing.bounds, one, z, ends)[0]
        if any(limit.kind == "acceleration" for limit in plan.problem.limits):
            # the single one spreads multipliers of accelerations by itself
            assert alone.value - 0.15 < value < alone.value
        else:
            assert value == pytest.approx(alone.value, rel=1e-7, abs=1e-7)


def tangent_of(plan, ball, y) -> Block:
    """y · (M ζ + m) ≤ radius, for a unit vector."""
    return Block(
        "size", None, None, np.zeros(1), np.zeros(4), y @ ball.matrix[:, plan.size], 0.0,
        np.array([ball.radius - y @ ball.shift]), "tangent",
    )  # fmt: skip


def test_no_cam_that_keeps_the_rows_is_below_whatever_the_multipliers_are(plan):
    """Cams at corners of what is allowed, multipliers good and spoilt."""
    draw, wanted = np.random.default_rng(11), some(plan, 7, 24)
    count = plan.program.equalities + plan.program.inequalities
    bounds = np.array(plan.problem.sizing.bounds) / plan.scales.size
    low, high = np.full((2, plan.program.matrix.shape[1]), np.inf)
    low = -low
    low[plan.size], high[plan.size] = bounds.T
    rows = LinearRows(
        plan.program.matrix[:count], plan.program.rhs[:count], plan.program.equalities, low, high
    )
    solved = least(rows, wanted.costs(plan))
    good = np.stack([each.multipliers for each in solved])
    for spoilt in (1.0, draw.uniform(0.7, 1.3, good.shape), draw.uniform(0.0, 3.0, good.shape)):
        z = good * spoilt
        value = floors(
            plan, controls(plan), plan.problem.sizing.bounds, wanted, z,
            solved_prices(plan, wanted, z),
        )  # fmt: skip
        for each in solved:
            laws, _ = plan.recover(each.x)
            for k, floor in enumerate(value):
                law, x = laws[wanted.law[k]].curve(), wanted.x[k : k + 1]
                reached = sum(a * law(x, order)[0] for order, a in enumerate(wanted.alpha[k]))
                assert floor <= reached + wanted.size[k] @ each.x[plan.size] + 1e-7
    spread = good[:, plan.program.equalities :]
    assert np.all(spread >= -1e-7)


def test_without_a_solution_the_list_ends_there():
    from scipy import sparse

    matrix = sparse.csc_matrix([[1.0], [-1.0]])
    rows = LinearRows(matrix, np.array([1.0, -2.0]), 0, np.array([-9.0]), np.array([9.0]))
    (only,) = least(rows, [np.ones(1), -np.ones(1)])
    assert only.stopped is Stopped.INFEASIBLE
    both = least(replace(rows, rhs=np.array([1.0, -0.5])), [np.ones(1), -np.ones(1)])
    assert [each.x[0] for each in both] == [0.5, 1.0]
    assert both[0].multipliers.tolist() == [0.0, 1.0]
    assert both[1].multipliers.tolist() == [1.0, 0.0]


def test_the_switching_function_s_integral_by_plain_quadrature():
    draw = np.random.default_rng(2)
    x, weights = draw.random(9), draw.normal(size=(4, 9, 3)) * np.array([9.0, 3.0, 1.0])
    found = integrals(*pieces(x, weights)).sum(axis=1)
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
    arcs = Arcs.of(x, ((0.05, 0.3), (0.55, 0.7)), EACH)
    assert arcs.left.tolist() == [0, 1, 2, 4]
    between = arcs.points[len(x) :].reshape(4, EACH)
    assert np.all((between > x[arcs.left, None]) & (between < x[arcs.left + 1, None]))
    z = np.array([[1.0, 2.0, 0.0, 3.0, 0.5, 4.0], [0.0, 0.0, 5.0, 0.0, 0.0, 1.0]])
    for chosen in (np.ones(4), np.array([0.0, 1.0, 1.0, 0.0])):
        masses = arcs.spread(z, chosen)
        assert np.all(masses >= -1e-15)
        assert masses.sum(axis=1) == pytest.approx(z.sum(axis=1))
    assert np.allclose(arcs.spread(z, np.zeros(4))[:, : len(x)], z)
    # of a law with even rows whose multipliers are even the density is even
    even = Arcs.of(np.linspace(0.2, 0.6, 9), ((0.1, 0.7),), EACH)
    masses = even.spread(np.ones((1, 9)), np.ones(8))[0]
    inner = masses[9:].reshape(8, EACH)[1:-1]
    assert np.allclose(inner, 1.0 / EACH)
    assert np.allclose(masses[:9], 0.0)


def test_what_lies_between_rows_is_summed_there():
    arcs = Arcs.of(np.array([0.25, 0.5, 0.8]), ((0.0, 1.0),), EACH)
    breaks = np.array([0.0, 0.25, 0.4, 0.5, 0.8, 1.0])
    amounts = np.array([[1.0, 2.0, 4.0, 8.0, 16.0]])
    assert arcs.between(breaks, amounts).tolist() == [[6.0, 8.0]]
