"""Half-planes of two sizes in a box: against the corners of the polygon that they leave."""

from __future__ import annotations

from itertools import combinations
from math import inf
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from synthesis.numerics.piecewise import Array
from synthesis.numerics.solvers.statuses import StopReason
from synthesis.optimise.propagation import bound_tightening, quantity_bounds
from synthesis.optimise.propagation.half_spaces import (
    FAN,
    TURN,
    HalfSpaces,
    cone_tangents,
    directions_around,
)
from synthesis.optimise.propagation.improving_region import ImprovingRegion

BOX = ((-3.0, 5.0), (20.0, 47.0))


def polygon(seed: int, count: int = 5) -> HalfSpaces:
    """Half-planes that keep a point of the box by a little."""
    rng = np.random.default_rng(seed)
    angle = rng.uniform(0.0, 2.0 * np.pi, count)
    normals = np.stack([np.cos(angle), np.sin(angle)], axis=1) * rng.uniform(0.1, 9.0, (count, 1))
    inside = rng.uniform(*np.array(BOX).T)
    return HalfSpaces(normals, normals @ inside - rng.uniform(0.1, 3.0, count))


def corners(planes: HalfSpaces) -> Array:
    """Of the half-planes and the box, by every two of their lines."""
    axes = np.concatenate([np.eye(2), -np.eye(2)])
    ends = np.array(BOX)
    normals = np.concatenate([planes.normals, axes])
    offsets = np.concatenate([planes.offsets, ends[:, 0], -ends[:, 1]])
    known = np.isfinite(offsets)
    normals, offsets = normals[known], offsets[known]
    found = [
        np.linalg.solve(normals[[i, j]], offsets[[i, j]])
        for i, j in combinations(range(len(offsets)), 2)
        if abs(np.linalg.det(normals[[i, j]])) > 1e-12
    ]
    return np.array([z for z in found if np.all(normals @ z >= offsets - 1e-9)])


@pytest.mark.parametrize("seed", range(8))
def test_the_least_is_that_of_a_corner_and_never_above_it(seed: int) -> None:
    planes = polygon(seed)
    unknown = planes.intersect([HalfSpaces(np.array([[1.0, 1.0]]), np.array([-np.inf]))])
    rng = np.random.default_rng(seed + 100)
    directions = np.concatenate([np.eye(2), -np.eye(2), rng.standard_normal((4, 2))])
    exact = np.min(corners(planes) @ directions.T, axis=0)
    scale = np.abs(directions) @ np.abs(BOX).max(axis=1)
    for found in (planes.minimise(directions, BOX), unknown.minimise(directions, BOX)):
        assert np.all(found <= exact + 1e-13 * scale)
        # the slack that makes every program feasible is two billionths wide
        assert np.all(found >= exact - 1e-7 * scale)


def test_nothing_is_left_where_half_planes_exclude_each_other() -> None:
    against = HalfSpaces(np.array([[1.0, 0.0], [-1.0, 0.0]]), np.array([1.0, 0.1]))
    assert np.all(np.isinf(against.minimise(np.eye(2), BOX)))
    nearly = HalfSpaces(np.array([[1.0, 0.0], [-1.0, 0.0]]), np.array([1.0, -1.0 + 1e-6]))
    assert np.all(np.isinf(nearly.minimise(np.eye(2), BOX)))
    apart = HalfSpaces(np.array([[1.0, 0.0], [-1.0, 0.0]]), np.array([1.0, -1.0 - 1e-3]))
    assert np.all(np.isfinite(apart.minimise(np.eye(2), BOX)))
    assert HalfSpaces.empty(2).minimise(np.eye(2), BOX) == pytest.approx([-3.0, 20.0], abs=1e-9)


