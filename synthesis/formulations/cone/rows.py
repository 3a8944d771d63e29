"""Rows of limits and objectives, written on the grid of a free law or on a given law."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from synthesis.formulations.question.ends import Ends
from synthesis.formulations.question.grid import TYPICAL, Grid
from synthesis.motion import Stretch
from synthesis.numerics.bspline import SplineSpace
from synthesis.numerics.digits import rounded
from synthesis.numerics.peaks import peak
from synthesis.numerics.piecewise import Array
from synthesis.terms import Row

ROOM = 0.25  # share of what lies between two bounds that they may be drawn in
CLOSE = 1e-12  # a knot is where a window ends
MONOTONE = 0.02  # share of the tightening that coefficients in order get: there are many of them


@dataclass(frozen=True)
class Scales:
    """Units of the dimensionless unknowns: size variables [mm], level [core units]."""

    size: float
    level: float


@dataclass(frozen=True, eq=False)
class Block:
    """Rows laws · c + size · ζ + level · π ≤ rhs of one kind on one stretch, row-scaled.

    Factors and right-hand sides without their last digits.

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
        spans: (r, 2) where on the law each row's multiplier may be spread, as its limit holds all
            along there; None for rows of the whole law.
        exact: = rhs in place of ≤ rhs.
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
    spans: Array | None = None
    exact: bool = False

    @classmethod
    def of_size(
        cls, size: Array, rhs: Array, source: str, *, level: float = 0.0, tighten: float = 0.0
    ) -> Block:
        """Rows without motion: size (n_size,) or (r, n_size), rhs (r,)."""
        nowhere = np.zeros(len(rhs))
        return cls("size", None, None, nowhere, np.zeros(4), size, level, rhs, source, tighten)

    @cached_property
    def orders(self) -> tuple[int, ...]:
        """The derivatives that ``alpha`` names, in any of its rows."""
        named = self.alpha if self.alpha.ndim == 1 else np.any(self.alpha, axis=1)
        return tuple(named.nonzero()[0].tolist())

    @property
    def highest(self) -> int:
        """The highest derivative that ``alpha`` names; −1: none."""
        return self.orders[-1] if self.orders else -1

    def opposite(self) -> Block:
        """The rows ≥ rhs of an equality, written as ≤."""
        assert self.laws is not None
        return replace(self, laws=-self.laws, alpha=-self.alpha, rhs=-self.rhs, exact=False)

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
    return _scale(row, *in_g(row, stretch), scales)


def _scale(row: Row, alpha: Array, rhs: float, scales: Scales) -> float:
    parts = [*(np.abs(alpha) * TYPICAL).tolist(), abs(row.level * scales.level)]
    parts += [abs(share * scales.size) for share in row.size]
    return float(max(parts) if row.size or row.level else max(*parts, abs(rhs)))


def sampled(row: Row, space: SplineSpace) -> bool:
    """Whether the row is written at points, and may be missed between them."""
    if row.exact or (row.part is not None and row.part[0] == row.part[1]):
        return False
    order = row.orders[0] if len(row.orders) == 1 else 0
    if row.part is not None:
        return space.degree - order > 1
    return order == 0 or (space.degree - order > 1 and order != 3)


def on_law(
    row: Row,
    position: int,
    stretch: Stretch,
    grid: Grid,
    known: Ends,
    scales: Scales,
    drawn: Drawn,
) -> Block:
    """The row on a free stretch: at its points, or on control points where these are exact.

    ``known``: what is settled of the law's ends. A row that a law which never moves backwards
    keeps all along once it keeps it at an end is written there alone.
    """
    alpha, rhs = in_g(row, stretch)
    scale, space = _scale(row, alpha, rhs, scales), grid.space
    if row.part is not None:
        return _on_part(row, row.part, position, stretch, grid, scale, drawn)
    size, level = (share * scales.size for share in row.size), row.level * scales.level
    digits = rounded(np.array([*alpha, level, rhs, *size]) / scale)
    factors, tighten = digits[:4], drawn.tighten
    if not sampled(row, space):
        order = row.orders[0]
        laws = space.control(order) * factors[order]
        x = space.breaks if space.degree - order == 1 else np.zeros(len(laws))
        kind: Literal["point", "control"] = "point" if space.degree - order == 1 else "control"
    else:
        x, kind, tighten = grid.points, "point", tighten + drawn.margin
        first, *others = (factors[k] * grid.table(k) for k in row.orders)
        laws = sum(others, start=first)
        end = _settling_end(alpha, stretch, known)
        if end is not None:
            x, laws = x[end], laws[end]
    bound = np.full(len(laws), digits[5])
    return Block(
        kind, position, laws, x, factors, digits[6:], float(digits[4]), bound, row.source, tighten
    )


def _settling_end(alpha: Array, stretch: Stretch, known: Ends) -> slice | None:
    """The end of a law at which α0 g + α1 g' is largest, whatever the law; None: any x may be.

    With 0 ≤ g ≤ 1 and α1 g' ≤ 0 the end where α0 g is largest is the place, if g' = 0 there.
    """
    assert stretch.free is not None
    if stretch.free.overshoot or alpha[2] != 0.0 or alpha[3] != 0.0 or alpha[1] > 0.0:
        return None
    state, end = (known.start, slice(0, 1)) if alpha[0] <= 0.0 else (known.end, slice(-1, None))
    return end if len(state) > 1 and state[1] == 0.0 else None


