"""Linear limits and objectives as rows: on the grid of a free law, or on a given law.

A limit Σ a_k s^(k)(θ) + b · z + c P ≤ d (the pressure angle of a roller on a slide, caps of
velocity, acceleration and jerk) becomes rows in the coefficients of the law's spline: s = s_0 + h
g(x), so that s^(k) = h/β^k g^(k). On a given law the largest value of the motion's part is known,
and the row is one half-plane of the size.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from synthesis.catalogue.constraints import LinearInequality
from synthesis.catalogue.motion import PlacedSegment
from synthesis.numerics.bspline import SplineSpace
from synthesis.numerics.double_double import round_mantissa
from synthesis.numerics.maxima import maximise
from synthesis.numerics.piecewise import Array
from synthesis.optimise.problem.boundary import BoundaryState
from synthesis.optimise.problem.grid import TYPICAL, Grid

SHARE_OF_RANGE = 0.25  # of the range between two bounds: how far at most these are tightened
CLOSE = 1e-12  # a knot is where a window ends
MONOTONE = 0.02  # share of the tightening that coefficients in order get: there are many of them


@dataclass(frozen=True)
class Scales:
    """Units of the dimensionless unknowns: size variables [length], level [problem units]."""

    size: float
    level: float


@dataclass(frozen=True, eq=False)
class RowOrigin:
    """What a block was made of: a row of a limit or an objective on a segment, divided by scale."""

    segment: PlacedSegment
    row: LinearInequality
    scale: float


@dataclass(frozen=True, eq=False)
class LinearBlock:
    """Rows laws · c + size · ζ + level · π ≤ rhs of one kind on one segment, row-scaled.

    Factors and right-hand sides without their last digits.

    Attributes:
        kind: point: Σ alpha_k g^(k)(x) is what the laws' part stands for, at the points x; mean:
            the mean of this along each row's span, all along which it is at most rhs; falling,
            rising: the same, weighed linearly, 0 at the end or at the start; control: a
            bound on the coefficients of the derivative that ``alpha`` names; monotone: coefficients
            in order; size: no motion in it.
        segment: position among the free segments, None for kind size.
        law_matrix: (r, n) over all coefficients of that segment, None for kind size.
        alpha: (4,), or (4, r) where the rows differ. size: (n_size,), or (r, n_size).
        x: (r,) never descending. Only where it strictly ascends (``ascending``) are two rows that
            follow each other neighbours on the law, with a density between them.
        level, rhs: (r,) the limit itself.
        tightening: by how much rhs is reduced for the solver's tolerance.
        source: the limit or objective behind it.
        spans: (r, 2) where on the law each row's multiplier may be spread, as its limit holds all
            along there; None for rows of the whole law.
        exact: = rhs in place of ≤ rhs.
        origin: of rows that hold whatever the region; None of cuts, and of rows of no limit.
    """

    kind: Literal["point", "mean", "falling", "rising", "control", "monotone", "size"]
    segment: int | None
    law_matrix: Array | None
    x: Array
    alpha: Array
    size: Array
    level: float
    rhs: Array
    source: str
    tightening: float = 0.0
    spans: Array | None = None
    exact: bool = False
    origin: RowOrigin | None = None

    @classmethod
    def of_size(
        cls, size: Array, rhs: Array, source: str, *, level: float = 0.0, tighten: float = 0.0,
        origin: RowOrigin | None = None,
    ) -> LinearBlock:  # fmt: skip
        """Rows without motion: size (n_size,) or (r, n_size), rhs (r,)."""
        nowhere = np.zeros(len(rhs))
        return cls(
            "size", None, None, nowhere, np.zeros(4), size, level, rhs, source, tighten,
            origin=origin,
        )  # fmt: skip

    @cached_property
    def orders(self) -> tuple[int, ...]:
        """The derivatives that ``alpha`` names, in any of its rows."""
        named = self.alpha if self.alpha.ndim == 1 else np.any(self.alpha, axis=1)
        return tuple(named.nonzero()[0].tolist())

    @property
    def highest_order(self) -> int:
        """The highest derivative that ``alpha`` names; −1: none."""
        return self.orders[-1] if self.orders else -1

    @property
    def ascending(self) -> bool:
        """Whether there are several points, each beyond the one before."""
        return len(self.x) > 1 and bool(np.all(self.x[1:] > self.x[:-1]))

    def inequalities(self) -> tuple[LinearBlock, LinearBlock]:
        """An equality as two inequalities, ≤ rhs and −laws · c ≤ −rhs."""
        assert self.law_matrix is not None
        below = replace(self, exact=False)
        above = replace(below, law_matrix=-self.law_matrix, alpha=-self.alpha, rhs=-self.rhs)
        return below, above


@dataclass(frozen=True)
class Tightening:
    """Relative amounts by which rows are drawn in for the solver's sake.

    Attributes:
        every_row: all rows, against the solver's own tolerance.
        sampled_rows: rows written at points, against what they miss in between.
    """

    every_row: float = 0.0
    sampled_rows: float = 0.0


def in_normalised_law(row: LinearInequality, segment: PlacedSegment) -> tuple[Array, float]:
    """The row's factors of g and its derivatives, and what is left of its right-hand side."""
    alpha = np.array(row.coefficients) * segment.lift / segment.angle ** np.arange(4)
    return alpha, row.upper - row.coefficients[0] * segment.s_start


