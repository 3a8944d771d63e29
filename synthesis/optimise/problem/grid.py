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
    beside = ramp_knots(np.array(needed), smoothness - 2) if needed else np.zeros(0)
    return _over(smoothness + 1, merge_knots(np.linspace(0.0, 1.0, intervals + 1), beside, needed))


def grid_through(segment: PlacedSegment, breaks: Array) -> Grid:
    """A grid over given breaks: every interval is divided so that about SAMPLES points result."""
    assert segment.free is not None
    return _over(segment.free.smoothness + 1, breaks)


def _over(degree: int, breaks: Array) -> Grid:
    each = max(2, -(-SAMPLES // (len(breaks) - 1)))
    inner = breaks[:-1, None] + np.diff(breaks)[:, None] * (np.arange(each) / each)
    return Grid(SplineSpace(degree, breaks), np.append(inner.ravel(), 1.0))


def ramp_knots(switches: Array, softer: int) -> Array:
    """Knots for a law that is smoother than the ideal one by ``softer`` derivatives.

    Where the ideal law's control jumps (at a switch, and at both ends), a smoother
    one needs a short ramp: knots at the switch and as close beside it as knots may lie.
    """
    step = ramp_step(softer)
    around = (switches[:, None] + step * np.arange(-softer, softer + 1)).ravel()
    ends = step * np.arange(1, softer + 1)
    result = np.concatenate([around, ends, 1.0 - ends])
    return result[(result > 0.0) & (result < 1.0)]


def ramp_step(softer: int) -> float:
    """Distance of a ramp's knots for a law that is smoother by ``softer`` derivatives."""
    return 1.01 * CLOSEST_KNOTS * (1.0 if softer < 2 else WIDER_STEP)


def round_knots(x: Array) -> Array:
    """Places for knots, without digits that are but rounding."""
    return np.asarray(np.round(x / KNOT_STEP) * KNOT_STEP, dtype=float)


def merge_knots(coarse: Array, wanted: Array, needed: Sequence[float] = ()) -> Array:
    """Breaks through every wanted point, and the coarse ones that keep their distance.

    Args:
        coarse: breaks from 0 to 1. wanted: further ones; of those too close the first is taken.
        needed: still others, which come before the wanted ones.
    """
    kept = [0.0, 1.0]
    for x in (*np.sort(needed), *round_knots(np.sort(wanted))):
        place = bisect(kept, x)
        if min(abs(x - other) for other in kept[max(place - 1, 0) : place + 1]) >= CLOSEST_KNOTS:
            kept.insert(place, float(x))
    pinned = np.array(kept)
    spacing = 0.25 / max(len(coarse) - 1, 1)
    pushing = np.setdiff1d(pinned, np.intersect1d(coarse, needed))  # not those that were there
    far = np.min(np.abs(coarse[:, None] - pushing[None, :]), axis=1) > spacing
    return np.union1d(pinned, coarse[far])