def test_rows_say_what_half_planes_say() -> None:
    planes, unit = polygon(3), 7.3
    z = np.random.default_rng(8).uniform(*np.array(BOX).T, (400, 2))
    kept = np.all(z @ planes.normals.T >= planes.offsets, axis=1)
    rows = planes.blocks(unit)
    unknown = HalfSpaces(np.eye(2), np.full(2, -np.inf))
    assert len(planes.intersect([unknown]).blocks(unit)) == len(rows) == 5
    by_rows = [np.all([b.size @ (each / unit) <= b.rhs for b in rows]) for each in z]
    assert kept.tolist() == by_rows
    assert 0 < np.count_nonzero(kept) < 400
    assert all(np.max(np.abs(b.size)) == pytest.approx(1.0) for b in rows)


def test_directions_go_all_round_what_is_open() -> None:
    round_ = directions_around(BOX)
    angle = np.sort(np.arctan2(*(round_ * [4.0, 13.5]).T))
    assert len(round_) == 16
    assert np.diff(angle) == pytest.approx(2.0 * np.pi / 16)
    for axis in np.concatenate([np.eye(2), -np.eye(2)]):  # the axes are among them
        assert any(np.array_equal(np.sign(each), axis) for each in round_)
    assert directions_around(((2.0, 2.0), (1.0, 4.0))).tolist() == [[0.0, 1.0], [0.0, -1.0]]
    assert directions_around(((2.0, 2.0),)).shape == (0, 1)


@pytest.mark.parametrize("seed", range(20))
def test_the_box_of_a_cone_holds_its_outermost_sizes(seed: int) -> None:
    """|M z/unit + m| ≤ r is farthest along an axis where the image is r times a unit vector."""
    rng = np.random.default_rng(seed)
    matrix, shift = rng.standard_normal((2, 2)), rng.standard_normal(2)
    radius, unit = rng.uniform(0.5, 3.0), rng.uniform(1.0, 9.0)
    cone = SimpleNamespace(bound_column=None, norm=1, shift=shift, matrix=matrix, radius=radius)
    model = SimpleNamespace(cone_blocks=[cone], size=slice(0, 2), scales=SimpleNamespace(size=unit))
    box = quantity_bounds.box_within_cones(model, ((-1e3, 1e3), (-1e3, 1e3)))
    inverse = np.linalg.inv(matrix)
    for axis, (low, high) in enumerate(box):
        for sign, end in ((-1.0, low), (1.0, high)):
            y = sign * inverse[axis] / np.linalg.norm(inverse[axis])
            z = unit * np.linalg.solve(matrix, radius * y - shift)
            assert low <= z[axis] <= high
            assert z[axis] == pytest.approx(end, rel=1e-7)
    inner = quantity_bounds.box_within_cones(model, ((-1e-3, 1e-3), (-1e3, 1e3)))
    assert inner[0] == (max(-1e-3, box[0][0]), min(1e-3, box[0][1]))
    assert inner[1] == box[1]


@pytest.mark.parametrize("turn", np.arange(0.1, 2.0 * np.pi, 0.3))
def test_tangents_leave_what_lies_in_a_cone_and_little_else(turn: float) -> None:
    """|M z/unit| ≤ r, M a turn of the box, on the arc of the circle that the box may reach."""
    unit, radius = 7.3, 1.9
    sizes = ((-5.0, 4.0), (20.0, 47.0))
    matrix = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    cone: Any = SimpleNamespace(
        bound_column=None, norm=1, shift=np.zeros(2), matrix=matrix, radius=radius, source=""
    )
    model: Any = SimpleNamespace(size=slice(0, 2), scales=SimpleNamespace(size=unit))
    blocks = list(cone_tangents(model, cone, sizes))
    assert len(blocks) < FAN  # the box is narrow enough for steps of ``TURN``
    low, high = (np.arctan2(end, sizes[1][0]) for end in sizes[0])
    angle = np.linspace(low, high, 2001)
    rim = radius * unit * np.stack([np.sin(angle), np.cos(angle)], axis=1)
    excess = np.max([rim @ block.size / unit - block.rhs for block in blocks], axis=0)
    assert np.max(excess) <= 1e-12 * radius
    # the tangents' polygon lies outside of the circle by what half a step makes
    assert np.min(excess) >= radius * (np.cos(0.5 * TURN) - 1.0) - 1e-12


