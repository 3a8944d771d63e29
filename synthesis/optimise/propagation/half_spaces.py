"""What all laws leave of the size: half-spaces, and how far any size within them may lie.

Each law bounds the size by itself; together they share it. So a few half-spaces, all round, carry
from law to law what all others have to say.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import inf, pi

import numpy as np
from scipy import sparse

from synthesis.numerics.piecewise import Array
from synthesis.numerics.solvers.highs import LinearRows, minimise_each
from synthesis.numerics.solvers.statuses import StopReason
from synthesis.optimise.conic.assembly import ConeBlock
from synthesis.optimise.conic.linear_rows import LinearBlock
from synthesis.optimise.conic.program import ConicModel
from synthesis.optimise.dual_bound.bound import ROUNDING

LOOSENING = 1e-9
"""Relative, by which every bound is loosened. Dual bounds allow for their own rounding, of about
1e-12; this covers the arithmetic that is done with them, and sizes known this well count as known.
"""
DIRECTIONS = 16
"""In which two sizes are bounded: a polygon of 16 sides is 2 % wider than its circle."""
FAN, TURN = 24, 0.03  # tangents of a circle: most of them, and their step [rad]

Sizes = Sequence[tuple[float, float]]


@dataclass(frozen=True, eq=False)
class HalfSpaces:
    """normals · z ≥ offsets [length]: (r, d) and (r,)."""

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
            LinearBlock.of_size(-unit * normal / each, np.array([-offset / each]), "shared")
            for normal, offset, each in zip(self.normals, self.offsets, scale, strict=True)
            if np.isfinite(offset)
        ]

    def minimise(self, directions: Array, box: Sizes) -> Array:
        """What direction · z is at least in a box, (q, d) to (q,); infinite where no size is left.

        Bounds from the multipliers of linear programs, whatever these are.
        """
        middle, half = _centre_and_half_width(box)
        # y from −1 to 1 and a slack t: normals · half · y + t ≥ offsets − normals · middle
        known = np.isfinite(self.offsets)
        matrix = self.normals[known] * half
        rhs = self.offsets[known] - self.normals[known] @ middle
        length = np.linalg.norm(matrix, axis=1)
        matrix = np.column_stack([matrix / length[:, None], np.ones(len(rhs))])
        # The least slack: a positive one proves that no size is left.
        least_slack = np.append(np.zeros(len(box)), 1.0)[None]
        if _lower_bounds(matrix, rhs / length, least_slack, 4.0)[0] > LOOSENING:
            return np.full(len(directions), inf)
        costs = np.column_stack([directions * half, np.zeros(len(directions))])
        values = _lower_bounds(matrix, rhs / length, costs, 2.0 * LOOSENING)
        return np.asarray(values + directions @ middle)


def _lower_bounds(matrix: Array, rhs: Array, costs: Array, most_slack: float) -> Array:
    """Lower bounds of every cost (q, d + 1) over matrix · (y, t) ≥ rhs, |y| ≤ 1, 0 ≤ t ≤ a most.

    By weak duality: any multipliers z ≥ 0 give one, those of the solver a good one.
    """
    high = np.append(np.ones(matrix.shape[1] - 1), most_slack)
    low = np.append(-high[:-1], 0.0)
    rows = LinearRows(sparse.csc_matrix(-matrix), -rhs, 0, low, high)
    z = np.zeros((len(costs), len(rhs)))
    for k, each in enumerate(minimise_each(rows, list(costs))):
        if each.stopped is StopReason.SOLVED:
            z[k] = np.maximum(each.multipliers, 0.0)
    rest, reach = costs - z @ matrix, np.maximum(np.abs(low), high)
    total = z @ rhs + np.sum(np.minimum(rest * low, rest * high), axis=1)
    magnitude = z @ np.abs(rhs) + (np.abs(rest) + z @ np.abs(matrix)) @ reach
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
    angle = 2.0 * pi / DIRECTIONS * np.arange(DIRECTIONS)
    result = np.zeros((DIRECTIONS, len(box)))
    result[:, open_] = np.stack([np.cos(angle), np.sin(angle)], axis=1) / half[open_]
    result[np.abs(result) * half < LOOSENING] = 0.0  # along the axes
    return result


def cone_tangents(model: ConicModel, cone: ConeBlock, sizes: Sizes) -> Iterator[LinearBlock]:
    """Tangents of a cone on the size, all round where sizes of the box may lie on it."""
    if cone.bound_column is not None or cone.norm is None:
        return
    matrix = cone.matrix[:, model.size]
    corners = np.stack(np.meshgrid(*(np.array(ends) for ends in sizes)), axis=-1)
    images = corners.reshape(-1, len(sizes)) / model.scales.size @ matrix.T + cone.shift
    if images.shape[1] == 2:
        middle = np.mean(images, axis=0)
        main = np.arctan2(*middle)
        off = np.arctan2(*images.T) - main
        off = (off + np.pi) % (2.0 * np.pi) - np.pi
        steps = min(int(np.ceil(np.ptp(off) / TURN)) + 1, FAN)
        angles = main + np.linspace(np.min(off), np.max(off), steps)
        directions = np.stack([np.sin(angles), np.cos(angles)], axis=1)
    else:
        norms = np.linalg.norm(images, axis=1)
        directions = images[norms > 0.0] / norms[norms > 0.0, None]
    for y in directions:
        yield LinearBlock.of_size(y @ matrix, np.array([cone.radius - y @ cone.shift]), cone.source)
