"""Rows of limits and objectives, written on the grid of a free law or on a given law."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from synthesis.formulations.ends import Ends
from synthesis.formulations.grid import TYPICAL, Grid
from synthesis.motion import Stretch
from synthesis.numerics.bspline import SplineSpace
from synthesis.numerics.peaks import peak
from synthesis.numerics.piecewise import Array
from synthesis.terms import Row

MONOTONE = 0.02  # share of the tightening that coefficients in order get: there are many of them


@dataclass(frozen=True)
class Scales:
    """Units of the dimensionless unknowns: size variables [mm], level [core units]."""

    size: float
    level: float


@dataclass(frozen=True, eq=False)
class Block:
    """Rows laws · c + size · ζ + level · π ≤ rhs of one kind on one stretch, row-scaled.

    Attributes:
        kind: point: Σ alpha_k g^(k)(x) is what the laws' part stands for, at the points x;
            control: a bound on the coefficients of the derivative that ``alpha`` names;
            monotone: coefficients in order; size: no motion in it.
        stretch: position among the free stretches, None for kind size.
        laws: (r, n) over all coefficients of that stretch, None for kind size.
        alpha: (4,), or (4, r) where the rows differ. x: (r,). size: (n_size,), or (r, n_size).
        level, rhs: (r,) the limit itself.
        tighten: by how much the solver is asked to stay below rhs.
        source: the limit or objective behind it.
    """

    kind: Literal["point", "control", "monotone", "size"]
    stretch: int | None
    laws: Array | None
    x: Array
    alpha: Array
    size: Array
    level: float
    rhs: Array
    source: str
    tighten: float = 0.0

    def priced(self, z: Array) -> Array:
        """What multipliers (r,) make of the size's share: (n_size,)."""
        return self.size * float(np.sum(z)) if self.size.ndim == 1 else z @ self.size


@dataclass(frozen=True)
class Drawn:
    """Relative amounts by which rows are drawn in for the solver's sake.

    Attributes:
        tighten: all rows, against the solver's own tolerance.
        margin: rows written at points, against what they miss in between.
    """

    tighten: float = 0.0
    margin: float = 0.0


def in_g(row: Row, stretch: Stretch) -> tuple[Array, float]:
    """The row's factors of g and its derivatives, and what is left of its right-hand side."""
    alpha = np.array(row.coefficients) * stretch.lift / stretch.angle ** np.arange(4)
    return alpha, row.upper - row.coefficients[0] * stretch.s_start


def row_scale(row: Row, stretch: Stretch, scales: Scales) -> float:
    """Natural size of the row's terms: rows are divided by it."""
    alpha, rhs = in_g(row, stretch)
    parts = [*(np.abs(alpha) * TYPICAL), abs(row.level * scales.level)]
    parts += [abs(share * scales.size) for share in row.size]
    return float(max(parts) if row.size or row.level else max(*parts, abs(rhs)))


def sampled(row: Row, space: SplineSpace) -> bool:
    """Whether the row is written at points, and may be missed between them."""
    orders = np.flatnonzero(row.coefficients)
    order = int(orders[0]) if len(orders) == 1 else 0
    return order == 0 or (space.degree - order > 1 and order != 3)


def on_law(
    row: Row, position: int, stretch: Stretch, grid: Grid, scales: Scales, drawn: Drawn
) -> Block:
    """The row on a free stretch: at its points, or on control points where these are exact."""
    alpha, rhs = in_g(row, stretch)
    orders = np.flatnonzero(alpha)
    size = np.array(row.size) * scales.size if row.size else np.zeros(0)
    level = row.level * scales.level
    scale = row_scale(row, stretch, scales)
    space = grid.space
    common = (size / scale, level / scale)
    tighten = drawn.tighten
    if not sampled(row, space):
        order = int(orders[0])
        laws = space.control(order) * (alpha[order] / scale)
        x = space.breaks if space.degree - order == 1 else np.zeros(len(laws))
        kind: Literal["point", "control"] = "point" if space.degree - order == 1 else "control"
    else:
        x, kind, tighten = grid.points, "point", tighten + drawn.margin
        laws = sum((alpha[k] / scale) * space.basis(x, int(k)) for k in orders)
    bound = np.full(len(laws), rhs / scale)
    return Block(kind, position, laws, x, alpha / scale, *common, bound, row.source, tighten)


def on_given(row: Row, stretch: Stretch, scales: Scales, tighten: float) -> Block | None:
    """The row on a given law: its worst angle alone; None where it leaves nothing to choose."""
    if not row.size and not row.level:
        return None
    worst, _ = peak(stretch.placed(), row.coefficients)
    size = np.array(row.size) * scales.size if row.size else np.zeros(0)
    level = row.level * scales.level
    scale = max(np.abs(size).max(initial=0.0), abs(level))
    return Block(
        "size", None, None, np.zeros(1), np.zeros(4), size / scale, level / scale,
        np.array([(row.upper - worst) / scale]), row.source, tighten,
    )  # fmt: skip


def monotone(position: int, grid: Grid, known: Ends, drawn: Drawn) -> Block:
    """Coefficients that never fall: the law never moves backwards."""
    first, stop = len(known.first) - 1, grid.space.size - len(known.last)
    laws = -np.diff(np.eye(grid.space.size), axis=0)[first:stop]
    nothing = np.zeros(len(laws))
    return Block(
        "monotone", position, laws, nothing, np.zeros(4), np.zeros(0), 0.0, nothing, "overshoot",
        MONOTONE * drawn.tighten,
    )  # fmt: skip


def exceeded(row: Row, stretch: Stretch, size: Sequence[float]) -> float:
    """How far a row is exceeded at its worst cam angle on a settled stretch (≤ 0: nowhere)."""
    worst, _ = peak(stretch.placed(), row.coefficients)
    return worst + sum(a * v for a, v in zip(row.size, size, strict=False)) - row.upper
