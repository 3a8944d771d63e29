"""A relaxation of a node without rows between its knots is too loose for a fine tolerance."""

from __future__ import annotations

from dataclasses import replace
from math import inf
from typing import Any

import numpy as np
import pytest

from synthesis import DesignSpec, synthesise
from synthesis.numerics import clock
from synthesis.optimise.branching import traced_node, traced_relaxation
from synthesis.optimise.branching.traced_node import TracedNode
from synthesis.optimise.branching.traced_relaxation import solve_relaxation
from synthesis.optimise.driver import optimise
from synthesis.optimise.problem.grid import grid_through
from synthesis.optimise.problem.problem import formulate_problem
from synthesis.optimise.refinement.row_violations import (
    exact_excess,
    row_violation_peaks,
    row_violations,
)
from synthesis.optimise.state import QUICK, ProofBudget, SolveState
from tests.hard.families import random_scene

FINE = 1e-4
SCENE = random_scene("slide, centred", 5)


def searched(tolerance: float, proof: ProofBudget) -> SolveState:
    spec = DesignSpec.model_validate(SCENE)
    problem = formulate_problem(spec, spec.objectives()[0])
    return optimise(problem, tolerance, proof=proof)


@pytest.fixture(scope="module")
def close() -> SolveState:
    return searched(FINE, ProofBudget(300, 1.0))


@pytest.fixture(scope="module")
def root(close: SolveState) -> TracedNode:
    node = TracedNode.root(replace(close, tolerance=0.1 * FINE, proof_deadline=inf))
    assert node is not None
    return node


def test_it_is_met_by_the_first_node(close: SolveState) -> None:
    """With rows at the knots alone, 34 boxes and 20 s left 2.05e-4 of the base radius."""
    assert close.gap_between(close.incumbent, close.lower) <= FINE
    assert close.stages[-1].nodes == 1


def test_a_bound_that_is_sufficient_ends_the_proof(close: SolveState) -> None:
    """A maximum below every cam: only that the bound lies above it is to be proven."""
    to_wire, machine = close.problem.objective.to_wire, close.problem.machine
    enough, before = to_wire(close.lower, machine) * (1.0 - 2e-4), clock.programs_solved()
    proof = ProofBudget(300, 1.0)
    found = optimise(close.problem, 0.01 * FINE, proof=proof, sufficient_bound=enough)
    assert enough <= to_wire(found.lower, machine) < enough * (1.0 + 1e-9)
    assert found.gap_between(found.incumbent, found.lower) > FINE
    assert found.stages[-1].exit == "sufficient"
    assert clock.programs_solved() - before < 200
    # it is none without a cam: the search for one goes on
    assert not replace(found, incumbent=None).is_good_enough
    assert not replace(found, sufficient_bound=enough * 1.01).is_good_enough


