"""The smallest cam whose free laws keep a limit on the pressure angle, and a bound over all laws.

The limit bends one way (``leverage``): its tangents about the last laws give a cone program all of
whose points keep it, so that every turn's cam is as good as the last one or better. Knots go where
that program's multipliers say. The bound is that of the fastest run; where it leaves more than is
asked and knots have nothing left to gain, chords over what better laws leave give another.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from math import inf

from synthesis.formulations.bounds.bound import Bound, bound
from synthesis.formulations.cams.candidate import Candidate, settle
from synthesis.formulations.cams.closed_form import nearest
from synthesis.formulations.cone.convex import Plan, formulate
from synthesis.formulations.cone.cuts import About, Region
from synthesis.formulations.cone.rows import Drawn
from synthesis.formulations.ladder.gentlest import gentlest
from synthesis.formulations.nonconvex.local import gentle
from synthesis.formulations.question.ends import meet
from synthesis.formulations.question.grid import SettledLaw, uniform
from synthesis.formulations.question.problem import Problem
from synthesis.formulations.rounds.knots import finer
from synthesis.formulations.rounds.missed import ALLOWED, misses
from synthesis.formulations.rounds.search import Search, Stage
from synthesis.numerics.piecewise import Array
from synthesis.solvers.clarabel import ConeSolution, solve
from synthesis.solvers.statuses import USABLE
from synthesis.spatial.formulations.chords import bounded, report
from synthesis.spatial.formulations.fastest import Track, least_size
from synthesis.spatial.formulations.scene import made_safe

FIRST = 24  # intervals of the first knots
ROUNDS, FEW, TURNS = 7, 3, 12  # few where no bound says what finer knots are worth
SHARES = (0.5, 0.25, 0.1)  # of a step, where the whole of it leads to no smaller cam
STAYS = 0.05  # of the tolerance: gain of a turn that is none
IDLE = 0.1  # of the tolerance: gain of a round after which knots have little left to gain
EVERY = "all motion laws"


@dataclass(eq=False)
class _Squeeze:
    """A search as it goes on.

    Attributes:
        safe: the same question with rows that keep every law safe.
        last: the last cam read from a program.
    """

    state: Search
    safe: Problem
    last: Candidate | None = None

    @property
    def value(self) -> float:
        """The best cam's, infinite while there is none."""
        return inf if self.state.best is None else self.state.best.value


def squeezed(problem: Problem, tolerance: float, deadline: float, tighten: float) -> Search:
    """The smallest cam, to a relative gap or as near as rounds of knots come.

    Args:
        problem: with free laws. tolerance: relative gap asked for.
        deadline: ``clock.now()`` at which to stop.
        tighten: relative amount by which rows are drawn in for the solver's sake.
    """
    squeeze = _Squeeze(Search(problem, tolerance, deadline, tighten), made_safe(problem))
    state = squeeze.state
    state.grids = tuple(uniform(stretch, FIRST) for stretch in problem.free)
    _outrun(state)
    squeeze.last = gentle(state) if _bulges(problem) else None
    before, idle = inf, 0
    for number in range(1, (FEW if _bulges(problem) else ROUNDS) + 1):
        lower, missed = _turned(squeeze, number)
        if lower is None:
            if number > 1 or not _eased(state):
                break
            continue
        if state.close(state.best) or state.left() <= 0.0:
            break
        idle += before - squeeze.value <= IDLE * tolerance * squeeze.value
        before = squeeze.value
        if idle and state.best is not None:
            lower = bounded(state, state.best.size[0], number) or lower
            if state.close(state.best) or not lower.switching:
                break
        state.grids = finer(problem, state.grids, squeeze.last, lower, missed)
    return state


def _bulges(problem: Problem) -> bool:
    """Whether limits speak of accelerations too: the fastest laws are then no good start."""
    return any(curve.order > 1 for stretch in problem.free for curve in problem.curves_on(stretch))


def _outrun(state: Search) -> None:
    """Learn below what size the fastest run is late, or a given law breaks a limit."""
    began, problem = time.perf_counter(), state.problem
    ends, _ = meet(problem.stretches, state.grids)
    largest = problem.sizing.bounds[0][1]
    least = [
        least_size(Track.of(problem, stretch, (own.start, own.end)), problem.length, largest)
        for stretch, own in zip(problem.free, ends, strict=True)
    ]
    given = tuple(stretch for stretch in problem.stretches if stretch.law is not None)
    size = nearest(replace(problem, stretches=given)) if given else None
    state.raise_to(max([*least, *(size or ())]), EVERY)
    state.stages.append(
        Stage("fastest run", "phase plane", "none", len(least), 0, 0, time.perf_counter() - began,
              "solved")
    )  # fmt: skip


def _turned(squeeze: _Squeeze, number: int) -> tuple[Bound | None, list[Array]]:
    """Safe programs about one law after the other until they stay.

    Returns:
        the bound that the last one's multipliers give, of its own rows and so for knots alone;
        None where there was no cam. And where rows were missed between their points.
    """
    state, began, iterations = squeeze.state, time.perf_counter(), 0
    missed, lower, base = list[Array](), None, squeeze.last
    for _ in range(TURNS):
        plan, solution = _safe(squeeze)
        iterations += solution.iterations
        if solution.stopped not in USABLE:
            break
        lower = bound(plan, solution)
        found = _stepped(state, settle(state.problem, *plan.recover(solution.x)), base)
        missed, excess = misses(state, found)
        if excess > ALLOWED:
            state.margin = 1.1 * (state.margin + excess)
        elif found.value < squeeze.value:
            state.best = found
        before, base = inf if base is None else base.value, found
        squeeze.last = found
        stays = before - found.value <= STAYS * state.tolerance * found.value
        if (stays and excess <= ALLOWED) or state.left() <= 0.0:
            break
    report(state, f"tangents {number}", plan, solution, iterations, began)
    return lower, missed


def _stepped(state: Search, found: Candidate, base: Candidate | None) -> Candidate:
    """The cam, or one on the way to it from the last one where that is smaller."""
    if base is None:
        return found
    best, before = (
        found,
        [law.on(grid.space) for law, grid in zip(base.laws, state.grids, strict=True)],
    )
    enough = base.value * (1.0 + STAYS * state.tolerance)
    for share in SHARES:
        if best.value <= enough:
            break
        laws = [
            SettledLaw(law.space, share * law.coefficients + (1.0 - share) * old)
            for law, old in zip(found.laws, before, strict=True)
        ]
        tried = settle(state.problem, laws, found.size)
        best = min(best, tried, key=lambda each: each.value)
    return best


def _safe(squeeze: _Squeeze) -> tuple[Plan, ConeSolution]:
    """The program with tangents about the last laws; with chords where there are none yet."""
    state = squeeze.state
    drawn, region = Drawn(state.tighten, state.margin), Region.whole(state.problem)
    if squeeze.last is not None:
        about = About(tuple(law.curve() for law in squeeze.last.laws), squeeze.last.size)
        region = replace(region, abouts=(about,))
    plan = formulate(squeeze.safe, state.grids, 0.0, drawn, region)
    return plan, solve(plan.program, state.left())


def _eased(state: Search) -> bool:
    """Knots on which limits on the motion alone can be kept; False where there are none."""
    found = gentlest(state.problem, state.grids, state.tighten, state.deadline)
    if found is None:
        return False
    state.grids = found.grids
    state.impossible, state.undecided = found.impossible, found.undecided
    state.infeasible = bool(found.impossible)
    return found.fits
