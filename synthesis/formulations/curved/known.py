"""Rows that a limit implies where a better cam lies: a box of sizes, and tubes of its laws.

The relaxation leaves limits out that are not convex, and its bound with them. But every cam better
than the best so far keeps the relaxation's rows and the best value; so its size lies in a box and
its laws in a tube, which the relaxation itself bounds, over all laws. Within these the limit
implies rows (a nearly known curve is nearly linear), and with them the bound is a bound all the
same: a cam that is no better than the best so far needs none. (McCormick's under-estimators with
bound tightening.)
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from synthesis.formulations.bounds.bound import Bound, bound, in_core_units
from synthesis.formulations.cams.candidate import Candidate, settle
from synthesis.formulations.cone import cuts
from synthesis.formulations.cone.control import controls
from synthesis.formulations.cone.convex import Plan, formulate, with_rows
from synthesis.formulations.cone.cuts import About
from synthesis.formulations.cone.rows import Block, Drawn
from synthesis.formulations.cone.tubing import Tube
from synthesis.formulations.curved.farther import farther
from synthesis.formulations.curved.tube import size_ends, tube_of
from synthesis.formulations.question.grid import Grid, uniform
from synthesis.formulations.question.problem import Held, Nothing, Problem
from synthesis.formulations.rounds.knots import finer
from synthesis.formulations.rounds.search import Search
from synthesis.motion import Stretch
from synthesis.solvers.clarabel import solve
from synthesis.solvers.statuses import USABLE, Stopped

COARSE = 20  # intervals of the laws that say how wide the tube is
NODES = 7  # of a tube
NEAR = -0.15  # a smooth limit above this, relative, is near to binding
SAMPLES = 200
ROUNDS = 5
FEWEST = 40  # points of the rows along a tube
SPARE = 1e-9
REACHED = 1e-5  # beyond what laws on coarse knots reach, so that there is a choice left
TURNS = 4  # tubes narrowed with the rows that the wider ones gave
WORTH = 0.15  # of the gap: what a turn must gain for another one
KNOTS = 0.3  # of the gap: what knots must have to gain for finer ones


@dataclass(frozen=True, eq=False)
class Known:
    """What every better cam of a box of sizes keeps to.

    Attributes:
        problem: the question, its sizes in the box. lower: what none of these cams is below.
        sizes, tubes: where they lie. about: the last answer, where rows are tight.
        grids: the present knots.
    """

    problem: Problem
    lower: float
    over: str
    grids: tuple[Grid, ...]
    sizes: tuple[tuple[float, float], ...] = ()
    tubes: Mapping[int, Tube] = field(default_factory=dict)
    about: About | None = None


def near_to_binding(best: Candidate, free: Stretch) -> tuple[float, float] | None:
    """The part of a free law on which a limit with implied rows is near to binding."""
    problem = best.problem
    (stretch,) = (s for s in problem.stretches if s.index == free.index)
    x = np.linspace(0.0, 1.0, SAMPLES + 1)
    theta = stretch.start + stretch.angle * x
    s = stretch.placed().derivatives(theta)
    worst = np.full(len(x), -np.inf)
    for limit in problem.limits:
        if limit.implied(stretch, problem.machine):
            for value in limit.smooth(stretch, problem.machine, theta, s, best.size):
                worst = np.maximum(worst, value)
    binding = x[worst > NEAR]
    if not len(binding) or np.max(worst) < 0.1 * NEAR:
        return None
    step = 2.0 / SAMPLES
    return max(float(binding[0]) - step, 0.0), min(float(binding[-1]) + step, 1.0)


def explored(
    state: Search, best: Candidate, near: Mapping[int, tuple[float, float]], known: Known
) -> Known:
    """Tubes and rows in turn, each from what the other has shown, while it is worth it."""
    for _ in range(TURNS):
        before = known.lower
        lair = narrowed(state, best, near, known)
        if lair is None:
            break
        known = climbed(state, best, lair)
        gained = known.lower - before
        if state.close_to(best, known.lower) or gained < WORTH * (best.value - before):
            break
    return known


def narrowed(
    state: Search, best: Candidate, near: Mapping[int, tuple[float, float]], known: Known
) -> Known | None:
    """The sizes and the tubes of all cams that are better; None where they are not bounded."""
    problem = known.problem
    coarse = (uniform(stretch, COARSE) for stretch in problem.free)
    grids = tuple(Grid(g.space, g.space.breaks) for g in coarse)
    held = Held(problem.objective, _reached(state, best, grids, known) * (1.0 + SPARE))
    asked = replace(problem, objective=Nothing(), held=(*problem.held, held))
    plan = formulate(asked, grids)
    steering = controls(plan)
    if steering is None or not all(np.isfinite(control.cap) for control in steering):
        return None
    if known.sizes:
        plan = with_rows(plan, list(_rows(plan, known)))
    ranges = known.sizes or problem.sizing.bounds
    sizes = tuple(size_ends(plan, axis, ends) for axis, ends in enumerate(ranges))
    tubes = {}
    for position, (low, high) in near.items():
        if state.left() <= 0.0:
            return None
        nodes = np.linspace(low, high, NODES)
        former = known.tubes.get(position)
        tubes[position] = tube_of(plan, position, steering[position], nodes, former, state.deadline)
    return replace(known, sizes=sizes, tubes=tubes)


def _reached(state: Search, best: Candidate, grids: tuple[Grid, ...], known: Known) -> float:
    """The best value, or what laws on coarse knots can reach: rows that nothing keeps say nothing.

    What is bounded then are the laws of a few cams that are worse, too.
    """
    if not known.sizes or known.problem.objective.norm(known.problem.machine) is None:
        return best.value
    relaxed = formulate(known.problem, grids)
    plan = with_rows(relaxed, list(_rows(relaxed, known)))
    solution = solve(plan.program, state.left())
    if solution.stopped not in USABLE:
        return best.value
    family = in_core_units(plan, plan.program.value(solution.x))
    return max(best.value, family * (1.0 + REACHED))


def climbed(state: Search, best: Candidate, known: Known) -> Known:
    """Cone programs with the implied rows, on finer and finer knots."""
    problem = known.problem
    for _ in range(ROUNDS):
        relaxed = formulate(problem, known.grids)
        plan = with_rows(relaxed, list(_rows(relaxed, known)))
        solution = solve(plan.program, state.left())
        if solution.stopped is Stopped.INFEASIBLE and empty(known, state.left()):
            return replace(known, lower=best.value)
        if solution.stopped not in USABLE:
            break
        lower = bound(plan, solution)
        if not lower.switching:
            break
        laws, size = plan.recover(solution.x)
        about = About(tuple(law.curve() for law in laws), size)
        known = replace(known, about=about)
        # above the best there is nothing left to bound: no cam of this box is better
        value = min(lower.value, best.value)
        if value > known.lower:
            known = replace(known, lower=value, over=lower.over)
        found = settle(problem, laws, size, keep_hint=True)
        # what knots can still gain is what lies between this family's best and the bound
        mine = found.value - lower.value
        if state.close_to(best, lower.value) or state.left() <= 0.0:
            break
        if mine < KNOTS * (best.value - lower.value):
            break
        nothing = [np.zeros(0)] * len(known.grids)
        known = replace(known, grids=finer(problem, known.grids, found, lower, nothing))
    return known


def empty(known: Known, time_limit: float) -> Bound | None:
    """What proves that no law at all keeps the implied rows; None where nothing does.

    It is a positive lower bound of how far one of them is exceeded at least. ``time_limit``: [s].
    """
    asked = formulate(replace(known.problem, objective=Nothing()), known.grids)
    plan = with_rows(asked, [replace(row, level=-1.0) for row in _rows(asked, known)])
    solution = solve(plan.program, time_limit)
    if solution.stopped not in USABLE:
        return None
    least = bound(plan, solution)
    return least if least.switching and least.value > SPARE else None


def _rows(plan: Plan, known: Known) -> Iterator[Block]:
    """Rows that limits imply in the box and along the tubes: at its middle, and at the answer."""
    yield from farther(known.problem, known.sizes, plan.scales)
    for position, tube in known.tubes.items():
        stretch, grid = known.problem.free[position], plan.grids[position]
        low, high = tube.nodes[0], tube.nodes[-1]
        points = grid.points[(grid.points >= low) & (grid.points <= high)]
        x = np.union1d(points, np.linspace(low, high, FEWEST))
        within = cuts.inside(tube, stretch, x, known.sizes)
        places = [None] if known.about is None else [None, known.about.at(position, stretch, x)]
        for limit in known.problem.limits:
            for implied in limit.implied(stretch, known.problem.machine):
                for place in places:
                    for found in implied.cuts(within, place):
                        yield cuts.block(
                            found, implied.source, position, stretch, Grid(grid.space, x),
                            plan.scales, Drawn(),
                        )  # fmt: skip
