"""Rows spread over the points between theirs: a block's points ascend, and its bound is valid."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from synthesis.optimise.conic.control import law_controls
from synthesis.optimise.dual_bound.arcs import density_terms
from synthesis.optimise.dual_bound.bound import add_costates, bound_from_lagrangian, dual_bound
from synthesis.optimise.dual_bound.costates import boundary_multipliers, nonnegative_multipliers
from synthesis.optimise.dual_bound.lagrangian import Lagrangian, sums_at_start
from synthesis.optimise.dual_bound.multiplier_density import MultiplierDensity, PointRuns
from synthesis.optimise.dual_bound.row_functionals import (
    cone_rows,
    fixed_size_rows,
    row_functionals,
)
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
    between = MultiplierDensity.of(answer.model, [], EACH, 3)
    ends = boundary_multipliers(answer.model, answer.solution, 3)
    own, _ = between.distribute_single(answer.solution.multipliers, ends)
    shaken = own * np.random.default_rng(seed).uniform(0.5, 1.5, len(own))
    balanced = between.balance(own[None], answer.solution.multipliers[None], 3)[0]
    values = [
        dual_bound(between.model, replace(answer.solution, multipliers=z), ends).value
        for z in (own, shaken, balanced)
    ]
    fine = direct(question, even(question, 100)).value
    assert max(values) <= fine * (1.0 + 1e-9)
    assert values[0] > dual_bound(answer.model, answer.solution).value - 0.01 * fine


def test_what_is_balanced_comes_to_what_the_points_did() -> None:
    """Or ψ would get a polynomial on all that lies before an arc, and the bound pay for it."""
    question = problem(SCENE)
    model = direct(question, uneven(question, 0)).model
    # rows of s'' with motion and speed beside it, as curvature implies them
    mixed = np.array([0.4, 0.3, 0.0, 0.0])
    model = replace(model, blocks=tuple(replace(b, alpha=b.alpha + mixed) for b in model.blocks))
    between, z = MultiplierDensity.of(model, [], EACH, 3), np.zeros((1, len(model.program.rhs)))
    for one in (one for one in row_functionals(model, 3) if one.uniform and one.jumps):
        z[0, one.first_row : one.first_row + one.count] = np.linspace(1.0, 2.0, one.count)
    spread, totals = between._masses(z, [1.0] * len(between.point_runs)), []
    for each, masses in (
        (model, z), (between.model, spread), (between.model, between.balance(spread, z, 3))
    ):  # fmt: skip
        total = []
        for one in (one for one in row_functionals(each, 3) if one.uniform and one.jumps):
            mass = masses[0, one.first_row : one.first_row + one.count]
            assert np.min(mass) > -1e-12
            rows = one.point_rows()
            total.append(mass @ sums_at_start(rows.x[:, None], rows.weights[:, None]))
        totals.append(np.array(total))
    assert np.max(np.abs(totals[1] - totals[0])) > 1e-3
    assert totals[2] == pytest.approx(totals[0], rel=1e-9)


def test_an_arc_of_which_nothing_is_left_has_nothing_to_balance() -> None:
    """Where the region of better cams excludes that a row binds anywhere on a law."""
    answer = direct(problem(SCENE), uneven(problem(SCENE), 0))
    model, z = answer.model, answer.solution.multipliers[None]
    number = next(k for k, one in enumerate(row_functionals(model, 3)) if one.may_be_density)
    block = replace(model.blocks[number], law_matrix=None, x=np.zeros(0), rhs=np.zeros(0))
    empty = replace(model, blocks=(*model.blocks, block))
    between = MultiplierDensity.of(empty, [(block, PointRuns.of(block.x, (), EACH))], EACH, 3)
    masses = between._masses(z, [1.0] * len(between.point_runs))
    assert between.balance(masses, z, 3).shape == masses.shape


def test_densities_lie_between_points_that_ascend() -> None:
    question = problem(SCENE)
    model = MultiplierDensity.of(direct(question, uneven(question, 0)).model, [], EACH, 3).model
    steered = [one for one in row_functionals(model, 3) if one.block.kind == "point"]
    assert any(one.uniform and one.jumps for one in steered)
    assert all(np.all(np.diff(one.block.x) > 0.0) for one in steered)
    # of the program's blocks those with a second derivative alone highest, at points in order
    model = direct(question, uneven(question, 0)).model
    spread = MultiplierDensity.of(model, [], EACH, 3).point_runs
    assert [runs is not None for runs in spread] == [
        bool(b.kind == "point" and b.alpha[2] and not b.alpha[3]) for b in model.blocks
    ]
    assert any(runs is not None for runs in spread)
    for change in ({"kind": "control"}, {}):
        still = tuple(replace(b, x=np.zeros_like(b.x), **change) for b in model.blocks)
        assert not any(MultiplierDensity.of(replace(model, blocks=still), [], EACH, 3).point_runs)
    model = MultiplierDensity.of(model, [], EACH, 3).model
    # points in any other order have no neighbours: their rows are taken at the points alone
    mixed = [replace(block, x=block.x[::-1]) for block in model.blocks]
    backwards = replace(model, blocks=tuple(mixed))
    assert not any(one.uniform for one in row_functionals(backwards, 3))


def test_only_rows_that_read_the_same_all_along_a_law_hold_between_their_points() -> None:
    """Not those whose factors differ, nor of a window; of equalities multipliers have any sign."""
    question = problem(SCENE)
    model = direct(question, uneven(question, 0)).model
    spread = MultiplierDensity.of(model, [], EACH, 3).point_runs
    number = next(k for k, runs in enumerate(spread) if runs is not None)
    block = model.blocks[number]
    share = np.linspace(1.0, 2.0, len(block.x))
    differing = replace(block, alpha=block.alpha[:, None] * share, rhs=block.rhs * share)
    windowed = replace(block, spans=np.tile([0.2, 0.7], (len(block.x), 1)))
    for other in (differing, windowed, replace(block, exact=True)):
        blocks = [other if k == number else b for k, b in enumerate(model.blocks)]
        between = MultiplierDensity.of(replace(model, blocks=tuple(blocks)), [], EACH, 3)
        assert between.point_runs[number] is None
        assert between.model.blocks[number] is other
        assert sum(runs is None for runs in between.point_runs) == 1 + spread.count(None)


def test_a_density_at_many_points_is_linear_between_these() -> None:
    """One node in a knot interval is for multipliers of a spline's own rows."""
    question = problem(SCENE)
    model = MultiplierDensity.of(direct(question, uneven(question, 2)).model, [], EACH, 3).model
    steered = [one for one in row_functionals(model, 3) if one.uniform and one.jumps]
    assert steered
    for one in steered:
        z = np.random.default_rng(5).exponential(size=one.count)
        widths = []
        for dense in (True, False):
            kept, nodes, masses = one.distribute(z, dense=dense)
            ((rows, mass),) = density_terms(one, nodes, masses)
            assert rows.spans is not None
            assert np.sum(kept) + np.sum(mass) == pytest.approx(np.sum(z), rel=1e-12)
            widths.append(np.ptp(rows.spans, axis=1).max())
        assert widths[0] <= np.diff(one.block.x).max() * (1.0 + 1e-12)
        assert widths[1] > 3.0 * widths[0]


