"""How far one number has to be relaxed, all others kept: a value that suffices, and a bound.

The excess of a question falls as a number of it is relaxed: the smallest cam's base radius over its
maximum, or the gentlest law's derivative over its cap. Its zero is the least value that suffices.

    1. Outwards: the secant of the excess from the requested value on; where that does not help, a
       cam without the number says which value suffices.
    2. Inwards: the bracket of the zero is narrowed, every value tried being a question.
    3. The bound: smaller values, closer ones first, until one is proven impossible.

A value is named only if the question with it, put as it stands, has a certified cam.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field
from math import copysign, isfinite, sqrt

from synthesis.catalogue.fields import ends
from synthesis.catalogue.objectives import BaseRadius, Objective, PeakAcceleration, PeakJerk
from synthesis.pipeline.largest_radius import Smallest
from synthesis.pipeline.oracle import ALONE, COARSE, Oracle, Trial
from synthesis.pipeline.relaxable import Relaxable, relaxed, without

FINE = 2e-4  # tolerance of a trial that is to prove a value impossible
NEAR_EXCESS = 1e-4  # relative: a base radius this far below its maximum cannot be brought nearer
ACCURACY = 1e-3
"""Of the way from the requested value, and of the value: bracket of a sufficient one at the end."""
ROUNDING = 1e-4  # relative: bracket of a value below which it is not narrowed
WIDE = 4.0  # ratio of a bracket's ends from which on it is halved on a logarithmic scale
SPARE = (0.0, 1e-4, 1e-3, 1e-2)
"""Relative: added to a value, until the question as it stands has a cam."""
SLACK = (0.0, 1e-6, 1e-3, 1.0)  # of the way: added to the value of a cam found without it
STEPS = 4  # of the secant outwards
SECANTS = 8  # inwards, before brackets are halved alone
FARTHEST = 0.5  # relative: of a value; what is farther is taken from a cam without the number
FALLING = 0.9  # of the excess before: where less is gained the number does not help in proportion
CLOSE = 1e-3  # relative: from a value proven impossible to one that suffices
WIDENING = 4.0  # factor from one distance to the next at which a value is tried for a proof

OBJECTIVE_OF: dict[str, Objective] = {"acceleration": PeakAcceleration(), "jerk": PeakJerk()}
"""What makes the quantity of a limit small, by the limit's name."""

LATE = "the time budget ended before this was known"
SUFFICES = "a cam was found with this value"
DEVIATION = "deviation allowed either way; a cam was found with it"