def test_a_cone_that_leaves_a_direction_open_bounds_nothing() -> None:
    flat = SimpleNamespace(
        bound_column=None, norm=1, shift=np.zeros(2), matrix=np.array([[1.0, 2.0], [2.0, 4.0]]),
        radius=1.0,
    )  # fmt: skip
    capped = SimpleNamespace(**vars(flat) | {"matrix": np.eye(2), "bound_column": 3})
    # of a flat face that swings: the base radius alone, beside its pivot
    one = SimpleNamespace(**vars(flat) | {"matrix": np.array([[0.0, 1.0]]), "shift": np.zeros(1)})
    model = SimpleNamespace(
        cone_blocks=[flat, capped, one], size=slice(0, 2), scales=SimpleNamespace(size=1.0)
    )
    assert quantity_bounds.box_within_cones(model, BOX) == BOX


def test_bounds_of_quantities_are_loosened(monkeypatch: pytest.MonkeyPatch) -> None:
    values, units = np.array([-7e5, -0.3, 0.0, 0.3, 7e5]), np.array([1.0, 2.0, 30.0, 0.1, 5.0])
    program = SimpleNamespace(
        matrix=np.eye(2), rhs=np.zeros(2), equalities=0, inequalities=2, cones=()
    )  # fmt: skip
    wanted = SimpleNamespace(
        objectives=lambda full: ([np.zeros(2)] * 5, np.zeros(5)), x=np.zeros(5),
        select=lambda which: wanted,
    )  # fmt: skip
    solved = SimpleNamespace(stopped=StopReason.SOLVED, multipliers=np.zeros(2))
    patch: dict[str, Any] = {
        "with_rows": lambda model, rows: SimpleNamespace(
            program=program,
            size=slice(0, 2),
            scales=SimpleNamespace(size=1.0),
            problem=SimpleNamespace(for_every_size=False),
        ),
        "highs": SimpleNamespace(minimise_each=lambda *_, **__: [solved]),
        "MultiplierDensity": SimpleNamespace(
            of=lambda *_: SimpleNamespace(
                model=None, distribute=lambda *_: None, balance=lambda *_: None
            )
        ),
        "solve_boundary_costates": lambda *_: None,
        "dual_bounds": lambda *_: values,
    }
    for name, stub in patch.items():
        monkeypatch.setattr(quantity_bounds, name, stub)
    model = SimpleNamespace(scales=SimpleNamespace(size=1.0), cone_blocks=())
    controls = (SimpleNamespace(order=3),)
    law = bound_tightening._LawSubproblem(model, 0, controls, [], [], inf)
    region = ImprovingRegion(BOX, {}, HalfSpaces.empty(2))
    quantities = SimpleNamespace(scaled=lambda: (wanted, units))
    for bounds in (
        law.lower_bounds(quantities, region, np.inf),
        quantity_bounds.bound_quantities(model, controls, BOX, quantities),
    ):
        lost = values - bounds / units
        assert np.all(lost > 1e-10 * np.maximum(1.0, np.abs(values)))
        assert np.all(lost < 1e-8 * np.maximum(1.0, np.abs(values)))
    stopped = SimpleNamespace(stopped=StopReason.INFEASIBLE, multipliers=np.zeros(2))
    monkeypatch.setattr(quantity_bounds.highs, "minimise_each", lambda *_, **__: [solved, stopped])
    assert law.lower_bounds(quantities, region, np.inf) is None
    assert quantity_bounds.bound_quantities(model, controls, BOX, quantities) is None


def test_a_region_is_divisible_while_a_size_is_open() -> None:
    for sizes, divisible, empty in (
        (((2.0, 2.0), (30.0, 30.0)), False, False),
        (((2.0, 2.0), (30.0, 30.0 * (1.0 + 1e-10))), False, False),
        (((2.0, 2.0), (30.0, 30.1)), True, False),
        (((2.0, 1.9), (30.0, 30.1)), True, True),
    ):
        region = ImprovingRegion(sizes, {}, HalfSpaces.empty(2))
        assert (region.is_divisible, region.is_empty) == (divisible, empty)
