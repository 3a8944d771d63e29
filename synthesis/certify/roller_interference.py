"""Interference of the roller with far parts of its own profile, by branch and bound.

O(θ) is the profile beside the traced curve P(θ), at the roller's radius R. A profile without
undercut can still intersect itself where far parts of it come together: in a lobe thinner than the
roller, or a hollow with a narrow mouth. Some position of the roller then reaches into another part
of the profile. There is no such interference if

    |O(θ) − P(φ)| ≥ R   for all cam angles θ, φ,

that is, if P has a global radius of curvature of at least R towards the cam (Gonzalez & Maddocks,
PNAS 96 (1999) 4769). Pairs (θ, φ) are excluded by the following four arguments.

**Near pairs**: along one of the two arcs of P between θ and φ the tangent's angle varies by less
than π. These satisfy the condition if the curvature is nowhere above 1/R, which is what the limit
``profile_radius`` checks; every spec of a roller has it. Proof: choose an axis m that has a
positive product with every tangent of the arc. Over it the arc is the graph of a function whose
slope angle σ satisfies d(sin σ)/dm ≥ −1/R, with equality for the circle of radius R that touches
the arc at θ. So the arc lies above that circle as far as the circle's own upper half reaches, and
beside it beyond. The centre of that circle is O(θ). Corners that turn away from the circle only
increase the distance.

**Curves around the axis** (excluded in ``self_intersection``, before this search): where P is
smooth and its tangent lines all pass the axis on the inner side at more than R, n · P > R. Then
P(θ) − (R − d) n has n · P > 0 too, for every d from 0 to R. Without undercut its polar angle is
therefore monotone, and it runs once round the axis as P does. So all these parallel curves are
simple and nested, and P(φ), which lies on the outermost, is on no other. If O(θ) were the profile's
nearest point to P(φ), at less than R, then P(φ) would lie on the normal at θ at that height above
O(θ), which is a point of an inner parallel curve: a contradiction. Where the profile lies outside
P the same holds for P + d n, for which n · P > 0 suffices.

**Pairs in different directions**: seen from the axis, the roller at φ fills the angle
± arcsin R/|P(φ)| about its centre, and O(θ) lies in the same range about P(θ). If these ranges are
disjoint, O(θ) is outside the roller. On most cams this leaves no far pair at all.

**All other pairs** are bounded by branch and bound over pairs of intervals. Two chords with
midpoints at the distance vector D are at least |D| − |a·D̂| − |b·D̂| apart, a and b their half
vectors, less the thickness of both enclosures. Where two curves are nearest they are perpendicular
to D, so the bound converges quadratically.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final

import numpy as np

from synthesis.catalogue.followers.kinematics import Vector2
from synthesis.certify.piecewise_motion import PiecewiseMotion
from synthesis.numerics.box_search import Boxes, BoxSearch, Budget
from synthesis.numerics.piecewise import Array, Indices, Mask
from synthesis.numerics.taylor import ROUNDING, Taylor
from synthesis.units import FULL_TURN

# Subdivision and effort. They decide how fast, and whether at all, a pair is excluded.
WIDEST: Final = FULL_TURN / 48.0  # of a first interval [rad]
LARGEST_TURNING: Final = 0.6  # an interval on which the tangent turns by more is divided [rad]
NARROWEST: Final = 1e-12  # an interval is not divided below this width [rad]
MAX_INTERVALS: Final = 2_000
MAX_GROUPS: Final = 96
MAX_PAIRS: Final = 400_000
PARTS: Final = 4  # into which an interval is divided
MAX_LEVELS: Final = 10

# Tolerances, relative to the roller's radius.
HARMLESS_DEPTH: Final = 1e-9  # interference of so little depth counts as none
FINE_WIDTH: Final = 1e-9  # width of the enclosure of the smallest distance that suffices

# Rounding errors.
DISTANCE_ROUNDING: Final = 2.0**-46  # relative to the coordinates: 128 roundings
ANGLE_ROUNDING: Final = 1e-12  # of angles that are continued round the turn and compared [rad]

TraceFunction = Callable[[Any], tuple[Vector2, ...]]  # s to s''' -> p and its derivatives


@dataclass(frozen=True, eq=False)
class ThickChords:
    """A plane curve on n intervals, each within ``thickness`` of the chord middle ± half [mm].

    ``point``: (2, n) the curve's own at the interval's centre, to within ``error`` (n,) [mm].
    """

    middle: Array
    half: Array
    thickness: Array
    point: Array
    error: Array

    @classmethod
    def of(cls, x: Taylor, y: Taylor) -> ThickChords:
        """c0 + c1 t + c2 t² ± rem, |t| ≤ 1, lies within |c2|/2 + |rem| of c0 + c2/2 + c1 t."""
        bend, rem = np.stack([x.c2, y.c2]), np.stack([x.rem, y.rem])
        point, error = np.stack([x.c0, y.c0]), np.hypot(*rem)
        thickness = 0.5 * np.hypot(*bend) + error
        return cls(point + 0.5 * bend, np.stack([x.c1, y.c1]), thickness, point, error)


@dataclass(frozen=True, eq=False)
class ProfileModels:
    """Traced curve and profile on intervals: p and T = D p in the machine frame, as models."""

    intervals: Boxes
    p: Vector2
    tangent: Vector2
    distance: float

    @cached_property
    def theta(self) -> Taylor:
        """The cam angle itself."""
        lo, hi = self.intervals.lo, self.intervals.hi
        centre, half = 0.5 * (lo + hi), 0.5 * (hi - lo)
        return Taylor.of(centre, half, np.zeros_like(half), ROUNDING * hi)

    @cached_property
    def tangent_angle(self) -> tuple[Array, Array]:
        """Lower and upper end of the tangent's angle on the cam, clockwise positive [rad].

        On each interval the angle is within half a turn of its value at the centre; it is not
        continued from interval to interval.
        """
        tx, ty = self.tangent
        return _range(self.theta - np.arctan2(ty, tx))

    def polar_range(self) -> tuple[Array, Array]:
        """Lower and upper end of the polar angle on the cam of every point of the roller [rad].

        The profile point that it touches is one of them. The whole turn where the roller may cover
        the axis: seen from there, a circle of radius R at distance r fills ± arcsin R/r.
        """
        px, py = self.p
        low, high = _range(np.arctan2(py, px) - self.theta)
        square = px * px + py * py
        # ROUNDING is 32 roundings: more than those of r, of R/r and of the arc sine's argument
        least = square.mignitude() - ROUNDING * square.mag
        nearest = np.sqrt(np.where(least > 0.0, least, np.nan))
        sine = abs(self.distance) / nearest
        half = np.arcsin(np.where(sine < 1.0, sine, np.nan))
        known = np.isfinite(low + high + half)
        return np.where(known, low - half, -math.pi), np.where(known, high + half, math.pi)

    def chords(self) -> tuple[ThickChords, ThickChords]:
        """Enclosures of the profile and of the traced curve, in the frame of the cam."""
        (px, py), (tx, ty) = self.p, self.tangent
        share = self.distance / np.sqrt(tx * tx + ty * ty)
        cos, sin = np.cos(self.theta), np.sin(self.theta)
        profile, traced = (
            ThickChords.of(x * cos + y * sin, y * cos - x * sin)  # turned by −θ
            for x, y in ((px + ty * share, py - tx * share), (px, py))  # n = (−ty, tx)/|T|
        )
        return profile, traced


def _range(angle: Taylor) -> tuple[Array, Array]:
    """Lower and upper end of an angle's model on each interval."""
    reach = np.abs(angle.c1) + np.abs(angle.c2) + angle.rem
    return angle.c0 - reach, angle.c0 + reach


