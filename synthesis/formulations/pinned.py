"""A free dimension that makes a scene not convex, pinned: a search over its one value.

With the value fixed, the scene is solved as any other; over the value no bound is known, so the
best of all values tried is a local optimum, and said to be no more.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from math import exp, inf, isfinite, log

import numpy as np
from scipy.optimize import minimize_scalar

from synthesis.followers.base import Pinning
from synthesis.formulations.candidate import Candidate, value
from synthesis.formulations.problem import Problem
from synthesis.formulations.search import Search, Stage

FAN = 9  # values tried first, evenly in their logarithm
REACH = 16.0  # an open end is so many times its unit away
ROUGH = 0.05  # tolerance while values are compared
CALLS = 14
Solver = Callable[[Problem, float, float, float], Search]


@dataclass(eq=False)
class _Trials:
    """Values tried, and what each came to."""

    state: Search
    pinning: Pinning
    solve: Solver
    found: dict[float, Search] = field(default_factory=dict)

    def worth(self, logarithm: float, tolerance: float = ROUGH) -> float:
        """The objective on the wire at exp(logarithm); infinite where nothing was found."""
        at = float(np.clip(exp(logarithm), self.pinning.low, self.pinning.high))
        if self.state.left() <= 0.0:
            return inf
        tried = self.solve(self.problem(at), tolerance, self.state.deadline, self.state.tighten)
        self.found[at] = tried
        best = tried.relaxed
        if best is None:
            return inf
        return tried.problem.objective.to_wire(best.value, tried.problem.machine)

    def problem(self, at: float) -> Problem:
        """The question with the dimension fixed."""
        asked = self.state.problem
        follower = self.pinning.at(at)
        machine = replace(asked.machine, follower=follower)
        return replace(asked, machine=machine, sizing=follower.sizing(asked.radii))

    def whole(self, at: float, found: Candidate) -> Candidate:
        """A cam of the fixed dimension as one of the free."""
        settled = self.state.problem.settled(found.problem.stretches)
        size = self.pinning.whole(at, found.size)
        return Candidate(settled, found.laws, size, value(settled, size))


def pinned(state: Search, solve: Solver) -> None:
    """Search over the dimension that can be pinned; offers the best cam to the search at hand."""
    started = time.perf_counter()
    pinning = state.problem.machine.follower.pinning()
    assert pinning is not None
    trials = _Trials(state, pinning, solve)
    low = log(max(pinning.low, pinning.unit / REACH))
    high = max(log(min(pinning.high, pinning.unit * REACH)), low)
    fan = np.linspace(low, high, FAN if high > low else 1)
    values = [trials.worth(float(x)) for x in fan]
    best = int(np.argmin(values))
    state.over = f"a local optimum: no bound over the {pinning.name} is known"
    if isfinite(values[best]):
        at = float(fan[best])
        if high > low:
            around = float(fan[max(best - 1, 0)]), float(fan[min(best + 1, FAN - 1)])
            at = _least(trials, around, state.tolerance)
        trials.worth(at, state.tolerance)
        _offer(state, trials)
    seconds, tried = time.perf_counter() - started, list(trials.found.values())
    iterations = sum(stage.iterations for one in tried for stage in one.stages)
    word = "solved" if state.best else "failed"
    state.stages.append(
        Stage(
            "pinned", f"{pinning.name} searched, {len(tried)} values", "bounded Brent", 1, 0,
            iterations, seconds, word,
        )
    )  # fmt: skip
    state.infeasible = state.relaxed is None


def _least(trials: _Trials, around: tuple[float, float], tolerance: float) -> float:
    """Where the value is least between two logarithms; flat at the top, so a root is enough."""
    accuracy = max(min(0.1 * tolerance**0.5, 0.01), 1e-7)

    def worth(x: float) -> float:
        found = trials.worth(x, min(ROUGH, 10.0 * tolerance))
        return found if isfinite(found) else 1e30

    found = minimize_scalar(
        worth, bounds=around, method="bounded", options={"xatol": accuracy, "maxiter": CALLS}
    )
    return float(found.x)


def _offer(state: Search, trials: _Trials) -> None:
    """The best cam of all values tried."""
    for at, tried in trials.found.items():
        state.grids = tried.grids or state.grids
        if tried.relaxed is not None:
            found = trials.whole(at, tried.relaxed)
            if state.relaxed is None or found.value < state.relaxed.value:
                state.relaxed, state.grids = found, tried.grids
        if tried.best is not None:
            found = trials.whole(at, tried.best)
            if state.best is None or found.value < state.best.value:
                state.best = found
