"""The bound of a neighbouring problem by the same multipliers: never false, and near at hand."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from math import inf, sqrt
from typing import Any

import numpy as np
import pytest

from synthesis.optimise.conic.program import formulate
from synthesis.optimise.driver import optimise
from synthesis.optimise.dual_bound.bound import dual_bound
from synthesis.optimise.dual_bound.sensitivity import neighbour
from synthesis.optimise.problem.problem import Problem, formulate_problem
from synthesis.optimise.state import SolveState
from synthesis.spec.design_spec import DesignSpec
from tests.hard.families import random_scene
from tests.optimise.dual_bound.test_bound import SYMMETRIC
from tests.optimise.scenes import (
    PLAIN,
    TURNING,
    acceleration,
    angles,
    direct,
    dwell,
    even,
    fall,
    jerk,
    problem,
    rise,
    scene,
    uneven,
    velocity,
)

Body = dict[str, Any]
SCENES: dict[str, DesignSpec] = {
    "jerk": scene(PLAIN, angles(27.1, 31.3), jerk(53.0, 71.7)),
    "turning": scene(TURNING, angles(24.7, 29.0), jerk(71.3, 131.7)),
    "acceleration": scene(PLAIN, angles(27.1, 31.3), acceleration(4.9, 71.7)),
    "velocity": scene(PLAIN, angles(33.0, 30.1), velocity(1.61, 71.7), jerk(61.0, 71.7)),
    "offset": scene(PLAIN, angles(27.1, 31.3), jerk(53.0, 71.7), offset={"min": -3.1, "max": 9.7}),
}  # fmt: skip


def changed(spec: DesignSpec, factor: float) -> DesignSpec:
    """The last limit's number times a factor."""
    body = spec.model_dump(mode="json", exclude_unset=True)
    last = body["limits"][-1]
    name = next(key for key in last if key.startswith("max_"))
    last[name] *= factor
    return DesignSpec.model_validate(body)


def steeper(spec: DesignSpec, factor: float) -> DesignSpec:
    """The pressure angle of the rise times a factor."""
    body = spec.model_dump(mode="json", exclude_unset=True)
    body["limits"][0]["rise_deg"] *= factor
    return DesignSpec.model_validate(body)


@cache
def solved(name: str, tolerance: float) -> SolveState:
    state = optimise(problem(SCENES[name]), tolerance)
    assert state.bound is not None
    return state


@cache
def neighbours(name: str, change: Any) -> list[tuple[Problem, float | None]]:
    """Two questions next to a scene's, and their least values; the same at every tolerance."""
    found = []
    for factor in np.random.default_rng(len(name)).uniform(0.8, 1.25, 2):
        other = problem(change(SCENES[name], factor))
        best = optimise(other, 3e-3).incumbent
        found.append((other, best and best.value))
    return found


@pytest.mark.parametrize("tolerance", [3e-3, 1e-5])
@pytest.mark.parametrize("change", [changed, steeper])
@pytest.mark.parametrize("name", SCENES)
def test_no_cam_of_a_neighbour_is_below_its_bound(name: str, change: Any, tolerance: float) -> None:
    state = solved(name, tolerance)
    for other, least in neighbours(name, change):
        found = state.bound_of_neighbour(other)
        assert found > -inf
        assert least is None or found <= least * (1.0 + 1e-9)


@pytest.mark.parametrize("tolerance", [3e-3, 1e-5])
@pytest.mark.parametrize("name", SCENES)
def test_at_the_same_numbers_it_is_the_bound_known(name: str, tolerance: float) -> None:
    state = solved(name, tolerance)
    assert state.bound_of_neighbour(state.problem) == pytest.approx(state.lower, rel=1e-9)


