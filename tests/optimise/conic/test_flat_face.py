"""A flat face: the linear program's optimum, stated a second time for another solver."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.optimize import linprog

from synthesis.optimise.dual_bound.bound import dual_bound
from synthesis.optimise.problem.grid import Grid
from synthesis.optimise.problem.problem import Problem
from synthesis.spec.design_spec import DesignSpec
from tests.optimise.scenes import (
    OMEGA,
    RPM,
    acceleration,
    direct,
    dwell,
    even,
    fall,
    jerk,
    problem,
    rise,
    uneven,
    velocity,
)

LEAST = 7.3
WIDE: dict[str, Any] = {"kind": "face_width", "left_mm": 35.7, "right_mm": 41.3}
RADIUS: dict[str, Any] = {"kind": "profile_radius", "min_mm": LEAST}
SCENES = {
    "jerk": [RADIUS, jerk(47.0, 73.0)],
    "jerk and face": [RADIUS, jerk(47.0, 73.0), WIDE],
    "acceleration": [RADIUS, acceleration(6.1, 73.0)],
    "velocity": [RADIUS, velocity(1.83, 73.0)],
    "undercut alone": [jerk(47.0, 73.0)],
    "radius alone": [RADIUS],
}


def question(*limits: dict[str, Any], law: str | None = None, **more: Any) -> DesignSpec:
    return DesignSpec.model_validate(
        {
            "speed_rpm": RPM,
            "program": [rise(73.0, law=law), dwell(31.0), fall(86.0, law=law), dwell(170.0)],
            "follower": {"kind": "translating_flat_face"},
            "limits": list(limits),
            "objective": {"kind": "base_radius"},
            **more,
        }
    )


def second_statement(scene: Problem, grids: list[Grid], limits: list[dict[str, Any]]) -> float:
    """The same spline program in mm and radians, for HiGHS: c of both laws, then Rb."""
    named = {limit["kind"]: limit for limit in limits}
    sizes = [grid.space.size for grid in grids]
    width = sum(sizes) + 1
    table: list[np.ndarray] = []
    rhs: list[float] = []
    equal: list[np.ndarray] = []
    known: list[float] = []
    least = named.get("profile_radius", {"min_mm": 0.0})["min_mm"]
    at = 0
    for segment, grid in zip(scene.free, grids, strict=True):
        h, beta, space = segment.lift, segment.angle, grid.space

        def put(x: Any, order: int, at: int = at, space: Any = space, h: float = h,
                beta: float = beta) -> np.ndarray:  # fmt: skip
            rows = np.zeros((len(x), width))
            rows[:, at : at + space.size] = h / beta**order * space.basis(np.asarray(x), order)
            return rows

        ends = np.array([0.0, 1.0])
        for order, values in ((0, (0.0, h)), (1, (0.0, 0.0)), (2, (0.0, 0.0))):
            equal += list(put(ends, order))
            known += list(values)
        radius = -put(grid.points, 0) - put(grid.points, 2)
        radius[:, -1] = -1.0
        table += list(radius)
        rhs += [segment.s_start - least] * len(radius)
        for order, (name, field) in enumerate(
            [("velocity", "max_mm_per_s"), ("acceleration", "max_mm_per_s2"),
             ("jerk", "max_mm_per_s3")], 1):  # fmt: skip
            if name in named:
                x = grid.points if order == 1 else space.breaks
                if order == 3:  # constant between knots
                    x = 0.5 * (space.breaks[1:] + space.breaks[:-1])
                rows = put(x, order)
                table += [*rows, *-rows]
                rhs += [named[name][field] / OMEGA**order] * (2 * len(rows))
        if "face_width" in named:
            rows = put(grid.points, 1)
            table += [*rows, *-rows]
            rhs += [named["face_width"]["right_mm"]] * len(rows)
            rhs += [named["face_width"]["left_mm"]] * len(rows)
        falls = np.zeros((space.size - 1, width))
        falls[:, at : at + space.size] = np.eye(space.size)[:-1] - np.eye(space.size)[1:]
        table += list(falls)
        rhs += [0.0] * len(falls)
        at += space.size
    found = linprog(
        np.eye(width)[-1], np.array(table), rhs, np.array(equal), known,
        bounds=[*[(None, None)] * (width - 1), (scene.sizing.min_norm, None)], method="highs",
        options={"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10},
    )  # fmt: skip
    assert found.status == 0, found.message
    dwells = max(least - s.s_start for s in scene.segments if s.kind == "dwell")
    return float(max(found.fun, dwells))


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("seed", [None, 5])
def test_the_optimum_is_that_of_another_statement(name: str, seed: int | None) -> None:
    limits = SCENES[name]
    scene = problem(question(*limits))
    grids = even(scene, 14) if seed is None else uneven(scene, seed, 11)
    found = direct(scene, grids)
    assert found.value == pytest.approx(second_statement(scene, grids, limits), rel=1e-7)
    # every cam of the family is at least as large as the bound, this one included
    assert dual_bound(found.model, found.solution).value <= found.value * (1.0 + 1e-9)


def test_the_bound_over_all_laws_closes_in_and_is_never_above_a_finer_cam() -> None:
    scene = problem(question(*SCENES["jerk and face"]))
    coarse, fine = (direct(scene, even(scene, n)) for n in (24, 96))
    reported = [dual_bound(each.model, each.solution) for each in (coarse, fine)]
    assert all(each.valid_for == "all motion laws with a bounded jerk" for each in reported)
    assert max(each.value for each in reported) <= fine.value <= coarse.value * (1.0 + 1e-9)
    assert reported[0].value < reported[1].value
    assert reported[1].value > 0.98 * fine.value


def test_where_the_size_caps_the_control_too_its_rows_have_densities() -> None:
    scene = problem(question(*SCENES["acceleration"]))
    coarse, fine = (direct(scene, even(scene, n)) for n in (24, 96))
    reported = [dual_bound(each.model, each.solution) for each in (coarse, fine)]
    assert all(each.valid_for == "all motion laws with a bounded acceleration" for each in reported)
    assert max(each.value for each in reported) <= fine.value <= coarse.value * (1.0 + 1e-9)
    assert 0.8 * fine.value < reported[0].value < reported[1].value


def test_the_rows_are_linear_so_nothing_is_left_to_ipopt() -> None:
    scene = problem(question(*SCENES["jerk and face"]))
    s = [np.zeros(3)] * 4
    for limit in scene.limits:
        assert (
            limit.smooth_constraints(scene.segments[0], scene.machine, np.zeros(1), s, (30.0,))
            == ()
        )
