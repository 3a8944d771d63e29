"""The least peak of the pressure angle where no row says it: a search over the limit.

With |tan α| limited to t the rest is a question like any other, and how small the cam can then be
says on which side of the best t one is: no smaller than the largest allowed, t is just possible.
A lower bound of that radius above the largest allowed proves that t is not, for all laws and sizes.
Where no size at all fits, given laws leave no point of their half-planes, and free ones none in the
region that every better cam keeps to.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import exp, inf, isfinite, log

from synthesis.formulations.bounds.bound import bound
from synthesis.formulations.cams.candidate import Candidate
from synthesis.formulations.cams.closed_form import nearest
from synthesis.formulations.cone.convex import formulate
from synthesis.formulations.cone.cuts import About
from synthesis.formulations.curved.known import Known, empty, narrowed
from synthesis.formulations.question.problem import Problem
from synthesis.formulations.rounds.search import Search, Stage
from synthesis.objectives.base_radius import BaseRadius
from synthesis.solvers.clarabel import solve
from synthesis.solvers.statuses import USABLE, Stopped

FIRST = 1.0  # 45°: where the search begins
MARGIN = 0.05  # of what is between them: how near to an end the next limit may lie
STEEPEST = 1e3  # a pressure angle of 89.94°
TRIALS = 60
SPREAD = 0.25  # of the tolerance: how near possible and impossible limits have to be
SHARP = 1e-3  # the same with given laws, where a trial costs little
OPENED = 100.0  # of the largest base radius: how far above it cams are still told apart
SPARE = 1e-9
LOOSER = (1.0, 2.0, 4.0, 8.0, 16.0)  # tolerances below the best at which a proof is tried
NARROWED = 2
Solver = Callable[[Problem, float, float, float], Search]


@dataclass(eq=False)
class _Steepness:
    """The search at hand: the least slope known to be possible, the largest known not to be.

    Attributes:
        possible: of the best cam. doubtful: the largest at which none was found that is small
            enough. missed: the smallest cam there, infinite where there is none.
        proven: the largest that is proven impossible. over: for which laws.
        found: the search that the best cam comes from.
    """

    state: Search
    searched: Solver
    possible: float = inf
    doubtful: float = 0.0
    missed: float = inf
    proven: float = 0.0
    over: str = ""
    trials: int = 0
    found: Search | None = field(default=None)

    @cached_property
    def largest(self) -> float:
        """The norm of the size at the largest base radius allowed."""
        problem = self.state.problem
        return BaseRadius().from_wire(problem.radii[1], problem.machine)

    def limited(self, slope: float, *, opened: bool = False) -> Problem:
        """The smallest cam with a limit on the pressure angle; with larger ones than allowed."""
        asked = self.state.problem
        limits = asked.objective.limits(slope, asked.machine)
        sizing, follower = asked.sizing, asked.machine.follower
        if opened:
            low, high = asked.radii
            sizing = follower.sizing(follower.reachable((low, OPENED * high), asked.length))
        return replace(
            asked, objective=BaseRadius(), limits=(*asked.limits, *limits), sizing=sizing
        )

    def tried(self, slope: float) -> None:
        """Whether a slope is possible, as far as one search can tell."""
        state, asked = self.state, self.limited(slope, opened=True)
        self.trials += 1
        tried = self.searched(asked, state.tolerance, state.deadline, state.tighten)
        reached = inf if tried.best is None else tried.best.value
        if reached <= self.largest:
            self._keep(slope, tried)
            return
        if slope > self.doubtful:
            self.doubtful, self.missed = slope, reached
        if not asked.free and self._too_large(asked):
            self._prove(slope, "every size of the given laws")
        elif asked.free and tried.lower > self.largest * (1.0 + SPARE):
            self._prove(slope, tried.over)

    def _too_large(self, settled: Problem) -> bool:
        """Whether half-planes and cones of given laws leave no size that is small enough."""
        size = nearest(settled)
        if size is None:
            return True
        norm = settled.machine.follower.prime_radius()
        if norm.value(size) > self.largest * (1.0 + SPARE):
            return True
        plan = formulate(settled, ())
        solution = solve(plan.program)
        if solution.stopped in USABLE:
            return bound(plan, solution).value > self.largest * (1.0 + SPARE)
        return solution.stopped is Stopped.INFEASIBLE

    def next(self) -> float:
        """Where the smallest cam is as large as allowed, if that can be told, else the middle."""
        found, missed = self.found, self.missed
        low, high = max(self.doubtful, 0.25 * self.possible), self.possible
        share = 0.5
        if found is not None and found.best is not None and isfinite(missed):
            share = log(missed / self.largest) / log(missed / found.best.value)
        share = min(max(share, MARGIN), 1.0 - MARGIN)
        return exp((1.0 - share) * log(low) + share * log(high))

    def _keep(self, slope: float, tried: Search) -> None:
        assert tried.best is not None
        objective, problem = self.state.problem.objective, tried.best.problem
        reached = max(
            objective.worst(stretch, problem.machine, tried.best.size)
            for stretch in problem.stretches
        )
        if min(slope, reached) < self.possible:
            self.found, self.possible = tried, min(slope, reached)

    def _prove(self, slope: float, over: str) -> None:
        if slope > self.proven:
            self.proven, self.over = slope, over

    def impossible(self, slope: float) -> bool:
        """Whether a slope is proven impossible by the region of cams that are no steeper."""
        found = self.found
        assert found is not None
        assert found.best is not None
        best, problem = found.best, self.limited(self.possible * (1.0 + SPARE))
        about = About(tuple(law.curve() for law in best.laws), best.size)
        known = Known(problem, -inf, "", found.grids, about=about)
        near = dict.fromkeys(range(len(problem.free)), (0.0, 1.0))
        for _ in range(NARROWED):
            region = narrowed(self.state, replace(best, value=self.largest), near, known)
            if region is None:
                return False
            proof = empty(replace(region, problem=self.limited(slope)), self.state.left())
            if proof is not None:
                self._prove(slope, proof.over)
                return True
            known = region
        return False


def steepness(state: Search, searched: Solver) -> None:
    """Solve a scene whose objective is a limit that no fixed row says.

    Args:
        state: the search.
        searched: solves a problem without it: problem, tolerance, deadline, tightening.
    """
    started, trials = time.perf_counter(), _Steepness(state, searched)
    _bracketed(trials)
    _closed_in(trials)
    if trials.found is not None and state.problem.free:
        _proven(trials)
    best = None if trials.found is None else trials.found.best
    if best is not None:
        settled = state.problem.settled(best.problem.stretches)
        state.best = state.relaxed = Candidate(settled, best.laws, best.size, trials.possible)
        state.grids = trials.found.grids if trials.found is not None else ()
        if trials.proven > 0.0:
            state.raise_to(min(trials.proven, trials.possible), trials.over)
    state.infeasible = best is None
    state.stages.append(
        Stage(
            "steepness", f"{trials.trials} limits on it", "all of the above", 1, 0, 0,
            time.perf_counter() - started, "failed" if best is None else "solved",
        )
    )  # fmt: skip


def _bracketed(trials: _Steepness) -> None:
    """A slope that is possible, and one below at which no cam was found."""
    for slope in (FIRST, STEEPEST):  # where a cam as steep as can be is not found, none is
        if trials.found is None and trials.state.left() > 0.0:
            trials.tried(slope)
    while not trials.doubtful and trials.possible > 1e-6 and trials.state.left() > 0.0:
        if trials.found is None:
            return
        trials.tried(0.5 * trials.possible)


def _closed_in(trials: _Steepness) -> None:
    """Possible and doubtful slopes brought together."""
    state = trials.state
    near = (SPREAD if state.problem.free else SHARP) * state.tolerance
    while trials.found is not None and trials.trials < TRIALS and state.left() > 0.0:
        if trials.possible - trials.doubtful <= near * trials.possible:
            break
        trials.tried(trials.next())


def _proven(trials: _Steepness) -> None:
    """The largest slope below the best that a region without a point proves impossible."""
    state = trials.state
    for share in LOOSER:
        slope = trials.possible * (1.0 - share * state.tolerance)
        if slope <= trials.proven or slope <= 0.0 or state.left() <= 0.0:
            return
        if trials.impossible(slope):
            return
