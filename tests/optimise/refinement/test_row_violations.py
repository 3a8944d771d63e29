"""What is looked for between the points of rows, and what the fitted size has settled already."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.main_job import CONVEX
from synthesis import DesignSpec
from synthesis.numerics.solvers.clarabel import ConeSolution, solve
from synthesis.optimise.conic.program import ConicModel, formulate
from synthesis.optimise.problem.grid import Grid, uniform_grid
from synthesis.optimise.problem.problem import formulate_problem
from synthesis.optimise.recovery.candidate import Candidate, recover_cam
from synthesis.optimise.refinement.row_violations import ALLOWED, row_violations
from synthesis.optimise.state import SolveState

INTERVALS = 13  # so few that rows written at knots alone are violated between them


def solved() -> tuple[ConicModel, ConeSolution, SolveState]:
    spec = DesignSpec.model_validate(CONVEX)
    problem = formulate_problem(spec, spec.objectives()[0])
    grids = tuple(uniform_grid(segment, INTERVALS) for segment in problem.free)
    grids = tuple(Grid(grid.space, grid.space.breaks) for grid in grids)
    model = formulate(problem, grids)
    state = SolveState(problem, 5e-3, np.inf, 0.0, grids=grids)
    return model, solve(model.program), state


def worst(found: Candidate) -> float:
    """The most by which a row that speaks of the size is exceeded on a fine mesh [mm]."""
    excess = -np.inf
    for segment in found.problem.segments:
        s = segment.placed().derivatives(segment.start + segment.angle * np.linspace(0, 1, 5003))
        for row in found.problem.limit_rows(segment):
            if row.size:
                left = np.array(row.coefficients) @ s + np.array(row.size) @ found.size
                excess = max(excess, float(np.max(left)) - row.upper)
    return excess


def test_a_fitted_size_keeps_its_rows_between_their_points() -> None:
    model, solution, state = solved()
    laws, size = model.recover(solution.x)
    fitted = recover_cam(model.problem, laws, size)
    assert fitted.fitted
    assert worst(fitted) <= 0.0
    assert row_violations(state, fitted)[1] <= ALLOWED


def test_the_solvers_own_size_does_not_and_a_larger_one_is_looked_at_again() -> None:
    model, solution, state = solved()
    laws, size = model.recover(solution.x)
    hinted = recover_cam(model.problem, laws, size, keep_size=True)
    assert not hinted.fitted
    assert worst(hinted) > 1e-3
    points, excess = row_violations(state, hinted)
    assert excess > 1e-5
    assert any(len(each) for each in points)
    assert not recover_cam(model.problem, laws, tuple(1.1 * v for v in size), keep_size=True).fitted


@pytest.mark.parametrize("fitted", [True, False])
def test_what_is_said_to_be_fitted_is_not_looked_at(fitted: bool) -> None:
    model, solution, state = solved()
    laws, size = model.recover(solution.x)
    found = recover_cam(model.problem, laws, size)
    small = replace(found, size=tuple(0.8 * v for v in found.size), fitted=fitted)
    assert (row_violations(state, small)[1] > ALLOWED) is not fitted
