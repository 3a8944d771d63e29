"""A part of a program is a relaxation of it: its rows are rows of the whole."""

from __future__ import annotations

import numpy as np
import pytest

from synthesis.numerics.piecewise import Array
from synthesis.optimise.conic.program import ConicModel
from synthesis.optimise.conic.subprogram import coupled_laws, submodel
from tests.optimise.scenes import direct, dwell, even, fall, jerk, problem, rise, scene, velocity

PROGRAMS = {
    "turning": (
        rise(61.0), fall(47.0, 11.0), dwell(33.0), rise(52.0, 7.7), fall(71.0, 24.0), dwell(96.0),
    ),
    "on the way": (
        rise(61.0, 12.0), rise(47.0, 9.0), dwell(33.0), fall(52.0, 7.7), fall(71.0, 13.3),
        dwell(96.0),
    ),
}  # fmt: skip


def model(name: str = "turning") -> ConicModel:
    question = problem(scene(PROGRAMS[name], jerk(70.0, 47.0), velocity(2.4, 47.0), offset=3.1))
    return direct(question, even(question, 7)).model


def rounded(*each: Array) -> list[tuple[float, ...]]:
    return list(zip(*(np.round(one, 9).tolist() for one in each), strict=True))


def columns(whole: ConicModel, positions: tuple[int, ...]) -> Array:
    """Numbers of the unknowns of some laws, and of the size."""
    parts = [*(whole.columns[k] for k in positions), whole.size]
    return np.concatenate([np.arange(part.start, part.stop) for part in parts])


@pytest.mark.parametrize("name", PROGRAMS)
def test_laws_are_coupled_where_they_meet_in_motion(name: str) -> None:
    whole = model(name)
    assert len(whole.grids) == 4
    assert [coupled_laws(whole, k) for k in range(4)] == [(0, 1), (0, 1), (2, 3), (2, 3)]


@pytest.mark.parametrize("name", PROGRAMS)
@pytest.mark.parametrize("positions", [(0,), (1,), (0, 1), (2, 3), (1, 2), (0, 1, 2, 3)])
def test_rows_of_a_part_are_rows_of_the_whole(positions: tuple[int, ...], name: str) -> None:
    whole, part = model(name), submodel(model(name), positions)
    x = np.random.default_rng(5).standard_normal(whole.program.matrix.shape[1])
    own, rhs = part.program.matrix @ x[columns(whole, positions)], part.program.rhs
    assert len(own) == part.program.equalities + part.program.inequalities
    every, at = whole.program.matrix @ x, whole.program.equalities
    kinds = (slice(0, at), slice(at, at + whole.program.inequalities))
    ends = np.split(np.arange(len(own)), [part.program.equalities])
    for mine, theirs in zip(ends, kinds, strict=True):
        known = set(rounded(every[theirs], whole.program.rhs[theirs]))
        assert set(rounded(own[mine], rhs[mine])) <= known
    # all rows that speak of nothing else are there
    alone = np.ones(whole.program.matrix.shape[1], dtype=bool)
    alone[columns(whole, positions)] = False
    matrix = whole.program.matrix.tocsr()[: at + whole.program.inequalities]
    of_others, of_it = (
        np.asarray(abs(matrix[:, which]).sum(axis=1)).ravel() > 0.0 for which in (alone, ~alone)
    )
    held = np.asarray(abs(part.program.matrix).sum(axis=1)).ravel() > 0.0
    assert np.count_nonzero(held) == np.count_nonzero(of_it & ~of_others)
    # blocks, by which bounds read the rows, are where they say
    for first, block in part.numbered_blocks:
        if block.law_matrix is None or block.segment is None:
            continue
        stop = first + len(block.rhs)
        moved, known_part = part.boundary_states[block.segment].split(block.law_matrix)
        rows = part.program.matrix[first:stop, part.columns[block.segment]].toarray()
        assert rows == pytest.approx(moved, abs=1e-12)
        assert rhs[first:stop] == pytest.approx(block.rhs - known_part - block.tightening)
