"""Nonconvex limits as linear rows: at points of free laws, exact half-planes on given ones.

A limit f(s, s', s'', z) ≤ 0 that is not linear (the pressure angle of an arm, the curvature on a
flat face) is a ``NonconvexConstraint``, made by the limit's ``nonconvex``. Its
``linear_relaxation`` gives rows that every motion and size of a region satisfy, tangent at a point
where one is given. They hold for every law with s and s' in the region's bounds, so that dual
bounds made of them hold for all laws.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np

from synthesis.catalogue.constraints import (
    MotionSizeBox,
    NonconvexConstraint,
    PointInequalities,
    Vector,
)
from synthesis.catalogue.motion import PlacedSegment
from synthesis.numerics.double_double import round_mantissa
from synthesis.numerics.piecewise import Array, Piecewise, gauss_points
from synthesis.optimise.conic.law_bounds import LawBounds
from synthesis.optimise.conic.linear_rows import LinearBlock, Scales, Tightening
from synthesis.optimise.conic.semi_infinite import local_maxima
from synthesis.optimise.problem.grid import TYPICAL, Grid

SAMPLES = 64  # on a given segment, about


@dataclass(frozen=True, eq=False)
class TangentPoint:
    """Normalised laws, one per free segment, and a size [length]: where rows shall be tight."""

    laws: tuple[Piecewise, ...]
    size: Vector

    def at(self, position: int, segment: PlacedSegment, x: Array) -> tuple[Array, Vector]:
        """s to s'' at points of a free law, (3, n), and the size."""
        law = self.laws[position]
        g = [segment.lift / segment.angle**order * law(x, order) for order in range(3)]
        return np.stack([segment.s_start + g[0], *g[1:]]), self.size


@dataclass(frozen=True, eq=False)
class Region:
    """Where curved limits are written as rows.

    Attributes:
        sizes: bounds of every size variable that any better cam keeps [length]; none: no rows.
        tangent_points: where the rows are tight; none, or None: all over the region.
        law_bounds: by position, what a free law of a better cam keeps to; of others the ends alone
            are known.
    """

    sizes: tuple[tuple[float, float], ...] = ()
    tangent_points: tuple[TangentPoint | None, ...] = ()
    law_bounds: Mapping[int, LawBounds] = field(default_factory=dict)


def cuts_on_law(
    curve: NonconvexConstraint,
    position: int,
    segment: PlacedSegment,
    grid: Grid,
    scales: Scales,
    tightening: Tightening,
    region: Region,
) -> Iterator[LinearBlock]:
    """Rows at the points of a free law, valid for every law and every size of the region."""
    if not region.sizes:
        return
    within = _within(position, segment, grid.points, region)
    for about in region.tangent_points or (None,):
        place = None if about is None else about.at(position, segment, grid.points)
        for cuts in curve.linear_relaxation(within, place):
            yield cut_block(cuts, curve.source, position, segment, grid, scales, tightening)


def _within(position: int, segment: PlacedSegment, x: Array, region: Region) -> MotionSizeBox:
    """What is known of s and s' at points of a free law, between the nodes of its bounds."""
    assert segment.free is not None
    fast = np.full_like(x, np.inf)
    if position in region.law_bounds:
        bounds = region.law_bounds[position]
        g, speed = bounds.position_bounds(x), bounds.speed_bounds(x)
    elif segment.free.overshoot:
        g, speed = (-fast, fast), (-fast, fast)
    else:
        g, speed = (np.zeros_like(x), np.ones_like(x)), (np.zeros_like(x), fast)
    places = np.sort(segment.s_start + segment.lift * np.stack(g), axis=0)
    speeds = np.sort(segment.lift / segment.angle * np.stack(speed), axis=0)
    return MotionSizeBox(places[0], places[1], speeds[0], speeds[1], region.sizes)


def cut_block(
    cuts: PointInequalities,
    source: str,
    position: int,
    segment: PlacedSegment,
    grid: Grid,
    scales: Scales,
    tightening: Tightening,
    spans: Array | None = None,
    *,
    bare: bool = False,
) -> LinearBlock:
    """Rows at the grid's points, each divided by its natural size.

    Args:
        spans: (r, 2) of the law all along which the rows hold, none across a knot: then the rows
            are their means there. bare: without the splines' matrix, which bounds over all laws do
            not read.
    """
    alpha = cuts.coefficients * (segment.lift / segment.angle ** np.arange(4))[:, None]
    size = cuts.size * scales.size
    scale = np.maximum(
        np.max(np.abs(alpha) * TYPICAL[:, None], axis=0), np.max(np.abs(size), axis=0)
    )
    scale = np.where(scale > 0.0, scale, 1.0)  # of a row of constants alone
    rhs = round_mantissa((cuts.upper - cuts.coefficients[0] * segment.s_start) / scale)
    alpha, size = round_mantissa(alpha / scale), round_mantissa(size / scale)
    laws = np.zeros((len(grid.points), 0 if bare else grid.space.size))
    for k in () if bare else np.flatnonzero(np.any(alpha != 0.0, axis=1)):
        laws += alpha[k][:, None] * _basis(grid, int(k), spans)
    return LinearBlock(
        "point" if spans is None else "mean", position, None if bare else laws, grid.points, alpha,
        size.T, 0.0, rhs, source, tightening.every_row + tightening.sampled_rows, spans,
    )  # fmt: skip


def _basis(grid: Grid, order: int, spans: Array | None) -> Array:
    """A derivative of the grid's splines at its points, or its means over spans (r, 2): (r, n)."""
    space = grid.space
    if spans is None:
        return space.basis(grid.points, order)
    # exact: splines are polynomials of their degree along a span
    points, shares = gauss_points(spans.ravel(), space.degree // 2 + 1)
    points, shares = points[::2], shares[::2] / np.ptp(spans, axis=1)[:, None]
    table = space.basis(points.ravel(), order).reshape(*points.shape, -1)
    return np.asarray(np.einsum("ij,ijk->ik", shares, table))


def cuts_on_given_law(
    curve: NonconvexConstraint, segment: PlacedSegment, scales: Scales, tighten: float
) -> Iterator[LinearBlock]:
    """Half-planes of the size from a given law.

    With one size variable the tightest to either side say all; with more, those at sampled angles
    do nearly.
    """
    placed = segment.placed()
    each = max(2, SAMPLES // placed.count) + 1
    step = np.linspace(0.0, 1.0, each)
    theta = (placed.breaks[:-1, None] + np.diff(placed.breaks)[:, None] * step).ravel()
    piece = np.repeat(np.arange(placed.count), each)
    s = placed.jet(theta, piece, 3)
    families = curve.half_planes(s)
    if not families:
        return
    normals = np.concatenate([cuts.size.T for cuts in families])
    offsets = np.concatenate([cuts.upper for cuts in families])
    if normals.shape[1] == 1:
        result = local_maxima(curve, placed, np.zeros(1))
        sides = [result.normals[:, 0] > 0.0, result.normals[:, 0] < 0.0]
        worst = [
            np.flatnonzero(side)[np.argmin(result.offsets[side])] for side in sides if any(side)
        ]
        normals, offsets = result.normals[worst], result.offsets[worst]
    rows = normals * scales.size
    scale = np.max(np.abs(rows), axis=1)
    rows, slack = round_mantissa(rows / scale[:, None]), round_mantissa(offsets / scale)
    yield LinearBlock.of_size(rows, slack, curve.source, tighten=tighten)
