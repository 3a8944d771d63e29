"""A dimension that makes the problem nonconvex, fixed at one value after the other.

With the laws given, the values are searched in one dimension. With free laws a nonlinear program
moves all together, from several starts; the problem with the dimension fixed at its answer then
gives the best of all laws for that value, and the nonlinear program goes on from there. No bound
over the dimension is known here: the answer is a local optimum, and the report says so.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from math import exp, inf, isfinite, log

import numpy as np
from scipy.optimize import minimize_scalar

from synthesis.catalogue.followers.base import FixableDimension
from synthesis.optimise.heuristics.local_search import improve_from, smooth_start
from synthesis.optimise.problem.grid import uniform_grid
from synthesis.optimise.problem.problem import Problem
from synthesis.optimise.recovery.candidate import (
    Candidate,
    cam_at_size,
    objective_value,
    smallest_size,
)
from synthesis.optimise.recovery.closed_form import closed_form_size
from synthesis.optimise.state import SolveState, Stage

STARTS = 9
"""Values of the dimension from which a local search starts."""
INTERVALS = 24
"""Of the first mesh."""
MANY_VALUES, FEW_VALUES = 49, 17
"""Values tried first where laws are given, evenly in their logarithm."""
ROUGH_TOLERANCE = 0.01
"""Tolerance from which on few values do."""
START_TOLERANCE = 0.05
"""Tolerance of a solve that only gives a start."""
NO_CAM = 1e30
"""Value of the objective where no cam was found."""
REACH = 16.0
"""Units of the dimension to which an open end of its range is taken."""
ASIDE = (0.8, 1.25)
"""Factors on the dimension of a start: other starts."""

Optimise = Callable[[Problem, float, float, float], SolveState]


@dataclass(frozen=True, eq=False)
class _FixedDimension:
    """Problems with the dimension fixed, and their cams as cams of the problem at hand."""

    problem: Problem
    pinning: FixableDimension

    def at(self, value: float) -> Problem:
        """The problem with the dimension fixed."""
        return self.problem.with_follower(self.pinning.fixed_at(value))

    def freed(self, value: float, cam: Candidate) -> Candidate:
        """A cam of the fixed dimension as one of the free dimension."""
        problem = self.problem.with_laws(cam.problem.segments)
        size = self.pinning.full_size(value, cam.size)
        return Candidate(problem, cam.laws, size, objective_value(problem, size))

    def clipped(self, value: float) -> float:
        """The nearest value of the range."""
        return float(np.clip(value, self.pinning.low, self.pinning.high))

    def values(self, count: int) -> list[float]:
        """Logarithms of values all over the range, evenly spaced."""
        low = log(max(self.pinning.low, self.pinning.unit / REACH))
        high = max(log(min(self.pinning.high, self.pinning.unit * REACH)), low)
        return [float(x) for x in np.linspace(low, high, count if high > low else 1)]


@dataclass(frozen=True)
class _Cost:
    """What the trials so far have cost: their number, and iterations of all their stages."""

    values: frozenset[float] = frozenset()
    iterations: int = 0


Trial = tuple[SolveState, _Cost]


def search_dimension(state: SolveState, optimise: Optimise) -> SolveState:
    """Search the value of a dimension that makes the problem nonconvex.

    Args:
        state: the solve.
        optimise: solves a problem: problem, tolerance, deadline, tightening.
    """
    pinning = state.problem.machine.follower.fixable_dimension()
    assert pinning is not None
    started, fixed = state.stopwatch, _FixedDimension(state.problem, pinning)
    if not isfinite(state.lower):
        valid_for = f"a local optimum: no bound over the {pinning.name} is known"
        state = replace(state, valid_for=valid_for)
    state, cost = _try_motion(state, fixed, state.relaxed, STARTS), _Cost()
    if not state.solved:
        # a nonlinear program over all sizes would leave what only a fixed value states
        together = state.problem.free and not pinning.needed
        search = _search_with_free_laws if together else _search_values
        state, cost = search(state, fixed, optimise)
    return replace(state, infeasible=state.incumbent is None).with_stage(
        Stage(
            "pinned", f"{pinning.name}, {len(cost.values)} values", "all of the above", 1, 0,
            cost.iterations, state.stopwatch - started,
            "solved" if state.incumbent else "failed",
        )
    )  # fmt: skip


def _solve_at(
    state: SolveState,
    cost: _Cost,
    fixed: _FixedDimension,
    optimise: Optimise,
    value: float,
    tolerance: float,
) -> tuple[SolveState, _Cost, SolveState]:
    """Solve with the dimension fixed, and offer the cam to the problem at hand."""
    trial = optimise(fixed.at(value), tolerance, state.deadline, state.tighten)
    relaxed = _better(state.relaxed, trial.relaxed and fixed.freed(value, trial.relaxed))
    incumbent = _better(state.incumbent, trial.incumbent and fixed.freed(value, trial.incumbent))
    state = replace(state, relaxed=relaxed, incumbent=incumbent)
    iterations = cost.iterations + sum(stage.iterations for stage in trial.stages)
    return state, _Cost(cost.values | {value}, iterations), trial


def _better(known: Candidate | None, found: Candidate | None) -> Candidate | None:
    """The cam of smaller value; the known one of equals."""
    return known if found is None or (known and known.value <= found.value) else found


def _try_motion(
    state: SolveState, fixed: _FixedDimension, cam: Candidate | None, count: int
) -> SolveState:
    """Offer a cam's motion with other sizes: its law may be a good one, and its size not."""
    if cam is None:
        return state
    for logarithm in fixed.values(count):
        value = fixed.clipped(exp(logarithm))
        problem = fixed.at(value).with_laws(cam.problem.segments)
        size = smallest_size(problem)
        if size is not None:
            state = state.with_incumbent(fixed.freed(value, cam_at_size(problem, cam.laws, size)))
        if state.solved or state.time_left <= 0.0:
            break
    return state


