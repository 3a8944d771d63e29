"""Whether the cam cuts itself: a roller that does its work here and stands in the way there.

O(θ) is the profile beside the traced curve P(θ), at the roller's radius R. A profile may be free
of undercut and yet cross itself where far parts of it come together: a lobe thinner than the
roller, a hollow with a narrow mouth. Then some position of the roller reaches into some other
part of the profile. What has to hold is that it never does:

    |O(θ) − P(φ)| ≥ R   for all cam angles θ, φ

(P has the global radius of curvature R towards the cam: Gonzalez & Maddocks, PNAS 96 (1999) 4769).

**Near pairs need no search.** If along one of the two arcs of P between θ and φ the tangent's
angle keeps within less than π, and the curvature is nowhere above 1/R, the pair is in order:
choose the axis m that makes a positive product with every tangent of the arc; over it the arc is
the graph of a function whose slope angle σ satisfies d(sin σ)/dm ≥ −1/R, as for the circle of
radius R that touches it at θ, which has equality. So the arc lies above that circle as far as
the circle's own upper arc reaches, and beyond it lies beside the circle. The centre of that
circle is O(θ). Corners that turn away from the circle only help. The curvature is the business
of the limit ``profile_radius``, which every spec of a roller has.

**A curve that goes round the axis** is cleared before (`simple` asks). Let P's tangent lines,
where P runs smoothly, pass the axis on one side and farther than R: n · P > R, n the normal on the
other side of the cam. Then P(θ) − (R − d) n has n · P > 0 too, for every d from 0 to R, and where
nothing is undercut its polar angle runs one way, once round as P's does: s comes back without a
turn about the axis. So these curves are simple, each lies around those of smaller d, and P(φ),
which lies on the outermost, is on no other. But if O(θ) were the profile's nearest point to it, at
less than R, P(φ) would lie on n(θ) at that height above O(θ), which is a point of another one.
Where the profile lies around P the same is said of P + d n, for which n · P > 0 is enough.

**Pairs aside** of each other need none either: seen from the cam's axis, the roller at φ fills the
angle ± arcsin R/|P(φ)| about its centre, and O(θ) lies in the same about P(θ). Where these do not
overlap, the point is outside of the roller. On most cams that leaves no far pair at all.

**Far pairs** that are left are excluded by branch and bound over pairs of boxes: two strokes with
midpoints apart by D lie apart by at least |D| − |a·D̂| − |b·D̂| less their thickness, a and b their
half vectors. Where two curves come nearest they are square to D, so this converges quadratically.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from synthesis.certify.course import Indices
from synthesis.certify.path import Boxes, Drawn, Path
from synthesis.numerics.piecewise import Array
from synthesis.units import FULL_TURN

WIDEST: Final = FULL_TURN / 48.0
TURNING: Final = 0.6  # a box whose tangent turns through more is split [rad]
UNSTEADY: Final = 1.0  # turning of a box from which on its neighbours' angles are not told apart
MOST_BOXES: Final = 2_000
GROUPS: Final = 96
MOST_PAIRS: Final = 400_000
SPLIT: Final = 4
ROUNDS: Final = 10
TOUCHING: Final = 1e-9  # of the roller: so deep a crossing counts as none
FINE: Final = 1e-9  # of the roller: width of an enclosure that is good enough
ROUNDING: Final = 2.0**-46  # of the distances compared
HALF_TURN: Final = math.pi * (1.0 - ROUNDING)
BESIDE: Final = 1e-12  # rad: roundings of the angles compared


@dataclass(frozen=True)
class Nearest:
    """How near the roller comes to far parts of the profile.

    Attributes:
        least: smallest distance found from a roller's centre to the profile, of pairs that had to
            be looked at [mm]; inf where there was none, or where the path has no steady tangent.
        lower: proven: no far pair is nearer. At least (1 − 1e-9) R where nothing crosses.
        profile, roller: cam angles of the pair found [rad].
        pairs: how many pairs of boxes it took.
    """

    least: float
    lower: float
    profile: float
    roller: float
    pairs: int

    def holds_off(self, radius: float) -> bool:
        """Whether it is proven that a roller of this radius reaches into no far part."""
        return self.lower >= radius * (1.0 - TOUCHING)


def nearest(path: Path) -> Nearest:
    """The nearest far pair, closely only where it is nearer than the roller's radius."""
    with np.errstate(all="ignore"):
        boxes = Boxes.of(path.course, WIDEST)
        drawn = path.on(boxes)
        boxes, drawn = _turning_little(path, boxes, drawn)
        low, high = drawn.heading
        unsteady = ~(high - low < UNSTEADY)
        if unsteady.any():
            where = float(boxes.lo[np.argmax(unsteady)])
            return Nearest(math.inf, 0.0, where, where, 0)
        groups = _Groups.of(len(boxes))
        apart = groups.aside(*drawn.shadow())
        apart |= groups.near(low, high, groups.longest(~apart))
        return _Search(path, boxes).run(*groups.pairs(~apart))