@dataclass(frozen=True, eq=False)
class OffsetProfile:
    """The traced curve P on the cam, and the profile O = P − d n at a signed distance d [mm].

    P runs clockwise; n is its normal to the left, which points outward. |d| is the radius of the
    roller; d is negative where the cam lies outside the traced curve.
    """

    motion: PiecewiseMotion
    trace: TraceFunction
    distance: float

    def models(self, intervals: Boxes) -> ProfileModels:
        """Both curves on intervals."""
        s = self.motion.jets.models(intervals.piece, intervals.lo, intervals.hi, 1)
        (px, py), (dx, dy), *_ = self.trace((*s, 0.0, 0.0))
        return ProfileModels(intervals, (px, py), (dx + py, dy - px), self.distance)


@dataclass(frozen=True)
class NearestPair:
    """How near the roller comes to far parts of the profile, in so many pairs of intervals.

    Attributes:
        distance: smallest distance found from a roller centre to the profile among the pairs that
            had to be examined [mm]; ∞ if there was none, or if the tangent angle is not known.
        lower_bound: proven lower bound of that distance over all far pairs [mm]; at least
            (1 − 1e-9) R if there is no interference.
        profile_angle, roller_angle: cam angles θ and φ of the pair found [rad].
    """

    distance: float
    lower_bound: float
    profile_angle: float
    roller_angle: float
    pairs: int

    def excludes_interference(self, radius: float) -> bool:
        """Whether it is proven that a roller of this radius reaches into no far part."""
        return self.lower_bound >= radius * (1.0 - HARMLESS_DEPTH)


