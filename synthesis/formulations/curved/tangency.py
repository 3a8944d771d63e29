"""Rows of curved limits, turned so that they touch the limit where the last answer was.

Each cone program with rows that hold for every motion and size of a region is a relaxation, and
bounds what is sought. Where the limit is convex, rows about the last answer make the next one
exact to the second order, as in Newton's method; those of the answers before are kept for a
while, without which it may swing to and fro.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import inf, isfinite, sqrt

import numpy as np

from synthesis.formulations.bounds.bound import Bound
from synthesis.formulations.cams.candidate import settle
from synthesis.formulations.cone.control import controls
from synthesis.formulations.cone.convex import EXACT, Plan, formulate
from synthesis.formulations.cone.cuts import About, Region
from synthesis.formulations.curved.tube import tubes
from synthesis.formulations.nonconvex.local import gentle, improve_from
from synthesis.formulations.question.grid import Grid
from synthesis.formulations.question.problem import Held, Nothing, Problem
from synthesis.formulations.rounds.missed import ALLOWED, misses
from synthesis.formulations.rounds.search import Search
from synthesis.solvers.clarabel import ConeSolution

TURNS = 24
STALLED = 0.05  # of the tolerance, or of what is missing: gain of a turn that is none
WORTH = 0.1  # of what is missing: what narrowing has to gain before it is done again
WIDE = 0.3  # of the gap: what the region's width may cost before it is narrowed
KEPT = 4  # answers whose rows are kept
MET = 1e-9  # excess of a curved limit that rows about the answer have no more to take off
SHARE = 0.1  # of the tolerance: what rows may leave to gain where the size alone is weighed
SPARE = 1e-9
Outcome = tuple[Plan, ConeSolution, Bound | None]
Solved = Callable[[Search, float], Outcome]


def turned(state: Search, trial: float, solved: Solved) -> Outcome:
    """Cone programs on the present grids, until their rows touch curved limits at the answer.

    Args:
        state: the search; it learns every bound, and is offered every cam.
        trial: trial level of a fractional objective.
        solved: states and solves one program.
    """
    value, narrowed_at = -inf, -inf
    if state.relaxed is None and state.region is None:
        gentle(state)  # any cam at all says what no better one exceeds
    for _ in range(TURNS):
        plan, solution, lower = solved(state, trial)
        if lower is None:
            break
        state.learn(lower)
        loose = _turn(state, plan, solution)
        state.tangent = not loose
        if state.tangent or state.close(state.relaxed) or state.left() <= 0.0:
            break
        if state.problem.rigid:
            break
        before, value = value, _value(plan, solution)
        if value - before > _gain_worth(state, value):
            continue
        # rows have turned as far as they do: what is left is due to the region's width
        if not _worth_it(state, value):
            break
        _improved(state)
        if value - narrowed_at <= WORTH * (_smallest(state) - value) < inf:
            break
        if not _narrowed(state, plan, lower, loose):
            break
        narrowed_at = value
    return plan, solution, lower


def _value(plan: Plan, solution: ConeSolution) -> float:
    """The program's objective in core units."""
    if plan.energy is not None:
        squares = float(np.sum(solution.x[plan.squares] ** 2))
        return sqrt(squares * plan.energy.unit + plan.energy.constant)
    norm = plan.problem.objective.norm(plan.problem.machine)
    assert plan.extra is not None
    unit = plan.scales.level if norm is None else plan.scales.size
    return float(solution.x[plan.extra]) * unit


def _smallest(state: Search) -> float:
    """The value of the best cam so far, infinite while there is none."""
    found = [cam.value for cam in (state.relaxed, state.best) if cam is not None]
    return min(found, default=inf)


def _improved(state: Search) -> None:
    """Where laws of the cone programs fit no size at all, another way to a cam, once."""
    if state.last is not None and not state.improved and misses(state, state.last)[1] > ALLOWED:
        state.improved = True
        improve_from(state, state.best or state.relaxed or state.last)