def _search_values(state: SolveState, fixed: _FixedDimension, optimise: Optimise) -> Trial:
    """The best value of a few, then the least between its neighbours."""
    cost, laws_are_free = _Cost(), bool(state.problem.free)
    tolerance = START_TOLERANCE if laws_are_free else state.tolerance  # of the first values

    def objective(logarithm: float) -> float:
        nonlocal state, cost
        if state.time_left <= 0.0:
            return NO_CAM
        value = fixed.clipped(exp(logarithm))
        state, cost, trial = _solve_at(state, cost, fixed, optimise, value, tolerance)
        if trial.incumbent is None:
            return NO_CAM
        return trial.problem.objective.to_wire(trial.incumbent.value, trial.problem.machine)

    fine = state.tolerance < ROUGH_TOLERANCE and not laws_are_free
    count = MANY_VALUES if fine else FEW_VALUES
    logarithms = fixed.values(count)
    values = [objective(x) for x in logarithms if state.time_left > 0.0]
    best, tolerance = int(np.argmin(values)) if values else 0, state.tolerance
    if values and values[best] < NO_CAM and len(values) > 1:
        around = logarithms[max(best - 1, 0)], logarithms[min(best + 1, len(values) - 1)]
        accuracy = max(min(0.1 * state.tolerance**0.5, 1e-3), 1e-7)
        minimize_scalar(objective, bounds=around, method="bounded", options={"xatol": accuracy})
    return state, cost


def _search_with_free_laws(state: SolveState, fixed: _FixedDimension, optimise: Optimise) -> Trial:
    """Free laws: all together from several starts, then the best laws for where that ended."""
    cost = _Cost()
    grids = tuple(uniform_grid(segment, INTERVALS) for segment in state.problem.free)
    state, smooth = smooth_start(replace(state, grids=grids))
    if state.incumbent is None:
        state = _try_motion(state, fixed, smooth, MANY_VALUES)
    starts = list[Candidate]()
    if state.incumbent is not None:
        starts = list(_starts_beside(fixed, state.incumbent))
    else:
        for logarithm in fixed.values(STARTS):
            if state.time_left <= 0.0:
                break
            value = fixed.clipped(exp(logarithm))
            state, cost, trial = _solve_at(state, cost, fixed, optimise, value, START_TOLERANCE)
            if trial.incumbent is not None:
                starts.append(fixed.freed(value, trial.incumbent))
    for start in starts:
        if state.time_left > 0.0:
            state = improve_from(state, start)
    if state.incumbent is None or state.time_left <= 0.0:
        return state, cost
    value = fixed.pinning.value_in(state.incumbent.size)
    inside = fixed.clipped(value)
    if inside != value:
        # the local search has left the range: the best is at the end of the range
        state = replace(state, incumbent=None, relaxed=None)
        state, cost, trial = _solve_at(state, cost, fixed, optimise, inside, state.tolerance)
        state = replace(state, grids=trial.grids or state.grids)
    return state, cost


def _starts_beside(fixed: _FixedDimension, best: Candidate) -> Iterator[Candidate]:
    """The incumbent, and its law with the best sizes for other values of the dimension."""
    yield best
    value = fixed.pinning.value_in(best.size)
    for factor in ASIDE:
        aside = fixed.clipped(factor * value)
        problem = fixed.at(aside).with_laws(best.problem.segments)
        size = closed_form_size(problem)
        if size is not None and isfinite(size[0]):
            yield fixed.freed(aside, Candidate(problem, best.laws, size, inf))
