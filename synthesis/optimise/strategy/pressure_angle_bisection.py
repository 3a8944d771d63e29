"""The least peak of the pressure angle where no row states it: a bisection over the limit.

With |tan α| limited to t the rest is an ordinary problem, and how small its cam can be says on
which side of the least t one is: if it is no larger than the largest size allowed, t is possible.
A lower bound of the size above the largest allowed proves that t is impossible, for all laws and
sizes. Where no size at all fits, given laws leave no point of their half-planes; free laws leave no
point in the region of better cams, which the dual bound proves.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from functools import cached_property
from math import exp, inf, isfinite, log

from synthesis.catalogue.objectives import BaseRadius
from synthesis.numerics.solvers.clarabel import solve
from synthesis.numerics.solvers.statuses import USABLE, StopReason
from synthesis.optimise.branching.pivot_node import PivotNode, prove_empty, tighten_node
from synthesis.optimise.conic.program import formulate
from synthesis.optimise.conic.tangent_cuts import TangentPoint
from synthesis.optimise.dual_bound.bound import dual_bound, infeasibility_bound
from synthesis.optimise.dual_bound.costates import boundary_multipliers
from synthesis.optimise.problem.problem import Problem
from synthesis.optimise.recovery.candidate import Candidate
from synthesis.optimise.recovery.closed_form import closed_form_size
from synthesis.optimise.state import Optimise, SolveState, Stage, solvers_of

FIRST = 1.0
"""tan 45°: where the bisection begins."""
MARGIN = 0.05
"""Share of the bracket: how near to one of its ends the next limit may lie."""
STEEPEST = 1e3
"""tan 89.94°."""
TRIALS = 60  # slopes tried at most
BRACKET = 0.25
"""Share of the tolerance: width of the bracket at which to stop."""
BRACKET_OF_GIVEN_LAWS = 1e-3
"""The same with given laws, where a trial costs little."""
ENLARGEMENT = 100.0
"""Factor on the largest base radius: trials may be that large, to tell how far they miss."""
SPARE = 1e-9
"""Relative slack of comparisons, against rounding."""
PROOFS = (1.0, 2.0, 4.0, 8.0, 16.0)
"""Tolerances below the least slope found at which a proof is tried."""
HIGHEST = 3  # derivative up to which the ends of laws have costates
TIGHTENINGS = 2
"""Of the region in one proof."""


@dataclass(frozen=True, eq=False)
class _Bracket:
    """What the trials so far have shown of the least slope.

    Attributes:
        best: the solve that the best cam comes from. possible: the slope of that cam.
        doubtful: the largest slope at which no cam small enough was found. missed: the smallest
            cam there, infinite where there is none.
        proven: the largest slope that is proven impossible. valid_for: for which laws.
        trials: how many slopes were tried. solvers: which solvers that took.
    """

    best: SolveState | None = None
    possible: float = inf
    doubtful: float = 0.0
    missed: float = inf
    proven: float = 0.0
    valid_for: str = ""
    trials: int = 0
    solvers: tuple[str, ...] = ()

    def with_proof(self, slope: float, valid_for: str) -> _Bracket:
        """The bracket with a slope proven impossible."""
        if slope <= self.proven:
            return self
        return replace(self, proven=slope, valid_for=valid_for)


@dataclass(frozen=True, eq=False)
class _SlopeSearch:
    """The problem, and what solving it with one slope as limit shows."""

    state: SolveState
    optimise: Optimise

    @cached_property
    def largest(self) -> float:
        """The norm of the size at the largest base radius allowed."""
        problem = self.state.problem
        return BaseRadius().from_wire(problem.base_radius_range[1], problem.machine)

    def with_limit(self, slope: float, *, enlarged: bool = False) -> Problem:
        """The smallest cam with |tan α| ≤ slope; ``enlarged``: also cams larger than allowed."""
        problem = self.state.problem
        limits = problem.objective.equivalent_limits(slope, problem.machine)
        sizing, follower = problem.sizing, problem.machine.follower
        if enlarged:
            low, high = problem.base_radius_range
            reachable = follower.feasible_base_radii((low, ENLARGEMENT * high), problem.length)
            sizing = follower.size_domain(reachable)
        return replace(
            problem, objective=BaseRadius(), limits=(*problem.limits, *limits), sizing=sizing
        )

    def try_slope(self, bracket: _Bracket, slope: float) -> _Bracket:
        """The bracket after a solve with the slope as limit."""
        state, problem = self.state, self.with_limit(slope, enlarged=True)
        trial = self.optimise(problem, state.tolerance, state.deadline, state.tighten)
        solvers = solvers_of(trial, bracket.solvers)
        bracket = replace(bracket, trials=bracket.trials + 1, solvers=solvers)
        best = trial.incumbent
        if best is not None and best.value <= self.largest:
            objective, machine = state.problem.objective, best.problem.machine
            segments = best.problem.segments
            reached = max(
                objective.segment_value(segment, machine, best.size) for segment in segments
            )
            if min(slope, reached) < bracket.possible:
                return replace(bracket, best=trial, possible=min(slope, reached))
            return bracket
        if slope > bracket.doubtful:
            missed = inf if best is None else best.value
            bracket = replace(bracket, doubtful=slope, missed=missed)
        if not problem.free and self._is_too_large(problem):
            return bracket.with_proof(slope, "every size of the given laws")
        if problem.free and trial.lower > self.largest * (1.0 + SPARE):
            return bracket.with_proof(slope, trial.valid_for)
        return bracket

    def _is_too_large(self, problem: Problem) -> bool:
        """Whether half-planes and cones of given laws leave no size that is small enough."""
        size = closed_form_size(problem)
        if size is None:
            return True
        norm = problem.machine.follower.radius_norm()
        if norm.value(size) > self.largest * (1.0 + SPARE):
            return True
        model = formulate(problem, ())
        solution = solve(model.program)
        if solution.stopped in USABLE:
            bound = dual_bound(model, solution)
        elif solution.stopped is StopReason.INFEASIBLE:  # its multipliers prove it, or nothing does
            ends = boundary_multipliers(model, solution, HIGHEST)
            bound = infeasibility_bound(model, solution, ends)
        else:
            return False
        return bound.value > self.largest * (1.0 + SPARE)

    def next_slope(self, bracket: _Bracket) -> float:
        """Where the smallest cam is as large as allowed, if that is known, else the middle.

        Between the bracket's ends the size is taken as a power of the slope.
        """
        best, missed = bracket.best, bracket.missed
        low, high = max(bracket.doubtful, 0.25 * bracket.possible), bracket.possible
        share = 0.5
        if best is not None and best.incumbent is not None and isfinite(missed):
            share = log(missed / self.largest) / log(missed / best.incumbent.value)
        share = min(max(share, MARGIN), 1.0 - MARGIN)
        return exp((1.0 - share) * log(low) + share * log(high))

    def prove_impossible(self, bracket: _Bracket, slope: float) -> _Bracket:
        """The bracket with a slope proven impossible, if the region of better cams proves it."""
        assert bracket.best is not None
        best = bracket.best.incumbent
        assert best is not None
        problem = self.with_limit(bracket.possible * (1.0 + SPARE))
        about = TangentPoint(tuple(law.curve() for law in best.laws), best.size)
        parts = dict.fromkeys(range(len(problem.free)), (0.0, 1.0))
        node = PivotNode(problem, parts, bracket.best.grids, about=about)
        for _ in range(TIGHTENINGS):
            tighter = tighten_node(self.state, replace(best, value=self.largest), node)
            if tighter is None:
                return bracket
            smaller = replace(tighter, problem=self.with_limit(slope))
            proof = prove_empty(smaller, self.state.time_left)
            if proof is not None:
                return bracket.with_proof(slope, proof.valid_for)
            node = tighter
        return bracket


def bisect_pressure_angle(state: SolveState, optimise: Optimise) -> SolveState:
    """Solve a problem whose objective is a limit that no row states.

    Args:
        state: the solve.
        optimise: solves a problem: problem, tolerance, deadline, tightening.
    """
    started, search = time.perf_counter(), _SlopeSearch(state, optimise)
    bracket = _narrow(search, _first_bracket(search))
    if bracket.best is not None and state.problem.free:
        bracket = _prove(search, bracket)
    best = None if bracket.best is None else bracket.best.incumbent
    if bracket.best is not None and best is not None:
        problem = state.problem.with_laws(best.problem.segments)
        cam = Candidate(problem, best.laws, best.size, bracket.possible)
        state = replace(state, incumbent=cam, relaxed=cam, grids=bracket.best.grids)
        if bracket.proven > 0.0:
            proven = min(bracket.proven, bracket.possible)
            state = state.raise_bound(proven, bracket.valid_for)
    return replace(state, infeasible=best is None).with_stage(
        Stage(
            "peak pressure angle", f"bisection, {bracket.trials} values",
            ", ".join(bracket.solvers) or "none", 1, 0, 0, time.perf_counter() - started,
            "failed" if best is None else "solved",
        )
    )  # fmt: skip


def _first_bracket(search: _SlopeSearch) -> _Bracket:
    """A slope that is possible, and one below at which no cam was found."""
    bracket, state = _Bracket(), search.state
    for slope in (FIRST, STEEPEST):  # where no cam as steep as can be is found, there is none
        if bracket.best is None and state.time_left > 0.0:
            bracket = search.try_slope(bracket, slope)
    while not bracket.doubtful and bracket.possible > 1e-6 and state.time_left > 0.0:
        if bracket.best is None:
            break
        bracket = search.try_slope(bracket, 0.5 * bracket.possible)
    return bracket


def _narrow(search: _SlopeSearch, bracket: _Bracket) -> _Bracket:
    """The bracket, narrowed to a share of the tolerance."""
    state = search.state
    near = (BRACKET if state.problem.free else BRACKET_OF_GIVEN_LAWS) * state.tolerance
    while bracket.best is not None and bracket.trials < TRIALS and state.time_left > 0.0:
        if bracket.possible - bracket.doubtful <= near * bracket.possible:
            break
        bracket = search.try_slope(bracket, search.next_slope(bracket))
    return bracket


def _prove(search: _SlopeSearch, bracket: _Bracket) -> _Bracket:
    """The largest slope below the best that an empty region of better cams proves impossible."""
    for share in PROOFS:
        slope = bracket.possible * (1.0 - share * search.state.tolerance)
        if slope <= bracket.proven or slope <= 0.0 or search.state.time_left <= 0.0:
            break
        before, bracket = bracket, search.prove_impossible(bracket, slope)
        if bracket is not before:
            break
    return bracket
