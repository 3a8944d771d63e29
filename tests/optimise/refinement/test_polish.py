"""The last digits of a bound: knots on the switches of laws that have some."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from synthesis import DesignSpec, synthesise
from synthesis.optimise.driver import optimise
from synthesis.optimise.problem.derivative_caps import control_order
from synthesis.optimise.refinement import mesh
from tests.hard.families import random_scene
from tests.optimise.scenes import PLAIN, acceleration, angles, jerk, problem, scene


def test_laws_without_a_switch_get_no_mesh_of_their_switches(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A law that time has ended for may be as smooth as its mesh: nothing tells where knots go."""
    state: Any = SimpleNamespace(
        relaxation=(None, None, None), relaxed=object(), problem=None, time_left=1.0,
        is_close=lambda cam: False,
    )  # fmt: skip
    monkeypatch.setattr(mesh, "grids_on_switches", lambda *_: ())
    monkeypatch.setattr(mesh, "_with_best_multipliers", lambda state: ("raised", state))

    def solve_once(state: Any, number: int) -> Any:
        pytest.fail("a program without a mesh")

    assert mesh._improve_multipliers(state, solve_once) == ("raised", state)


def test_where_no_law_fits_on_few_knots_the_multipliers_stay(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The program of the best ones takes seconds on many."""

    def intervals(count: int) -> Any:
        return (SimpleNamespace(space=SimpleNamespace(breaks=range(count + 1))),)

    @dataclass(frozen=True)
    class State:
        relaxation: Any = (SimpleNamespace(grids=intervals(800)), None, None)
        relaxed: Any = "cam"
        problem: Any = None
        time_left: float = 1.0
        grids: Any = ()
        stages: tuple[Any, ...] = ()

        def is_close(self, cam: Any) -> bool:
            return False

    monkeypatch.setattr(mesh, "grids_on_switches", lambda *_: intervals(100))
    monkeypatch.setattr(mesh, "_with_best_multipliers", lambda state: "raised")
    state: Any = State()
    assert mesh._improve_multipliers(state, lambda state, number: (state, None)) is state


@pytest.mark.parametrize(("tolerance", "moved"), [(1e-2, False), (1e-5, True)])
def test_a_search_for_a_cam_alone_moves_knots_for_its_digits_at_most(
    monkeypatch: pytest.MonkeyPatch, tolerance: float, moved: bool
) -> None:
    """Nobody asks for its bound."""
    problem = SimpleNamespace(
        free=(1,), has_curved_limits=False, objective=SimpleNamespace(quasiconvex=False)
    )
    cam = SimpleNamespace(value=1.1)
    state: Any = SimpleNamespace(
        relaxed=cam, incumbent=cam, lower=0.5, tolerance=tolerance, cam_only=True, problem=problem,
        is_close=lambda cam: False, suffices=False, covers_all_laws=True,
    )  # fmt: skip
    polished: Any = SimpleNamespace(suffices=False, cam_only=True)
    monkeypatch.setattr(mesh, "_move_knots", lambda *_: polished)
    monkeypatch.setattr(mesh, "_improve_multipliers", lambda *_: pytest.fail("a bound"))
    assert mesh.polish_knots(state, lambda *_: pytest.fail("a program")) is (
        polished if moved else state
    )


def test_a_law_on_arcs_is_next_to_the_best_to_a_millionth() -> None:
    """Pressure angles bind along arcs: what knots cost there falls as their number squared."""
    question = problem(scene(PLAIN, angles(31.0, 43.0), jerk(47.0, 71.7)))
    found = optimise(question, 3e-7)
    assert found.covers_all_laws
    assert 0.0 < found.relaxation_gap < 2e-6
    # one program, on few knots, gives the multipliers: on many it takes long and gains nothing
    assert [stage.stage for stage in found.stages].count("multipliers") == 1


@pytest.mark.parametrize("smoothness", [3, 4])
def test_laws_with_ramps_have_the_bound_of_those_that_switch(smoothness: int) -> None:
    """Any law of class C3 or C4 is one of class C2, and comes as near to the best as it likes."""
    limits = angles(34.7, 37.1), jerk(40.0, 71.7)
    sharp = optimise(problem(scene(PLAIN, *limits)), 3e-7)
    moves = [
        {**move, "law": {**move["law"], "smoothness": smoothness}} if "law" in move else move
        for move in PLAIN
    ]
    smooth = optimise(problem(scene(moves, *limits)), 3e-6)
    assert smooth.covers_all_laws
    assert sharp.incumbent is not None
    assert smooth.incumbent is not None
    best = sharp.incumbent.value
    assert best * (1.0 - 2e-6) <= smooth.lower <= best
    assert smooth.incumbent.value <= best * (1.0 + 1e-4)  # ramps of 4e-5 cost 3e-4


def test_laws_whose_acceleration_switches_have_knots_where_it_does() -> None:
    """Without a cap on the jerk the acceleration goes from cap to cap, in ramps of a C2 law."""
    question = problem(scene(PLAIN, angles(34.7, 37.1), acceleration(6.3, 71.7)))
    assert control_order(question) == 2
    found = optimise(question, 1e-5)
    assert found.covers_all_laws
    assert 0.0 < found.relaxation_gap < 1e-5


def test_points_are_added_where_a_law_breaks_rows_between_them() -> None:
    """A size fitted to the whole law hides that: the cam would be larger than its laws need."""
    body = {**random_scene("slide, offset given", 2), "tolerance": 1e-5, "proof": "quick"}
    proven = synthesise(DesignSpec.model_validate(body)).certificate
    assert proven.value is not None
    assert proven.lower_bound is not None
    assert 0.0 <= proven.value / proven.lower_bound - 1.0 < 1e-5


def test_a_mesh_on_which_nothing_is_lost_is_halved(monkeypatch: pytest.MonkeyPatch) -> None:
    question = problem(scene(PLAIN, angles(31.0, 43.0), jerk(47.0, 71.7)))
    found = optimise(question, 0.5)
    assert found.relaxation is not None
    grids, cam, (_, _, bound) = found.grids, found.incumbent, found.relaxation
    assert cam is not None
    assert bound.switching
    nothing = [np.zeros(len(grid.space.breaks) - 1) for grid in grids]
    monkeypatch.setattr(mesh, "_losses", lambda *_: nothing)
    finer = mesh.refine_mesh(question, grids, cam, bound)
    expected = mesh.halve_intervals(question, grids)
    for one, other in zip(finer, expected, strict=True):
        assert np.array_equal(one.space.breaks, other.space.breaks)
