"""Rows of curved limits, turned so that they touch the limit where the last answer was.

Each cone program with rows that hold for every motion and size of a region is a relaxation, and
bounds what is sought. Where the limit is convex, rows about the last answer make the next one
exact to the second order, as in Newton's method; those of the answers before are kept for a
while, without which it may swing to and fro.
"""

from __future__ import annotations

from math import isfinite

import numpy as np

from synthesis.formulations.candidate import settle
from synthesis.formulations.convex import Plan
from synthesis.formulations.cuts import About, Region
from synthesis.formulations.problem import Problem
from synthesis.formulations.search import Search
from synthesis.solvers.clarabel import ConeSolution

KEPT = 4  # answers whose rows are kept
MET = 1e-9  # excess of a curved limit that rows about the answer have no more to take off
SHARE = 0.02  # the same as a share of the tolerance, where the size alone is weighed
SPARE = 1e-9


def turn(state: Search, plan: Plan, solution: ConeSolution) -> bool:
    """Take the answer as the place where rows shall be tight; True where they were already.

    A cam is made of it as well: its smallest size follows from the law alone, and no better cam
    is larger than the best so far.
    """
    problem = state.problem
    laws, size = plan.recover(solution.x)
    state.last = settle(problem, laws, size)
    curves = tuple(law.curve() for law in laws)
    if _excess(state.last.problem, problem, state.last.size) <= MET:
        state.offer(state.last)
    weighed = problem.objective.norm(problem.machine) is not None
    met = SHARE * state.tolerance if weighed else MET
    settled = problem.settled(
        [s.with_law(curve) for s, curve in zip(problem.free, curves, strict=True)]
    )
    tangent = _excess(settled, problem, size) <= met
    abouts = () if state.region is None else state.region.abouts
    abouts = (About(curves, state.last.size), About(curves, size), *abouts)[:KEPT]
    state.region = Region(_sizes(state), abouts)
    return tangent


def _excess(settled: Problem, asked: Problem, size: tuple[float, ...]) -> float:
    """By how much curved limits are exceeded on the free laws, at sampled angles."""
    worst = -np.inf
    by_index = {stretch.index: stretch for stretch in settled.stretches}
    for free in asked.free:
        stretch = by_index[free.index]
        theta = stretch.start + stretch.angle * np.linspace(0.0, 1.0, 129)
        s = stretch.placed().derivatives(theta)
        for curve in asked.curves_on(stretch):
            for value in curve.excess(s, size):
                worst = max(worst, float(np.max(value)))
    return worst


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
