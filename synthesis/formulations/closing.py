"""The gap that limits leave which are not convex: rows that they imply where a better cam lies.

The relaxation leaves such limits out, and its bound with them. But every cam better than the best
so far keeps the relaxation's rows and the best value; so its size lies in a box and its laws in a
tube, which the relaxation itself bounds, over all laws. Within these the limit implies rows (a
nearly known curve is nearly linear), and with them the bound is a bound all the same: a cam that
is no better than the best so far needs none. (mathematics: McCormick's under-estimators with
bound tightening.)
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from synthesis.formulations import cuts
from synthesis.formulations.bound import Bound, bound
from synthesis.formulations.candidate import Candidate, settle
from synthesis.formulations.control import controls
from synthesis.formulations.convex import Plan, formulate, with_rows
from synthesis.formulations.cuts import About
from synthesis.formulations.grid import Grid, uniform
from synthesis.formulations.knots import finer
from synthesis.formulations.local import improve_from
from synthesis.formulations.problem import Held, Nothing, Problem
from synthesis.formulations.rows import Block, Drawn
from synthesis.formulations.search import Search, Stage
from synthesis.formulations.tube import size_ends, tube
from synthesis.formulations.tubing import Tube
from synthesis.motion import Stretch
from synthesis.solvers.clarabel import solve
from synthesis.solvers.statuses import Stopped

COARSE = 20  # intervals of the laws that say how wide the tube is
NODES = 7  # of a tube
NEAR = -0.15  # a smooth limit above this, relative, is near to binding
SAMPLES = 200
ROUNDS = 5
FEWEST = 40  # points of the rows along a tube
SPARE = 1e-9
USABLE = (Stopped.SOLVED, Stopped.INACCURATE)
Sizes = tuple[tuple[float, float], ...]


def close(state: Search) -> None:
    """Narrow the gap of a search that limits which are not convex have left open.

    Raises the bound, and where that is not enough looks for a better cam on the knots which the
    bound asks for.
    """
    best = state.best
    if best is None or state.close(best) or state.left() <= 0.0:
        return
    if state.problem.objective.fractional or not state.problem.free:
        return
    near = {k: part for k, s in enumerate(state.problem.free) if (part := _near(best, s))}
    if not near:
        return
    started = time.perf_counter()
    region = _region(state, best, near)
    if region is None:
        return
    solved, grids = _climb(state, best, *region)
    seconds = time.perf_counter() - started
    state.stages.append(
        Stage("implied rows", "cone programs, rows implied inside a tube", "Clarabel",
              solved.program.matrix.shape[1], solved.program.matrix.shape[0], 0, seconds, "solved",
              "what a better cam keeps to, and the rows that its curvature implies there")
    )  # fmt: skip
    if not state.close(best) and state.left() > 0.0:
        state.grids = grids
        improve_from(state, best)


def _near(best: Candidate, free: Stretch) -> tuple[float, float] | None:
    """The part of a free law on which a limit with implied rows is near to binding."""
    problem = best.problem
    (stretch,) = (s for s in problem.stretches if s.index == free.index)
    x = np.linspace(0.0, 1.0, SAMPLES + 1)
    s = stretch.placed().derivatives(stretch.start + stretch.angle * x)
    worst = np.full(len(x), -np.inf)
    for limit in problem.limits:
        if limit.implied(stretch, problem.machine):
            for value in limit.smooth(stretch, problem.machine, s, best.size):
                worst = np.maximum(worst, value)
    binding = x[worst > NEAR]
    if not len(binding) or np.max(worst) < 0.1 * NEAR:
        return None
    step = 2.0 / SAMPLES
    return max(float(binding[0]) - step, 0.0), min(float(binding[-1]) + step, 1.0)


def _region(
    state: Search, best: Candidate, near: Mapping[int, tuple[float, float]]
) -> tuple[Sizes, dict[int, Tube]] | None:
    """The sizes and the tubes of all cams that are better; None where they are not bounded."""
    problem = state.problem
    held = Held(problem.objective, best.value * (1.0 + SPARE))
    asked = replace(problem, objective=Nothing(), held=(*problem.held, held))
    coarse = (uniform(stretch, COARSE) for stretch in problem.free)
    plan = formulate(asked, tuple(Grid(g.space, g.space.breaks) for g in coarse))
    steering = controls(plan)
    if steering is None or not all(np.isfinite(control.cap) for control in steering):
        return None
    sizes = tuple(size_ends(plan, axis) for axis in range(len(problem.sizing.bounds)))
    tubes = {}
    for position, (low, high) in near.items():
        if state.left() <= 0.0:
            return None
        nodes = np.linspace(low, high, NODES)
        tubes[position] = tube(plan, position, steering[position], nodes)
    return sizes, tubes


def _climb(
    state: Search, best: Candidate, sizes: Sizes, tubes: Mapping[int, Tube]
) -> tuple[Plan, tuple[Grid, ...]]:
    """Cone programs with the implied rows, on finer and finer knots."""
    problem, grids = state.problem, state.grids
    about: About | None = None
    for _ in range(ROUNDS):
        plan = formulate(problem, grids)
        plan = with_rows(plan, list(_rows(problem, plan, sizes, tubes, about)))
        solution = solve(plan.program, state.left())
        if solution.stopped not in USABLE:
            break
        lower: Bound = bound(plan, solution)
        if not lower.switching:
            break
        state.learn(lower)
        laws, size = plan.recover(solution.x)
        about = About(tuple(law.curve() for law in laws), size)
        found = settle(problem, laws, size, keep_hint=True)
        before, grids = grids, finer(problem, grids, found, lower, [np.zeros(0)] * len(grids))
        if state.close(best) or state.left() <= 0.0:
            return plan, before
    return plan, grids


def _rows(
    problem: Problem, plan: Plan, sizes: Sizes, tubes: Mapping[int, Tube], about: About | None
) -> Iterator[Block]:
    """Rows that limits imply along the tubes: at the middle of what is known, and at the answer."""
    for position, known in tubes.items():
        stretch, grid = problem.free[position], plan.grids[position]
        low, high = known.nodes[0], known.nodes[-1]
        points = grid.points[(grid.points >= low) & (grid.points <= high)]
        x = np.union1d(points, np.linspace(low, high, FEWEST))
        within = cuts.inside(known, stretch, x, sizes)
        places = [None] if about is None else [None, about.at(position, stretch, x)]
        for limit in problem.limits:
            for implied in limit.implied(stretch, problem.machine):
                for place in places:
                    for found in implied.cuts(within, place):
                        yield cuts.block(
                            found, implied.source, position, stretch, Grid(grid.space, x),
                            plan.scales, Drawn(),
                        )  # fmt: skip