def test_a_better_cam_is_sought_on_few_knots_where_no_mesh_was_kept(
    close: SolveState, root: TracedNode, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The first meshes had no point, and that of the bound is finer than any for a cam."""
    state = replace(close, tolerance=0.1 * FINE)
    node = solve_relaxation(state, root)
    assert node.relaxation is not None
    monkeypatch.setattr(traced_node, "MOST_INTERVALS", 1)
    meshes = list[Any]()
    monkeypatch.setattr(
        traced_node, "improve_from", lambda state, _: (meshes.append(state.grids), state)[1]
    )
    for kept in (node.grids, ()):
        traced_node._improve_incumbent(state, replace(node, grids=kept))
    assert len(meshes) == 2
    assert all(len(mesh) == len(state.problem.free) for mesh in meshes)


def test_a_cam_that_a_node_offers_keeps_its_rows_by_as_much_as_any(
    close: SolveState, root: TracedNode
) -> None:
    """The certificate refuses a jerk above its cap by a rounding error."""
    node = solve_relaxation(close, root)
    found = traced_node._offer_relaxation(replace(close, incumbent=None), node)[0]
    cam = found.incumbent
    assert cam is not None
    both = zip(close.problem.free, cam.laws, strict=True)
    grids = tuple(grid_through(segment, law.space.breaks) for segment, law in both)
    assert exact_excess(replace(close, grids=grids), cam) < -0.5 * close.tighten


def test_rows_are_added_where_the_relaxation_breaks_them(
    close: SolveState, root: TracedNode, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = solve_relaxation(close, root)
    assert any(len(points) for points in first.violated)
    again = solve_relaxation(close, first)
    monkeypatch.setattr(traced_relaxation, "row_violation_peaks", lambda *_: [np.zeros(0)] * 2)
    without = solve_relaxation(close, solve_relaxation(close, root))
    assert without.relaxation is not None
    assert again.relaxation is not None
    loosest = row_violations(replace(close, grids=first.grids), without.relaxation[0])[1]
    assert row_violations(replace(close, grids=first.grids), again.relaxation[0])[1] < 0.1 * loosest


def test_one_place_is_named_of_every_violation(close: SolveState, root: TracedNode) -> None:
    node = solve_relaxation(close, root)
    assert node.relaxation is not None
    cam, grids, _ = node.relaxation
    state = replace(close, grids=tuple(grid.knots_only for grid in grids))
    every, _ = row_violations(state, cam)
    for peaks, points in zip(row_violation_peaks(state, cam, 2), every, strict=True):
        assert set(peaks) <= set(points)
        assert len(peaks) <= len(points)
    assert sum(map(len, row_violation_peaks(state, cam, 2))) < sum(map(len, every))
    # of a row with s', where ψ would jump under a capped acceleration, none
    assert not any(map(len, row_violation_peaks(state, cam, 1)))


def test_where_the_acceleration_is_capped_no_rows_are_added() -> None:
    """With them 0.69 % was left after 10 s; without, the first box closes it."""
    body = random_scene("slide, acceleration and profile radius", 7)
    spec = DesignSpec.model_validate({**body, "proof": "thorough", "time_budget_s": 60.0})
    design = synthesise(spec)
    assert design.status == "optimal"
    assert design.report.stages[-1].nodes == 1


def test_the_cam_of_a_relaxation_is_an_incumbent(
    close: SolveState, root: TracedNode, monkeypatch: pytest.MonkeyPatch
) -> None:
    """No local search is needed to find a better one than the root of the driver did."""
    monkeypatch.setattr(traced_node, "_improve_incumbent", lambda state, node: (state, node))
    worse = searched(5e-3, QUICK).incumbent
    assert worse is not None
    found, _ = root.process(replace(close, incumbent=worse, tolerance=0.1 * FINE))
    assert found.incumbent is not None
    assert found.incumbent.value < worse.value * (1.0 - 1e-4)
    # all rows hold on it, on many more points too
    laws = found.incumbent.laws
    grids = tuple(
        grid_through(s, np.union1d(law.space.breaks, np.linspace(0.0, 1.0, 701)))
        for s, law in zip(found.problem.free, laws, strict=True)
    )
    assert row_violations(replace(found, grids=grids), found.incumbent)[1] <= 1e-9


def test_laws_that_may_jump_are_none_of_a_smoother_problem(
    close: SolveState, root: TracedNode
) -> None:
    node: Any = solve_relaxation(close, root)
    smoother = [
        replace(s, free=replace(s.free, smoothness=3)) if s.free else s
        for s in close.problem.segments
    ]
    state = replace(close, problem=replace(close.problem, segments=tuple(smoother)), incumbent=None)
    assert traced_node._offer_relaxation(replace(close, incumbent=None), node)[0].incumbent
    assert traced_node._offer_relaxation(state, node)[0].incumbent is None


def test_a_finer_mesh_is_kept_where_knots_lose_more_than_is_missing(
    close: SolveState, root: TracedNode, monkeypatch: pytest.MonkeyPatch
) -> None:
    state = replace(close, deadline=inf)

    def kept() -> int:
        node = solve_relaxation(state, replace(root, lower=0.999 * root.task.target))
        return sum(len(grid.space.breaks) for grid in node.grids)

    fine = kept()
    monkeypatch.setattr(traced_relaxation, "KEPT_LOSS", inf)
    assert kept() < fine
