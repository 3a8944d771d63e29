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

from synthesis.numerics.piecewise import Array
from synthesis.numerics.solvers.highs import LinearRows, minimise_each
from synthesis.numerics.solvers.statuses import StopReason
from synthesis.optimise.conic.linear_rows import LinearBlock
from synthesis.optimise.dual_bound.bound import ROUNDING
from synthesis.optimise.propagation.tolerances import LOOSENING

ROUND = 16  # directions of a plane

Sizes = Sequence[tuple[float, float]]


@dataclass(frozen=True, eq=False)
class HalfSpaces:
    """normals · z ≥ floors [length]: (r, d) and (r,)."""

    normals: Array
    offsets: Array

    @classmethod
    def empty(cls, sizes: int) -> HalfSpaces:
        """Nothing known."""
        return cls(np.zeros((0, sizes)), np.zeros(0))

    def intersect(self, others: Sequence[HalfSpaces]) -> HalfSpaces:
        """These and others."""
        return HalfSpaces(
            np.concatenate([self.normals, *(other.normals for other in others)]),
            np.concatenate([self.offsets, *(other.offsets for other in others)]),
        )

    def blocks(self, unit: float) -> list[LinearBlock]:
        """As rows of a program whose sizes are in a unit [length]."""
        scale = np.maximum(unit * np.max(np.abs(self.normals), axis=1, initial=0.0), 1e-300)
        return [
            LinearBlock.of_size(-unit * normal / each, np.array([-floor / each]), "shared")
            for normal, floor, each in zip(self.normals, self.offsets, scale, strict=True)
            if np.isfinite(floor)
        ]

    def minimise(self, directions: Array, box: Sizes) -> Array:
        """What direction · z is at least in a box, (q, d) to (q,); infinite where no size is left.

        Bounds from the multipliers of linear programs, whatever these are.
        """
        middle, half = _centre_and_half_width(box)
        # y from −1 to 1 and a slack t: normals · half · y + t ≥ floors − normals · middle
        known = np.isfinite(self.offsets)
        matrix = self.normals[known] * half
        rhs = self.offsets[known] - self.normals[known] @ middle
        length = np.linalg.norm(matrix, axis=1)
        matrix, rhs = matrix / length[:, None], rhs / length
        task = _BoxProgram(np.column_stack([matrix, np.ones(len(rhs))]), rhs)
        far = np.append(np.zeros(len(box)), 1.0)
        (excess,) = task.lower_bounds(far[None], 4.0)
        if excess > LOOSENING:
            return np.full(len(directions), inf)
        costs = np.column_stack([directions * half, np.zeros(len(directions))])
        return np.asarray(task.lower_bounds(costs, 2.0 * LOOSENING) + directions @ middle)


@dataclass(frozen=True, eq=False)
class _BoxProgram:
    """matrix · (y, t) ≥ rhs: (r, d + 1) and (r,)."""

    matrix: Array
    rhs: Array

    def lower_bounds(self, costs: Array, slack: float) -> Array:
        """Lower bounds of every cost (q, d + 1) over |y| ≤ 1 and 0 ≤ t ≤ slack."""
        high = np.append(np.ones(self.matrix.shape[1] - 1), slack)
        low = np.append(-high[:-1], 0.0)
        rows = LinearRows(sparse.csc_matrix(-self.matrix), -self.rhs, 0, low, high)
        result = minimise_each(rows, list(costs))
        z = np.zeros((len(costs), len(self.rhs)))
        for k, each in enumerate(result):
            if each.stopped is StopReason.SOLVED:
                z[k] = np.maximum(each.multipliers, 0.0)
        rest = costs - z @ self.matrix
        total = z @ self.rhs + np.sum(np.minimum(rest * low, rest * high), axis=1)
        magnitude = z @ np.abs(self.rhs) + np.abs(rest) @ np.maximum(np.abs(low), high)
        magnitude += (z @ np.abs(self.matrix)) @ np.maximum(np.abs(low), high)
        return np.asarray(total - ROUNDING * magnitude)


def _centre_and_half_width(box: Sizes) -> tuple[Array, Array]:
    """The middle of a box, and half of its widths, none of them nothing."""
    low, high = np.array(box, dtype=float).T
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    return middle, np.maximum(half, LOOSENING * np.max(np.abs(middle) + half))


def directions_around(box: Sizes) -> Array:
    """Directions (q, d) in which sizes of a box are bounded: along the axes, and between two."""
    half = _centre_and_half_width(box)[1]
    open_ = np.flatnonzero([high > low for low, high in box])
    if len(open_) != 2:
        axes = np.eye(len(box))[open_]
        return np.concatenate([axes, -axes])
    angle = 2.0 * pi / ROUND * np.arange(ROUND)
    result = np.zeros((ROUND, len(box)))
    result[:, open_] = np.stack([np.cos(angle), np.sin(angle)], axis=1) / half[open_]
    result[np.abs(result) * half < LOOSENING] = 0.0  # along the axes
    return result
