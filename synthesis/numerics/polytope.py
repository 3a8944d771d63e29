"""Part of the unit box where linear equations hold: where a few free numbers may lie."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import linprog

from synthesis.numerics.piecewise import Array

RANK = 1e-12


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
        room = np.vstack([np.eye(n), -np.eye(n)])
        found = minimise_linear(
            np.append(np.zeros(n), -1.0),
            (np.hstack([room, np.ones((2 * n, 1))]), np.append(np.ones(n), np.zeros(n))),
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
            cost, nothing = rng.standard_normal((n,)), (np.zeros((0, n)), np.zeros(0))
            corner = minimise_linear(cost, nothing, (self.matrix, self.rhs), [(0.0, 1.0)] * n)
            if corner is not None:
                found.append(self.project(corner))
        return found


def minimise_linear(
    cost: Array,
    below: tuple[Array, Array],
    equal: tuple[Array, Array],
    bounds: Sequence[tuple[float | None, float | None]],
) -> Array | None:
    """Where cost · x is least with A x ≤ b, C x = d and bounds; None where there is no such x."""
    answer = linprog(cost, *below, *equal, bounds=bounds, method="highs")
    return None if answer.status or answer.x is None else np.asarray(answer.x)
