"""Problems with longer moves bound boxes of angles; the boxes about some numbers hold all."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from math import inf
from typing import Any

import numpy as np
import pytest

from synthesis.numerics import clock
from synthesis.numerics.piecewise import Array
from synthesis.optimise.driver import optimise
from synthesis.optimise.parameters import search
from synthesis.optimise.parameters.longer_moves import LongerMoves
from synthesis.optimise.parameters.number_search import Box
from synthesis.optimise.parameters.value_function import ValueFunction
from synthesis.optimise.state import QUICK, SolveState
from tests.optimise.parameters.test_number_search import (
    CASES,
    PRESSURE,
    angles,
    dwell,
    move,
    of_body,
)

TOLERANCE = 5e-3
RADIUS = {"kind": "profile_radius", "min_mm": 4.4}
JERK = {"kind": "jerk", "max_mm_per_s3": 1.9e7}
CURVED: dict[str, dict[str, Any]] = {
    # one free direction, the size one number
    "two": {**CASES["angles"], "limits": [PRESSURE, JERK, RADIUS]},
    # no dwell above; the offset couples the laws; a dwell is free as well: two directions
    "coupled": {
        "program": [move("rise", angles(60.0, 90.0), 28.2),
                    move("return", angles(62.0, 92.0), 28.2), dwell(angles(190.0, 230.0))],
        "limits": [PRESSURE, JERK, RADIUS],
        "follower": {"kind": "translating_roller", "roller_radius_mm": 11.2},
    },
}  # fmt: skip


@cache
def question(name: str) -> tuple[ValueFunction, LongerMoves]:
    return longer_moves_of(CURVED[name])


def longer_moves_of(changes: dict[str, Any]) -> tuple[ValueFunction, LongerMoves]:
    worth, placement = of_body(changes)
    return worth, LongerMoves(
        placement, worth.state, unknown, 0.95 * TOLERANCE, 0.4 * TOLERANCE, QUICK
    )


def unknown(box: Box, target: float) -> tuple[float, Array]:
    """No bound without curvature: that of longer moves is to be seen alone."""
    return -inf, 0.5 * (box.low + box.high)


def _serves(changes: dict[str, Any]) -> bool:
    return longer_moves_of(changes)[1].serves()


def points(longer: LongerMoves, count: int) -> list[Array]:
    """Random numbers that the equation allows."""
    corners = longer.placement.polytope.corners(9)
    shares = np.random.default_rng(5).dirichlet(np.full(len(corners), 0.6), count)
    return [np.asarray(share @ np.array(corners)) for share in shares]


@pytest.mark.parametrize("name", CURVED)
def test_no_cam_of_a_box_is_smaller_than_the_bound_of_longer_moves(name: str) -> None:
    worth, longer = question(name)
    assert longer.serves()
    for u in points(longer, 1):
        state = worth.state(u, TOLERANCE)
        assert state is not None
        assert state.incumbent is not None
        step = np.random.default_rng(2).uniform(0.0, 0.2, len(u))
        high = np.minimum(u + step, 1.0)
        bound = optimise(longer.problem(high), TOLERANCE)
        assert bound.covers_all_laws
        assert bound.lower <= state.incumbent.value * (1.0 + 1e-9)
        # the box of the numbers alone has the bound there
        own = optimise(longer.problem(u), TOLERANCE)
        assert own.lower == pytest.approx(state.lower, rel=1e-3)


@pytest.mark.parametrize("name", CURVED)
def test_the_boxes_about_some_numbers_hold_all(name: str) -> None:
    longer = question(name)[1]
    known = points(longer, 5)
    for u in (*known, *longer.placement.polytope.corners(4)):
        boxes = [box for _, box in longer._cover(np.asarray(u))]
        assert all(any(holds(box, other) for box in boxes) for other in known)


def holds(box: Box, u: Array) -> bool:
    return bool(np.all(u >= box.low - 1e-7) and np.all(u <= box.high + 1e-7))


def test_where_curvature_decides_the_gap_over_all_angles_closes() -> None:
    worth, longer = question("two")
    centre = longer.placement.polytope.centre()
    assert centre is not None
    proof = longer.run(centre, clock.programs_solved(), inf)
    assert proof is not None
    assert proof.cam is not None
    assert proof.lower <= proof.value
    assert proof.gap <= 2.0 * TOLERANCE
    # cams at these numbers and at others are not below the bound
    for other in points(longer, 2):
        state = worth.state(proof.u + 0.03 * (other - proof.u), TOLERANCE)
        assert state is not None
        assert state.incumbent is not None
        assert state.incumbent.value >= proof.lower


def test_the_numbers_are_those_at_which_laws_ask_for_equal_sizes() -> None:
    longer = question("two")[1]
    centre = longer.placement.polytope.centre()
    assert centre is not None
    u = longer._balanced(centre, inf)
    first, second = (longer._asked(k, u[k], inf) for k in range(2))
    assert first == pytest.approx(second, abs=0.1 * TOLERANCE)


def test_it_does_not_serve_what_the_theorem_leaves_out() -> None:
    """Free lifts; a force that depends on the cam angle; a law that rests at neither end."""
    assert not _serves(CASES["lifts"])
    load = {"kind": "slide", "moving_mass_kg": 1.0, "spring": {"rate_n_per_mm": 3.0,
            "preload_n": 900.0}}  # fmt: skip
    # of a torque there are no rows, which would tell that they differ with the place
    limits = [PRESSURE, JERK, {"kind": "camshaft_torque", "max_n_m": 900.0}]
    constant = {**CURVED["two"], "limits": limits, "load": load}
    assert _serves(constant)
    course = [{"angle_deg": 0.0, "force_n": 0.0}, {"angle_deg": 90.0, "force_n": 70.0}]
    assert not _serves({**constant, "load": {**load, "process": course}})
    fast = {"velocity_mm_per_s": 80.0}
    gliding = {
        "program": [{**move("rise", 70.0, 14.0), "end": fast},
                    {**move("rise", angles(30.0, 60.0), 8.0), "start": fast, "end": fast},
                    {**move("rise", 70.0, 14.0), "start": fast}, dwell(20.0),
                    move("return", angles(80.0, 120.0), 36.0), dwell(37.0)],
        "limits": [PRESSURE, JERK],
    }  # fmt: skip
    assert not _serves(gliding)


def test_a_finer_tolerance_has_the_answer_of_the_rough_one() -> None:
    """Where there is time for no search to the finer one, the rough one's numbers and cam stay."""
    worth, rough = question("two")
    centre = rough.placement.polytope.centre()
    assert centre is not None
    known = rough.run(centre, clock.programs_solved(), inf)
    assert known is not None

    def while_rough(u: Array, gap: float) -> Any:
        return worth.state(u, gap) if gap >= 0.39 * TOLERANCE else None

    finer = replace(
        rough, solve_at=while_rough, tolerance=0.05 * rough.tolerance,
        single=0.05 * rough.single, known={}, asked={},
    )  # fmt: skip
    found = finer.run(centre, clock.programs_solved(), inf)
    assert found is not None
    assert found.value == pytest.approx(known.value, rel=1e-6)
    assert found.lower == pytest.approx(known.lower, rel=1e-3)


def test_without_a_bound_of_a_box_the_cam_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    longer = question("two")[1]
    centre = longer.placement.polytope.centre()
    assert centre is not None
    bounded = LongerMoves._bound

    def of_few_laws(self: LongerMoves, *given: Any) -> SolveState:
        return replace(bounded(self, *given), covers_all_laws=False)

    monkeypatch.setattr(LongerMoves, "_bound", of_few_laws)
    found = longer.run(centre, clock.programs_solved(), inf)
    assert found is not None
    assert found.cam is not None
    assert found.lower == -inf


def test_the_best_numbers_stay_where_descents_find_none(monkeypatch: pytest.MonkeyPatch) -> None:
    """As where the time ends before them."""
    worth, _ = question("coupled")
    middle = worth.free_parameters.polytope.centre()
    assert middle is not None
    monkeypatch.setattr(search, "_descend", lambda *_: None)
    monkeypatch.setattr(LongerMoves, "run", lambda *_: None)
    monkeypatch.setattr(search, "FIRST_PROGRAMS", 6)
    best, proof = search._search_program(worth, middle, inf, QUICK)
    assert proof is not None
    assert proof.gap > search.LITTLE  # it went on to them
    assert best is not None
    assert np.array_equal(best.u, proof.u)