def _gain_worth(state: Search, value: float) -> float:
    """The least gain of a turn for which there is another one."""
    least, missing = STALLED * state.tolerance * abs(value), _smallest(state) - value
    return max(least, STALLED * missing) if isfinite(missing) else least


def _worth_it(state: Search, value: float) -> bool:
    """Whether rows leave more to gain than knots do."""
    best = _smallest(state)
    if not isfinite(best - state.lower):
        return True
    return best - value > WIDE * (best - state.lower)


def _narrowed(state: Search, plan: Plan, lower: Bound, loose: set[int]) -> bool:
    """Narrow the region to what a better cam can be; False where nothing says how."""
    region, problem, best = state.region, state.problem, _smallest(state)
    if region is None or not lower.switching or not isfinite(best):
        return False
    inside = replace(problem.sizing, bounds=region.sizes, least=0.0)
    asked = replace(problem, objective=Nothing(), sizing=inside)
    if problem.objective.norm(problem.machine) is None:  # otherwise the sizes say it
        held = Held(problem.objective, best * (1.0 + SPARE))
        asked = replace(asked, held=(*problem.held, held))
    grids = tuple(Grid(grid.space, grid.space.breaks) for grid in plan.grids)
    free = formulate(asked, grids, 0.0, EXACT, replace(region, abouts=region.abouts[:1]))
    steering = controls(free)
    if steering is None or any(not isfinite(control.cap) for control in steering):
        return False
    state.region = replace(region, tubes=tubes(free, steering, region.tubes, loose, state.deadline))
    return True


def _turn(state: Search, plan: Plan, solution: ConeSolution) -> set[int]:
    """Take the answer as the place where rows shall be tight; the laws on which they were not.

    A cam is made of it as well: its smallest size follows from the law alone, and no better cam
    is larger than the best so far.
    """
    problem = state.problem
    laws, size = plan.recover(solution.x)
    state.last = settle(problem, laws, size)
    curves = tuple(law.curve() for law in laws)
    if misses(state, state.last)[1] <= ALLOWED:
        state.offer(state.last)
    settled = problem.settled(
        [s.with_law(curve) for s, curve in zip(problem.free, curves, strict=True)]
    )
    region = state.region or Region()
    abouts = (About(curves, state.last.size), About(curves, size), *region.abouts)[:KEPT]
    state.region = replace(region, sizes=_sizes(state), abouts=abouts)
    value = _value(plan, solution)
    if _smallest(state) - value <= SHARE * state.tolerance * abs(value):
        return set()
    excesses = _excesses(state, settled, size)
    return {position for position, excess in enumerate(excesses) if excess > MET}


def _excesses(state: Search, settled: Problem, size: tuple[float, ...]) -> list[float]:
    """By how much curved limits are exceeded on every free law, at the points of its rows."""
    found = []
    by_index = {stretch.index: stretch for stretch in settled.stretches}
    for free, grid in zip(state.problem.free, state.grids, strict=True):
        stretch = by_index[free.index]
        s = stretch.placed().derivatives(stretch.start + stretch.angle * grid.points)
        curves = state.problem.curves_on(stretch)
        values = [value for curve in curves for value in curve.excess(s, size)]
        found.append(max((float(np.max(value)) for value in values), default=-inf))
    return found


def _sizes(state: Search) -> tuple[tuple[float, float], ...]:
    """Bounds of the size that every better cam keeps, where the size is what is made small."""
    bounds = state.problem.sizing.bounds
    norm = state.problem.objective.norm(state.problem.machine)
    if norm is None or len(bounds) > 1:
        return bounds
    ((factor,),), (shift,) = norm.matrix, norm.shift
    ((low, high),) = bounds
    high = min(high, (_smallest(state) * (1.0 + SPARE) - shift) / factor)
    if isfinite(state.lower):
        low = max(low, (state.lower * (1.0 - SPARE) - shift) / factor)
    return ((min(low, high), high),)
