"""What is looked for between the points of rows, and what the fitted size has settled already."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.main_job import CONVEX
from synthesis import DesignSpec
from synthesis.formulations.cams.candidate import Candidate, settle
from synthesis.formulations.cone.convex import Plan, formulate
from synthesis.formulations.question.grid import Grid, uniform
from synthesis.formulations.question.problem import pose
from synthesis.formulations.rounds.missed import ALLOWED, misses
from synthesis.formulations.rounds.search import Search
from synthesis.solvers.clarabel import ConeSolution, solve

INTERVALS = 13  # so few that rows at knots alone are missed between them


def solved() -> tuple[Plan, ConeSolution, Search]:
    spec = DesignSpec.model_validate(CONVEX)
    problem = pose(spec, spec.objectives()[0])
    grids = tuple(uniform(stretch, INTERVALS) for stretch in problem.free)
    grids = tuple(Grid(grid.space, grid.space.breaks) for grid in grids)
    plan = formulate(problem, grids)
    state = Search(problem, 5e-3, np.inf, 0.0)
    state.grids = grids
    return plan, solve(plan.program), state


def worst(found: Candidate) -> float:
    """The most by which a row that speaks of the size is exceeded on a fine mesh [mm]."""
    excess = -np.inf
    for stretch in found.problem.stretches:
        s = stretch.placed().derivatives(stretch.start + stretch.angle * np.linspace(0, 1, 5003))
        for row in found.problem.limit_rows(stretch):
            if row.size:
                left = np.array(row.coefficients) @ s + np.array(row.size) @ found.size
                excess = max(excess, float(np.max(left)) - row.upper)
    return excess


def test_a_fitted_size_keeps_its_rows_between_their_points() -> None:
    plan, solution, state = solved()
    laws, size = plan.recover(solution.x)
    fitted = settle(plan.problem, laws, size)
    assert fitted.fitted
    assert worst(fitted) <= 0.0
    assert misses(state, fitted)[1] <= ALLOWED


def test_the_solvers_own_size_does_not_and_a_larger_one_is_looked_at_again() -> None:
    plan, solution, state = solved()
    laws, size = plan.recover(solution.x)
    hinted = settle(plan.problem, laws, size, keep_hint=True)
    assert not hinted.fitted
    assert worst(hinted) > 1e-3
    points, excess = misses(state, hinted)
    assert excess > 1e-5
    assert any(len(each) for each in points)
    assert not settle(plan.problem, laws, tuple(1.1 * v for v in size), keep_hint=True).fitted


@pytest.mark.parametrize("fitted", [True, False])
def test_what_is_said_to_be_fitted_is_not_looked_at(fitted: bool) -> None:
    plan, solution, state = solved()
    laws, size = plan.recover(solution.x)
    found = settle(plan.problem, laws, size)
    small = replace(found, size=tuple(0.8 * v for v in found.size), fitted=fitted)
    assert (misses(state, small)[1] > ALLOWED) is not fitted
