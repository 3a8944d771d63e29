"""Sizes under more half-planes than all corners are looked at of, against linear programs."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from scipy.optimize import linprog, minimize

from synthesis.catalogue.constraints import AffineNorm
from synthesis.optimise.problem.problem import Problem
from synthesis.optimise.recovery import closed_form

PROBLEM = cast(Problem, SimpleNamespace(length=1.0))
PLANE = AffineNorm(((1.0, 0.0), (0.0, 1.0)), (0.3, -0.2))
FIRST_ALONE = AffineNorm(((1.0, 0.0),), (0.0,))  # arms: the second variable is not in the norm


def half_planes(count: int, room: float, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Tangents of a curve about a random centre, nearly all of which bound the polygon."""
    random = np.random.default_rng(seed)
    angles = random.uniform(0.0, 2.0 * np.pi, count)
    normals = np.stack([np.cos(angles), np.sin(angles)], axis=1) * random.uniform(0.3, 3.0)
    centre = 5.0 * random.normal(size=2)
    radius = room * (1.0 + 0.3 * np.cos(angles) ** 2) * np.hypot(*normals.T)
    return normals, normals @ centre + radius


def nearest(norm: AffineNorm, normals: np.ndarray, offsets: np.ndarray) -> Any:
    return closed_form._nearest_size(PROBLEM, norm, normals, offsets)


@pytest.mark.parametrize("count", [49, 130, 1700])
@pytest.mark.parametrize("seed", range(4))
def test_the_least_of_one_variable_is_that_of_a_linear_program(count: int, seed: int) -> None:
    normals, offsets = half_planes(count, 1.1, seed)
    best = linprog([1.0, 0.0], normals, offsets, bounds=(None, None))
    found = nearest(FIRST_ALONE, normals, offsets)
    assert found[0] == pytest.approx(best.fun, rel=1e-6, abs=1e-6)
    assert np.all(normals @ found <= offsets + 1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_half_planes_that_are_looked_at_first_may_leave_the_least_open(seed: int) -> None:
    """The last ones bound the variable from above alone, and the corners of these are no least."""
    normals, offsets = half_planes(90, 1.1, seed)
    order = np.argsort(normals[:, 0])
    found = nearest(FIRST_ALONE, normals[order], offsets[order])
    best = linprog([1.0, 0.0], normals, offsets, bounds=(None, None))
    assert found[0] == pytest.approx(best.fun, rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("count", [49, 130, 1700])
@pytest.mark.parametrize("seed", range(4))
def test_the_nearest_point_is_that_of_a_quadratic_program(count: int, seed: int) -> None:
    normals, offsets = half_planes(count, 1.1, seed)
    found = nearest(PLANE, normals, offsets)
    assert np.all(normals @ found <= offsets + 1e-9)
    rows = {"type": "ineq", "fun": lambda z: offsets - normals @ z, "jac": lambda z: -normals}
    known = minimize(
        lambda z: np.sum((z + PLANE.shift) ** 2), found, jac=lambda z: 2.0 * (z + PLANE.shift),
        constraints=rows, method="SLSQP", options={"ftol": 1e-14},
    )  # fmt: skip
    assert PLANE.value(found) <= np.sqrt(known.fun) * (1.0 + 1e-7)


@pytest.mark.parametrize("norm", [PLANE, FIRST_ALONE])
def test_where_few_of_them_have_no_point_there_is_none(norm: AffineNorm) -> None:
    normals, offsets = half_planes(400, -0.1, 7)
    assert nearest(norm, normals, offsets) is None


@pytest.mark.parametrize("norm", [PLANE, FIRST_ALONE])
def test_never_are_all_corners_of_many_looked_at(
    norm: AffineNorm, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Those of two thousand, compared with each of these, would take gigabytes."""
    seen = []
    corners = closed_form._corners
    monkeypatch.setattr(
        closed_form, "_corners", lambda a, b: (seen.append(len(b)), corners(a, b))[1]
    )
    assert nearest(norm, *half_planes(2000, 1.1, 3)) is not None
    assert max(seen) < 200