def row_scale(row: LinearInequality, segment: PlacedSegment, scales: Scales) -> float:
    """Natural size of the row's terms: rows are divided by it."""
    alpha, rhs = in_normalised_law(row, segment)
    parts = [*(np.abs(alpha) * TYPICAL).tolist(), abs(row.level * scales.level)]
    parts += [abs(share * scales.size) for share in row.size]
    return float(max(parts) if row.size or row.level else max(*parts, abs(rhs)))


def is_sampled(row: LinearInequality, space: SplineSpace) -> bool:
    """Whether the row is written at points, and may be missed between them."""
    if row.equality or (row.interval is not None and row.interval[0] == row.interval[1]):
        return False
    order = row.orders[0] if len(row.orders) == 1 else 0
    if row.interval is not None:
        return space.degree - order > 1
    return order == 0 or (space.degree - order > 1 and order != 3)


def rows_on_law(
    row: LinearInequality,
    position: int,
    segment: PlacedSegment,
    grid: Grid,
    boundary: BoundaryState,
    scales: Scales,
    tightening: Tightening,
) -> LinearBlock:
    """The row on a free segment: at its points, or on control points where these are exact.

    ``boundary``: the known ends of the law. A row that a law which never moves backwards
    keeps all along once it keeps it at an end is written there alone.
    """
    alpha, rhs = in_normalised_law(row, segment)
    scale, space = row_scale(row, segment, scales), grid.space
    if row.interval is not None:
        return _row_on_window(row, row.interval, position, segment, grid, scale, tightening)
    size, level = (share * scales.size for share in row.size), row.level * scales.level
    digits = round_mantissa(np.array([*alpha, level, rhs, *size]) / scale)
    factors, tighten = digits[:4], tightening.every_row
    if not is_sampled(row, space):
        order = row.orders[0]
        laws = space.control_matrices[order] * factors[order]
        x = space.breaks if space.degree - order == 1 else np.zeros(len(laws))
        kind: Literal["point", "control"] = "point" if space.degree - order == 1 else "control"
    else:
        x, kind, tighten = grid.points, "point", tighten + tightening.sampled_rows
        first, *others = (factors[k] * grid.basis_table(k) for k in row.orders)
        laws = sum(others, start=first)
        end = _worst_end(alpha, segment, boundary)
        if end is not None:
            x, laws = x[end], laws[end]
    bound = np.full(len(laws), digits[5])
    return LinearBlock(
        kind, position, laws, x, factors, digits[6:], float(digits[4]), bound, row.source, tighten,
        origin=RowOrigin(segment, row, scale),
    )  # fmt: skip


def _worst_end(alpha: Array, segment: PlacedSegment, boundary: BoundaryState) -> slice | None:
    """The end of a law at which α0 g + α1 g' is largest, whatever the law; None: any x may be.

    With 0 ≤ g ≤ 1 and α1 g' ≤ 0 the end where α0 g is largest is the place, if g' = 0 there.
    """
    assert segment.free is not None
    if segment.free.overshoot or alpha[2] != 0.0 or alpha[3] != 0.0 or alpha[1] > 0.0:
        return None
    state, end = (
        (boundary.start, slice(0, 1)) if alpha[0] <= 0.0 else (boundary.end, slice(-1, None))
    )
    return end if len(state) > 1 and state[1] == 0.0 else None


def _row_on_window(
    row: LinearInequality,
    part: tuple[float, float],
    position: int,
    segment: PlacedSegment,
    grid: Grid,
    scale: float,
    tightening: Tightening,
) -> LinearBlock:
    """A row of one derivative that holds on a part of the law alone, or at a point of it."""
    alpha, rhs = in_normalised_law(row, segment)
    order, space = row.orders[0], grid.space
    x, spans = _window_points(space, order, part, grid.points, exact=row.equality)
    factors, bound = round_mantissa(alpha / scale), np.full(len(x), round_mantissa(rhs / scale))
    tighten = min(
        tightening.every_row + tightening.sampled_rows * is_sampled(row, space),
        SHARE_OF_RANGE * row.range_width / scale,
    )
    laws = space.basis(x, order) * factors[order]
    return LinearBlock(
        "point", position, laws, np.clip(x, *part), factors, np.zeros(0), 0.0, bound, row.source,
        tighten, spans, row.equality, RowOrigin(segment, row, scale),
    )  # fmt: skip


