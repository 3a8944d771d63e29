"""Rows of curved limits, turned so that they touch the limit where the last answer was.

Each cone program with rows that hold for every motion and size of a region is a relaxation, and
bounds what is sought. Where the limit is convex, rows about the last answer make the next one
exact to the second order, as in Newton's method; those of the answers before are kept for a
while, without which it may swing to and fro.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import inf, isfinite

import numpy as np

from synthesis.formulations.bound import Bound
from synthesis.formulations.candidate import settle
from synthesis.formulations.convex import EXACT, Plan, formulate
from synthesis.formulations.cuts import About, Region
from synthesis.formulations.grid import Grid
from synthesis.formulations.problem import Nothing, Problem
from synthesis.formulations.search import Search
from synthesis.formulations.tube import tubes
from synthesis.solvers.clarabel import ConeSolution

TURNS, NARROWINGS = 24, 3
STALLED = 0.05  # of the tolerance: gain of a turn that is none
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
    value, narrowed = -inf, 0
    for _ in range(TURNS):
        plan, solution, lower = solved(state, trial)
        if lower is None:
            break
        state.learn(lower)
        loose = _turn(state, plan, solution)
        state.tangent = not loose
        if state.tangent or state.close(state.relaxed) or state.left() <= 0.0:
            break
        if not any(curve.turns for s in state.problem.free for curve in state.problem.curves_on(s)):
            break
        before, value = value, _value(plan, solution)
        if value - before > STALLED * state.tolerance * abs(value):
            continue
        # rows have turned as far as they do: what is left is due to the region's width
        if narrowed == NARROWINGS or not _worth_it(state, value * plan.scales.size):
            break
        if not _narrowed(state, plan, lower, loose):
            break
        narrowed += 1
    return plan, solution, lower


def _value(plan: Plan, solution: ConeSolution) -> float:
    """The program's objective, in its own unit."""
    if plan.extra is not None:
        return float(solution.x[plan.extra])
    return float(np.sum(solution.x[plan.squares] ** 2))


def _worth_it(state: Search, value: float) -> bool:
    """Whether rows leave more to gain than knots do, the size being what is weighed."""
    norm = state.problem.objective.norm(state.problem.machine)
    if norm is None or state.relaxed is None or not isfinite(state.lower):
        return norm is not None
    return state.relaxed.value - value > WIDE * (state.relaxed.value - state.lower)


def _narrowed(state: Search, plan: Plan, lower: Bound, loose: set[int]) -> bool:
    """Narrow the region to what a better cam can be; False where nothing says how."""
    region, problem = state.region, state.problem
    if region is None or not lower.switching or problem.objective.norm(problem.machine) is None:
        return False
    inside = replace(problem.sizing, bounds=region.sizes, least=0.0)
    asked = replace(problem, objective=Nothing(), sizing=inside)
    grids = tuple(Grid(grid.space, grid.space.breaks) for grid in plan.grids)
    fewer = replace(region, abouts=region.abouts[:1])
    free = formulate(asked, grids, 0.0, EXACT, fewer)
    state.region = replace(region, tubes=tubes(free, lower.steering, region.tubes, loose))
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
    if max(_excesses(problem, state.last.problem, state.last.size), default=-inf) <= MET:
        state.offer(state.last)
    settled = problem.settled(
        [s.with_law(curve) for s, curve in zip(problem.free, curves, strict=True)]
    )
    region = state.region or Region()
    abouts = (About(curves, state.last.size), About(curves, size), *region.abouts)[:KEPT]
    state.region = replace(region, sizes=_sizes(state), abouts=abouts)
    norm = problem.objective.norm(problem.machine)
    if norm is not None and state.relaxed is not None:
        missing = state.relaxed.value - norm.value(size)
        if missing <= SHARE * state.tolerance * state.relaxed.value:
            return set()
    excesses = _excesses(problem, settled, size)
    return {position for position, excess in enumerate(excesses) if excess > MET}


def _excesses(asked: Problem, settled: Problem, size: tuple[float, ...]) -> list[float]:
    """By how much curved limits are exceeded on every free law, at sampled angles."""
    found = []
    by_index = {stretch.index: stretch for stretch in settled.stretches}
    for free in asked.free:
        stretch = by_index[free.index]
        theta = stretch.start + stretch.angle * np.linspace(0.0, 1.0, 129)
        s = stretch.placed().derivatives(theta)
        values = [v for curve in asked.curves_on(stretch) for v in curve.excess(s, size)]
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
    if state.relaxed is not None:
        high = min(high, (state.relaxed.value * (1.0 + SPARE) - shift) / factor)
    if isfinite(state.lower):
        low = max(low, (state.lower * (1.0 - SPARE) - shift) / factor)
    return ((min(low, high), high),)
