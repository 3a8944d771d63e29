"""What all laws leave of the size: half-spaces, and how far any size that keeps them may lie.

Each law bounds the size by itself; together they share it. So a few half-spaces, all round, carry
from law to law what all others have to say.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, pi

import numpy as np
from scipy import sparse

from synthesis.formulations.cone.rows import Block
from synthesis.numerics.piecewise import Array
from synthesis.solvers.highs import LinearRows, least
from synthesis.solvers.statuses import Stopped

ROUND = 16  # directions of a plane
SPARE = 1e-9  # of the box, by which sizes may break half-spaces, and of its place, its least width
ROUNDING = 1e-12  # relative allowance for the floating-point sums below

Sizes = Sequence[tuple[float, float]]


@dataclass(frozen=True, eq=False)
class Planes:
    """normals · z ≥ floors [mm]: (r, d) and (r,)."""

    normals: Array
    floors: Array

    @classmethod
    def none(cls, sizes: int) -> Planes:
        """Nothing known."""
        return cls(np.zeros((0, sizes)), np.zeros(0))

    def joined(self, others: Sequence[Planes]) -> Planes:
        """These and others."""
        return Planes(
            np.concatenate([self.normals, *(other.normals for other in others)]),
            np.concatenate([self.floors, *(other.floors for other in others)]),
        )

    def blocks(self, unit: float) -> list[Block]:
        """As rows of a program whose sizes are in a unit [mm]."""
        scale = np.maximum(unit * np.max(np.abs(self.normals), axis=1, initial=0.0), 1e-300)
        return [
            Block.of_size(-unit * normal / each, np.array([-floor / each]), "shared")
            for normal, floor, each in zip(self.normals, self.floors, scale, strict=True)
            if np.isfinite(floor)
        ]

    def least(self, directions: Array, box: Sizes) -> Array:
        """What direction · z is at least in a box, (q, d) to (q,); infinite where no size is left.

        Bounds from the multipliers of linear programs, whatever these are.
        """
        middle, half = _middle(box)
        # y from −1 to 1 and a slack t: normals · half · y + t ≥ floors − normals · middle
        known = np.isfinite(self.floors)
        matrix = self.normals[known] * half
        rhs = self.floors[known] - self.normals[known] @ middle
        length = np.linalg.norm(matrix, axis=1)
        matrix, rhs = matrix / length[:, None], rhs / length
        task = _Task(np.column_stack([matrix, np.ones(len(rhs))]), rhs)
        far = np.append(np.zeros(len(box)), 1.0)
        (excess,) = task.floors(far[None], 4.0)
        if excess > SPARE:
            return np.full(len(directions), inf)
        costs = np.column_stack([directions * half, np.zeros(len(directions))])
        return np.asarray(task.floors(costs, 2.0 * SPARE) + directions @ middle)


@dataclass(frozen=True, eq=False)
class _Task:
    """matrix · (y, t) ≥ rhs: (r, d + 1) and (r,)."""

    matrix: Array
    rhs: Array

    def floors(self, costs: Array, slack: float) -> Array:
        """Lower bounds of every cost (q, d + 1) over |y| ≤ 1 and 0 ≤ t ≤ slack."""
        high = np.append(np.ones(self.matrix.shape[1] - 1), slack)
        low = np.append(-high[:-1], 0.0)
        rows = LinearRows(sparse.csc_matrix(-self.matrix), -self.rhs, 0, low, high)
        found = least(rows, list(costs))
        z = np.zeros((len(costs), len(self.rhs)))
        for k, each in enumerate(found):
            if each.stopped is Stopped.SOLVED:
                z[k] = np.maximum(each.multipliers, 0.0)
        rest = costs - z @ self.matrix
        total = z @ self.rhs + np.sum(np.minimum(rest * low, rest * high), axis=1)
        spent = z @ np.abs(self.rhs) + np.abs(rest) @ np.maximum(np.abs(low), high)
        spent += (z @ np.abs(self.matrix)) @ np.maximum(np.abs(low), high)
        return np.asarray(total - ROUNDING * spent)


def _middle(box: Sizes) -> tuple[Array, Array]:
    """The middle of a box, and half of its widths, none of them nothing."""
    low, high = np.array(box, dtype=float).T
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    return middle, np.maximum(half, SPARE * np.max(np.abs(middle) + half))


def all_round(box: Sizes) -> Array:
    """Directions (q, d) in which sizes of a box are bounded: along the axes, and between two."""
    half = _middle(box)[1]
    open_ = np.flatnonzero([high > low for low, high in box])
    if len(open_) != 2:
        axes = np.eye(len(box))[open_]
        return np.concatenate([axes, -axes])
    angle = 2.0 * pi / ROUND * np.arange(ROUND)
    found = np.zeros((ROUND, len(box)))
    found[:, open_] = np.stack([np.cos(angle), np.sin(angle)], axis=1) / half[open_]
    found[np.abs(found) * half < SPARE] = 0.0  # along the axes
    return found
