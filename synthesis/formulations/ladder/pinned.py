"""A free dimension that makes a scene not convex, pinned: the rest is solved as any other scene.

With the laws given, its values are searched. With free laws, a nonlinear program moves all
together, from several starts; the scene pinned at its answer then finds the best of all laws for
that value, and the program moves on from there. Over the value itself no bound is known: the
answer is a local optimum, and said to be no more.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from math import exp, inf, isfinite, log

import numpy as np
from scipy.optimize import minimize_scalar

from synthesis.followers.base import Pinning
from synthesis.formulations.cams.candidate import Candidate, at_size, smallest, value
from synthesis.formulations.cams.closed_form import nearest
from synthesis.formulations.nonconvex.local import gentle, improve_from
from synthesis.formulations.question.grid import uniform
from synthesis.formulations.question.problem import Problem
from synthesis.formulations.rounds.search import Search, Stage

STARTS = 9  # values from which starts are made
KNOTS = 24  # intervals of the first knots
FAN, FEW = 49, 17  # values tried first where laws are given, evenly in their logarithm
ROUGHLY = 0.01  # tolerance from which on few of them do
NOTHING = 1e30  # worth of a value at which nothing fits
REACH = 16.0  # an open end is so many times its unit away
ASIDE = (0.8, 1.25)  # of the value of a start: others
ROUGH = 0.05  # tolerance where only a start is wanted
Solver = Callable[[Problem, float, float, float], Search]


@dataclass(eq=False)
class _Pinned:
    """The search at hand, with its dimension pinned at one value after the other."""

    state: Search
    pinning: Pinning
    solve: Solver
    found: dict[float, Search] = field(default_factory=dict)

    def problem(self, at: float) -> Problem:
        """The question with the dimension fixed."""
        return self.state.problem.with_follower(self.pinning.at(at))

    def whole(self, at: float, found: Candidate) -> Candidate:
        """A cam of the fixed dimension as one of the free."""
        settled = self.state.problem.settled(found.problem.stretches)
        size = self.pinning.whole(at, found.size)
        return Candidate(settled, found.laws, size, value(settled, size))

    def within(self, at: float) -> float:
        """The value of the range that is nearest."""
        return float(np.clip(at, self.pinning.low, self.pinning.high))

    def fan(self, count: int) -> list[float]:
        """Values all over the range, evenly in their logarithm."""
        low = log(max(self.pinning.low, self.pinning.unit / REACH))
        high = max(log(min(self.pinning.high, self.pinning.unit * REACH)), low)
        return [float(x) for x in np.linspace(low, high, count if high > low else 1)]

    def worth(self, logarithm: float) -> float:
        """The objective on the wire with the laws given; a large number where nothing fits."""
        if self.state.left() <= 0.0:
            return NOTHING
        at = self.within(exp(logarithm))
        tried = self.solved(at, self.state.tolerance)
        if tried.best is None:
            return NOTHING
        return tried.problem.objective.to_wire(tried.best.value, tried.problem.machine)

    def solved(self, at: float, tolerance: float) -> Search:
        """The scene with the dimension at a value; its cam is offered to the search at hand."""
        state = self.state
        self.found[at] = tried = self.solve(
            self.problem(at), tolerance, state.deadline, state.tighten
        )
        for mine, its in (("relaxed", tried.relaxed), ("best", tried.best)):
            if its is not None:
                known, found = getattr(state, mine), self.whole(at, its)
                if known is None or found.value < known.value:
                    setattr(state, mine, found)
        return tried


def pinned(state: Search, solve: Solver) -> None:
    """Solve a scene with a dimension that can be pinned.

    Args:
        state: the search.
        solve: solves a problem without it: problem, tolerance, deadline, tightening.
    """
    pinning = state.problem.machine.follower.pinning()
    assert pinning is not None
    started, trials = time.perf_counter(), _Pinned(state, pinning, solve)
    if not isfinite(state.lower):
        state.over = f"a local optimum: no bound over the {pinning.name} is known"
    _as_it_moves(trials, state.relaxed, STARTS)
    if not state.close(state.best):
        (_jointly if state.problem.free else _one_by_one)(trials)
    state.infeasible = state.best is None
    tried = list(trials.found.values())
    iterations = sum(stage.iterations for one in tried for stage in one.stages)
    word = "solved" if state.best else "failed"
    state.stages.append(
        Stage(
            "pinned", f"{pinning.name}, {len(tried)} values", "all of the above", 1, 0, iterations,
            time.perf_counter() - started, word,
        )
    )  # fmt: skip


def _as_it_moves(trials: _Pinned, cam: Candidate | None, count: int) -> None:
    """A cam's motion on other sizes: its law may be a good one, and its size not."""
    state = trials.state
    if cam is None:
        return
    for logarithm in trials.fan(count):
        at = trials.within(exp(logarithm))
        problem = trials.problem(at).settled(cam.problem.stretches)
        size = smallest(problem)
        if size is not None:
            state.finish(trials.whole(at, at_size(problem, cam.laws, size)))
        if state.close(state.best) or state.left() <= 0.0:
            break


def _one_by_one(trials: _Pinned) -> None:
    """Given laws: the best value of a fan, and the least between its neighbours."""
    fan = trials.fan(FAN if trials.state.tolerance < ROUGHLY else FEW)
    values = [trials.worth(x) for x in fan if trials.state.left() > 0.0]
    best = int(np.argmin(values)) if values else 0
    if not values or values[best] >= NOTHING or len(values) == 1:
        return
    around = fan[max(best - 1, 0)], fan[min(best + 1, len(values) - 1)]
    accuracy = max(min(0.1 * trials.state.tolerance**0.5, 1e-3), 1e-7)
    minimize_scalar(trials.worth, bounds=around, method="bounded", options={"xatol": accuracy})


def _jointly(trials: _Pinned) -> None:
    """Free laws: all together from several starts, then the best laws for where that ended."""
    state = trials.state
    state.grids = tuple(uniform(stretch, KNOTS) for stretch in state.problem.free)
    quiet = gentle(state)
    if state.best is None:
        _as_it_moves(trials, quiet, FAN)
    for start in list(_starts(trials)):
        if state.left() > 0.0:
            improve_from(state, start)
    if state.best is None or state.left() <= 0.0:
        return
    at = trials.pinning.of(state.best.size)
    inside = trials.within(at)
    if inside != at:
        state.best = state.relaxed = None  # it had left the range: the best is at its end
        tried = trials.solved(inside, state.tolerance)
        state.grids = tried.grids or state.grids


def _starts(trials: _Pinned) -> Iterator[Candidate]:
    """The gentlest law with the best size for it, and with others beside; else what fits."""
    state = trials.state
    if state.best is None:
        for logarithm in trials.fan(STARTS):
            if state.left() <= 0.0:
                return
            at = trials.within(exp(logarithm))
            tried = trials.solved(at, ROUGH)
            if tried.best is not None:
                yield trials.whole(at, tried.best)
        return
    yield state.best
    at = trials.pinning.of(state.best.size)
    for factor in ASIDE:
        aside = trials.within(factor * at)
        problem = trials.problem(aside).settled(state.best.problem.stretches)
        size = nearest(problem)
        if size is not None and isfinite(size[0]):
            yield trials.whole(aside, Candidate(problem, state.best.laws, size, inf))
