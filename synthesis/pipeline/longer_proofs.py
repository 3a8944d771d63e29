"""Where a quick proof leaves a gap open: values that suffice, and values proven impossible, brought
near to each other by longer proofs.

The excess of the smallest cam over its maximum falls as a number is relaxed. A value is impossible
where a lower bound of that excess is above 0, and it suffices where a cam has none. Where limits
that bind are not convex no multiplier carries a bound from one value to another: each value takes a
branch and bound of its own, and the nearer it is to the zero of the excess, the longer that takes.

    1. A rough proof of every member comes first: of a value far from the zero it takes little time.
       Then the smallest cam at the value that suffices: by its excess, and the slope of the excess,
       the zero is known to the tolerance.
    2. Then one member after the other is brought to the accuracy, the nearest to it first: proofs
       that end in the time there is are worth more than many that do not. A cam is sought as far on
       the one side of the zero, and a proof on the other, as the accuracy allows.
    3. A trial may take an equal share of the time that is left to all members. A member whose last
       one took longer than that comes after the others, and may take a multiple of it.

A proof ends with a cam whose excess is far below its tolerance: it would not exclude the value, and
the excess says where the zero is. One that ends with its gap open says how wide that is: the next
value is one that such a gap excludes, and once that is proven, one half-way to the value that was
not. Where this promises too little, the member waits until it may take more time. At the end every
value with a cam that is not named yet is put as it stands.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from typing import NamedTuple

from synthesis.pipeline.boundary import Boundary
from synthesis.pipeline.oracle import Oracle, relative_gap

ACCURACY = 1e-2  # of the way: how near to each other both values are brought
CAM_SIDE, PROOF_SIDE = 0.25 * ACCURACY, 0.5 * ACCURACY
"""How far from the zero a value with a cam is sought in the end, and one that is impossible."""
FIRST_STEP = 1.0 / 8.0  # of the way: how far from the zero a value is that a first proof excludes
WIDER_FIRST = 2.0  # of the tolerance of a proof: that of the cam by which the zero is known
WITHIN = 0.6  # of the excess where a proof is sought: the tolerance of a trial
HOPELESS = 0.3  # of the tolerance of a proof: with a cam of so little excess it ends
CERTIFIED = 0.1  # of it: by how much the certificate may draw such a cam outwards
FAR_OUT = 1.5  # of ``CAM_SIDE``: farther from the zero, a nearer value with a cam is sought
NEARER = 0.5  # of what the values are apart: a value with a cam as much nearer is put as it stands
STEEPER = 3.0  # factor by which one trial changes the slope at most
LONGER = 2.0  # of the time of a member's last trial, which the next one may take
IDLE, FINER, WIDER = 6, 0.5, 3.0
"""Trials that bring neither value nearer, one after the other, at most; after each of them the
tolerance is finer, and a value to be excluded lies farther from the zero, by these factors."""
WORSE = 1.3  # of a gap that was left open: the excess of a value that it excludes
GAIN = 0.1  # of the way from the excluded value to the zero: what a trial has to promise
FINEST = 1e-6  # relative: the least tolerance
CONFIRMING = 3.0  # of the time of a trial: a question as it stands takes two or three
LAST = 0.1  # of the time, for questions as they stand at the end
MORE = 1.0 + 1e-6  # of a share: what counts as more of it, against rounding


class Point(NamedTuple):
    """The way to a value, the excess of a cam with it, and how far above the smallest that may be.

    Where a search ends with any cam that is small enough, its bound says that.
    """

    way: float
    excess: float
    tolerance: float


@dataclass(eq=False)
class Closing:
    """A boundary whose two values are brought near to each other.

    Values are measured by their way from the request.

    Attributes:
        boundary: what is known of the number.
        slope: by how much the excess falls per unit of the way, near its zero.
        zero: the way at which it is 0.
        points: cams whose excess is known, that of the request first.
        open_gap: what the last proof that excluded nothing has left. unproven: the way to the
            nearest value that a proof has not excluded in its time.
        idle: trials that have brought neither value nearer, one after the other. misses: trials
            that were to exclude a value and have found a cam, one after the other.
        took: the time of the last trial; questions as they stand are none.
        waits_for: the share of the time beyond which another trial is made.
    """

    boundary: Boundary
    slope: float
    zero: float
    points: list[Point]
    open_gap: float = 0.0
    unproven: float = inf
    idle: int = 0
    misses: int = 0
    took: float = 0.0
    waits_for: float = 0.0

    @classmethod
    def of(cls, boundary: Boundary) -> Closing | None:
        """None where the request is not proven impossible, or no value with a cam is known."""
        excess = boundary.requested_excess
        if boundary.nearest is None or boundary.excluded is None or excess is None:
            return None
        way = boundary.way_to(boundary.nearest[0])
        if way <= 0.0 or boundary.way_to(boundary.excluded) < 0.0:
            return None
        return cls(boundary, excess / way, way, [Point(0.0, excess, 0.0)])

    @property
    def good(self) -> float:
        """The way to the nearest value with a cam."""
        assert self.boundary.nearest is not None
        return self.boundary.way_to(self.boundary.nearest[0])

    @property
    def bad(self) -> float:
        """The way to the farthest value that is proven impossible."""
        assert self.boundary.excluded is not None
        return self.boundary.way_to(self.boundary.excluded)

    @property
    def named(self) -> float:
        """The way to the value that is known to suffice as it stands; else to the nearest."""
        needed = self.boundary.needed
        return self.good if needed is None else self.boundary.way_to(needed)

    @property
    def apart(self) -> float:
        """How far both values are apart, as a share of the way."""
        return self._apart_from(self.named)

    @property
    def is_done(self) -> bool:
        """Whether both values are as near as the accuracy asks, or come no nearer: as it stands,
        the question has a cam that is found neither with the nearest value nor with a nearer one.
        """
        assert self.boundary.nearest is not None
        is_tried = self.boundary.confirmed == self.boundary.nearest[0]
        return self.apart <= ACCURACY or (is_tried and self._apart_from(self.good) <= ACCURACY)

    @property
    def rank(self) -> tuple[bool, bool, bool, float]:
        """Members of a lower one come first: by whether they wait, whether all that is missing is
        their cam for the question as it stands, whether they are rough, and how near they are.
        """
        apart = self._apart_from(self.good)
        return self.waits_for > 0.0, not self.is_worth_confirming, not self._is_rough, apart

    @property
    def _is_rough(self) -> bool:
        """Whether no value near the zero is excluded yet."""
        return self.zero - self.bad > 2.0 * FIRST_STEP * self.zero

    def _apart_from(self, way: float) -> float:
        return (way - self.bad) / way

    def advance(self, oracle: Oracle, share: float) -> None:
        """Put the nearest value as it stands, or make one more trial.

        ``share``: of the time that is left, what the oracle has.
        """
        self.boundary.oracle = oracle
        if self.is_worth_confirming:
            self.boundary.confirm(oracle.spec.proof)
            if oracle.is_late():
                self._wait(share)
            return
        trial, zero, open_gap = self._next_trial(), self.zero, self.open_gap
        if trial is None:
            self._wait(share)
            return
        values, had_point, before = (self.good, self.bad), self._has_point, oracle.left
        self._try(*trial)
        self.took = before - oracle.left
        if trial[2] is not None:  # where the excess is flat beside its zero, many values have a cam
            self.misses = 0 if self.good == values[0] else self.misses + 1
        self.zero = min(self.zero, self.good)
        if self.zero <= self.bad:  # the excess is no straight line so far from its zero
            self.zero = 0.5 * (self.bad + self.good)
        if (self.good, self.bad) != values or self._has_point != had_point:
            self.idle = 0
        elif oracle.is_late():
            # Only of another value more can be hoped for: one that the gap excludes.
            if trial[0] >= zero or self.open_gap == open_gap:
                self._wait(share)
        else:
            self.idle += 1
            if self.idle >= IDLE:
                self._wait(share)

    @property
    def _has_point(self) -> bool:
        """Whether the excess of a cam is known, besides that of the request."""
        return len(self.points) > 1

    def _next_trial(self) -> tuple[float, float, float | None] | None:
        """The way to a value, a tolerance, and the excess of a cam with which the search may end.

        None: nothing is promised. Of the excess: the smallest cam is sought. The tolerance is a
        part of the excess that is expected there.
        """
        good, finer = self.good, FINER**self.idle
        if self.boundary.minimised:  # the smallest cam is the value, and its bound the other
            excess = self.boundary.requested_excess or 0.0
            return good, PROOF_SIDE * finer * excess / (1.0 + excess), None
        step, room = FIRST_STEP * self.zero, CAM_SIDE * good
        step = step if self._is_rough else PROOF_SIDE * good
        tolerance, widest = WITHIN * finer * self.slope * step, 0.5 * (self.zero - self.bad)
        if not self._is_rough:
            if not self._has_point:
                return good, WIDER_FIRST * tolerance, None
            if good - self.zero > FAR_OUT * room:
                return self.zero + room, tolerance, None
        wider = WIDER ** max(self.idle, self.misses)
        step = max(min(step * wider, widest), WORSE * self.open_gap / self.slope)
        way = self.zero - step
        if way >= self.unproven:
            way = 0.5 * (self.bad + self.unproven)
            tolerance *= (self.zero - way) / step
        if way - self.bad < GAIN * (self.zero - self.bad):
            return None
        return way, tolerance, HOPELESS * tolerance

    @property
    def is_worth_confirming(self) -> bool:
        """Whether a cam is known with a value near enough, or much nearer than the one named."""
        boundary = self.boundary
        assert boundary.nearest is not None
        if boundary.nearest[0] == boundary.confirmed:
            return False
        if boundary.needed is None or self._apart_from(self.good) <= ACCURACY:
            return True
        return self.named - self.good > NEARER * (self.named - self.bad)

    def _wait(self, share: float) -> None:
        """Make no further trial until there is more time for it.

        Where programs are counted there is none: the same trial would come to the same again.
        """
        counts = self.boundary.oracle.last_program < inf
        self.idle, self.open_gap, self.waits_for = 0, 0.0, inf if counts else share
        self.unproven = inf

    def _try(self, way: float, tolerance: float, enough: float | None) -> None:
        """Look for the smallest cam at a value, or for one whose excess is small ``enough``.

        Either ends where the bound excludes the value.
        """
        boundary, tolerance = self.boundary, max(tolerance, FINEST)
        value = boundary.value_at(way)
        trial = boundary.oracle.relaxed(
            boundary.number, value, tolerance, exactly=enough is None, enough=enough or 0.0,
            proof="thorough",
        )  # fmt: skip
        before = boundary.nearest
        boundary.record(value, trial)
        if boundary.nearest is not before:
            boundary.needs_proof = True  # a quick search has found no such cam
            if boundary.minimised:
                self._leave_room()
        excess, bound = trial.excess, trial.bound_excess
        if trial.proof:  # it ends before its cam is the smallest
            self.open_gap = 0.0  # that of another value says nothing any more
            self.unproven = inf if way >= self.unproven else self.unproven
            return
        if excess is None or bound is None:
            return
        ended_early = enough is not None and excess <= enough + CERTIFIED * tolerance
        gap = relative_gap(excess, bound)
        if gap > tolerance and not ended_early:
            self.open_gap = excess - bound
            if not trial.certified:
                self.unproven = min(way, self.unproven)
                self.zero = min(self.zero, way + excess / self.slope)  # the smallest is smaller
                return
        self.points.append(Point(way, excess, max(tolerance, min(gap, abs(excess)))))
        self._follow_slope()
        self.zero = way + excess / self.slope

    def _follow_slope(self) -> None:
        """Take the slope from the last point and the nearest one that differs for certain."""
        *others, (way, excess, tolerance) = self.points
        slopes = {
            abs(each.way - way): (each.excess - excess) / (way - each.way)
            for each in others
            if each.way != way and abs(each.excess - excess) > max(each.tolerance, tolerance)
        }
        if slopes:
            nearest = slopes[min(slopes)]
            self.slope = min(max(nearest, self.slope / STEEPER), self.slope * STEEPER)

    def _leave_room(self) -> None:
        """Let the value be a little farther than the smallest cam: few are as small as that."""
        boundary, way = self.boundary, (1.0 + CAM_SIDE) * self.good
        assert boundary.nearest is not None
        way = way if boundary.needed is None else min(way, self.named)
        boundary.nearest = boundary.value_at(way), boundary.nearest[1]


def close_in(oracle: Oracle, boundaries: Sequence[Boundary]) -> None:
    """Bring both values of every boundary near to each other, as far as the time goes."""
    closings = [each for each in map(Closing.of, boundaries) if each is not None]
    working = oracle.share(1.0 / (1.0 - LAST))
    while not working.is_late():
        far = [each for each in closings if not each.is_done]
        equal = working.left / max(len(far), 1)
        shares = [(each, equal) for each in far if each.took <= equal]
        longer = [(each, min(working.left, LONGER * each.took)) for each in far]
        for some in (shares, longer):
            ready = [(each, share) for each, share in some if share > MORE * each.waits_for]
            if ready:
                break
        else:
            break
        each, share = min(ready, key=lambda pair: pair[0].rank)
        if each.is_worth_confirming:
            share = min(working.left, max(share, CONFIRMING * each.took))
        each.advance(working.share(working.left / share), share)
    for left, each in zip(range(len(closings), 0, -1), closings, strict=True):
        each.boundary.oracle = oracle.share(left)
        each.boundary.confirm(oracle.spec.proof)
