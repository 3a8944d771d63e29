"""A dimension that makes the problem nonconvex, fixed at one value after the other.

With the laws given, the values are searched in one dimension. With free laws a local search moves
laws, size and dimension together, from several starts. Where it ends outside the dimension's range,
the problem with the dimension fixed at the nearest end of the range gives the answer. No bound over
the dimension is known here: the answer is a local optimum, and the report says so.
"""

from __future__ import annotations

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
from synthesis.optimise.state import CAM_ONLY, Optimise, SolveState, Stage, solvers_of

STARTS = 9
"""Values of the dimension from which a local search starts."""
INTERVALS = 24
"""Of the first mesh."""
MANY_VALUES, FEW_VALUES = 49, 17
"""Values tried first where laws are given, spaced evenly in their logarithm."""
ROUGH_TOLERANCE = 0.01
"""Relative tolerance from which on the smaller number of values suffices."""
START_TOLERANCE = 0.05
"""Tolerance of a solve that only gives a start."""
NO_CAM = 1e30
"""Value of the objective where no cam was found."""
REACH = 16.0
"""Units of the dimension to which an open end of its range is taken."""
ASIDE = (0.8, 1.25)
"""Factors on the dimension of a start: other starts."""


@dataclass(frozen=True, eq=False)
class _FixedDimension:
    """Problems with the dimension fixed, and their cams as cams of the problem at hand."""

    problem: Problem
    dimension: FixableDimension

    def at(self, value: float) -> Problem:
        """The problem with the dimension fixed."""
        return self.problem.with_follower(self.dimension.fixed_at(value))

    def release(self, value: float, cam: Candidate) -> Candidate:
        """A cam of the problem with the dimension fixed, as a cam of the problem at hand."""
        problem = self.problem.with_laws(cam.problem.segments)
        size = self.dimension.full_size(value, cam.size)
        return Candidate(problem, cam.laws, size, objective_value(problem, size))

    def clip(self, value: float) -> float:
        """The nearest value inside the dimension's range."""
        return float(np.clip(value, self.dimension.low, self.dimension.high))

    def log_values(self, count: int) -> list[float]:
        """Logarithms of values from one end of the range to the other, evenly spaced."""
        low = log(max(self.dimension.low, self.dimension.unit / REACH))
        high = max(log(min(self.dimension.high, self.dimension.unit * REACH)), low)
        return [float(x) for x in np.linspace(low, high, count if high > low else 1)]


@dataclass(frozen=True)
class _Cost:
    """What the solves with the dimension fixed have cost.

    Attributes:
        values: of the dimension. iterations, solvers: of all stages of these solves.
    """

    values: frozenset[float] = frozenset()
    iterations: int = 0
    solvers: tuple[str, ...] = ()

    def with_solve(self, value: float, solve: SolveState) -> _Cost:
        """The cost with that of one more solve."""
        iterations = self.iterations + sum(stage.iterations for stage in solve.stages)
        return _Cost(self.values | {value}, iterations, solvers_of(solve, self.solvers))


