"""The ladder: closed form, cone program on finer and finer knots, IPOPT; no rung without need."""

from __future__ import annotations

import time
from collections.abc import Sequence
from math import inf, sqrt

import numpy as np

from synthesis.formulations.bounds.bound import Bound, bound, in_core_units
from synthesis.formulations.cams.candidate import (
    Candidate,
    at_size,
    grow,
    needs_size,
    settle,
    smallest,
)
from synthesis.formulations.cams.closed_form import nearest
from synthesis.formulations.cone.convex import Plan, formulate
from synthesis.formulations.cone.rows import Drawn
from synthesis.formulations.curved.closing import close
from synthesis.formulations.curved.everywhere import enclose
from synthesis.formulations.curved.tangency import turned
from synthesis.formulations.ladder.gentlest import gentlest
from synthesis.formulations.ladder.leaving import left_out
from synthesis.formulations.ladder.pinned import pinned
from synthesis.formulations.ladder.polish import polish
from synthesis.formulations.ladder.steepness import steepness
from synthesis.formulations.nonconvex.local import nonlinear
from synthesis.formulations.question.grid import Grid, uniform
from synthesis.formulations.question.problem import Problem
from synthesis.formulations.rounds.knots import all_halved, denser, finer
from synthesis.formulations.rounds.missed import ALLOWED, misses
from synthesis.formulations.rounds.neighbour import Neighbour
from synthesis.formulations.rounds.search import Search, Stage
from synthesis.numerics.digits import rounded
from synthesis.numerics.piecewise import Array
from synthesis.solvers.clarabel import ConeSolution, solve
from synthesis.solvers.statuses import USABLE, Stopped

SHAPE = 0.05  # a gap below which rounds for the bound alone do not pay, where curvature decides
KNOTS = 2.0  # tolerances: a gap at which knots are good enough for what curvature leaves
ROUNDS = 8
COARSE, FINE = 12, 96  # intervals of the first grid, by tolerance
CURVED = 16  # the most of them while rows still have to turn
RIGID = 150  # the most of them, of all laws together, where limits of a face are left out
MORE = 1.1  # times the intervals: what adds less says nothing about finer knots
LEVELS = 20
MARGIN_BITS = 16  # what a cam misses between points is known no better
STAYS = 1e-7  # of the level: an estimate's slope is taken over steps a thousand times longer


def search(
    problem: Problem,
    tolerance: float,
    deadline: float = inf,
    tighten: float = 1e-7,
    *,
    thorough: bool = False,
    near: Neighbour | None = None,
) -> Search:
    """Solve one problem to a relative gap, or as near as the ladder comes.

    Args:
        problem: the question.
        tolerance: relative gap asked for.
        deadline: ``time.monotonic()`` at which to stop with the best so far.
        tighten: relative amount by which limits are drawn in for the solver's sake.
        thorough: where limits that are not convex leave a gap, spend more on the bound.
        near: where a neighbouring question's local search ended, to begin one there.

    Returns:
        the search as it ended; without a best cam where no rung gave a usable point.
    """
    state = Search(problem, tolerance, deadline, tighten, near=near)
    _searched(state, thorough=thorough)
    state.round_off().over += left_out(state)
    return state


def _searched(state: Search, *, thorough: bool) -> None:
    """The ladder itself."""
    problem, tolerance = state.problem, state.tolerance
    if problem.cramped:
        state.infeasible, state.impossible = True, problem.cramped
        return
    if problem.objective.limits(1.0, problem.machine):
        steepness(state, search)
        return
    if _closed_form(state):
        pass
    elif problem.curved and problem.machine.follower.pinning() is not None:
        pinned(state, search)
        enclose(state, thorough=thorough)
        return
    else:
        most = CURVED if problem.curved else FINE
        first = int(min(max(3.7 / sqrt(tolerance), COARSE), most))
        state.grids = tuple(uniform(stretch, first) for stretch in problem.free)
        _climb(state)
        polish(state, _once)
        _unrung(state)
    if _elsewhere(state):
        pinned(state, search)
        return
    if (state.limited_by_shape or state.short) and state.left() > 0.0:
        nonlinear(state)
        if problem.rigid and problem.machine.follower.pinning() is None:
            enclose(state, thorough=thorough)
        else:
            close(state, thorough=thorough)


def _unrung(state: Search) -> None:
    """A bound without what rings, where its own is not near: a mode too fast for the knots.

    Splines that cannot swing with it pay for rest far more than other laws would.
    """
    problem = state.problem
    unfit = problem.curved or problem.objective.fractional or not state.grids
    if not problem.ringing or unfit or state.close(state.best) or state.left() <= 0.0:
        return
    plan = formulate(problem.unrung, state.grids, 0.0, Drawn(state.tighten, state.margin))
    solution = solve(plan.program, state.left())
    if solution.stopped in USABLE:
        state.learn(bound(plan, solution))


