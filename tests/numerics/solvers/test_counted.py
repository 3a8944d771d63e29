"""Programs are counted as they end: what a proof may cost is said in them."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from math import ceil, inf

import numpy as np
import pytest
from scipy import sparse

from synthesis.numerics import clock
from synthesis.numerics.solvers import clarabel
from synthesis.numerics.solvers.clarabel import ConeProgram
from synthesis.numerics.solvers.clarabel import minimise_each as minimise_each_of_cones
from synthesis.numerics.solvers.clarabel import solve as solve_cone_program
from synthesis.numerics.solvers.highs import LinearRows, minimise_each
from synthesis.numerics.solvers.statuses import StopReason
from synthesis.optimise.propagation.quantity_bounds import _cone_multipliers

ABOVE = sparse.csc_matrix(-np.eye(2))
CONE = ConeProgram(
    sparse.csc_matrix((2, 2)), np.array([1.3, 0.7]), ABOVE, np.array([-2.1, 0.4]), 0, 2, ()
)
ROWS = LinearRows(ABOVE, np.array([-2.1, 0.4]), 0, np.full(2, -9.0), np.full(2, 9.0))


def counted() -> int:
    """What a cone program and three linear ones on the same rows count as."""
    before = clock.programs_solved()
    solve_cone_program(CONE)
    minimise_each(ROWS, [np.array([1.0, k]) for k in (0.3, 1.9, 0.8)])
    return clock.programs_solved() - before


def test_a_batch_on_one_matrix_counts_as_one() -> None:
    assert counted() == 2


OBJECTIVES = [np.array([1.0, 0.1 + k]) for k in range(31)]


def test_cone_programs_on_one_matrix_count_by_their_work(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(clarabel, "WORK", 57.0)
    before = clock.programs_solved()
    found = minimise_each_of_cones(CONE, OBJECTIVES)
    work = sum(each.iterations for each in found) * CONE.matrix.nnz
    assert len(found) == len(OBJECTIVES)
    assert clock.programs_solved() - before == ceil(work / 57.0) > 2


def test_they_end_with_the_budget(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(clarabel, "WORK", 57.0)
    before = clock.programs_solved()
    *found, last = minimise_each_of_cones(CONE, OBJECTIVES, last_program=before + 3)
    assert last.stopped is StopReason.OUT_OF_TIME
    assert 0 < len(found) < len(OBJECTIVES)
    assert 3 <= clock.programs_solved() - before <= 4


def test_objectives_beyond_the_budget_have_no_multipliers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(clarabel, "WORK", 17.0)
    now = clock.programs_solved()
    z = _cone_multipliers(CONE, OBJECTIVES, inf, now + 3)
    assert z is not None
    assert z.shape == (len(OBJECTIVES), 2)
    assert np.all(np.any(z[:3], axis=1))
    assert not np.any(z[-3:])
    assert _cone_multipliers(CONE, OBJECTIVES, inf, clock.programs_solved()) is None


def test_every_thread_counts_its_own() -> None:
    before = clock.programs_solved()
    with ThreadPoolExecutor(1) as pool:
        assert pool.submit(counted).result() == 2
    assert clock.programs_solved() == before