@pytest.mark.parametrize("seed", range(2))
def test_a_distributed_density_is_bounded_as_it_is(seed: int) -> None:
    """In a bound the masses of dense rows are not gathered again."""
    question = problem(SCENE)
    answer = direct(question, uneven(question, seed))
    between = MultiplierDensity.of(answer.model, [], EACH, 3)
    ends = boundary_multipliers(answer.model, answer.solution, 3)
    own, _ = between.distribute_single(answer.solution.multipliers, ends)
    spread = replace(answer.solution, multipliers=own)
    lagrangian = Lagrangian(between.model, 3)
    z = nonnegative_multipliers(between.model, spread)
    for rows, mass in (*fixed_size_rows(between.model, z), *cone_rows(between.model, z)):
        lagrangian.add_rows(rows, mass)
    for one in row_functionals(between.model, 3, z):
        own = z[one.first_row : one.first_row + one.count]
        kept, *density = one.distribute(own, dense=True)
        lagrangian.add_rows(one.point_rows(), kept)
        for rows, mass in density_terms(one, *density):
            lagrangian.add_rows(rows, mass)
    controls = law_controls(between.model)
    assert controls
    add_costates(lagrangian, controls, ends)
    expected = bound_from_lagrangian(spread, lagrangian, controls).value
    assert dual_bound(between.model, spread, ends).value == pytest.approx(expected, rel=1e-9)