def search_dimension(state: SolveState, optimise: Optimise) -> SolveState:
    """Search the value of a dimension that makes the problem nonconvex.

    Args:
        state: the solve.
        optimise: solves a problem: problem, tolerance, deadline, tightening.
    """
    dimension = state.problem.machine.follower.fixable_dimension()
    assert dimension is not None
    started, fixed = state.stopwatch, _FixedDimension(state.problem, dimension)
    if not isfinite(state.lower):
        valid_for = f"a local optimum: no bound over the {dimension.name} is known"
        state = replace(state, valid_for=valid_for)
    state, cost = _try_motion(state, fixed, state.relaxed, STARTS), _Cost()
    if not state.is_good_enough:
        # a nonlinear program over all sizes would leave what only a fixed value states
        together = state.problem.free and not dimension.needed
        search = _search_with_free_laws if together else _search_values
        state, cost = search(state, fixed, optimise)
    return replace(state, infeasible=state.incumbent is None).with_stage(
        Stage(
            "fixed dimension", f"{dimension.name} fixed at {len(cost.values)} values",
            ", ".join(cost.solvers) or "none", 1, 0, cost.iterations, state.stopwatch - started,
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
    # A bound with the dimension fixed is none of the problem at hand: a cam is all that is sought.
    problem = fixed.at(value)
    trial = optimise(problem, tolerance, state.deadline, state.tighten, proof=CAM_ONLY)
    relaxed = _better(state.relaxed, trial.relaxed and fixed.release(value, trial.relaxed))
    incumbent = _better(state.incumbent, trial.incumbent and fixed.release(value, trial.incumbent))
    state = replace(state, relaxed=relaxed, incumbent=incumbent)
    return state, cost.with_solve(value, trial), trial


def _better(known: Candidate | None, found: Candidate | None) -> Candidate | None:
    """The cam of smaller value; the known one of equals."""
    return known if found is None or (known and known.value <= found.value) else found


def _try_motion(
    state: SolveState, fixed: _FixedDimension, cam: Candidate | None, count: int
) -> SolveState:
    """Offer a cam's motion with the best size for each of some values of the dimension."""
    if cam is None:
        return state
    for logarithm in fixed.log_values(count):
        value = fixed.clip(exp(logarithm))
        problem = fixed.at(value).with_laws(cam.problem.segments)
        size = smallest_size(problem)
        if size is not None:
            state = state.with_incumbent(fixed.release(value, cam_at_size(problem, cam.laws, size)))
        if state.is_good_enough or state.time_left <= 0.0:
            break
    return state


def _search_values(
    state: SolveState, fixed: _FixedDimension, optimise: Optimise
) -> tuple[SolveState, _Cost]:
    """The best value of a few, then the least between its neighbours."""
    cost, laws_are_free = _Cost(), bool(state.problem.free)
    tolerance = START_TOLERANCE if laws_are_free else state.tolerance  # of the first values

    def objective(logarithm: float) -> float:
        nonlocal state, cost
        if state.time_left <= 0.0:
            return NO_CAM
        value = fixed.clip(exp(logarithm))
        state, cost, trial = _solve_at(state, cost, fixed, optimise, value, tolerance)
        if trial.incumbent is None:
            return NO_CAM
        return trial.problem.objective.to_wire(trial.incumbent.value, trial.problem.machine)

    fine = state.tolerance < ROUGH_TOLERANCE and not laws_are_free
    count = MANY_VALUES if fine else FEW_VALUES
    logarithms = fixed.log_values(count)
    values = [objective(x) for x in logarithms if state.time_left > 0.0]
    best, tolerance = int(np.argmin(values)) if values else 0, state.tolerance
    if values and values[best] < NO_CAM and len(values) > 1:
        around = logarithms[max(best - 1, 0)], logarithms[min(best + 1, len(values) - 1)]
        accuracy = max(min(0.1 * state.tolerance**0.5, 1e-3), 1e-7)
        minimize_scalar(objective, bounds=around, method="bounded", options={"xatol": accuracy})
    return state, cost


def _search_with_free_laws(
    state: SolveState, fixed: _FixedDimension, optimise: Optimise
) -> tuple[SolveState, _Cost]:
    """Free laws: local searches over laws, size and dimension together, from several starts."""
    cost = _Cost()
    grids = tuple(uniform_grid(segment, INTERVALS) for segment in state.problem.free)
    state, smooth = smooth_start(replace(state, grids=grids))
    if state.incumbent is None:
        state = _try_motion(state, fixed, smooth, MANY_VALUES)
    starts = list[Candidate]()
    if state.incumbent is not None:
        state, cost, starts = _starts_beside(state, cost, fixed, optimise)
    else:
        for logarithm in fixed.log_values(STARTS):
            if state.time_left <= 0.0:
                break
            value = fixed.clip(exp(logarithm))
            state, cost, trial = _solve_at(state, cost, fixed, optimise, value, START_TOLERANCE)
            if trial.incumbent is not None:
                starts.append(fixed.release(value, trial.incumbent))
    for start in starts:
        if state.time_left > 0.0:
            state = improve_from(state, start)
    if state.incumbent is None or state.time_left <= 0.0:
        return state, cost
    value = fixed.dimension.value_in(state.incumbent.size)
    inside = fixed.clip(value)
    if inside != value:
        # The local search knows no range of the dimension and has left it: the end next to its
        # answer is taken, with the best laws for that value.
        state = replace(state, incumbent=None, relaxed=None)
        state, cost, trial = _solve_at(state, cost, fixed, optimise, inside, state.tolerance)
        state = replace(state, grids=trial.grids or state.grids)
    return state, cost


def _starts_beside(
    state: SolveState, cost: _Cost, fixed: _FixedDimension, optimise: Optimise
) -> tuple[SolveState, _Cost, list[Candidate]]:
    """The incumbent, and its law with the best sizes for other values of the dimension.

    Where such a value is an end of the range, with the best laws there: in a narrow range no cam is
    much better, and the end itself is one that a question with it given would find.
    """
    best = state.incumbent
    assert best is not None
    starts, value = [best], fixed.dimension.value_in(best.size)
    for factor in ASIDE:
        aside = fixed.clip(factor * value)
        if aside != factor * value:
            state, cost, trial = _solve_at(state, cost, fixed, optimise, aside, state.tolerance)
            if trial.incumbent is not None:
                starts.append(fixed.release(aside, trial.incumbent))
            continue
        problem = fixed.at(aside).with_laws(best.problem.segments)
        size = closed_form_size(problem)
        if size is not None and isfinite(size[0]):
            starts.append(fixed.release(aside, Candidate(problem, best.laws, size, inf)))
    return state, cost, starts
