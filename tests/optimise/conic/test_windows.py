"""Windows and points in the cone program: other statements of the same, and the bound over laws."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import pi
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from synthesis.numerics.bspline import SplineSpace
from synthesis.numerics.solvers.clarabel import solve
from synthesis.numerics.solvers.statuses import StopReason
from synthesis.optimise.conic.program import formulate
from synthesis.optimise.dual_bound.bound import Bound, dual_bound
from synthesis.optimise.problem.grid import CLOSEST_KNOTS, RAMP_STEP, merge_knots, uniform_grid
from synthesis.spec.design_spec import DesignSpec
from tests.optimise.conic.reference import optimum
from tests.optimise.scenes import (
    LIFT,
    OMEGA,
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
    velocity,
)

UP, DOWN = 71.7, 83.3
V = LIFT / (UP * pi / 180.0) * OMEGA  # mean velocity of the rise
A, J = V * OMEGA / (UP * pi / 180.0), V * (OMEGA / (UP * pi / 180.0)) ** 2


def window(first: float, last: float, **bounds: Any) -> dict[str, Any]:
    return {"from_deg": first, "to_deg": last, **bounds}


def point(angle: float, travel: float, **more: Any) -> dict[str, Any]:
    return {"angle_deg": angle, "travel_mm": travel, **more}


def cam(
    *limits: dict[str, Any],
    up: Sequence[dict[str, Any]] = (),
    down: Sequence[dict[str, Any]] = (),
    through: Sequence[dict[str, Any]] = (),
    back: Sequence[dict[str, Any]] = (),
    objective: str = "base_radius",
    base: Any = None,
    **free: Any,
) -> DesignSpec:
    program = (
        {**rise(UP, **free), "windows": list(up), "points": list(through)},
        dwell(23.9),
        {**fall(DOWN, **free), "windows": list(down), "points": list(back)},
        dwell(181.1),
    )
    return scene(program, *limits, objective=objective, base=base)


LEAST = {"min": 4.3}  # without it, nothing would keep a cam of free laws from shrinking
SIZED = (angles(29.3, 41.7), jerk(97.0, UP))
LOOSE = (angles(29.3, 41.7), jerk(331.0, UP))
CASES: dict[str, DesignSpec] = {
    "exact point": cam(*SIZED, through=[point(23.3, 9.1)]),
    "point with a tolerance": cam(*SIZED, through=[point(23.3, 9.1, tolerance_mm=0.43)]),
    "point with a velocity": cam(
        *SIZED, back=[point(41.3, 12.9, velocity_mm_per_s=-1.61 * V)]
    ),
    "points on both": cam(
        *SIZED, through=[point(23.3, 7.7), point(47.9, 20.3)], back=[point(31.7, 8.3)]
    ),
    "velocity held": cam(*SIZED, up=[window(24.3, 37.1, velocity_mm_per_s=1.43 * V)]),
    "velocity held on the return": cam(
        *SIZED, down=[window(33.1, 49.7, velocity_mm_per_s=-1.13 * V)]
    ),
    "stands still on the way": cam(*LOOSE, up=[window(30.3, 35.1, velocity_mm_per_s=0.0)]),
    "travel held": cam(*LOOSE, up=[window(30.3, 35.1, travel_mm=13.3)]),
    "acceleration held": cam(*SIZED, up=[window(11.3, 20.9, acceleration_mm_per_s2=3.1 * A)]),
    "velocity between": cam(
        *SIZED, up=[window(24.3, 37.1, velocity_mm_per_s={"min": 1.2 * V, "max": 1.3 * V})]
    ),
    "acceleration above": cam(
        *SIZED, down=[window(8.3, 20.1, acceleration_mm_per_s2={"min": -2.3 * A})]
    ),
    "jerk between": cam(
        *SIZED, up=[window(0.0, 11.9, jerk_mm_per_s3={"min": -9.0 * J, "max": 31.0 * J})]
    ),
    "travel below": cam(*SIZED, up=[window(20.3, 27.7, travel_mm={"max": 6.1})]),
    "two that overlap": cam(
        *SIZED,
        up=[
            window(20.3, 37.7, velocity_mm_per_s={"max": 1.15 * V}),
            window(30.1, 45.3, velocity_mm_per_s={"max": 1.7 * V}, travel_mm={"min": 9.0}),
        ],
    ),
    "all along": cam(*SIZED, up=[window(0.0, UP, acceleration_mm_per_s2={"min": -5.1 * A})]),
    "peak acceleration": cam(
        objective="peak_acceleration", base=51.3, up=[window(24.3, 37.1, velocity_mm_per_s=V)]
    ),
    "peak acceleration, bounded in the window": cam(
        objective="peak_acceleration", base=51.3,
        up=[window(9.3, 19.1, acceleration_mm_per_s2={"max": 1.9 * A})],
    ),
    "peak acceleration under a jerk cap": cam(
        jerk(151.0, UP), objective="peak_acceleration", base=51.3, through=[point(19.1, 9.3)]
    ),
    "peak jerk": cam(
        objective="peak_jerk", base=51.3, up=[window(24.3, 37.1, velocity_mm_per_s=1.43 * V)],
        back=[point(31.7, 8.3, tolerance_mm=0.31)],
    ),
    "rms jerk": cam(
        objective="rms_jerk", base=51.3, up=[window(24.3, 37.1, velocity_mm_per_s=1.43 * V)],
        back=[point(31.7, 8.3)],
    ),
    "rms acceleration": cam(
        acceleration(9.1, UP), objective="rms_acceleration", base=51.3, through=[point(31.7, 8.3)]
    ),
}  # fmt: skip
ALL_LAWS = "all motion laws"


def found(spec: DesignSpec, intervals: int) -> tuple[float, Bound]:
    question = problem(spec)
    answer = direct(question, [uniform_grid(segment, intervals) for segment in question.free])
    return answer.value, dual_bound(answer.model, answer.solution)


def test_the_scenes_bite() -> None:
    """Without its windows and points, every scene has a better optimum."""
    for name, spec in CASES.items():
        body = spec.model_dump()
        for segment in body["program"]:
            for field in ("windows", "points"):
                if field in segment:
                    segment[field] = []
        free = DesignSpec.model_validate(body)
        assert found(free, 40)[0] < found(spec, 40)[0] * (1.0 - 1e-3), name


@pytest.mark.parametrize("name", CASES)
def test_same_optimum_as_stated_in_cvxpy(name: str) -> None:
    question = problem(CASES[name])
    grids = even(question, 13)
    expected = optimum(question, grids)
    assert expected.value is not None, expected.status
    assert direct(question, grids).value == pytest.approx(expected.value, rel=1e-6)


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("intervals", [11, 40])
def test_the_bound_is_below_the_optimum_on_much_finer_knots(name: str, intervals: int) -> None:
    _, lower = found(CASES[name], intervals)
    fine, _ = found(CASES[name], 200)
    assert lower.valid_for.startswith(ALL_LAWS)
    assert 0.0 < lower.value <= fine * (1.0 + 1e-9)


@pytest.mark.parametrize("name", CASES)
def test_the_gap_closes_with_knots(name: str) -> None:
    gaps = []
    for intervals in (16, 144):
        value, lower = found(CASES[name], intervals)
        gaps.append((value - lower.value) / value)
    slow = lower.order == 2 or "acceleration" in name
    assert gaps[1] < (0.04 if slow else 8e-3)
    assert gaps[1] < 0.4 * gaps[0] + 1e-8


@settings(max_examples=7)
@given(
    st.sampled_from(sorted(CASES)), st.integers(0, 2**32 - 1), st.floats(-9.0, 1.0)
)  # fmt: skip
def test_garbage_gives_a_bound_too(name: str, seed: int, magnitude: float) -> None:
    fine, _ = found(CASES[name], 64)
    question = problem(CASES[name])
    answer = direct(question, [uniform_grid(segment, 10) for segment in question.free])
    rng = np.random.default_rng(seed)
    z = answer.solution.multipliers
    noise = rng.standard_normal(len(z)) * 10.0**magnitude
    for wrong in (z * np.exp(noise), z + noise, rng.permutation(z)):
        lower = dual_bound(answer.model, replace(answer.solution, multipliers=wrong))
        assert not lower.value > fine * (1.0 + 1e-9)


# -- an independent statement: jerk piecewise constant on a fine grid, states by summation ---------


def least_peak_jerk(
    cells: int, rows: Sequence[tuple[float, int, float, float]]
) -> float:  # unit lift and angle
    """Least max|g'''| from rest to rest with low ≤ g^(k)(x) ≤ high, a linear program in SciPy.

    The jerk is constant on every cell; rows are (x, k, low, high).
    """
    edges = np.linspace(0.0, 1.0, cells + 1)

    def state(x: float, order: int) -> np.ndarray:
        """g^(order)(x) as a functional of the cells' jerks."""
        n = 3 - order
        left, right = np.maximum(x - edges[:-1], 0.0), np.maximum(x - edges[1:], 0.0)
        factorial = {1: 1.0, 2: 2.0, 3: 6.0}[n]
        return (left**n - right**n) / factorial

    table, upper = [], []
    for x, k, low, high in rows:
        for sign, end in ((1.0, high), (-1.0, -low)):
            if np.isfinite(end):
                table.append(np.append(sign * state(x, k), 0.0))
                upper.append(end)
    cap = np.hstack([np.vstack([np.eye(cells), -np.eye(cells)]), -np.ones((2 * cells, 1))])
    monotone = [np.append(-state(x, 1), 0.0) for x in edges[1:-1]]
    unequal = np.vstack([cap, *(row[None, :] for row in (*monotone, *table))])
    rhs = np.concatenate([np.zeros(2 * cells + len(monotone)), upper])
    equal = np.array([np.append(state(1.0, k), 0.0) for k in range(3)])
    answer = linprog(
        np.append(np.zeros(cells), 1.0), unequal, rhs, equal, [1.0, 0.0, 0.0],
        bounds=[(None, None)] * cells + [(0.0, None)], method="highs",
    )  # fmt: skip
    assert answer.status == 0, answer.message
    return float(answer.fun)


def test_the_independent_program_knows_the_exact_optimum() -> None:
    assert least_peak_jerk(200, []) == pytest.approx(32.0, rel=1e-7)


SCENES: dict[str, tuple[dict[str, Any], list[tuple[float, int, float, float]]]] = {
    "point": (
        {"through": [point(0.325 * UP, 0.31 * LIFT)]}, [(0.325, 0, 0.31, 0.31)],
    ),
    "point with tolerance and velocity": (
        {"through": [point(0.325 * UP, 0.31 * LIFT, tolerance_mm=0.017 * LIFT,
                           velocity_mm_per_s=1.37 * V)]},
        [(0.325, 0, 0.293, 0.327), (0.325, 1, 1.37, 1.37)],
    ),
    "velocity held": (
        {"up": [window(0.375 * UP, 0.6 * UP, velocity_mm_per_s=1.31 * V)]},
        [(x, 1, 1.31, 1.31) for x in np.linspace(0.375, 0.6, 91)],
    ),
    "velocity below": (
        {"up": [window(0.4 * UP, 0.575 * UP, velocity_mm_per_s={"max": 1.41 * V})]},
        [(x, 1, -np.inf, 1.41) for x in np.linspace(0.4, 0.575, 71)],
    ),
    "acceleration between, travel above": (
        {"up": [window(0.1 * UP, 0.3 * UP, acceleration_mm_per_s2={"min": 1.3 * A, "max": 3.9 * A},
                       travel_mm={"min": 0.021 * LIFT})]},
        [(x, k, low, high) for x in np.linspace(0.1, 0.3, 81)
         for k, low, high in ((2, 1.3, 3.9), (0, 0.021, np.inf))],
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", SCENES)
def test_against_an_independent_linear_program(name: str) -> None:
    """Both sides of the truth: the spline's optimum and the bound enclose it."""
    question, rows = SCENES[name]
    spec = cam(objective="peak_jerk", base=51.3, **question)
    # the return's own optimum lies below the rise's: its peak does not decide
    value, lower = found(spec, 200)
    unit = LIFT / (UP * pi / 180.0) ** 3
    truth = least_peak_jerk(400, rows)
    assert truth > 32.0 * (UP / DOWN) ** 3 * 1.2
    assert value / unit == pytest.approx(truth, rel=2e-3)
    assert lower.value / unit == pytest.approx(truth, rel=4e-3)
    assert lower.value <= value


# -- where knots lie, and nothing fits ------------------------------------------------------------


def test_knots_lie_where_windows_end_and_at_points() -> None:
    spec = cam(*SIZED, up=[window(24.3, 37.1, velocity_mm_per_s=V)], through=[point(51.9, 21.0)])
    first, second = problem(spec).free
    assert first.free is not None
    for grid in (uniform_grid(first, 9), uniform_grid(first, 40)):
        for x in (24.3 / UP, 37.1 / UP, 51.9 / UP):
            assert x in grid.space.breaks
        assert np.diff(grid.space.breaks).min() >= CLOSEST_KNOTS
    assert len(uniform_grid(second, 9).space.breaks) == 10


@pytest.mark.parametrize(("smoothness", "softer"), [(2, 1), (3, 1), (4, 2)])
def test_short_ramps_keep_rows_well_conditioned(smoothness: int, softer: int) -> None:
    """Rows of the control are no larger than on a mesh without them, but for known coefficients."""
    coarse, order = np.linspace(0.0, 1.0, 21), smoothness + 1 - softer
    breaks = merge_knots(coarse, np.array([0.4321, 0.75]), softer=softer)
    largest = []
    for each in (coarse, breaks):
        rows = SplineSpace(smoothness + 1, each).control_matrices[order]
        largest.append(np.max(np.abs(rows[:, smoothness + 1 : -smoothness - 1])))
    assert largest[1] < 200.0 * largest[0]
    width = np.diff(breaks)
    assert np.sum(width < 1.1 * RAMP_STEP) == softer * (2 + 2)  # two wanted points, and both ends
    assert not np.any((width > 1.1 * RAMP_STEP) & (width < CLOSEST_KNOTS))
    assert np.min(np.abs(breaks - 0.4321)) < softer * RAMP_STEP


def test_needed_knots_come_first_and_push_none_away_that_were_there() -> None:
    coarse = np.linspace(0.0, 1.0, 11)
    once = merge_knots(coarse, np.array([0.4321]), (0.4325, 0.7))
    assert 0.4325 in once
    assert 0.4321 not in once
    refined = np.union1d(once, [0.444])
    assert 0.444 in merge_knots(refined, np.zeros(0), (0.4325, 0.7))


@pytest.mark.parametrize(
    "spec",
    [
        cam(jerk(47.0, UP), through=[point(11.3, 13.0)], base=LEAST),
        cam(jerk(47.0, UP), up=[window(20.3, 45.7, velocity_mm_per_s=0.3 * V)], base=LEAST),
        cam(
            velocity(1.9, UP),
            up=[window(20.3, 21.7, velocity_mm_per_s={"min": 2.0 * V})],
            base=LEAST,
        ),
    ],
)
def test_nothing_is_found_where_nothing_is(spec: DesignSpec) -> None:
    question = problem(spec)
    grids = even(question, 20)
    assert solve(formulate(question, grids).program).stopped is StopReason.INFEASIBLE
    assert optimum(question, grids).value is None