def _window_points(
    space: SplineSpace, order: int, part: tuple[float, float], points: Array, *, exact: bool
) -> tuple[Array, Array]:
    """Where rows hold one derivative of a spline on a part of it (r,), and what part each speaks
    for (r, 2).

    Of an inequality at the points given, but where the derivative is at most linear between
    knots; of an equality as many as determine the derivative on the knot intervals it touches.
    """
    low, high = part
    if low == high:
        return np.array([low]), np.array([part])
    breaks, degree = space.breaks, space.degree - order
    first = int(np.searchsorted(breaks, low + CLOSE, side="right")) - 1
    last = int(np.searchsorted(breaks, high - CLOSE, side="left"))
    inner = breaks[first + 1 : last]
    ends = np.concatenate([[low], inner, [high]])
    if degree == 0:
        return 0.5 * (ends[:-1] + ends[1:]), np.stack([ends[:-1], ends[1:]], axis=1)
    if exact:
        touched = breaks[first : last + 1]
        start, width = touched[0], touched[-1] - touched[0]
        x = start + width * SplineSpace(degree, (touched - start) / width).greville
    elif degree == 1:
        x = ends
    else:
        x = np.union1d(points[(points > low) & (points < high)], ends)
    middle = np.clip(0.5 * (x[1:] + x[:-1]), low, high)
    return x, np.stack([np.append(low, middle), np.append(middle, high)], axis=1)


def applies_at(row: LinearInequality, x: Array) -> NDArray[np.bool_]:
    """Which x of its segment a row, written at points, speaks of: (n,)."""
    low, high = (0.0, 1.0) if row.interval is None else row.interval
    return np.asarray((x >= low) & (x <= high))


def row_on_given_law(
    row: LinearInequality, segment: PlacedSegment, scales: Scales, tighten: float
) -> LinearBlock | None:
    """The row on a given law: its worst angle alone; None where it leaves nothing to choose."""
    if not row.size and not row.level:
        return None
    worst, _ = maximise(segment.placed(), row.coefficients)
    size = np.array(row.size) * scales.size if row.size else np.zeros(0)
    level = row.level * scales.level
    scale = max(np.abs(size).max(initial=0.0), abs(level))
    slack = round_mantissa(np.array([(row.upper - worst) / scale]))
    return LinearBlock.of_size(
        round_mantissa(size / scale), slack, row.source, level=float(round_mantissa(level / scale)),
        tighten=tighten, origin=RowOrigin(segment, row, scale),
    )  # fmt: skip


def monotonicity_rows(
    position: int, grid: Grid, boundary: BoundaryState, tightening: Tightening
) -> LinearBlock:
    """Coefficients that never fall: the law never moves backwards."""
    first, stop = len(boundary.first) - 1, grid.space.size - len(boundary.last)
    laws = grid.space.step_matrix[first:stop]
    nothing = np.zeros(len(laws))
    return LinearBlock(
        "monotone", position, laws, nothing, np.zeros(4), np.zeros(0), 0.0, nothing, "overshoot",
        MONOTONE * tightening.every_row,
    )  # fmt: skip


def row_excess(row: LinearInequality, segment: PlacedSegment, size: Sequence[float]) -> float:
    """How far a row is exceeded at its worst cam angle on a given segment (≤ 0: nowhere)."""
    worst = _worst(row, segment)
    return worst + sum(a * v for a, v in zip(row.size, size, strict=False)) - row.upper


def _worst(row: LinearInequality, segment: PlacedSegment) -> float:
    """The largest value of a row's motion, of an exact one how far it is from its right side."""
    curve = segment.placed()
    if row.interval is not None:
        first, last = (segment.start + segment.angle * x for x in row.interval)
        if first == last:
            value = float(np.array(row.coefficients) @ curve.derivatives([first])[:, 0])
            return row.upper + abs(value - row.upper) if row.equality else value
        curve = curve.restrict(first, last)
    worst, _ = maximise(curve, row.coefficients)
    if row.equality:
        least, _ = maximise(curve, [-a for a in row.coefficients])
        worst = max(worst, 2.0 * row.upper + least)
    return worst