def nearest_far_pair(profile: OffsetProfile) -> NearestPair:
    """Smallest distance of the roller centre from far parts of the profile, enclosed.

    The enclosure is narrow only if the distance is below the roller's radius.
    """
    with np.errstate(all="ignore"):
        # 1. intervals on which the tangent turns little
        intervals, models = _divided_by_turning(profile)
        low, high = models.tangent_angle
        unknown = ~np.isfinite(high - low)
        if unknown.any():
            where = float(intervals.lo[np.argmax(unknown)])
            return NearestPair(math.inf, 0.0, where, where, 0)
        # 2. exclude pairs in different directions and near pairs, by groups of intervals
        first = np.arange(0, len(intervals), math.ceil(len(intervals) / MAX_GROUPS))
        excluded = groups_apart(first, *models.polar_range()) | near_groups(first, low, high)
        # 3. branch and bound on the pairs of intervals that are left
        owner = np.searchsorted(first, np.arange(len(intervals)), side="right") - 1
        pairs = _Pairs(intervals, *np.nonzero(~excluded[owner][:, owner]))
        return _Search(profile).nearest(pairs)


def _divided_by_turning(profile: OffsetProfile) -> tuple[Boxes, ProfileModels]:
    """Boxes divided until the tangent turns little on each, and the models on them."""
    intervals = profile.motion.intervals(WIDEST)
    while True:
        models = profile.models(intervals)
        low, high = models.tangent_angle
        wide = ~(high - low <= LARGEST_TURNING)
        narrow = not wide.any() or np.min((intervals.hi - intervals.lo)[wide]) < NARROWEST
        if narrow or len(intervals) >= MAX_INTERVALS:
            return intervals, models
        finer = intervals.take(np.flatnonzero(wide)).split(PARTS)
        both = intervals.take(np.flatnonzero(~wide)).append(finer)
        intervals = both.take(np.lexsort((both.lo, both.piece)))


def near_groups(first: Indices, low: Array, high: Array) -> Mask:
    """Pairs of groups along one of the arcs between which the tangent turns less than π.

    ``first``: (n,) first interval of every group of consecutive intervals; ``low``, ``high``: ends
    of the tangent's angle on every interval [rad].
    """
    # neighbours share a point: their angles there differ by a corner, less than half a turn
    (bottom, top), turn = _continued(first, low, high)
    count = len(first)
    start = np.arange(count)[:, None]
    arcs = start + np.arange(count)
    bottom, top = (np.concatenate([each, each + turn])[arcs] for each in (bottom, top))
    turning = np.maximum.accumulate(top, axis=1) - np.minimum.accumulate(bottom, axis=1)
    forward = np.zeros((count, count), dtype=bool)
    forward[start, arcs % count] = turning < math.pi - ANGLE_ROUNDING
    return np.asarray(forward | forward.T)


def groups_apart(first: Indices, low: Array, high: Array) -> Mask:
    """Pairs of groups in different directions, by the ends of the polar angle on every interval."""
    (bottom, top), _ = _continued(first, low, high)
    middle, half = 0.5 * (bottom + top), 0.5 * (top - bottom)
    between = middle[:, None] - middle
    between -= FULL_TURN * np.round(between / FULL_TURN)
    return np.asarray(np.abs(between) > half[:, None] + half + ANGLE_ROUNDING)


