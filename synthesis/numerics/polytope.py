"""Part of the unit box where linear equations hold, and the least value of a function on it.

``minimise`` is a cutting-plane (bundle) method for a function of a few numbers that costs much and
has kinks. Where the largest of several peaks is to be small, the best point lies where several are
equal: on a kink, at which smooth models fail. Here the model is the largest of the tangents seen so
far, within a radius that shrinks where it misleads. Slopes are differences.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import inf
from typing import Any

import numpy as np
from scipy.optimize import linprog

from synthesis.numerics.piecewise import Array

RANK = 1e-12  # relative: smaller singular values are 0


@dataclass(frozen=True, eq=False)
class Polytope:
    """All u in [0, 1]^n with matrix · u = rhs, (m, n) and (m,)."""

    matrix: Array
    rhs: Array

    @cached_property
    def directions(self) -> Array:
        """Orthonormal directions that keep the equations: (n, d)."""
        _, size, rows = np.linalg.svd(self.matrix)
        rank = int(np.sum(size > RANK * max(size.max(initial=0.0), 1e-300)))
        return np.asarray(rows[rank:].T)

    def centre(self) -> Array | None:
        """A point as far from the box's sides as can be; None where there is no point."""
        m, n = self.matrix.shape
        sides = np.vstack([np.eye(n), -np.eye(n)])
        found = minimise_linear(
            np.append(np.zeros(n), -1.0),
            (np.hstack([sides, np.ones((2 * n, 1))]), np.append(np.ones(n), np.zeros(n))),
            (np.hstack([self.matrix, np.zeros((m, 1))]), self.rhs),
            [*[(0.0, 1.0)] * n, (0.0, 0.5)],
        )
        return None if found is None else self.project(found[:n])

    def project(self, u: Array) -> Array:
        """The point next to u at which the equations hold to rounding."""
        inverse = np.linalg.pinv(self.matrix, rcond=RANK)
        for _ in range(2):
            u = u - inverse @ (self.matrix @ u - self.rhs)
        return np.asarray(u)

    def corners(self, count: int) -> list[Array]:
        """Some corners, the same ones every time."""
        rng, n = np.random.default_rng(1), self.matrix.shape[1]
        found = []
        for _ in range(count):
            cost, equal = rng.standard_normal((n,)), (self.matrix, self.rhs)
            corner = minimise_linear(cost, (None, None), equal, [(0.0, 1.0)] * n)
            if corner is not None:
                found.append(self.project(corner))
        return found


Rows = tuple[Any, Any]  # a matrix and what its product is compared with, or None twice


def minimise_linear(
    cost: Array, below: Rows, equal: Rows, bounds: Sequence[tuple[float | None, float | None]]
) -> Array | None:
    """Where cost · x is least with A x ≤ b, C x = d and bounds; None where there is no such x."""
    answer = linprog(cost, *below, *equal, bounds=bounds, method="highs")
    return None if answer.status or answer.x is None else np.asarray(answer.x)


Function = Callable[[Array], float | None]
STEP = 1e-5  # for slopes, of the box's side
KEPT = 8  # tangents per direction that are remembered
ENOUGH = 1e-6  # relative gain that is not worth a step
CLOSEST = 1e-5  # trust radius in the unit box at which a descent ends
NEAR = 20.0  # radii: tangents farther off say nothing of the place, the function is not convex
LONGER, SHORTER = 1.5, 0.4  # factors on the trust radius after good and poor steps
GOOD, POOR = 0.5, 0.1  # shares of the promised gain


@dataclass(frozen=True, eq=False)
class BundlePoint:
    """A point of the polytope and the function's value there."""

    u: Array
    value: float


_Tangent = tuple[Array, float, Array]  # a point, the function's value and its slopes there


def minimise(
    function: Function, polytope: Polytope, start: BundlePoint, radius: float, steps: int
) -> BundlePoint:
    """A point where the function, None where it has no value, is locally least.

    ``radius``: how far the first step may go in each direction; ``steps``: most steps.
    """
    best, tangents = start, list[_Tangent]()
    if not polytope.directions.shape[1]:
        return best
    tangents.append(_tangent(function, polytope, best))
    while steps > 0 and radius >= CLOSEST:
        tangents = [t for t in tangents if np.max(np.abs(t[0] - best.u)) <= NEAR * radius]
        step, promised = _step(polytope, best, tangents, radius)
        if promised <= ENOUGH * abs(best.value):
            radius *= SHORTER
            continue
        steps -= 1
        at = best.u + polytope.directions @ step
        value = function(at)
        gain = -inf if value is None else best.value - value
        if value is not None:
            tangents.append(_tangent(function, polytope, BundlePoint(at, value)))
        if value is not None and gain > POOR * promised:
            best = BundlePoint(at, value)
        radius *= LONGER if gain > GOOD * promised else 1.0 if gain > POOR * promised else SHORTER
        tangents = tangents[-KEPT * polytope.directions.shape[1] :]
    return best


def _tangent(function: Function, polytope: Polytope, here: BundlePoint) -> _Tangent:
    """The slope in every direction, by a difference to whichever side is allowed."""
    slope = np.zeros(polytope.directions.shape[1])
    for k, direction in enumerate(polytope.directions.T):
        for step in (STEP, -STEP):
            at = here.u + step * direction
            if np.all((at >= 0.0) & (at <= 1.0)) and (value := function(at)) is not None:
                slope[k] = (value - here.value) / step
                break
    return here.u, here.value, slope


def _step(
    polytope: Polytope, best: BundlePoint, tangents: list[_Tangent], radius: float
) -> tuple[Array, float]:
    """The step to the lowest point of the model, and the gain that it promises."""
    directions, count = polytope.directions, polytope.directions.shape[1]
    table, rhs = [], []
    for at, value, slope in tangents:
        here = value + float(slope @ (directions.T @ (best.u - at)))
        # the function is not convex: a tangent may not cut off the best point
        table.append(np.append(slope, -1.0))
        rhs.append(best.value - min(here, best.value))
    for sign, slack in ((1.0, 1.0 - best.u), (-1.0, best.u)):
        table += list(np.hstack([sign * directions, np.zeros((len(slack), 1))]))
        rhs += list(np.maximum(slack, 0.0))
    found = minimise_linear(
        np.append(np.zeros(count), 1.0), (np.array(table), np.array(rhs)), (None, None),
        [*[(-radius, radius)] * count, (None, None)],
    )  # fmt: skip
    return (np.zeros(count), 0.0) if found is None else (found[:count], -float(found[count]))