def _turning_little(path: Path, boxes: Boxes, drawn: Drawn) -> tuple[Boxes, Drawn]:
    """Boxes cut until the tangent turns little on each, and what is drawn there."""
    while True:
        low, high = drawn.heading
        wide = ~(high - low <= TURNING)
        if not wide.any() or np.min((boxes.hi - boxes.lo)[wide]) < 1e-12:
            return boxes, drawn
        if len(boxes) >= MOST_BOXES:
            return boxes, drawn
        finer, kept = boxes.take(wide).split(SPLIT), boxes.take(~wide)
        order = np.lexsort((np.append(kept.lo, finer.lo), np.append(kept.piece, finer.piece)))
        boxes = kept.joined(finer).take(order)
        drawn = path.on(boxes)


@dataclass(frozen=True, eq=False)
class _Groups:
    """Neighbouring boxes are looked at in groups: two boxes are in order where their groups are.

    Attributes:
        first: (n,) the first box of every group. counts: (n,) how many it has.
    """

    first: Indices
    counts: Indices

    @classmethod
    def of(cls, boxes: int) -> _Groups:
        """A limited number of about equal groups."""
        first = np.arange(0, boxes, math.ceil(boxes / GROUPS))
        return cls(first, np.diff(np.append(first, boxes)))

    def longest(self, pairs: NDArray[np.bool_]) -> int:
        """How many groups on the shorter arcs between these pairs are, both ends with them."""
        count, index = len(self.first), np.flatnonzero(pairs)
        between = np.abs(index % count - index // count)
        return int(np.max(np.minimum(between, count - between), initial=0)) + 1

    def near(self, low: Array, high: Array, longest: int) -> NDArray[np.bool_]:
        """Pairs that one of the arcs between them brings together, by the tangent's angle.

        Of arcs of no more than so many groups.
        """
        # neighbours meet in a point: their angles differ by a corner's, less than half a turn
        (bottom, top), turn = self._ends(low, high)
        count = len(self.first)
        start = np.arange(count)[:, None]
        arcs = start + np.arange(longest)
        bottom, top = (np.concatenate([each, each + turn])[arcs] for each in (bottom, top))
        turning = np.maximum.accumulate(top, axis=1) - np.minimum.accumulate(bottom, axis=1)
        forward = np.zeros((count, count), dtype=bool)
        forward[start, arcs % count] = turning < HALF_TURN
        return np.asarray(forward | forward.T)

    def aside(self, low: Array, high: Array) -> NDArray[np.bool_]:
        """Pairs of which the one lies beside the other, seen from the cam's axis."""
        (bottom, top), _ = self._ends(low, high)
        middle, half = 0.5 * (bottom + top), 0.5 * (top - bottom)
        between = middle[:, None] - middle
        between -= FULL_TURN * np.round(between / FULL_TURN)
        apart: NDArray[np.bool_] = np.abs(between) > half[:, None] + half + BESIDE
        return apart

    def _ends(self, low: Array, high: Array) -> tuple[tuple[Array, Array], float]:
        """Least and largest angle in every group, continued from box to box, and its gain in all.

        Of a group that is continued wrongly the range is too wide, never too narrow.
        """
        middle = 0.5 * (low + high)
        wraps = np.cumsum(np.round(np.diff(middle, append=middle[0]) / FULL_TURN))
        shift, turn = np.append(0.0, wraps[:-1]) * -FULL_TURN, -FULL_TURN * float(wraps[-1])
        ends = (
            np.minimum.reduceat(low + shift, self.first),
            np.maximum.reduceat(high + shift, self.first),
        )
        return ends, turn

    def pairs(self, chosen: NDArray[np.bool_]) -> tuple[Indices, Indices]:
        """The pairs of boxes in these pairs of groups: of profile, of roller."""
        if not chosen.any():
            return np.zeros(0, dtype=np.intp), np.zeros(0, dtype=np.intp)
        each = np.repeat(np.repeat(chosen, self.counts, axis=0), self.counts, axis=1)
        profile, roller = np.nonzero(each)
        return profile, roller


class _Search:
    """Branch and bound over pairs of boxes."""

    def __init__(self, path: Path, boxes: Boxes) -> None:
        self.path, self.boxes = path, boxes
        self.radius = abs(path.distance)
        self.least, self.profile, self.roller = math.inf, 0.0, 0.0
        self.pairs = 0

    def run(self, i: Indices, j: Indices) -> Nearest:
        """The pairs that are left: box i of the profile, box j of the roller's path."""
        open_end = math.inf
        for round_ in range(ROUNDS):
            if len(i) == 0:
                break
            lower = self._look(i, j)
            keep = ~(lower >= self._wanted())
            i, j, lower = i[keep], j[keep], lower[keep]
            full = len(i) * SPLIT * SPLIT + self.pairs > MOST_PAIRS
            if full or round_ == ROUNDS - 1:
                known = np.where(np.isfinite(lower), lower, 0.0)
                open_end = float(np.min(known, initial=math.inf))
                break
            i, j = self._split(i, j)
        lower_end = max(min(self._wanted(), open_end), 0.0)
        return Nearest(self.least, lower_end, self.profile, self.roller, self.pairs)

    def _wanted(self) -> float:
        """Distance from which on a pair is of no interest."""
        harmless = self.radius * (1.0 - TOUCHING)
        return min(harmless, self.least - FINE * self.radius)

    def _look(self, i: Indices, j: Indices) -> Array:
        """Lower bounds of the distances; takes in the nearest pair of centres."""
        self.pairs += len(i)
        profile, traced = self.path.on(self.boxes).strokes()
        dx, dy = profile.mid[:, i] - traced.mid[:, j]
        apart = _length(dx, dy)
        a, b = profile.half[:, i], traced.half[:, j]
        slack = (np.abs(a[0] * dx + a[1] * dy) + np.abs(b[0] * dx + b[1] * dy)) / apart
        size = _length(*profile.mid)[i] + _length(*traced.mid)[j]
        lower: Array = apart - slack - profile.thick[i] - traced.thick[j] - ROUNDING * size
        found = _length(*(profile.at[:, i] - traced.at[:, j])) + profile.near[i] + traced.near[j]
        found = np.where(np.isfinite(found), found, np.inf)
        best = int(np.argmin(found))
        if found[best] < self.least:
            centre = 0.5 * (self.boxes.lo + self.boxes.hi)
            self.least = float(found[best])
            self.profile, self.roller = float(centre[i[best]]), float(centre[j[best]])
        return lower

    def _split(self, i: Indices, j: Indices) -> tuple[Indices, Indices]:
        """The pairs of the parts of each pair's boxes, which take the boxes' place."""
        used = np.union1d(i, j)
        self.boxes = self.boxes.take(used).split(SPLIT)
        parts = np.arange(SPLIT)
        first = np.searchsorted(used, i)[:, None] * SPLIT + np.repeat(parts, SPLIT)
        second = np.searchsorted(used, j)[:, None] * SPLIT + np.tile(parts, SPLIT)
        return first.ravel(), second.ravel()


def _length(x: Array, y: Array) -> Array:
    """√(x² + y²), ten times as fast as ``np.hypot``; lengths on a cam overflow nowhere."""
    return np.asarray(np.sqrt(x * x + y * y))
