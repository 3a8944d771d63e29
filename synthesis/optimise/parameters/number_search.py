"""Branch and bound over free angles and lifts: the best numbers, proven over all of them.

A node is a box of numbers. Programs that were solved at single numbers bound a box
(``parametric_bound``), several of them together better than each. Where that bound is least, or
half-way from there to the best numbers, the next program is solved: it raises the bound, and its
cam may be a better incumbent. A box where this no longer helps is divided.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from heapq import heappop, heappush
from itertools import count
from math import inf

import numpy as np

from synthesis.numerics import clock
from synthesis.numerics.piecewise import Array
from synthesis.numerics.polytope import Polytope
from synthesis.optimise.driver import BUDGET, SUFFICIENT
from synthesis.optimise.dual_bound.bound import all_laws
from synthesis.optimise.parameters.parametric_bound import (
    ParametricBound,
    bound_over_box,
    parametric_bound,
)
from synthesis.optimise.parameters.placement import Placement
from synthesis.optimise.recovery.candidate import Candidate
from synthesis.optimise.state import SolveState

TOGETHER = 8  # programs that bound a box together: the nearest to it
NEAR = 0.05  # of a box's width: no second program is solved so near to one
INWARDS = 0.5
"""Of the way from where a bound is least to the best numbers: with several free directions the
former jump about between far corners."""
SHARE_OF_GAP = 0.1  # of the gap at hand, to which single numbers are solved at most
ALL_NUMBERS = "at all angles and lifts that are free"
ROUNDING = 1e-9  # of the box [0, 1]: what the equations may miss


@dataclass(frozen=True)
class Enough:
    """A value, and a lower bound, of the first objective [wire] at which a search may end."""

    value: float = -inf
    bound: float = inf


NOTHING = Enough()


@dataclass(frozen=True, eq=False)
class NumberProof:
    """What a search over all numbers came to.

    Attributes:
        u: the best numbers. value: of their cam [core units].
        lower: no numbers at all allow a better value [core units].
        valid_for: the laws that this covers.
        gap_to: relative gap of that cam to a bound, on the wire.
        searches: how many at single numbers it took. exit: why it ended.
        curved: whether limits that are not in the bound of programs at single numbers matter.
        is_enough: whether value or bound are as good as was asked for.
        cam: the best one, where no further search is to better it.
    """

    u: Array
    value: float
    lower: float
    valid_for: str
    gap_to: Callable[[float], float]
    searches: int
    exit: str
    curved: bool = False
    is_enough: bool = False
    cam: Candidate | None = None

    @property
    def gap(self) -> float:
        """Relative gap of the best cam to the bound, on the wire."""
        return self.gap_to(self.lower)

    def combined(self, other: NumberProof) -> NumberProof:
        """The better cam of two proofs over all numbers, with the better bound."""
        better, worse = sorted((self, other), key=lambda one: one.value)
        return better.with_bound(worse)

    def with_bound(self, other: NumberProof) -> NumberProof:
        """The same with the better bound of two proofs over all numbers."""
        if other.lower <= self.lower:
            return self
        return replace(self, lower=other.lower, valid_for=other.valid_for)


@dataclass(frozen=True, eq=False)
class Box:
    """Numbers from low to high: (n,), (n,)."""

    low: Array
    high: Array

    def within(self, polytope: Polytope) -> Box | None:
        """The box without what the equations exclude; None where nothing is left."""
        low, high = self.low.copy(), self.high.copy()
        for row, rhs in zip(polytope.matrix, polytope.rhs, strict=True):
            least, most = np.minimum(row * low, row * high), np.maximum(row * low, row * high)
            for k in np.flatnonzero(np.abs(row) > ROUNDING):
                # row_k u_k = rhs − all others, which lie in their ranges
                ends = np.array([rhs - most.sum() + most[k], rhs - least.sum() + least[k]]) / row[k]
                low[k] = max(low[k], ends.min() - ROUNDING)
                high[k] = min(high[k], ends.max() + ROUNDING)
        return Box(low, high) if np.all(low <= high) else None

    def halves(self) -> tuple[Box, Box]:
        """The box divided on its widest side."""
        k = int(np.argmax(self.high - self.low))
        middle = 0.5 * (self.low[k] + self.high[k])
        below, above = self.high.copy(), self.low.copy()
        below[k] = above[k] = middle
        return Box(self.low, below), Box(above, self.high)

    def distance(self, u: Array) -> float:
        """How far a point lies outside, in widths of the box."""
        width = np.maximum(self.high - self.low, ROUNDING)
        outside = np.maximum(self.low - u, 0.0) + np.maximum(u - self.high, 0.0)
        return float(np.max(outside / width))


class NumberSearch:
    """The search over all numbers: what it learns from a first start serves the next.

    Attributes:
        known: what programs at single numbers say of all, and to which gap each was solved.
        best: the best cam's value [core units], numbers and search.
    """

    def __init__(
        self,
        placement: Placement,
        solve_at: Callable[[Array, float], SolveState | None],
        tolerance: float,
        single: float,
        enough: Enough = NOTHING,
    ) -> None:
        """Prepare a search.

        Args:
            placement: where segments lie. solve_at: the search at single numbers to a gap.
            tolerance: relative gap [wire] at which to stop. single: that at single numbers.
            enough: a value and a lower bound at which to stop as well.
        """
        self._placement, self._solve_at = placement, solve_at
        self._tolerance, self._single = tolerance, single
        self._enough = enough
        self.known: list[tuple[ParametricBound, float]] = []
        self.best: tuple[float, Array, SolveState] | None = None
        self._searches, self._lower, self._curved = 0, -inf, False

    def run(self, start: Array, last_program: float, deadline: float) -> NumberProof | None:
        """The best numbers and a bound over all of them; None where nothing bounds a box.

        Args:
            start: numbers to begin with.
            last_program: ``clock.programs_solved()`` from which on no further search begins.
            deadline: ``clock.now()`` to stop at.
        """
        polytope, order = self._placement.polytope, count()
        self._solve(start, self._single)
        root = Box(np.zeros(len(start)), np.ones(len(start))).within(polytope)
        if self.best is None or not self.known or root is None:
            return None
        heap = [(self._lower, next(order), root)]
        pruned, why = inf, "no box has a better cam"
        while heap:
            # 1. The box with the least bound, bounded by the programs nearest to it.
            lower, _, box = heappop(heap)
            bound, u = self.bound(box, self._target)
            lower = max(lower, bound)
            if lower >= self._target:
                pruned = min(pruned, lower)
                continue
            if reason := self._reason_to_end(last_program, deadline):
                heappush(heap, (lower, next(order), box))
                why = reason
                break
            # 2. A program where that bound is least, as exact as the gap at hand is worth.
            if polytope.directions.shape[1] > 1 and box.distance(self.best[1]) == 0.0:
                u = u + INWARDS * (self.best[1] - u)
            u = _on_equations(polytope, u)
            gap = self.best[2].gap_between(self.best[2].incumbent, lower)
            wanted = max(self._single, SHARE_OF_GAP * min(gap, 1.0))
            reach = NEAR * (box.high - box.low)
            near = [one for one in self.known if np.all(np.abs(one[0].u - u) <= reach)]
            exact = min((solved for _, solved in near), default=inf)
            if exact > wanted:
                if near:
                    u = near[-1][0].u
                if self._solve(u, wanted):
                    heappush(heap, (lower, next(order), box))
                    continue
            elif exact <= self._single and any(self._is_open(one) for one, _ in near):
                heappush(heap, (lower, next(order), box))
                why = "the relaxation leaves a gap at single numbers"
                break
            # 3. Where none helps any more, the box is divided.
            for half in box.halves():
                inside = half.within(polytope)
                if inside is not None:
                    heappush(heap, (lower, next(order), inside))
        value, numbers, state = self.best
        lower = self._lower = min([pruned, *(each[0] for each in heap)])
        enough = self._suffices or self._on_wire(lower) >= self._enough.bound
        return NumberProof(
            numbers, value, lower,
            f"{all_laws(self.known[0][0].lagrangian.order)}, {ALL_NUMBERS}",
            partial(state.gap_between, state.incumbent), self._searches,
            SUFFICIENT if enough else why, self._curved, enough,
        )  # fmt: skip

    def bound(self, box: Box, target: float) -> tuple[float, Array]:
        """A bound of a box, and where it is least, from the programs nearest to it.

        Above ``target`` [core units] nothing is gained. −∞ where no program is known.
        """
        nearest = sorted(self.known, key=lambda one: box.distance(one[0].u))[:TOGETHER]
        if not nearest:
            return -inf, 0.5 * (box.low + box.high)
        return bound_over_box([one for one, _ in nearest], box.low, box.high, target)

    def _solve(self, u: Array, gap: float) -> bool:
        """Solve at single numbers; whether that bounds others too."""
        self._searches += 1
        state = self._solve_at(u, gap)
        if state is None or state.relaxation is None:
            return False
        self._curved |= state.local_optimum is not None
        cam = state.incumbent
        if cam is not None and (self.best is None or cam.value < self.best[0]):
            self.best = cam.value, u, state
        model, solution, _ = state.relaxation
        one = parametric_bound(self._placement, u, model, solution)
        if one is not None:
            self.known.append((one, gap))
        return one is not None

    @property
    def _target(self) -> float:
        """The bound [core units] of a box that needs no more: it holds nothing better by more than
        the tolerance, or nothing as good as is asked for.
        """
        if self.best is None:
            return inf
        value, _, state = self.best
        least = self._on_wire(value) * (1.0 - self._tolerance)
        wanted = min(least, self._enough.bound)
        return state.problem.objective.from_wire(wanted, state.problem.machine)

    def _reason_to_end(self, last_program: float, deadline: float) -> str:
        """Why no further program is solved, whatever the boxes' bounds; empty: one may be."""
        if self._suffices:
            return SUFFICIENT
        late = clock.now() >= deadline
        return "time" if late else BUDGET if clock.programs_solved() >= last_program else ""

    @property
    def _suffices(self) -> bool:
        """Whether the best cam is as good as is asked for."""
        return self.best is not None and self._on_wire(self.best[0]) <= self._enough.value

    def _on_wire(self, value: float) -> float:
        """A value of the objective [core units] as on the wire."""
        if self.best is None:
            return value
        problem = self.best[2].problem
        return problem.objective.to_wire(value, problem.machine)

    def _is_open(self, one: ParametricBound) -> bool:
        """Whether a program leaves too large a gap at its own numbers."""
        return bound_over_box([one], one.u, one.u, self._target)[0] < self._target


def _on_equations(polytope: Polytope, u: Array) -> Array:
    """The point of the unit box next to u at which the equations hold to rounding."""
    u = np.where(u < ROUNDING, 0.0, np.where(u > 1.0 - ROUNDING, 1.0, u))
    inside = (u > 0.0) & (u < 1.0)
    missed = polytope.matrix @ u - polytope.rhs
    step, *_ = np.linalg.lstsq(polytope.matrix[:, inside], missed, rcond=None)
    u[inside] -= step
    return np.asarray(np.clip(u, 0.0, 1.0))