def _on_part(
    row: Row,
    part: tuple[float, float],
    position: int,
    stretch: Stretch,
    grid: Grid,
    scale: float,
    drawn: Drawn,
) -> Block:
    """A row of one derivative that holds on a part of the law alone, or at a point of it."""
    alpha, rhs = in_g(row, stretch)
    order, space = row.orders[0], grid.space
    table, x, spans = on_window(space, order, part, grid.points, exact=row.exact)
    factors, bound = rounded(alpha / scale), np.full(len(table), rounded(rhs / scale))
    tighten = min(drawn.tighten + drawn.margin * sampled(row, space), ROOM * row.room / scale)
    laws = table * factors[order]
    return Block(
        "point", position, laws, np.clip(x, *part), factors, np.zeros(0), 0.0, bound, row.source,
        tighten, spans, row.exact,
    )  # fmt: skip


def on_window(
    space: SplineSpace, order: int, part: tuple[float, float], points: Array, *, exact: bool
) -> tuple[Array, Array, Array]:
    """Rows that hold one derivative of a spline on a part of it, or at a point.

    Of an inequality at the points given, but where the derivative is at most linear between
    knots; of an equality as many as determine the derivative on the knot intervals it touches.

    Returns:
        (r, n) rows over all coefficients, (r,) where they stand, (r, 2) what part of the law
        each speaks for.
    """
    low, high = part
    if low == high:
        x = np.array([low])
        return space.basis(x, order), x, np.array([part])
    breaks, degree = space.breaks, space.degree - order
    first = int(np.searchsorted(breaks, low + CLOSE, side="right")) - 1
    last = int(np.searchsorted(breaks, high - CLOSE, side="left"))
    inner = breaks[first + 1 : last]
    ends = np.concatenate([[low], inner, [high]])
    if degree == 0:
        x = 0.5 * (ends[:-1] + ends[1:])
        return space.basis(x, order), x, np.stack([ends[:-1], ends[1:]], axis=1)
    if exact:
        touched = np.concatenate([breaks[first : first + 1], inner, breaks[last : last + 1]])
        x = (
            touched[0]
            + (touched[-1] - touched[0])
            * SplineSpace(degree, (touched - touched[0]) / (touched[-1] - touched[0])).greville
        )
    elif degree == 1:
        x = ends
    else:
        x = np.union1d(points[(points > low) & (points < high)], ends)
    middle = np.clip(0.5 * (x[1:] + x[:-1]), low, high)
    spans = np.stack([np.append(low, middle), np.append(middle, high)], axis=1)
    return space.basis(x, order), x, spans


def inside(row: Row, x: Array) -> NDArray[np.bool_]:
    """Which x of its stretch a row, written at points, speaks of: (n,)."""
    low, high = (0.0, 1.0) if row.part is None else row.part
    return np.asarray((x >= low) & (x <= high))


def on_given(row: Row, stretch: Stretch, scales: Scales, tighten: float) -> Block | None:
    """The row on a given law: its worst angle alone; None where it leaves nothing to choose."""
    if not row.size and not row.level:
        return None
    worst, _ = peak(stretch.placed(), row.coefficients)
    size = np.array(row.size) * scales.size if row.size else np.zeros(0)
    level = row.level * scales.level
    scale = max(np.abs(size).max(initial=0.0), abs(level))
    room = rounded(np.array([(row.upper - worst) / scale]))
    return Block.of_size(
        rounded(size / scale), room, row.source, level=float(rounded(level / scale)),
        tighten=tighten,
    )  # fmt: skip


def half_planes(bounding: Sequence[tuple[Row, float]]) -> tuple[Array, Array]:
    """normals · z ≤ offsets of rows with their worst values on given laws: (k, n), (k,).

    Of size 1, and without their last digits, as in ``on_given``.
    """
    sizes = np.array([row.size for row, _ in bounding])
    room = np.array([row.upper - worst for row, worst in bounding])
    scale = np.max(np.abs(sizes), axis=1)
    return rounded(sizes / scale[:, None]), rounded(room / scale)


def monotone(position: int, grid: Grid, known: Ends, drawn: Drawn) -> Block:
    """Coefficients that never fall: the law never moves backwards."""
    first, stop = len(known.first) - 1, grid.space.size - len(known.last)
    laws = grid.space.steps[first:stop]
    nothing = np.zeros(len(laws))
    return Block(
        "monotone", position, laws, nothing, np.zeros(4), np.zeros(0), 0.0, nothing, "overshoot",
        MONOTONE * drawn.tighten,
    )  # fmt: skip


def exceeded(row: Row, stretch: Stretch, size: Sequence[float]) -> float:
    """How far a row is exceeded at its worst cam angle on a settled stretch (≤ 0: nowhere)."""
    worst = _worst(row, stretch)
    return worst + sum(a * v for a, v in zip(row.size, size, strict=False)) - row.upper


def _worst(row: Row, stretch: Stretch) -> float:
    """The largest value of a row's motion, of an exact one how far it is from its right side."""
    curve = stretch.placed()
    if row.part is not None:
        first, last = (stretch.start + stretch.angle * x for x in row.part)
        if first == last:
            value = float(np.array(row.coefficients) @ curve.derivatives([first])[:, 0])
            return row.upper + abs(value - row.upper) if row.exact else value
        curve = curve.within(first, last)
    worst, _ = peak(curve, row.coefficients)
    if row.exact:
        least, _ = peak(curve, [-a for a in row.coefficients])
        worst = max(worst, 2.0 * row.upper + least)
    return worst
