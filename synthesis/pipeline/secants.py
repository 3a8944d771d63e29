"""Secants of the excess of a question over one of its numbers: its slope, and its zero."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from math import copysign, inf, sqrt

from scipy.optimize import brentq

WIDE = 4.0  # ratio of a bracket's ends from which on it is halved on a logarithmic scale
WIDENING = 4.0  # factor from one distance to the next at which a value is tried for a proof
PROOF_MARGIN = 0.3  # of what a bound leaves open: as much nearer to the request a proof is sought
STEPS_BACK = 4  # from a point that proves nothing


def halfway(one: float, other: float) -> float:
    """The middle of two values; where they are far apart, on a logarithmic scale."""
    if one * other > 0.0 and not 1.0 / WIDE < other / one < WIDE:
        return copysign(sqrt(one * other), other)
    return 0.5 * (one + other)


def slope_of(excesses: Mapping[float, float], noise: float) -> float:
    """By how much the excess falls per unit, near its zero; 0 where that is not known.

    Args:
        excesses: by the values tried. noise: those that differ by no more say nothing of the slope,
            if others do.
    """
    if len(excesses) < 2:
        return 0.0
    (value, excess), *others = sorted(excesses.items(), key=lambda pair: abs(pair[1]))
    # The search for a cam that is small enough ends with the first: others' excesses say more.
    others.sort(key=lambda pair: (pair[1] < 0.0, abs(pair[1])))
    apart = (pair for pair in others if abs(pair[1] - excess) > noise)
    farthest = max(others, key=lambda pair: pair[1])
    other, further = next(apart, farthest if noise else others[0])
    return (further - excess) / (value - other)


def zero_of(
    excesses: Mapping[float, float], failed: Collection[float], good: float
) -> float | None:
    """Where the secant of the two least excesses of questions comes to zero.

    With one alone, that to the excess of the cam nearest to it: the search for it ended as soon as
    it was small enough, so the zero lies no nearer to that cam.

    Args:
        excesses: by the values tried. failed: values of questions whose excess is the least.
        good: the value of that cam.
    """
    known = [(excesses[value], value) for value in failed if value in excesses]
    known.sort(key=lambda pair: abs(pair[0]))
    if len(known) == 1 and good in excesses:
        known.append((excesses[good], good))
    if len(known) < 2 or known[0][0] == known[1][0]:
        return None
    (excess, near), (further, far) = known[:2]
    return near - excess * (far - near) / (further - excess)


def approach_zero(
    falling: Callable[[float], float], at: float, expected: float, step: float
) -> bool:
    """Evaluate a falling function ever nearer to its zero, on the side where it is positive.

    A bound by fixed multipliers is such a function, known best at one point. Where a limit binds
    along an arc it has a kink there: from a point where it is positive it leads nearly to the zero
    that the slope says; from one where it is not, a few steps back show whether it turns positive.

    Args:
        at: the point. expected: where its slope says that the zero is. step: the accuracy.

    Returns:
        whether the function was positive anywhere. Negative arguments are not tried.
    """
    low, high = min(at, expected), max(at, expected)
    if falling(at) <= 0.0:
        steps = (low - step * WIDENING**k for k in range(STEPS_BACK))
        tried = (one for one in steps if one > 0.0)
        low, high = next((one for one in tried if falling(one) > 0.0), 0.0), at
    if low <= 0.0:
        return False
    if falling(high) <= 0.0:
        root = float(brentq(falling, low, high, xtol=step))
        falling(root - step)
    return True


@dataclass
class SecantBracket:
    """The zero of a falling excess, bracketed by secants: a cam on one side, a proof on the other.

    A trial says where the cam's excess comes to zero, and how much nearer its bound does. The end
    that is farther from there is brought next to it, after a first proof. Where a secant leaves
    more than half of the bracket, as at a kink, that is halved.

    Attributes:
        slope: by how much the excess falls per unit of the way; 0 where that is not known.
        proof_step: how far from the zero a proof is sought as long as no bound is known.
        zero: the way at which the cam's excess is 0; ∞ where that is not known.
        gap: between the excesses of cam and bound in the last trial that has both.
        before: way and excess of the last trial that was exact.
        above, below: way and excess of the trials nearest to the zero on either side.
        has_proof: whether a trial has excluded a way. may_end_early: whether the next trial for a
            cam may end with any that is small enough.
        halved_above: width of a bracket above which it is halved.
    """

    slope: float
    proof_step: float
    zero: float = inf
    gap: float | None = None
    before: tuple[float, float] | None = None
    above: tuple[float, float] | None = None
    below: tuple[float, float] | None = None
    has_proof: bool = False
    may_end_early: bool = True
    halved_above: float = inf

    @property
    def open_way(self) -> float:
        """From the zero of the bound to that of the cam; 0 where it is not known.

        By the steeper of two slopes: one next to the zero may be that of a flat part.
        """
        slope = self.slope
        if self.above is not None and self.below is not None:
            (low, excess), (high, other) = self.above, self.below
            slope = max(slope, (excess - other) / (high - low)) if low < high else slope
        return self.gap / slope if self.gap is not None and slope > 0.0 else 0.0

    def zero_from(self, way: float, excess: float | None) -> float:
        """The way at which an excess falls to 0; ∞ where that is not known."""
        return inf if excess is None or self.slope <= 0.0 else way + excess / self.slope

    def next_way(self, bad: float, good: float, width: float) -> tuple[float, bool]:
        """The way to try next, and whether its smallest cam is sought, not any.

        Args:
            bad, good: the ends of the bracket. width: how near to the zero an end is brought.
        """
        self.zero = min(max(self.zero, bad), good)
        is_wide = good - bad > self.halved_above
        nearer = self.has_proof and good - self.zero > max(width, self.zero - bad)
        self.halved_above = inf if is_wide else 0.5 * (good - bad)
        if nearer and not is_wide:
            exactly, self.may_end_early = not self.may_end_early, False
            return self.zero + 0.5 * width, exactly
        apart = self.proof_step if self.gap is None else self.open_way
        way = self.zero - apart - max(0.5 * width, PROOF_MARGIN * apart)
        way, self.proof_step = max(way, 0.5 * (bad + self.zero)), WIDENING * self.proof_step
        return 0.5 * (bad + good) if is_wide or way <= bad else way, True

    def learn(
        self, way: float, excess: float | None, bound: float | None = None, *, certified: bool,
        exactly: bool, slope: float, noise: float,
    ) -> None:  # fmt: skip
        """Take slope, zero and gap from a trial.

        Args:
            way: that was tried. excess, bound: of its cam, and of the bound of all; None where they
                are not known. certified: whether there is a cam. exactly: whether it is the
                smallest. slope: to be taken if none is known. noise: excesses that differ by no
                more say nothing of the slope.
        """
        if exactly and excess is not None:
            before_way, before = self.before or (way, excess)
            if before_way != way and abs(excess - before) > noise:
                self.slope = (excess - before) / (before_way - way)
            self.before = way, excess
            if excess > 0.0 and (self.above is None or way > self.above[0]):
                self.above = way, excess
            if excess <= 0.0 and (self.below is None or way < self.below[0]):
                self.below = way, excess
            self.gap = self.gap if bound is None else max(excess - bound, 0.0)
        self.slope = self.slope if self.slope > 0.0 else slope
        found = self.zero_from(way, excess)
        if found < inf and (exactly or found < self.zero):
            self.zero = found
        elif found == inf and certified:
            self.zero = min(self.zero, way)