def _elsewhere(state: Search) -> bool:
    """Whether a dimension that can be pinned has a least value, which no cone program knows.

    A cam that happens to have it and is as good as the bound needs no further search.
    """
    if state.problem.machine.follower.pinning() is None or state.close(state.best):
        return False
    return any(cone.least > 0.0 for cone in state.problem.sizing.cones)


def estimate(
    problem: Problem, grids: Sequence[Grid], guess: float = 1.0, deadline: float = inf
) -> float | None:
    """What a problem's optimum on given grids is [core units]; None where nothing fits.

    A smooth function of the problem's numbers, but for kinks. Limits that are not convex count
    where a larger cam would mend them. ``guess``: first trial level of a fractional objective.
    """
    state = Search(problem, 1e-2, deadline, 1e-7)
    if problem.loud:
        return None
    if _closed_form(state):
        return None if state.best is None else state.best.value
    for _ in range(LEVELS):
        plan = formulate(problem, grids, guess, Drawn(state.tighten))
        solution = solve(plan.program, state.left())
        if solution.stopped not in USABLE:
            return None
        fractional = problem.objective.fractional
        if problem.objective.norm(problem.machine) is None and not fractional:
            return in_core_units(plan, plan.program.value(solution.x))
        found = _read(plan, solution)
        if not fractional or abs(found.value - guess) <= STAYS * found.value:
            break
        guess = found.value
    grown = grow(found)
    return None if grown is None else grown.value


def _closed_form(state: Search) -> bool:
    """First rung: given laws and rows only; True where it spoke."""
    started = time.perf_counter()
    problem = state.problem
    if problem.free or needs_size(problem):
        return False
    size = smallest(problem)
    if size is None:
        state.infeasible = problem.curved and nearest(problem) is None
        return state.infeasible
    found = at_size(problem, (), size)
    norm = problem.objective.norm(problem.machine)
    if problem.curved:
        size = nearest(problem) or size  # that one was drawn in
    exact = found.value if norm is None else norm.value(size)
    state.learn(Bound(exact * (1.0 - 1e-12), "every size of the given laws"))
    state.offer(found)
    seconds = time.perf_counter() - started
    sizes = len(problem.sizing.bounds)
    state.stages.append(Stage("closed form", "half-planes", "none", sizes, 0, 0, seconds, "solved"))
    return True


def _climb(state: Search) -> None:
    """Second rung: cone programs on finer and finer knots until the bound is near."""
    solve_once = _fraction if state.problem.objective.fractional else _round
    usable: tuple[Grid, ...] = ()  # on which there was a law: not on other knots that are no finer
    knots = 0
    for number in range(1, ROUNDS + 1):
        started = time.perf_counter()
        before, bound_before = state.gap, state.lower
        plan, solution, lower = solve_once(state)
        found, missed = _weigh(state, plan, solution, lower)
        _report(state, number, plan, solution, time.perf_counter() - started)
        if solution.stopped is Stopped.INFEASIBLE and usable:
            state.grids, usable, state.margin = usable, (), 0.0
            state.grids = all_halved(state.problem, state.grids, missed)
            continue
        if solution.stopped is Stopped.INFEASIBLE and (number > 1 or not state.grids):
            state.infeasible = state.relaxed is None
            return
        if solution.stopped is Stopped.INFEASIBLE and not state.problem.curved:
            eased = gentlest(state.problem, state.grids, state.tighten, state.deadline)
            if eased is not None:
                state.grids = eased.grids
                state.impossible, state.undecided = eased.impossible, eased.undecided
                if eased.fits:
                    continue
                state.infeasible = True
                return
        if state.problem.rigid and state.best is None and number == 1:
            nonlinear(state)  # a cam at once: these rounds are of the bound alone
        stuck = lower is None and number > 1
        if stuck or _climbed(state, plan, solution, lower):
            state.grids = _for_shape(state, found, lower, missed)
            break
        idle = 0.9 * before < state.gap < inf
        slight = _count(state.grids) < MORE * knots and not state.limited_by_shape
        knots = _count(state.grids)
        if _open(state) and state.lower - bound_before <= state.tolerance * abs(state.lower):
            break  # no knots make such rows cams
        if (idle and not slight) or (number > 1 and _fine_enough(state)):
            break  # finer knots no longer help, or what comes next is served by these
        usable = state.grids if lower is not None else ()
        state.grids = _next(state, found, lower, missed, every=idle)
        if state.limited_by_shape and state.gap < SHAPE:
            break  # what comes next finds its cam on these knots, and far above this bound


def _next(
    state: Search,
    found: Candidate | None,
    lower: Bound | None,
    missed: list[Array],
    *,
    every: bool,
) -> tuple[Grid, ...]:
    """The grids of the next round; ``every``: all intervals halved, as single knots were idle."""
    if every:
        return all_halved(state.problem, state.grids, missed)
    if state.relaxed is not None and lower is not None and not lower.switching:
        return denser(state.grids)
    return finer(state.problem, state.grids, found, lower, missed)


