"""What is done to a cone program's point after the solver: equalities closed to rounding."""

from __future__ import annotations

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from scipy import sparse

from synthesis.numerics.solvers import clarabel
from synthesis.numerics.solvers.clarabel import ConeProgram, minimise_each, solve
from synthesis.numerics.solvers.statuses import StopReason

UNKNOWNS, ROWS = 37, 11


def program() -> ConeProgram:
    """Least squares on a banded set of equalities, one of them said twice and one a sum of two."""
    random = np.random.default_rng(20_261)
    rows = np.zeros((ROWS + 2, UNKNOWNS))
    for k in range(ROWS):
        rows[k, 3 * k : 3 * k + 5] = random.normal(size=5)
    rows[ROWS], rows[ROWS + 1] = 2.7 * rows[4], rows[1] + rows[7]
    rhs = rows @ random.normal(size=UNKNOWNS)
    return ConeProgram(
        sparse.eye_array(UNKNOWNS, format="csc"), np.zeros(UNKNOWNS), sparse.csc_matrix(rows), rhs,
        ROWS + 2, 0, (),
    )  # fmt: skip


def test_the_point_keeps_equalities_to_rounding() -> None:
    question = program()
    found = solve(question)
    assert found.stopped is StopReason.SOLVED
    assert np.max(np.abs(question.matrix @ found.x - question.rhs)) < 1e-13
    least, *_ = np.linalg.lstsq(question.matrix.toarray(), question.rhs, rcond=1e-12)
    assert found.x == pytest.approx(least, abs=1e-9)


def test_the_nearest_such_point_is_taken() -> None:
    question, away = program(), np.cos(np.arange(UNKNOWNS))
    closed = clarabel.project_on_equalities(question, away)
    assert np.max(np.abs(question.matrix @ closed - question.rhs)) < 1e-13
    # what was moved lies in the span of the rows alone
    rows = question.matrix.toarray()
    part, *_ = np.linalg.lstsq(rows.T, closed - away, rcond=1e-12)
    assert rows.T @ part == pytest.approx(closed - away, abs=1e-12)


def test_thousands_of_equalities_take_no_matrix_of_their_square() -> None:
    """Each joins neighbours alone; a full matrix of these takes 128 MB."""
    count = 4001
    joined = sparse.diags_array([1.0, -2.3, 1.7], offsets=[0, 1, 2], shape=(count, count + 2))
    wanted = np.sin(np.arange(count + 2))
    question = ConeProgram(
        sparse.csc_matrix((count + 2, count + 2)), np.zeros(count + 2),
        sparse.csc_matrix(joined), joined @ wanted, count, 0, (),
    )  # fmt: skip
    tracemalloc.start()
    closed = clarabel.project_on_equalities(question, wanted + 1e-6 * np.cos(wanted))
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert np.max(np.abs(question.matrix @ closed - question.rhs)) < 1e-13
    assert most < 16e6


def test_a_program_that_ends_at_the_limit_of_iterations_is_solved_with_less_regularisation(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    once, regular = clarabel._solve_once, list[float]()

    def drifting(question: ConeProgram, time_limit: float, much: float) -> clarabel.ConeSolution:
        regular.append(much)
        found = once(question, time_limit, much)
        if much == clarabel.LESS_REGULAR:
            return found
        lost = StopReason.OUT_OF_ITERATIONS
        return replace(found, x=0.0 * found.x, stopped=lost, iterations=clarabel.MOST_ITERATIONS)

    monkeypatch.setattr(clarabel, "_solve_once", drifting)
    found = solve(program())
    assert found.stopped is StopReason.SOLVED
    assert regular == [clarabel.REGULAR, clarabel.LESS_REGULAR]


def _bowl(bottom: float) -> ConeProgram:
    """x + y ≥ a bottom within a circle of radius 1.3 about (0.4, −0.7)."""
    matrix = np.array([[-1.0, -1.0], [0.0, 0.0], [-1.0, 0.0], [0.0, -1.0]])
    rhs = np.array([-bottom, 1.3, -0.4, 0.7])
    return ConeProgram(
        sparse.csc_matrix((2, 2)), np.zeros(2), sparse.csc_matrix(matrix), rhs, 0, 1, (3,)
    )  # fmt: skip


def test_many_objectives_over_the_same_rows_have_the_minima_of_each_by_itself() -> None:
    question, random = _bowl(-1.1), np.random.default_rng(5)
    objectives = list(random.normal(size=(9, 2)))
    found = minimise_each(question, objectives)
    assert len(found) == len(objectives)
    for each, one in zip(found, objectives, strict=True):
        alone = solve(replace(question, linear=one))
        assert one @ each.x == pytest.approx(one @ alone.x, rel=1e-5)
        # multipliers are those of this objective: its dual value is the minimum
        assert -question.rhs @ each.multipliers == pytest.approx(one @ alone.x, rel=1e-5)


def test_many_objectives_end_where_there_is_no_point_or_no_time() -> None:
    objectives = [np.array([1.0, 0.3]), np.array([0.2, -1.0])]
    (only,) = minimise_each(_bowl(1.9), objectives)
    assert only.stopped is StopReason.INFEASIBLE
    (late,) = minimise_each(_bowl(-1.1), objectives, 0.0)
    assert late.stopped is StopReason.OUT_OF_TIME


@pytest.mark.parametrize("left", [0.0, -3.0])
def test_what_is_late_is_not_solved(left: float) -> None:
    """The solver would be through with so small a program before it looked at the clock."""
    late = solve(_bowl(-1.1), left)
    assert late.stopped is StopReason.OUT_OF_TIME
    assert late.iterations == 0
