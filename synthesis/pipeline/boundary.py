"""How far one number has to be relaxed, all others kept: a value that suffices, and a bound.

The excess of a question falls as a number of it is relaxed: the smallest cam's base radius over its
maximum, or the gentlest law's derivative over its cap. Its zero is the least value that suffices.

    1. Outwards: the secant of the excess from the requested value on; where that does not help, a
       cam without the number says which value suffices.
    2. Inwards: the bracket of the zero is narrowed, every value tried being a question.
    3. To the end, at a fine tolerance: what the smallest cam exceeds vanishes at the least value
       known to suffice, its lower bound at the farthest one known to be impossible. Both are
       zeros of functions that fall alike. Where the quick proof leaves a gap open, longer ones
       follow (``longer_proofs``).

A value is named only if the question with it, put as it stands, has a certified cam.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, field
from math import inf

from synthesis.pipeline.largest_radius import Smallest
from synthesis.pipeline.oracle import (
    COARSE,
    FINE,
    ON_KNOTS,
    Oracle,
    Trial,
    gap_left_by,
    missing_excess,
)
from synthesis.pipeline.relaxable import Relaxable
from synthesis.pipeline.secants import SecantBracket, approach_zero, halfway, slope_of, zero_of

FINEST = {"quick": 1e-4, "auto": 3e-7, "thorough": 3e-7}  # least tolerance of a trial, by ``proof``
NEAR_EXCESS = 1e-6  # relative: a base radius this far below its maximum cannot be brought nearer
ROUGH = 1e-2  # of the way, and of the value: how near the end is come to at coarse tolerances
ROUNDING = 1e-6  # relative: bracket of a value below which it is not narrowed
SPARE = (0.0, 1e-2), (0.0, 1e-4, 1e-3, 1e-2, 0.1, 1.0)
"""Of the way and of the value: added until there is a cam, where no excess says what is missing."""
THIN = 1e-5  # relative: of a maximum, what a cam keeps it by that is next to the best
FARTHER = 3.0  # from one value put as it stands to the next, of the distance from the nearest
UNKNOWN = 0.1  # of the way: a bracket is no longer halved where no excess is known in it
CLOSING = 14  # trials at the fine tolerance
WIDE_GAP = 5e-3  # of the request's excess: a gap that keeps both ends as much of the way apart
LEFT = 1.5  # of a gap that was left open: the tolerance from then on, so that it can be met
BEYOND, REACH = 1.3, 2.0
"""Of what a question misses by: how far it is put next. Of the accuracy: how far will do."""
CLOSE = 0.1  # of the width of a bracket: how near the zero of a bound is come to

LATE = "the budget ended before this was known"
SUFFICES = "a cam was found with this value"
UNCONFIRMED = "a cam was found on the way, but none for the spec with a value of this number in it"
DEVIATION = "deviation allowed either way; a cam was found with it"


@dataclass(eq=False)
class Boundary:
    """What is known of the least value of a number that suffices.

    Attributes:
        oracle: answers questions. number: the number. original: the question with it as requested.
        accuracy: how near to each other both ends are brought, as a share of the way.
        direction: +1 or −1: towards values that allow more.
        nearest: the value nearest to the request with which a trial has found a cam, and that.
        excluded: the value farthest from the request that is proven impossible.
        requested_excess: of the request. by_size: whether excesses are of a size, or of a law.
        excesses, trials: by the values tried. levels: excesses, or 1 without a cam, −1 with one.
        needed: a value whose question, as it stands, has a cam. note: on it, or why there is none.
        confirmed: the nearest value for which that was sought. needs_proof: whether a longer proof
            has led to its cam. finest: least tolerance of a trial.
    """

    oracle: Oracle
    number: Relaxable
    original: Trial
    accuracy: float = ROUGH
    direction: float = 1.0
    nearest: tuple[float, Trial] | None = None
    excluded: float | None = None
    needed: float | None = None
    confirmed: float | None = None
    note: str = LATE
    needs_proof: bool = False
    finest: float = FINE
    requested_excess: float | None = None
    by_size: bool = False
    excesses: dict[float, float] = field(default_factory=dict)
    levels: dict[float, float] = field(default_factory=dict)
    trials: dict[float, Trial] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.direction = self.number.direction
        self.trials[self.number.tightest] = self.original
        self.by_size = self.original.smallest is not None
        if self.original.excess is not None:
            self.requested_excess = max(self.original.excess, NEAR_EXCESS)
            for each in (self.excesses, self.levels):
                each[self.number.tightest] = self.requested_excess
            self._note_gap(self.original, max(COARSE, self.oracle.spec.tolerance))
        if self.original.proof:
            self.exclude(self.number.tightest)

    def narrow(self) -> None:
        """Bring the value that suffices nearer to the least one: step 2."""
        with suppress(TimeoutError):
            self._narrow()
        self.confirm()

    def seek_bound(self, accuracy: float) -> None:
        """Bring the value that suffices, and one that is impossible, to the zero: step 3."""
        if self.nearest is None:
            return
        self.accuracy, self.finest = accuracy, FINEST[self.oracle.spec.proof]
        with suppress(TimeoutError):
            if self._is_left_to_longer_proofs():
                return
            bounded = self.minimised and self._minimise_radius()
            # What is not proven of the value requested is not of one that allows more.
            if not bounded and self.excluded is not None:
                self._close_in()
        if not self._is_left_to_longer_proofs():  # these put their own values, which are better
            self.confirm()

    def _minimise_radius(self) -> bool:
        """Whether the smallest cam, sought to the end, is bounded: no more is to be known then."""
        assert self.nearest is not None
        found, _ = self.nearest
        finer = self.tried(found, self.fine, exactly=True)
        least, trial = self.nearest
        spare = 0.5 * max(self.accuracy * self._way(least), self.fine * least)
        self.nearest = min(least + spare, found), trial
        return finer.bound_excess is not None

    @property
    def minimised(self) -> bool:
        """Whether the smallest cam has the nearest value: of a given radius only if it grows."""
        return self.number.minimised and self.direction > 0.0

    @property
    def fine(self) -> float:
        """The tolerance with which both ends come as near as the accuracy asks, or the finest."""
        fall = self.requested_excess or 1.0
        slope = self.direction * slope_of(self.excesses, ON_KNOTS)
        if slope > 0.0 and self.nearest is not None:
            fall = min(fall, slope * self._way(self.nearest[0]))
        return min(max(self.accuracy * fall, self.finest, self.oracle.open_gap), COARSE)

    def _close_in(self) -> None:
        """Bracket the zero by a cam and by a proof, as near as the tolerance lets both come.

        Values are measured by their way from the request. With the slope of the excess a trial says
        where the cam's excess comes to zero, and how much nearer its bound does.
        """
        assert self.nearest is not None
        noise = ON_KNOTS if self.original.attempt.mesh(COARSE) else 0.0
        slope = self.direction * slope_of(self.excesses, noise)
        gap = max(self.fine, self.oracle.open_gap)
        search = SecantBracket(slope, gap / slope if slope > 0.0 else gap * abs(self.nearest[0]))
        known = min(self.excesses.items(), key=lambda pair: abs(pair[1]), default=(0.0, None))
        search.zero = search.zero_from(self.way_to(known[0]), known[1])
        for _ in range(CLOSING):
            good, by_size = self.way_to(self.nearest[0]), self.by_size
            bad = 0.0 if self.excluded is None else max(self.way_to(self.excluded), 0.0)
            width = self.accuracy * self._way(self.nearest[0])
            left = gap if search.gap is None else max(search.gap, self.oracle.open_gap)
            width = max(width, left / search.slope) if search.slope > 0.0 else width
            if good - bad <= REACH * max(width, search.open_way):
                return
            way, exactly = search.next_way(bad, good, width)
            value = self.value_at(way)
            trial = self.tried(value, self.fine, exactly=exactly)
            excess = self.excesses.get(value)
            slope = self.direction * slope_of(self.excesses, noise)
            bound = trial.bound_excess if exactly and excess is not None else None
            if self.by_size is not by_size:  # the excess of another function begins
                search = SecantBracket(slope, search.proof_step)
            search.learn(
                way, excess, bound, certified=trial.certified, exactly=exactly, slope=slope,
                noise=REACH * self.fine,
            )  # fmt: skip
            search.has_proof |= exactly and bool(trial.proof)
            if (zero := search.zero_from(way, bound)) < inf:
                search.has_proof |= self._exclude_by_multipliers(trial, way, zero, width)
            if exactly and self._is_for_longer_proofs(gap_left_by(trial, self.fine)):
                return

    def _is_left_to_longer_proofs(self) -> bool:
        """Whether longer proofs go on from the request, and no multipliers exclude other values."""
        begins = self.excluded is not None and self.way_to(self.excluded) >= 0.0
        follow = begins and self._is_for_longer_proofs(self.oracle.open_gap / LEFT)
        tightest = self.number.tightest
        return follow and self.oracle.bound_excess(self.original, self.number, tightest) == -inf

    def _is_for_longer_proofs(self, gap: float) -> bool:
        """Whether longer proofs follow, which bring both ends nearer than quick ones with a gap."""
        return self.oracle.has_longer_proofs and gap > WIDE_GAP * (self.requested_excess or inf)

    def _exclude_by_multipliers(self, trial: Trial, way: float, zero: float, width: float) -> bool:
        """Exclude the farthest value that a trial's multipliers exclude; whether there is one.

        Weak duality: they bound cams at any value. ``zero``: the bound's, as its slope says.
        """

        def excess(at: float) -> float:
            value = self.value_at(at)
            result = self.oracle.bound_excess(trial, self.number, value)
            if result > 0.0:
                self.exclude(value)
            return max(result, -1.0)

        return approach_zero(excess, way, zero, CLOSE * width)

    @property
    def at_least(self) -> float | None:
        """The value farthest from the request that is proven impossible; None where none is.

        Not one beyond the value that suffices, nor a stricter one than the request.
        """
        most = inf if self.needed is None else self.way_to(self.needed)
        known = self.excluded is not None and 0.0 <= self.way_to(self.excluded) <= most
        return self.excluded if known else None

    # -- trials ------------------------------------------------------------------------------

    def tried(self, value: float, tolerance: float = COARSE, *, exactly: bool = False) -> Trial:
        """The question with the number at a value; raises TimeoutError where time is over."""
        if self.oracle.is_late():
            raise TimeoutError
        _, near = min(self.trials.items(), key=lambda pair: abs(pair[0] - value))
        trial = self.oracle.relaxed(self.number, value, tolerance, near, exactly=exactly)
        self.record(value, trial)
        if not trial.on_time:
            raise TimeoutError
        if exactly:
            self._note_gap(trial, tolerance)
        return trial

    def _note_gap(self, trial: Trial, tolerance: float) -> None:
        """Keep a gap that a tolerance has left open: no smaller one closes it, of any number.

        What knots and solvers leave is none: another trial may come nearer.
        """
        gap = gap_left_by(trial, tolerance)
        if gap > 0.0:
            self.oracle.open_gap = LEFT * gap

    def record(self, value: float, trial: Trial) -> None:
        self.trials[value] = trial
        self.levels[value] = self._level(trial)
        if trial.excess is not None:
            self._keep_excess(value, trial, trial.excess)
        if trial.certified:
            self._allow(value, trial)
        if trial.proof:
            self.exclude(value)
        if self.minimised and trial.smallest is not None:
            self.take(trial.smallest)

    def _keep_excess(self, value: float, trial: Trial, excess: float) -> None:
        """Keep the excess of a value, if it is one of the function whose zero is sought.

        That of the gentlest law and that of the smallest cam fall to zeros of their own. The one
        whose zero lies farther is sought: it is above 0 where the other is no longer.
        """
        by_size = trial.smallest is not None
        if by_size is not self.by_size:
            failed = (known for known, level in self.excesses.items() if level > 0.0)
            if trial.certified or any(self._beyond(known, value) <= 0.0 for known in failed):
                return
            self.by_size, self.excesses = by_size, {}
        self.excesses[value] = excess

    def take(self, smallest: Smallest) -> None:
        """Of a maximum of the base radius: the smallest cam is a value, its bound excludes one."""
        self._allow(smallest.radius, Trial(smallest.attempt, smallest, on_time=True))
        if smallest.is_bounded:
            self.exclude(smallest.lower)

    def _allow(self, value: float, trial: Trial) -> None:
        if self.nearest is None or self._beyond(value, self.nearest[0]) > 0.0:
            self.nearest = value, trial

    def exclude(self, value: float) -> None:
        farther = self.excluded is None or self._beyond(self.excluded, value) > 0.0
        if self.number.monotone and farther:  # else values nearer to the request might do
            self.excluded = value

    def way_to(self, value: float) -> float:
        """How far a value allows more than the request."""
        return self._beyond(self.number.tightest, value)

    def value_at(self, way: float) -> float:
        """The value that allows as much more than the request."""
        return self.number.tightest + self.direction * way

    def _beyond(self, value: float, other: float) -> float:
        """How far another value allows more than a value."""
        return self.direction * (other - value)

    def _way(self, value: float) -> float:
        """By how much a value differs from the request; of a request that is far out, itself.

        No less than a millionth of the request: a value may be 0.
        """
        least = ROUNDING * abs(self.number.tightest)
        return min(abs(value - self.number.tightest), max(abs(value), least))

    def _narrow(self) -> None:
        """Bring the value that suffices nearer to the least one, to an accuracy.

        Where a question has no cam its excess is known, and falls to zero at the least value: the
        secant of the two nearest to it says where; where it has one, if the search for it began
        next to the best. A trial half the accuracy beyond the secant's zero finds a cam, or another
        excess. Without two, or where the last secant has left more than half of the bracket, that
        is halved: the excess may have a kink where another limit begins to bind.
        """
        requested, most = self.number.tightest, inf  # of a bracket that the next secant may divide
        began_near, levels = bool(self.original.attempt.mesh(COARSE)), self.levels
        while self.nearest is not None:
            good = self.nearest[0]
            failed = [v for v in levels if levels[v] > 0.0 and self._beyond(v, good) > 0.0]
            bad = max(failed, key=lambda value: self._beyond(requested, value), default=requested)
            known = bool(failed) and bad in self.excesses
            width = max((ROUGH if known else UNKNOWN) * self._way(good), ROUNDING * abs(good))
            if self.levels.get(good, 0.0) >= 0.0 or abs(good - bad) <= width:
                return
            zero = zero_of(self.excesses, levels if began_near else failed, good)
            if zero is not None and 0.0 < self._beyond(zero, good) <= width:
                return
            value = bad if zero is None else zero + 0.5 * self.direction * width
            is_inside = self._beyond(bad, value) > 0.0 < self._beyond(value, good)
            if is_inside and abs(good - bad) <= most:
                most = 0.5 * abs(good - bad)
            else:
                value, most = halfway(bad, good), inf
            self.tried(value)

    def _level(self, trial: Trial) -> float:
        """Above 0 where no cam is found; 0, which ends a search, next to the least value."""
        excess = None if trial.excess is None else trial.excess + 0.5 * NEAR_EXCESS
        if not trial.certified:
            return excess if excess is not None and excess > 0.0 else 1.0
        if excess is None:
            return -1.0
        near = ROUGH * (self.requested_excess or 0.0)
        return 0.0 if excess >= -max(0.5 * NEAR_EXCESS, near) else excess

    def confirm(self, proof: str = "quick") -> None:
        """Name the nearest value if the question with it, as it stands, has a cam; else one near.

        That is the question of anyone who sends the value back.
        ``proof``: where it is the spec's own, it follows if a search for a cam alone finds none.
        """
        if self.nearest is None or self.nearest[0] in (self.needed, self.confirmed):
            return
        nearest, trial = self.nearest
        units = zip(SPARE, (self._way(nearest), abs(nearest)), strict=True)
        spares = sorted({share * unit for shares, unit in units for share in shares})
        # Another's search may not find a cam that is next to the best, or only with a bound.
        next_to_best = trial.excess is not None and -THIN < trial.excess <= 0.0
        most = ROUGH * self._way(nearest) if next_to_best else 0.0
        spare = min(self._missing_way(nearest, trial), most)
        if not self.oracle.is_valid(self.number, nearest + self.direction * spare):
            spare = 0.0
        for _ in range(len(spares)):
            value = nearest + self.direction * spare
            farther = self.needed is not None and self._beyond(self.needed, value) >= 0.0
            if farther or not self.oracle.is_valid(self.number, value):
                break
            if self.oracle.is_late():
                self.note = self.note if self.needed is not None else LATE
                return
            # Most cams are found without a proof, in a fraction of the time.
            ask, first = self.oracle.ask_as_it_stands, proof if next_to_best else "quick"
            longer = proof == self.oracle.spec.proof
            if not (longer and self.needs_proof):
                found = ask(self.number, value, first, cam_only=not next_to_best)
                longer &= not (found.certified or next_to_best or self.oracle.is_late())
            if longer:
                found = ask(self.number, value, proof)
            if found.certified:
                _, note = self.oracle.value_on(self.number, trial)
                self.needed, self.confirmed = value, nearest
                self.note = (DEVIATION if self.number.sense == "±" else SUFFICES) + note
                return
            missing = self._missing_way(value, found)
            ladder = next((x for x in spares if x > spare), inf)
            spare = max(spare + missing, FARTHER * spare) if missing else ladder
        self.confirmed = nearest  # as far as that goes
        self.note = self.note if self.needed is not None else UNCONFIRMED

    def _missing_way(self, value: float, trial: Trial) -> float:
        """How far a value's question is from a cam, by the secant from the request; else 0."""
        same = (trial.smallest is None) is (self.original.smallest is None)
        if self.requested_excess is None or trial.excess is None or not same:
            return 0.0
        slope = (self.requested_excess - trial.excess) / (self.way_to(value) or inf)
        return BEYOND * missing_excess(trial) / slope if slope > 0.0 else 0.0