@pytest.mark.parametrize("name", ["jerk", "turning", "velocity"])
def test_it_is_off_by_the_square_of_a_change_of_a_cap(name: str) -> None:
    state = solved(name, 1e-5)
    for change in (1e-3, -1e-3):
        other = problem(changed(SCENES[name], 1.0 + change))
        near = optimise(other, 1e-5)
        assert near.incumbent is not None
        missing = near.incumbent.value / state.bound_of_neighbour(other) - 1.0
        assert -1e-9 <= missing < 3e-5 + 10.0 * change**2
        assert abs(near.lower - state.lower) > 2.0 * missing * state.lower  # and that is a gain


def test_the_least_jerk_under_caps_of_acceleration_near_one_another() -> None:
    """J with a = J/4 (1 − √(1 − 32/J)), in closed form: the bound stays below, by a square."""

    def of(share: float) -> tuple[Problem, float]:
        cap = share / 4.0 * (1.0 - sqrt(1.0 - 32.0 / share))
        spec = scene(SYMMETRIC, acceleration(cap, 71.7), objective="peak_jerk")
        return problem(spec), share

    state = optimise(of(57.3)[0], 1e-7)
    for share in (52.9, 56.8, 57.0, 57.6, 61.7):
        other, exact = of(share)
        ratio = state.bound_of_neighbour(other) / state.lower * 57.3 / exact
        assert 1.0 - 2.0 * (share / 57.3 - 1.0) ** 2 - 1e-6 < ratio < 1.0 + 3e-7


def test_other_rows_are_no_neighbours() -> None:
    state = solved("jerk", 1e-5)
    assert state.bound_of_neighbour(problem(SCENES["velocity"])) == -inf  # one limit more
    assert state.bound_of_neighbour(problem(SCENES["turning"])) == -inf  # one dwell less
    spec = scene(PLAIN, angles(27.1, 31.3), jerk(53.0, 71.7), objective="peak_jerk")
    assert state.bound_of_neighbour(problem(spec)) == -inf
    steep = problem(
        scene(PLAIN, jerk(53.0, 71.7), objective="peak_pressure_angle", base={"max": 70.0})
    )
    assert neighbour(formulate(steep, even(steep, 9), 0.5), steep) is None  # rows of one level
    one = (rise(71.7), dwell(23.9), fall(83.3, law="cycloidal"), dwell(181.1))
    given = problem(scene(one, angles(27.1, 31.3), jerk(95.0, 71.7)))
    assert state.bound_of_neighbour(given) == -inf
    proven = state.raise_bound(1.01 * state.lower, "something else")
    assert proven.bound_of_neighbour(state.problem) == -inf


def test_a_bound_for_every_size_has_no_multipliers_of_rows_with_the_size() -> None:
    """Where a largest base radius is given, those may have multipliers: there are more of them."""
    limits = angles(13.1, 14.3), acceleration(4.9, 71.7)
    spec, given = (
        scene(PLAIN, *limits, objective="peak_jerk", base=base) for base in (None, {"max": 1e5})
    )
    state = optimise(problem(spec), 1e-6)
    assert state.problem.for_every_size
    best = optimise(problem(given), 1e-6).incumbent
    assert best is not None
    assert state.bound_of_neighbour(problem(given)) <= best.value * (1.0 + 1e-9)


def test_a_program_with_tangent_rows_at_its_own_cams_has_other_rows_than_a_neighbour() -> None:
    question = problem(DesignSpec.model_validate(random_scene("arm, pivot given", 1)))
    assert question.has_curved_limits
    state = optimise(question, 1e-2)
    assert state.relaxation is not None
    bound = state.relaxation[2]
    assert bound.of_neighbour is not None
    assert bound.of_neighbour(question) is None


def test_a_bound_over_splines_alone_says_nothing_of_neighbours() -> None:
    spec = scene(PLAIN, angles(27.1, 31.3))
    own = formulate_problem(spec, spec.objectives()[0])
    found = direct(own, uneven(own, 5))
    bound = dual_bound(found.model, found.solution)
    assert bound.switching == ()
    state = replace(solved("jerk", 1e-5), problem=own, lower=-inf, grids=found.model.grids)
    assert state.with_bound(bound).bound_of_neighbour(own) == -inf
