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
from synthesis.optimise.refinement import mesh, polish
from tests.hard.families import random_scene
from tests.optimise.scenes import (
    PLAIN,
    acceleration,
    angles,
    dwell,
    fall,
    jerk,
    problem,
    rise,
    scene,
    velocity,
)


def test_laws_without_a_switch_get_no_mesh_of_their_switches(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A law that time has ended for may be as smooth as its mesh: nothing tells where knots go."""
    state: Any = SimpleNamespace(
        relaxation=(None, None, None), relaxed=object(), problem=None, time_left=1.0,
        is_close=lambda cam: False,
    )  # fmt: skip
    monkeypatch.setattr(polish, "control_order", lambda problem: 3)
    monkeypatch.setattr(polish, "_with_best_multipliers", lambda state: ("raised", state))

    def solve_once(state: Any, number: int) -> Any:
        pytest.fail("a program without a mesh")

    assert polish._improve_multipliers(state, (), solve_once) == ("raised", state)


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

    monkeypatch.setattr(polish, "control_order", lambda problem: 3)
    monkeypatch.setattr(polish, "_through_switches", lambda *_: intervals(100))
    monkeypatch.setattr(polish, "_with_best_multipliers", lambda state: "raised")
    state: Any = State()
    assert polish._improve_multipliers(
        state, [np.zeros(1)], lambda state, number: (state, None)
    ) is (state)


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
    monkeypatch.setattr(polish, "_move_knots", lambda *_: (polished, ()))
    monkeypatch.setattr(polish, "_improve_multipliers", lambda *_: pytest.fail("a bound"))
    assert polish.polish_knots(state, lambda *_: pytest.fail("a program")) is (
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


KNOTS = np.array([0.0, 0.1, 0.2, 0.25, 0.302, 0.35, 0.4, 0.6, 1.0])


def _means(high: float, start: float, end: float, low: float, knots: np.ndarray = KNOTS) -> Any:
    """Means over intervals of a derivative: high, 0 along an arc from start to end, then low."""
    integral = high * np.minimum(knots, start) + low * np.maximum(knots - end, 0.0)
    return np.diff(integral) / np.diff(knots)


@pytest.mark.parametrize(("high", "low"), [(1.0, -1.0), (2.0, -1.0), (-1.3, 1.9)])
def test_a_step_that_stays_spread_about_its_knot_is_a_short_arc(high: float, low: float) -> None:
    level, none = _means(high, 0.297, 0.308, low), np.zeros(0)
    (first,) = polish._locate_switches(KNOTS, level, none)
    assert 0.297 < first < 0.308  # where the derivative has the same integral
    ends = polish._locate_switches(KNOTS, level, np.array([0.302]))
    assert ends == pytest.approx([0.297, 0.308], abs=1e-12)


@pytest.mark.parametrize(("left", "right"), [(0.297, 0.306), (0.299, 0.308), (0.294, 0.311)])
def test_an_arc_keeps_both_its_ends(left: float, right: float) -> None:
    """What its own mean is beyond 0 belongs to the step before or to the one behind."""
    knots = np.array([0.0, 0.1, 0.2, 0.25, left, right, 0.35, 0.4, 0.6, 1.0])
    level, ends = _means(1.0, 0.297, 0.308, -1.0, knots), np.array([left, right])
    assert len(polish._locate_switches(knots, level, np.zeros(0))) == 1
    found = polish._locate_switches(knots, level, ends)
    outside = left < 0.297 and right > 0.308  # as much too far on either side: nothing tells
    assert found == pytest.approx(ends if outside else [0.297, 0.308], abs=1e-12)


@pytest.mark.parametrize("at", [0.29, 0.31])
def test_a_step_beside_its_knot_moves_there(at: float) -> None:
    found = polish._locate_switches(KNOTS, _means(1.0, at, at, -1.0), np.array([0.302]))
    assert found == pytest.approx([at], abs=1e-12)


def test_a_step_to_an_arc_of_the_same_sign_is_one() -> None:
    """As from a cap to where a pressure angle binds."""
    level = _means(1.0, 0.31, 0.31, 0.0) + 0.05 * (KNOTS[1:] > 0.302)
    assert len(polish._locate_switches(KNOTS, level, np.array([0.302]))) == 1


@pytest.mark.parametrize("cap", [1.0, -1.7])
def test_a_derivative_that_comes_back_to_its_cap_has_both_ends_of_the_arc(cap: float) -> None:
    level = np.full(8, cap)
    level[3] = 0.85 * cap  # 15 % of [0.25, 0.302] are missing
    found = polish._locate_switches(KNOTS, level, np.zeros(0))
    assert found == pytest.approx([0.276 - 0.0039, 0.276 + 0.0039], abs=1e-12)
    # With knots there, at whatever level it is between them, it is wider by what is missing beside.
    knots = np.array([0.0, 0.1, 0.2, 0.25, *found, 0.35, 0.4, 0.6, 1.0])
    level = np.array([1.0, 1.0, 1.0, 0.95, -0.5, 0.98, 1.0, 1.0, 1.0]) * cap
    wider = polish._locate_switches(knots, level, found)
    left, right = found[0] - 0.25, 0.35 - found[1]
    assert wider == pytest.approx(
        [found[0] - 0.05 / 1.5 * left, found[1] + 0.02 / 1.5 * right], abs=1e-12
    )
    assert len(polish._locate_switches(KNOTS, np.full(8, cap), found)) == 0


def test_between_two_knots_at_a_cap_lies_no_arc() -> None:
    level = np.array([1.0, 1.0, 1.0, 0.5, 1.0, 0.5, 1.0, 1.0])
    assert len(polish._locate_switches(KNOTS, level, KNOTS[[4, 5]])) == 0


def test_the_ramps_at_both_ends_are_no_part_of_a_step_next_to_them() -> None:
    ramp = 4e-5
    knots = np.array([0.0, ramp, 0.02, 0.04, 0.06, 0.3, 0.6, 0.94, 0.96, 1.0 - ramp, 1.0])
    level = _means(1.0, 0.044, 0.95, -1.0, knots)
    level[0], level[-1] = 0.5, -0.5
    found = polish._locate_switches(knots, level, np.zeros(0))
    assert found == pytest.approx([0.044, 0.95], abs=1e-12)


@pytest.mark.parametrize("slope", [-0.3, -1.0, -1.4, -6.0])
def test_knots_on_either_side_of_a_switch_in_turn_come_to_lie_on_it(slope: float) -> None:
    switch, before = np.array([0.3, 0.7]), np.array([0.29, 0.71])

    def found(knots: Any) -> Any:
        return switch + slope * (knots - switch)

    knots = found(before)
    result = polish._extrapolate([before], [knots], [knots], [found(knots)])
    assert result[0] == pytest.approx(switch, abs=1e-12)


def test_knots_that_would_go_ever_farther_come_to_lie_on_a_switch(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    switch = np.array([0.3, 0.7])

    def switches(cam: Any, order: int, before: Any = ()) -> Any:
        return (switch - 1.4 * (cam.knots - switch),)

    def law_with(knots: Any, more: float = 0.0) -> Any:
        value = 1.0 + more + np.max(np.abs(knots - switch))
        return SimpleNamespace(laws=(), knots=knots, value=value)

    @dataclass(frozen=True)
    class State:
        problem: Any = None
        tolerance: float = 1e-6
        time_left: float = 1.0
        grids: Any = ()
        stages: tuple[Any, ...] = ()
        suffices: bool = False
        relaxed: Any = None

        def is_close(self, cam: Any) -> bool:
            return False

        def problem_tolerance(self, value: float) -> float:
            return self.tolerance

    monkeypatch.setattr(polish, "control_order", lambda problem: 3)
    monkeypatch.setattr(polish, "_switches_of_laws", switches)
    monkeypatch.setattr(polish, "_through_switches", lambda problem, each, *_: each[0])
    state: Any = State()
    _, found = polish._move_knots(
        state,
        law_with(np.array([0.31, 0.68]), 0.1),  # on equal intervals
        lambda state, _: (state, law_with(state.grids)),
    )
    assert found[0] == pytest.approx(switch, abs=1e-9)


def test_knots_that_come_nearer_from_one_side_go_on() -> None:
    x, y, z = np.array([0.29]), np.array([0.295]), np.array([0.2975])
    assert polish._extrapolate([x], [y], [y], [z])[0] == pytest.approx(z)
    assert polish._extrapolate([y], [y], [y], [z])[0] == pytest.approx(z)  # knots that stayed
    two = [np.array([0.29, 0.3])]
    assert polish._extrapolate([x], [y], [y], two) is two
    assert polish._extrapolate([], [y], [y], [z])[0] is z


def test_a_step_from_an_arc_to_a_cap_is_one() -> None:
    """A pressure angle binds along a jerk that is next to nothing: no second arc is found there."""
    level = _means(1.0, 0.29, 0.29, -1.0)
    level[:5] = 0.01, 0.01, 0.01, -0.5, -0.9
    assert len(polish._locate_switches(KNOTS, level, np.array([0.302]))) == 1


@pytest.mark.parametrize(
    ("rise_deg", "jerk_factor"),
    [
        (33.31, 43.96),  # the acceleration is at its cap for 0.4 % of the return alone
        (34.21, 58.16),
        (30.8, 78.05),
    ],
)
def test_a_law_with_short_arcs_between_its_caps_is_next_to_the_best(
    rise_deg: float, jerk_factor: float
) -> None:
    """One knot in place of such an arc leaves a gap of 2e-4."""
    moves, h, angle = (rise(102.0, 20.3), dwell(49.7), fall(82.1, 20.3), dwell(126.2)), 20.3, 82.1
    caps = velocity(2.18, angle, h), acceleration(8.704, angle, h), jerk(jerk_factor, angle, h)
    found = optimise(problem(scene(moves, angles(rise_deg, 28.7), *caps, roller=9.91)), 1e-5)
    assert found.covers_all_laws
    assert 0.0 < found.relaxation_gap < 2e-6


def test_laws_whose_acceleration_switches_have_knots_where_it_does() -> None:
    """Without a cap on the jerk the acceleration goes from cap to cap, in ramps of a C2 law."""
    question = problem(scene(PLAIN, angles(34.7, 37.1), acceleration(6.3, 71.7)))
    assert control_order(question) == 2
    found = optimise(question, 1e-5)
    assert found.covers_all_laws
    assert 0.0 < found.relaxation_gap < 1e-5


@pytest.mark.parametrize("smoothness", [3, 4])
@pytest.mark.parametrize("share", [6.3, 9.1])
def test_a_smoother_law_reaches_its_cap_on_acceleration(smoothness: int, share: float) -> None:
    """Rows written at points miss some hundredths between those of a coarse mesh: no margin of
    that size is left on the last one.
    """
    program = tuple(
        {**move, "law": {"kind": "spline", "smoothness": smoothness}} if "law" in move else move
        for move in PLAIN
    )
    limits = angles(34.7, 37.1), acceleration(share, 71.7)
    found, rough = (optimise(problem(scene(p, *limits)), 1e-4) for p in (program, PLAIN))
    assert found.covers_all_laws
    assert found.relaxed is not None
    assert rough.relaxed is not None
    assert found.relaxed.value == pytest.approx(rough.relaxed.value, rel=4e-4)
    assert 0.0 < found.relaxation_gap < 6e-4


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
