"""Where a free law may bend (knots) and where its limits are written (points)."""

from __future__ import annotations

from bisect import bisect
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from scipy.interpolate import make_interp_spline

from synthesis.catalogue.motion import PlacedSegment
from synthesis.numerics.bspline import SplineSpace
from synthesis.numerics.piecewise import Array, Piecewise

TYPICAL = np.array([1.0, 2.0, 6.0, 48.0])  # sizes of g to g''' in a good law
SAMPLES = 64  # collocation points of a law, about
KNOT_STEP = 2.0**-34  # of the segment: what multipliers say of a knot's place beyond it is rounding
WIDER_STEP = 4.0  # of ramps of two steps: with closer ones the fourth derivative loses digits
CLOSEST_KNOTS = 2.5e-4  # of the segment; closer ones make the rows ill-conditioned
RAMP_STEP = 4e-5
"""Of the segment, between knots of a ramp: from 1e-5 downwards C4 laws lose digits. A law pays for
what is missing while its control rises from the end of a segment: half of this of a C3 law."""


@dataclass(frozen=True, eq=False)
class Grid:
    """Spline space of one free segment, and the points x in [0, 1] of its rows."""

    space: SplineSpace
    points: Array

    def with_points(self, more: Array) -> Grid:
        """The same knots with further points."""
        return Grid(self.space, np.union1d(self.points, more)) if len(more) else self

    @property
    def knots_only(self) -> Grid:
        """The same knots, with points there alone."""
        return Grid(self.space, self.space.breaks)

    def basis_table(self, order: int) -> Array:
        """The ``order``-th derivative of every basis function at the points, made once."""
        if order not in self._basis_tables:
            self._basis_tables[order] = self.space.basis(self.points, order)
        return self._basis_tables[order]

    @cached_property
    def _basis_tables(self) -> dict[int, Array]:
        return {}


@dataclass(frozen=True, eq=False)
class SplineLaw:
    """A law that came out: the spline's space and coefficients."""

    space: SplineSpace
    coefficients: Array

    def curve(self) -> Piecewise:
        """g(x) on [0, 1]."""
        return self.space.curve(self.coefficients)

    def on(self, space: SplineSpace) -> Array:
        """Coefficients on another space of the same degree: equal or finer knots keep the law."""
        if space is self.space:
            return self.coefficients
        values = self.curve()(space.greville)
        spline = make_interp_spline(space.greville, values, space.degree, space.knots)
        return np.asarray(spline.c, dtype=float)


def law_curves(laws: Sequence[SplineLaw]) -> list[Piecewise]:
    """g(x) on [0, 1] of every law; those on one space are made together."""
    result: dict[int, Piecewise] = {}
    for space in {id(law.space): law.space for law in laws}.values():
        own = [k for k, law in enumerate(laws) if law.space is space]
        made = space.curves(np.stack([laws[k].coefficients for k in own]))
        result |= zip(own, made, strict=True)
    return [result[k] for k in range(len(laws))]


def uniform_grid(segment: PlacedSegment, intervals: int) -> Grid:
    """Equal intervals, but for the knots that the law needs; points at every knot and between."""
    assert segment.free is not None
    return _uniform(segment.free.smoothness, segment.free.knots, intervals)


@lru_cache(maxsize=64)
def _uniform(smoothness: int, needed: tuple[float, ...], intervals: int) -> Grid:
    """One grid for every law that begins alike: its tables, made once, serve all of them."""
    beside = knots_beside(np.array(needed), smoothness - 2) if needed else np.zeros(0)
    return _over(smoothness + 1, merge_knots(np.linspace(0.0, 1.0, intervals + 1), beside, needed))


def grid_through(segment: PlacedSegment, breaks: Array) -> Grid:
    """A grid over given breaks: every interval is divided so that about SAMPLES points result."""
    assert segment.free is not None
    return _over(segment.free.smoothness + 1, breaks)