def _open(state: Search) -> bool:
    """Whether rows of curved limits allow what no cam keeps, and there is none to narrow them by.

    They are exceeded at their own points then, so that more of these are of no use.
    """
    return state.problem.curved and not state.tangent and state.best is state.relaxed is None


def _count(grids: Sequence[Grid]) -> int:
    """Intervals of all laws."""
    return sum(len(grid.space.breaks) - 1 for grid in grids)


def _fine_enough(state: Search) -> bool:
    """Whether knots are good enough for the local search that curvature asks for."""
    return state.limited_by_shape and state.gap <= KNOTS * state.tolerance


def _for_shape(
    state: Search, found: Candidate | None, lower: Bound | None, missed: Sequence[Array]
) -> tuple[Grid, ...]:
    """The knots for a local search: finer ones where a least size, not they, has closed the gap."""
    if state.relaxed is None or lower is None or not lower.switching:
        return state.grids
    if not state.limited_by_shape or state.close_to(state.relaxed, lower.value):
        return state.grids
    return finer(state.problem, state.grids, found, lower, missed)


def _climbed(state: Search, plan: Plan, solution: ConeSolution, lower: Bound | None) -> bool:
    """Whether finer knots are not needed, or there is no time for them.

    Where limits of the face are left out, no cam of these rounds says so: the rows' own value does.
    There too many knots make the local search slow.
    """
    if state.close(state.relaxed) or state.left() <= 0.0 or not state.grids:
        return True
    if not state.problem.rigid or lower is None:
        return False
    value = in_core_units(plan, plan.program.value(solution.x))
    known = value - lower.value <= 0.5 * state.tolerance * abs(value)
    return known or _count(state.grids) > RIGID


def _once(state: Search, number: int) -> Candidate | None:
    """One cone program on the present grids, weighed and reported; its cam, if it has one."""
    started = time.perf_counter()
    plan, solution, lower = _round(state)
    found, _ = _weigh(state, plan, solution, lower)
    _report(state, number, plan, solution, time.perf_counter() - started)
    return found


def _weigh(
    state: Search, plan: Plan, solution: ConeSolution, lower: Bound | None
) -> tuple[Candidate | None, list[Array]]:
    """Offer the cam and the bound of one round; where its rows were missed between points."""
    if lower is None:
        return None, [np.zeros(0)] * len(state.grids)
    # where rows are turned to the answer, it has been read already
    found = state.last if state.problem.curved and state.last else _read(plan, solution)
    missed, excess = misses(state, found)
    if excess <= ALLOWED:
        state.offer(found)
    elif _open(state):
        missed = [np.zeros(0)] * len(missed)
    elif state.tangent:
        state.margin = float(rounded(1.1 * (state.margin + excess), MARGIN_BITS))
    state.learn(lower)
    state.program = plan, solution, lower
    return found, missed


def _round(state: Search, trial: float = 0.0) -> tuple[Plan, ConeSolution, Bound | None]:
    """One cone program on the present grids, with its bound; curved limits are met in it."""
    return turned(state, trial, _solved) if state.problem.curved else _solved(state, trial)


def _solved(state: Search, trial: float) -> tuple[Plan, ConeSolution, Bound | None]:
    drawn = Drawn(state.tighten, state.margin)
    plan = formulate(state.problem, state.grids, trial, drawn, state.region)
    solution = solve(plan.program, state.left())
    return plan, solution, bound(plan, solution) if solution.stopped in USABLE else None


def _fraction(state: Search) -> tuple[Plan, ConeSolution, Bound | None]:
    """A fractional objective on the present grids: lower the trial level until it stays."""
    trial = 1.0 if state.relaxed is None else state.relaxed.value
    for _ in range(12):
        plan, solution, lower = _round(state, trial)
        if solution.stopped not in USABLE:
            return plan, solution, None
        reached = _read(plan, solution).value
        stays = abs(reached - trial) <= 1e-2 * state.tolerance * trial
        trial = reached
        if stays:
            break
    below = trial * (1.0 - 0.5 * state.tolerance)
    _, _, excess = _round(state, below)
    if excess is None:
        return plan, solution, lower
    proven = below if excess.value > 0.0 else 0.0
    return plan, solution, Bound(proven, excess.over, excess.switching, excess.steering)


def _read(plan: Plan, solution: ConeSolution) -> Candidate:
    laws, size = plan.recover(solution.x)
    return settle(plan.problem, laws, size)


def _report(state: Search, number: int, plan: Plan, solution: ConeSolution, seconds: float) -> None:
    rows, unknowns = plan.program.matrix.shape
    knots = _count(plan.grids)
    conic = any(len(ball.shift) > 1 for ball in plan.balls)  # of one row: two half-spaces
    model = "QP" if plan.energy is not None else "SOCP" if conic else "LP"
    state.stages.append(
        Stage(
            f"convex {number}", f"{model}, {knots} spline intervals", "Clarabel", unknowns, rows,
            solution.iterations, seconds, solution.stopped.value,
        )
    )  # fmt: skip