@dataclass(eq=False)
class Boundary:
    """What is known of the least value of a number that suffices.

    Attributes:
        oracle: answers questions. number: the number. original: the question with it as requested.
        direction: +1 or −1: towards values that allow more.
        nearest: the value nearest to the request with which a trial has found a cam, and that.
        excluded: the value farthest from the request that is proven impossible.
        needed: a value whose question, as it stands, has a cam. note: on it, or why there is none.
    """

    oracle: Oracle
    number: Relaxable
    original: Trial
    direction: float = 1.0
    nearest: tuple[float, Trial] | None = None
    excluded: float | None = None
    needed: float | None = None
    note: str = LATE
    excesses: dict[float, float] = field(default_factory=dict)
    levels: dict[float, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.direction = self.number.direction
        if self.original.excess is not None:
            excess = max(self.original.excess, NEAR_EXCESS)
            self.excesses[self.number.tightest] = self.levels[self.number.tightest] = excess
        if self.original.proof:
            self._exclude(self.number.tightest)

    def seek_value(self) -> None:
        """Find a value that suffices, near the least one: steps 1 and 2."""
        try:
            if self.number.minimised and self.original.smallest is not None:
                self._take(self.original.smallest)
            elif self._step_outwards() or self._minimise() or self._leave_out():
                self._narrow()
        except TimeoutError:
            self.note = LATE
        self._confirm()

    def seek_bound(self) -> None:
        """Find the largest value that is proven impossible, near the one that suffices: step 3."""
        if self.nearest is None or self.excluded is None:
            return  # what is not proven of the requested value is not of one that allows more
        distance = self._distance_of_proof()
        try:
            while not self._is_close():
                value = self.nearest[0] - self.direction * distance
                if self._beyond(self.number.tightest, value) <= 0.0:
                    break
                if self._tried(value, FINE).proof:
                    break
                distance *= WIDENING
        except TimeoutError:
            pass
        if not self._is_close():
            self._confirm()

    def _is_close(self) -> bool:
        """Whether the value named lies so near to an impossible one that no nearer is sought."""
        if self.needed is None or self.excluded is None:
            return False
        return self._beyond(self.excluded, self.needed) <= CLOSE * abs(self.needed)

    @property
    def at_least(self) -> float | None:
        """The value below which no cam at all fits; None where that is not proven of any."""
        if self.excluded is None or self.needed is None:
            return self.excluded
        return None if self._beyond(self.needed, self.excluded) > 0.0 else self.excluded

    # -- trials ------------------------------------------------------------------------------

    def _tried(self, value: float, tolerance: float = COARSE) -> Trial:
        """The question with the number at a value; raises TimeoutError where time is over."""
        if self.oracle.is_late():
            raise TimeoutError
        trial = self.oracle.relaxed(self.number, value, tolerance)
        self._record(value, trial)
        if not trial.on_time:
            raise TimeoutError
        return trial

    def _record(self, value: float, trial: Trial) -> None:
        self.levels[value] = self._level(trial)
        if trial.excess is not None:
            self.excesses[value] = trial.excess
        if trial.certified:
            self._allow(value, trial)
        if trial.proof:
            self._exclude(value)
        if self.number.minimised and trial.smallest is not None:
            self._take(trial.smallest)

    def _take(self, smallest: Smallest) -> None:
        """Of a maximum of the base radius: the smallest cam is a value, its bound excludes one."""
        self._allow(smallest.radius, Trial(smallest.attempt, smallest, on_time=True))
        if smallest.is_bounded:
            self._exclude(smallest.lower)

    def _allow(self, value: float, trial: Trial) -> None:
        if self.nearest is None or self._beyond(value, self.nearest[0]) > 0.0:
            self.nearest = value, trial

    def _exclude(self, value: float) -> None:
        if not self.number.provable:
            return  # values nearer to the request might do
        if self.excluded is None or self._beyond(self.excluded, value) > 0.0:
            self.excluded = value

    def _beyond(self, value: float, other: float) -> float:
        """How far another value allows more than a value."""
        return self.direction * (other - value)

    def _step_outwards(self) -> bool:
        """Whether a value that suffices is found by the secant of the excess."""
        before = value = self.number.tightest
        excess = self.excesses.get(value)
        if self.number.sense in "=±" or excess is None or value == 0.0:
            return False
        way = (excess + COARSE) * abs(value) / self.number.power
        for _ in range(STEPS):
            value = self.number.tightest + self.direction * way
            if way > FARTHEST * abs(self.number.tightest):
                return False
            trial = self._tried(value)
            if trial.certified:
                return True
            if trial.excess is None or trial.excess > FALLING * excess:
                return False
            fall = (excess - trial.excess) / abs(value - before)
            way += (trial.excess + COARSE) / fall
            before, excess = value, trial.excess
        return False

    def _minimise(self) -> bool:
        """Whether the least value is found by making it the objective, which bounds it as well."""
        objective = OBJECTIVE_OF.get(self.number.limit)
        spec = self.oracle.spec
        if objective is None or self.number.paths[0].startswith("program"):
            return False
        if isfinite(ends(spec.base_radius_mm)[1]):  # the smallest cam is a sharper measure
            return False
        trial = self.oracle.ask(without(spec, [self.number]), COARSE, objective)
        if not trial.certified:
            return False
        if trial.lower is not None:
            self._exclude(trial.lower)
        least, _ = self.oracle.value_on(self.number, trial)
        if least is None:
            return False
        for spare in SPARE:
            value = least * (1.0 + spare)
            if self._tried(value).certified:
                self.levels[value] = 0.0  # no nearer one is sought
                return True
        return False

    def _leave_out(self) -> bool:
        """Whether a cam without the number shows a value that suffices."""
        if self.oracle.is_late():
            raise TimeoutError
        if self.number.farthest is not None:  # an excess, if it is known, says more
            far = self.number.farthest
            return self.number.tightest not in self.excesses and self._tried(far).certified
        if self.number.dimension:  # its value on the smallest cam, not on any
            open_spec = without(self.oracle.spec, [self.number])
            trial = self.oracle.ask(open_spec, COARSE, BaseRadius())
        else:
            trial = self.oracle.without([self.number])
        if not trial.certified:
            self.note = ALONE if trial.on_time else LATE
            return False
        reached, note = self.oracle.value_on(self.number, trial)
        self.note = note or ALONE
        if reached is None:
            return False
        if self.number.sense == "=":
            self.direction = copysign(1.0, reached - self.number.tightest)
        way = reached - self.number.tightest or abs(reached)
        for beyond in SLACK:  # it may have no room with the number
            if self._tried(reached + beyond * way).certified:
                return True
        self.note = ALONE
        return False

    def _narrow(self) -> None:
        """Bring the value that suffices nearer to the least one, to an accuracy.

        Where a question has no cam its excess is known, and falls to zero at the least value: the
        secant of the two nearest to it says where. Where it has one, its excess often is not: a
        trial half the accuracy beyond the secant's zero finds a cam, or a third excess. Without two
        excesses, or where the secant has not come to its end, the bracket is halved.
        """
        requested, secants = self.number.tightest, 0
        while self.nearest is not None:
            good = self.nearest[0]
            levels = self.levels.items()
            failed = [v for v, level in levels if level > 0.0 and self._beyond(v, good) > 0.0]
            bad = max(failed, key=lambda value: self._beyond(requested, value), default=requested)
            way = min(abs(good - requested), abs(good))  # of a request that is far out: the value
            width = max(ACCURACY * way, ROUNDING * abs(good))
            if self.levels.get(good, 0.0) >= 0.0 or abs(good - bad) <= width:
                return
            zero = self._zero_of_excess(failed)
            if zero is not None and 0.0 < self._beyond(zero, good) <= width:
                return
            value = bad if zero is None else zero + 0.5 * self.direction * width
            if secants < SECANTS and self._beyond(bad, value) > 0.0 < self._beyond(value, good):
                secants += 1
            elif bad * good > 0.0 and not 1.0 / WIDE < good / bad < WIDE:
                value = copysign(sqrt(bad * good), good)
            else:
                value = 0.5 * (bad + good)
            self._tried(value)

    def _zero_of_excess(self, failed: Collection[float]) -> float | None:
        """Where the secant of the two least excesses of questions without a cam comes to zero."""
        known = sorted((self.excesses[value], value) for value in failed if value in self.excesses)
        if len(known) < 2 or known[0][0] == known[1][0]:
            return None
        (excess, near), (further, far) = known[:2]
        return near - excess * (far - near) / (further - excess)

    def _level(self, trial: Trial) -> float:
        """Above 0 where no cam is found; 0, which ends a search, next to the least value."""
        excess = None if trial.excess is None else trial.excess + 0.5 * NEAR_EXCESS
        if not trial.certified:
            return excess if excess is not None and excess > 0.0 else 1.0
        if excess is None:
            return -1.0
        return 0.0 if excess >= -0.5 * NEAR_EXCESS else excess

    def _distance_of_proof(self) -> float:
        """How far below the value that suffices one may be proven impossible.

        A bound lies below the excess by about the tolerance; the secant of the excess says which
        change of the number makes up for that.
        """
        assert self.nearest is not None
        good = self.nearest[0]
        least = FINE * abs(good)
        near = sorted(self.excesses, key=lambda value: abs(value - good))[:2]
        if len(near) < 2:
            return least
        rise = abs(self.excesses[near[1]] - self.excesses[near[0]])
        return max(least, FINE * abs(near[1] - near[0]) / rise) if rise > 0.0 else least

    def _confirm(self) -> None:
        """Name the nearest value if the question with it, as it stands, has a cam; else one near.

        That is the same question as will be asked with the value put back, and the same answer.
        """
        if self.nearest is None or self.nearest[0] == self.needed:
            return
        nearest, trial = self.nearest
        spec = self.oracle.spec
        for spare in SPARE:
            value = nearest + self.direction * spare * abs(nearest)
            if self.needed is not None and self._beyond(self.needed, value) >= 0.0:
                return
            if self.oracle.is_late():
                return
            if self.oracle.ask_as_it_stands(relaxed(spec, self.number, value)).certified:
                _, note = self.oracle.value_on(self.number, trial)
                self.needed = value
                self.note = (DEVIATION if self.number.sense == "±" else SUFFICES) + note
                return
