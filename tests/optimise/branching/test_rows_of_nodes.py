"""Rows of a node's relaxation stand where its solutions break limits, not where the first ones did.

Without them boxes of sizes are halved without end, and the bound does not move.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from synthesis import DesignSpec, synthesise
from synthesis.numerics.solvers.clarabel import ConeProgram, ConeSolution
from synthesis.optimise.branching import traced_relaxation
from synthesis.optimise.branching.node import VIOLATED, violated_parts
from synthesis.optimise.branching.traced_node import TracedNode, tighten
from synthesis.optimise.branching.traced_relaxation import (
    SAMPLES,
    _violation_peaks,
    solve_relaxation,
)
from synthesis.optimise.driver import optimise
from synthesis.optimise.problem.problem import formulate_problem
from synthesis.optimise.recovery.candidate import Candidate
from synthesis.optimise.relaxation import size_rows
from synthesis.optimise.state import ProofBudget, SolveState
from tests.hard.families import random_scene


@pytest.mark.parametrize(
    ("family", "number", "tolerance"),
    [
        # Curvature is broken beyond the part where it bound on the first cams: 0.9 % were left.
        ("swinging face, laws free", 9, 6e-3),
        # The pressure angle of an arm is broken between knots: 0.31 %, in any number of boxes.
        ("arm, groove", 8, 1.5e-3),
        # No spline is better, but points on 850 intervals lie too far apart: 0.043 %.
        ("swinging face, laws free", 8, 3.5e-4),
    ],
)
def test_a_gap_that_boxes_do_not_close_is_closed_by_rows(
    family: str, number: int, tolerance: float
) -> None:
    body = {**random_scene(family, number), "proof": "thorough", "tolerance": tolerance}
    assert synthesise(DesignSpec.model_validate(body)).status == "optimal"


@pytest.fixture(scope="module")
def searched() -> SolveState:
    spec = DesignSpec.model_validate(random_scene("swinging face, laws free", 9))
    problem = formulate_problem(spec, spec.objectives()[0])
    return optimise(problem, 5e-3, proof=ProofBudget(0, 1.0))


@pytest.fixture(scope="module")
def node(searched: SolveState) -> TracedNode:
    begun = replace(searched, tolerance=1e-3, proof_deadline=np.inf, last_program=np.inf)
    root = TracedNode.root(begun)
    assert root is not None
    return tighten(begun, solve_relaxation(begun, root), 5)[1]


def excess(cam: Candidate, position: int, x: np.ndarray) -> np.ndarray:
    law = [each for each in cam.problem.segments if each.free is not None][position]
    return size_rows.relative_excess(cam.problem, law, law.start + law.angle * x, cam.size)


def test_parts_on_which_a_cam_violates_limits_are_found(node: TracedNode) -> None:
    assert node.relaxation is not None
    cam, x = node.relaxation[0], np.linspace(0.0, 1.0, 1001)
    found = violated_parts(cam, {})
    assert found
    for position in range(2):
        broken = x[excess(cam, position, x) > 1.1 * VIOLATED]
        parts = found.get(position, ())
        assert all(any(a <= place <= b for a, b in parts) for place in broken)
        # each has a place where a limit is violated
        assert all(np.any((broken >= a) & (broken <= b)) for a, b in parts)
    assert not violated_parts(cam, found)


def test_a_part_without_rows_gets_them(searched: SolveState, node: TracedNode) -> None:
    """Cut off half of what has rows: it is found again, nothing else is forgotten."""
    assert node.relaxation is not None
    keys = {position: bounds for (position, _), bounds in node.region.point_bounds.items()}
    position = max(violated_parts(node.relaxation[0], {}))
    bounds = keys[position]
    low, high = max(bounds.parts, key=lambda part: part[1] - part[0])
    middle = float(bounds.nodes[np.argmin(np.abs(bounds.nodes - 0.5 * (low + high)))])
    kept = bounds.nodes <= middle
    cut = replace(
        bounds, nodes=bounds.nodes[kept], low=bounds.low[:, kept], high=bounds.high[:, kept],
        parts=tuple((a, min(b, middle)) for a, b in bounds.parts if a < middle),
    )  # fmt: skip
    point_bounds = {
        key: cut if key[0] == position else known for key, known in node.region.point_bounds.items()
    }
    short = replace(node, region=replace(node.region, point_bounds=point_bounds))
    again = solve_relaxation(searched, short).region.point_bounds
    for key, known in again.items():
        if key[0] == position:
            assert known.parts[-1][1] > middle
            assert np.array_equal(known.low[:, np.isin(known.nodes, cut.nodes)], cut.low)


def test_points_are_added_where_rows_between_knots_are_broken() -> None:
    spec = DesignSpec.model_validate(random_scene("arm, groove", 8))
    problem = formulate_problem(spec, spec.objectives()[0])
    state = optimise(problem, 5e-3, proof=ProofBudget(0, 1.0))
    state = replace(state, tolerance=1e-3, proof_deadline=np.inf, last_program=np.inf)
    root = TracedNode.root(state)
    assert root is not None
    _, node = tighten(state, solve_relaxation(state, root), 1)
    assert node.relaxation is not None
    cam, x = node.relaxation[0], np.linspace(0.0, 1.0, SAMPLES + 1)
    found = _violation_peaks(cam, 2)
    assert any(map(len, found))
    for position, places in enumerate(found):
        assert np.all(np.isin(places, node.violated[position]))
        assert np.all(np.isin(places, x))
        assert np.all(excess(cam, position, places) > 0.0)
    # the pressure angle has rows of the first derivative; where that is the control's own
    # derivative, multipliers make ψ jump, and no points are added
    assert not any(map(len, _violation_peaks(cam, 1)))


def test_multipliers_that_say_nothing_bound_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the cap on a mean square has no multiplier, no derivative of a law is weighed."""
    solve = traced_relaxation.solve
    calls = list[int]()

    def without_multipliers(program: ConeProgram, time_limit: float) -> ConeSolution:
        found = solve(program, time_limit)
        calls.append(len(found.multipliers))
        return replace(found, multipliers=0.0 * found.multipliers)

    monkeypatch.setattr(traced_relaxation, "solve", without_multipliers)
    scene = random_scene("no objective, swinging face, pivot in a range", 7)
    design = synthesise(DesignSpec.model_validate({**scene, "proof": "auto"}))
    assert design.status == "feasible"
    assert design.certificate is not None
    assert design.certificate.certified
    assert calls