def _continued(first: Indices, low: Array, high: Array) -> tuple[tuple[Array, Array], float]:
    """Smallest and largest angle in every group, continued round the turn, and the total gain.

    Where the continuation picks the wrong turn, a group's range is too wide, never too narrow.
    """
    middle = 0.5 * (low + high)
    wraps = np.cumsum(np.round(np.diff(middle, append=middle[0]) / FULL_TURN))
    shift = np.append(0.0, wraps[:-1]) * -FULL_TURN
    ends = np.minimum.reduceat(low + shift, first), np.maximum.reduceat(high + shift, first)
    return ends, -FULL_TURN * float(wraps[-1])


@dataclass(frozen=True, eq=False)
class _Pairs:
    """Pairs of intervals: number ``first`` (n,) on the profile, ``second`` on the roller's path."""

    intervals: Boxes
    first: Indices
    second: Indices


class _Search(BoxSearch[_Pairs]):
    """Box search over pairs for the smallest distance: the box search maximises its negative."""

    children = PARTS * PARTS

    def __init__(self, profile: OffsetProfile) -> None:
        self.profile = profile
        self.radius = abs(profile.distance)
        self.distance, self.profile_angle, self.roller_angle = math.inf, 0.0, 0.0
        self.pairs = 0

    def nearest(self, pairs: _Pairs) -> NearestPair:
        """The smallest distance of these pairs and its lower bound."""
        if len(pairs.first):
            self.run(pairs, Budget(MAX_LEVELS, MAX_PAIRS))
        # of pruned pairs it is enough to know that they are at least at the threshold
        lower = max(min(-self.threshold(), -float(self.proven)), 0.0)
        return NearestPair(self.distance, lower, self.profile_angle, self.roller_angle, self.pairs)

    def threshold(self) -> float:
        """A pair is pruned if it is harmless, or no nearer than the nearest one found."""
        harmless = self.radius * (1.0 - HARMLESS_DEPTH)
        return -min(harmless, self.distance - FINE_WIDTH * self.radius)

    def bound(self, boxes: _Pairs) -> Array:
        """Negative lower bounds of the distances; the nearest pair of centres is the incumbent."""
        i, j = boxes.first, boxes.second
        self.pairs += len(i)
        profile, traced = self.profile.models(boxes.intervals).chords()
        # lower bound between two thick chords (see the head of this file)
        dx, dy = profile.middle[:, i] - traced.middle[:, j]
        apart = _length(dx, dy)
        a, b = profile.half[:, i], traced.half[:, j]
        along = (np.abs(a[0] * dx + a[1] * dy) + np.abs(b[0] * dx + b[1] * dy)) / apart
        size = _length(*profile.middle)[i] + _length(*traced.middle)[j]
        thickness = profile.thickness[i] + traced.thickness[j]
        lower: Array = apart - along - thickness - DISTANCE_ROUNDING * size
        # upper bound of the distance of the centres
        found = _length(*(profile.point[:, i] - traced.point[:, j]))
        found = found + profile.error[i] + traced.error[j]
        found = np.where(np.isfinite(found), found, np.inf)
        best = int(np.argmin(found))
        if found[best] < self.distance:
            centre = 0.5 * (boxes.intervals.lo + boxes.intervals.hi)
            self.distance = float(found[best])
            self.profile_angle, self.roller_angle = float(centre[i[best]]), float(centre[j[best]])
        return -lower

    def split(self, boxes: _Pairs, keep: Mask) -> _Pairs:
        """Divide the intervals of the pairs to keep; each pair becomes the pairs of their parts."""
        i, j = boxes.first[keep], boxes.second[keep]
        used = np.union1d(i, j)
        parts = np.arange(PARTS)
        first = np.searchsorted(used, i)[:, None] * PARTS + np.repeat(parts, PARTS)
        second = np.searchsorted(used, j)[:, None] * PARTS + np.tile(parts, PARTS)
        return _Pairs(boxes.intervals.take(used).split(PARTS), first.ravel(), second.ravel())


def _length(x: Array, y: Array) -> Array:
    """√(x² + y²), ten times as fast as ``np.hypot``; lengths on a cam do not overflow."""
    return np.asarray(np.sqrt(x * x + y * y))
