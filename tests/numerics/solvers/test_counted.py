"""Programs are counted as they end: what a proof may cost is said in them."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
from scipy import sparse

from synthesis.numerics import clock
from synthesis.numerics.solvers.clarabel import SMALL_PROGRAMS, ConeProgram
from synthesis.numerics.solvers.clarabel import minimise_each as minimise_each_of_cones
from synthesis.numerics.solvers.clarabel import solve as solve_cone_program
from synthesis.numerics.solvers.highs import LinearRows, minimise_each

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


def test_small_cone_programs_on_one_matrix_count_by_the_two_dozen() -> None:
    objectives = [np.array([1.0, 0.1 + k]) for k in range(2 * SMALL_PROGRAMS + 1)]
    before = clock.programs_solved()
    assert len(minimise_each_of_cones(CONE, objectives)) == len(objectives)
    assert clock.programs_solved() - before == 3


def test_every_thread_counts_its_own() -> None:
    before = clock.programs_solved()
    with ThreadPoolExecutor(1) as pool:
        assert pool.submit(counted).result() == 2
    assert clock.programs_solved() == before
