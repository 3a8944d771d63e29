"""Curved limits as rows: point by point on free laws, exact half-planes on given ones."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from synthesis.formulations.cone.exchange import peaks
from synthesis.formulations.cone.rows import Block, Drawn, Scales
from synthesis.formulations.cone.tubing import Tube
from synthesis.formulations.question.grid import TYPICAL, Grid
from synthesis.formulations.question.problem import Problem
from synthesis.motion import Stretch
from synthesis.numerics.digits import rounded
from synthesis.numerics.piecewise import Array, Piecewise
from synthesis.terms import Curved, Cuts, Vector, Within

SAMPLES = 64  # on a given stretch, about


@dataclass(frozen=True, eq=False)
class About:
    """Normalised laws, one per free stretch, and a size [mm]: where rows shall be tight."""

    laws: tuple[Piecewise, ...]
    size: Vector

    def at(self, position: int, stretch: Stretch, x: Array) -> tuple[Array, Vector]:
        """s to s'' at points of a free law, (3, n), and the size."""
        law = self.laws[position]
        g = [stretch.lift / stretch.angle**order * law(x, order) for order in range(3)]
        return np.stack([stretch.s_start + g[0], *g[1:]]), self.size


@dataclass(frozen=True, eq=False)
class Region:
    """Where curved limits are written as rows.

    Attributes:
        sizes: bounds of every size variable that any better cam keeps [mm]; none: no rows.
        abouts: where the rows are tight; none: all over the region.
        tubes: what every free law of a better cam keeps to; none: its ends alone are known.
    """

    sizes: tuple[tuple[float, float], ...] = ()
    abouts: tuple[About, ...] = ()
    tubes: tuple[Tube, ...] = ()

    @classmethod
    def whole(cls, problem: Problem) -> Region:
        """All that the problem allows."""
        return cls(problem.sizing.bounds)


def on_law(
    curve: Curved,
    position: int,
    stretch: Stretch,
    grid: Grid,
    scales: Scales,
    drawn: Drawn,
    region: Region,
) -> Iterator[Block]:
    """Rows at the points of a free law, valid for every law and every size of the region."""
    if not region.sizes:
        return
    within = _within(position, stretch, grid.points, region)
    if not region.abouts:
        for cuts in curve.cuts(within, None):
            yield block(cuts, curve.source, position, stretch, grid, scales, drawn)
    for about in region.abouts:
        for cuts in curve.cuts(within, about.at(position, stretch, grid.points)):
            yield block(cuts, curve.source, position, stretch, grid, scales, drawn)


def _within(position: int, stretch: Stretch, x: Array, region: Region) -> Within:
    """What is known of s and s' at points of a free law."""
    assert stretch.free is not None
    if region.tubes:
        return inside(region.tubes[position], stretch, x, region.sizes)
    low, high = np.zeros_like(x), np.ones_like(x)
    slow, fast = np.zeros_like(x), np.full_like(x, np.inf)
    if stretch.free.overshoot:
        low, high, slow = -fast, fast, -fast
    return _in_mm(stretch, (low, high), (slow, fast), region.sizes)


def inside(
    tube: Tube, stretch: Stretch, x: Array, sizes: tuple[tuple[float, float], ...]
) -> Within:
    """What a tube says of s and s' at points of a free law, all of them between its nodes."""
    return _in_mm(stretch, tube.positions(x), tube.speeds(x), sizes)


def _in_mm(
    stretch: Stretch,
    position: tuple[Array, Array],
    speed: tuple[Array, Array],
    sizes: tuple[tuple[float, float], ...],
) -> Within:
    """From bounds of g and g' to those of s and s'."""
    (low, high), (slow, fast) = position, speed
    places = np.sort(stretch.s_start + stretch.lift * np.stack([low, high]), axis=0)
    speeds = np.sort(stretch.lift / stretch.angle * np.stack([slow, fast]), axis=0)
    return Within(places[0], places[1], speeds[0], speeds[1], sizes)


def block(
    cuts: Cuts,
    source: str,
    position: int,
    stretch: Stretch,
    grid: Grid,
    scales: Scales,
    drawn: Drawn,
    *,
    bare: bool = False,
) -> Block:
    """Rows at the grid's points, each divided by its natural size.

    ``bare``: without the splines' matrix, which bounds over all laws do not read.
    """
    alpha = cuts.coefficients * (stretch.lift / stretch.angle ** np.arange(4))[:, None]
    size = cuts.size * scales.size
    scale = np.maximum(
        np.max(np.abs(alpha) * TYPICAL[:, None], axis=0), np.max(np.abs(size), axis=0)
    )
    rhs = rounded((cuts.upper - cuts.coefficients[0] * stretch.s_start) / scale)
    alpha, size = rounded(alpha / scale), rounded(size / scale)
    laws = np.zeros((len(grid.points), 0 if bare else grid.space.size))
    for k in () if bare else np.flatnonzero(np.any(alpha != 0.0, axis=1)):
        laws += alpha[k][:, None] * grid.space.basis(grid.points, int(k))
    return Block(
        "point", position, None if bare else laws, grid.points, alpha, size.T, 0.0, rhs,
        source, drawn.tighten + drawn.margin,
    )  # fmt: skip


def on_given(curve: Curved, stretch: Stretch, scales: Scales, tighten: float) -> Iterator[Block]:
    """Half-planes of the size from a given law.

    With one size variable the tightest to either side say all; with more, those at sampled angles
    do nearly.
    """
    placed = stretch.placed()
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
        found = peaks(curve, placed, np.zeros(1))
        sides = [found.normals[:, 0] > 0.0, found.normals[:, 0] < 0.0]
        worst = [
            np.flatnonzero(side)[np.argmin(found.offsets[side])] for side in sides if any(side)
        ]
        normals, offsets = found.normals[worst], found.offsets[worst]
    rows = normals * scales.size
    scale = np.max(np.abs(rows), axis=1)
    rows, room = rounded(rows / scale[:, None]), rounded(offsets / scale)
    yield Block.of_size(rows, room, curve.source, tighten=tighten)