def _over(degree: int, breaks: Array) -> Grid:
    each = max(2, -(-SAMPLES // (len(breaks) - 1)))
    inner = breaks[:-1, None] + np.diff(breaks)[:, None] * (np.arange(each) / each)
    return Grid(SplineSpace(degree, breaks), np.append(inner.ravel(), 1.0))


def knots_beside(places: Array, softer: int) -> Array:
    """Places where a law's limits change at once, and knots beside them for what it does there.

    A law that is smoother than the ideal one by ``softer`` derivatives takes as many intervals, on
    either side.
    """
    step = beside_step(softer)
    result = (places[:, None] + step * np.arange(-softer, softer + 1)).ravel()
    return result[(result > 0.0) & (result < 1.0)]


def beside_step(softer: int) -> float:
    """Distance of knots beside a place where a law smoother by ``softer`` derivatives changes."""
    return 1.01 * CLOSEST_KNOTS * (1.0 if softer < 2 else WIDER_STEP)


def round_knots(x: Array) -> Array:
    """Places for knots, without digits that are but rounding."""
    return np.asarray(np.round(x / KNOT_STEP) * KNOT_STEP, dtype=float)


def merge_knots(
    coarse: Array, wanted: Array, needed: Sequence[float] = (), beside: Sequence[float] = (),
    softer: int = 0, end_steps: tuple[float, float] = (RAMP_STEP, RAMP_STEP),
    ramp_step: float = RAMP_STEP,
) -> Array:  # fmt: skip
    """Breaks through every wanted point, and the coarse ones that keep their distance.

    Where the ideal law's control jumps (at the wanted points, and at both ends), one that is
    smoother by ``softer`` derivatives needs a short ramp: as many intervals, which a B-spline of
    degree ``softer`` takes to rise. Divided differences up to the control's span one interval more,
    so that rows stay well-conditioned however short the ramp is.

    Args:
        coarse: breaks from 0 to 1. wanted: further ones; of those too close the first is taken.
        needed, beside: still others, which come before the wanted ones and have no ramps.
        softer, ramp_step: intervals of every ramp, and their length. end_steps: that at both ends.
    """
    kept, ramped = [0.0, 1.0], list[float]()
    first_ones = (*np.sort(needed), *round_knots(np.sort(beside)))
    for k, x in enumerate((*first_ones, *round_knots(np.sort(wanted)))):
        place = bisect(kept, x)
        if min(abs(x - y) for y in kept[max(place - 1, 0) : place + 1]) >= CLOSEST_KNOTS:
            kept.insert(place, float(x))
            if k >= len(first_ones):
                ramped.append(float(x))
    pinned = np.array(kept)
    spacing = 0.25 / max(len(coarse) - 1, 1)
    pushing = np.setdiff1d(pinned, np.intersect1d(coarse, needed))  # not those that were there
    far = np.min(np.abs(coarse[:, None] - pushing[None, :]), axis=1) > spacing
    result = np.union1d(pinned, coarse[far])
    if softer <= 0:
        return result
    # a ramp about each wanted point in its place, and ramps at the ends
    around = np.array(ramped)[:, None] + ramp_step * (np.arange(softer + 1) - 0.5 * softer)
    first, last = (step * np.arange(softer + 1) for step in end_steps)
    ramps = np.concatenate([around.ravel(), first, 1.0 - last])
    inside = (result >= first[-1] + CLOSEST_KNOTS) & (result <= 1.0 - last[-1] - CLOSEST_KNOTS)
    others = np.union1d(np.setdiff1d(result[inside], ramped), needed)
    return np.union1d(others, round_knots(ramps))


def count_intervals(grids: Sequence[Grid]) -> int:
    """Intervals of all laws."""
    return count_knots(grids) - len(grids)


def count_knots(grids: Sequence[Grid]) -> int:
    """Knots of all laws, their ends among them."""
    return sum(len(grid.space.breaks) for grid in grids)
