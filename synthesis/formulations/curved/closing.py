"""The gap that curvature leaves: no better cam lies anywhere, shown box by box.

The relaxation leaves limits out that are not convex, and its bound with them. But a cam that is
better by more than the tolerance keeps the relaxation's rows and its own value; so its size lies in
a box and what draws its curves in hulls, which duality bounds over all laws. Within these the limit
implies rows (a nearly known curve is nearly linear); they narrow box and hulls, and so on in turn,
until nothing is left or nothing moves. Then the box is split. (McCormick's under-estimators with
bound tightening, in a search that takes the worst box first.)
"""

from __future__ import annotations

import time
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from synthesis.formulations.bounds.bound import Bound, bound
from synthesis.formulations.bounds.multipliers import ends_priced, heard
from synthesis.formulations.bounds.spreading import Spreading
from synthesis.formulations.cams.candidate import Candidate, settle
from synthesis.formulations.cone.control import Control, controls
from synthesis.formulations.cone.convex import Plan, formulate, with_rows
from synthesis.formulations.curved.lair import Guess, Lair, Parts, unknown
from synthesis.formulations.curved.narrowing import narrowed
from synthesis.formulations.nonconvex.local import improve_from
from synthesis.formulations.question.grid import Grid, merged, over, snapped, uniform
from synthesis.formulations.question.problem import Held, Nothing, Problem
from synthesis.formulations.rounds.knots import all_halved, finer
from synthesis.formulations.rounds.missed import misses
from synthesis.formulations.rounds.search import Search, Stage
from synthesis.motion import Stretch
from synthesis.numerics.piecewise import Array
from synthesis.solvers.clarabel import ConeSolution, solve
from synthesis.solvers.statuses import USABLE, Stopped
from synthesis.terms import Vector

INTERVALS = 20  # of the first laws of every climb
FEW = 2  # times at most that these are refined for the laws that say where better cams lie
ENOUGH = 0.25  # of what rows must still gain: a loss to coarse knots that does not matter yet
NEAR = -0.15  # a smooth limit above this, relative, is near to binding
SAMPLES = 200
CLOSE_BY = 0.08  # of a law: parts that are no farther apart are one
AIM = 0.985  # of the tolerance: the gap that is to be proven
SPARE = 1e-9
FIRST_TURNS = 3  # before a better cam is looked for
TURNS = 8  # of hulls and rows in a box
WORTH = 0.85  # of the hulls' width: what a turn must leave at most for another one
ROUNDS = 5  # of finer knots
GAIN = 0.1  # of what is missing: less is not worth another climb
MOST_BOXES = 21
SPREAD = 14  # points between two rows over which multipliers are spread
RAYS = (1e2, 1e4, 1e6)
# of laws whose second derivative may jump, one more angle says nothing of the angles beside it
LEFT_OUT = "; limits on curvature left out: a jerk limit on every free law would bring them in"


@dataclass(frozen=True, eq=False)
class Quest:
    """What is to be proven: no cam is better than ``target`` [core units].

    Attributes:
        problem: the question, its laws free to jump in their third derivative: all laws are.
        best: the best cam. steering: caps of the free laws.
        keeping: the same with nothing asked for, and the target's value held, or the best's.
    """

    state: Search
    problem: Problem
    best: Candidate
    target: float
    steering: tuple[Control, ...]
    keeping: tuple[Problem, ...]


@dataclass(frozen=True, eq=False)
class Relaxed:
    """The answer of a cone program with implied rows, on its knots, and the bound it gave."""

    cam: Candidate
    grids: tuple[Grid, ...]
    lower: Bound


@dataclass(frozen=True, eq=False)
class Box:
    """A box of sizes: what its better cams keep to, and what none of them is below.

    ``grids``: few knots, where the bound asks for them. ``relaxed``: its last cone program.
    """

    lair: Lair
    lower: float
    over: str
    grids: tuple[Grid, ...] = ()
    relaxed: Relaxed | None = None


def close(state: Search) -> None:
    """Narrow the gap of a search that limits which are not convex have left open."""
    best = state.best
    if best is None or state.close(best) or state.left() <= 0.0:
        return
    if state.problem.objective.fractional or not state.problem.free:
        return
    parts = {k: near for k, s in enumerate(state.problem.free) if (near := binding(state, s))}
    if not parts:
        return
    quest = asked(state, best)
    if quest is None:
        state.over += LEFT_OUT
        return
    started = time.perf_counter()
    lair = unknown(quest.problem, quest.steering, parts)
    box = climbed(quest, Box(lair, state.lower, state.over))
    for turns in (FIRST_TURNS, TURNS):
        box = explored(quest, box, turns)
        if box.lower >= quest.target or state.left() <= 0.0:
            break
        quest = improved(quest, box)
    boxes, count = [box], 1
    while count < MOST_BOXES and state.left() > 0.0:
        worst = min(boxes, key=lambda box: box.lower)
        if worst.lower >= quest.target or not worst.lair.divisible:
            break
        boxes.remove(worst)
        boxes += [explored(quest, half) for half in halves(worst)]
        count += 2
    lowest = finished(quest, boxes)
    state.raise_to(min(lowest.lower, quest.target), lowest.over)
    state.stages.append(
        Stage(
            "implied rows", f"linear and cone programs in {count} boxes", "HiGHS, Clarabel",
            0, 0, 0, time.perf_counter() - started, "solved",
            "what a better cam keeps to, and the rows that its curvature implies there",
        )
    )  # fmt: skip


def binding(state: Search, free: Stretch) -> Parts:
    """The parts of a free law on which limits with implied rows are near to binding, or broken.

    In the best cam, or in that of the relaxation.
    """
    x = np.linspace(0.0, 1.0, SAMPLES + 1)
    worst = np.full(len(x), -np.inf)
    for cam in (state.best, state.relaxed):
        if cam is not None:
            (stretch,) = (s for s in cam.problem.stretches if s.index == free.index)
            worst = np.maximum(worst, _excess(cam.problem, stretch, x, cam.size))
    where = np.flatnonzero(worst > NEAR)
    if not len(where):
        return ()
    runs = np.split(where, np.flatnonzero(np.diff(where) > CLOSE_BY * SAMPLES) + 1)
    ends = np.array([[x[run[0]] - 2.0 / SAMPLES, x[run[-1]] + 2.0 / SAMPLES] for run in runs])
    places = snapped(np.clip(ends, 0.0, 1.0))  # there will be knots
    return tuple((float(low), float(high)) for low, high in places)


def _excess(problem: Problem, stretch: Stretch, x: Array, size: Vector) -> Array:
    """By how much limits with implied rows are broken on a settled stretch, relative: (n,)."""
    theta = stretch.start + stretch.angle * x
    s, worst = stretch.placed().derivatives(theta), np.full(len(x), -np.inf)
    for limit in problem.limits:
        if limit.traced(stretch, problem.machine):
            for value in limit.smooth(stretch, problem.machine, theta, s, size):
                worst = np.maximum(worst, value)
    return worst


def asked(state: Search, best: Candidate) -> Quest | None:
    """What has to be shown about a cam; None where all laws are not bounded."""
    problem = state.problem
    free = {
        s.index: replace(s, free=replace(s.free, smoothness=2))
        for s in problem.free
        if s.free is not None
    }
    problem = replace(problem, stretches=tuple(free.get(s.index, s) for s in problem.stretches))
    objective, machine = problem.objective, problem.machine
    wire = objective.to_wire(best.value, machine)
    target = objective.from_wire(wire - AIM * state.tolerance * abs(wire), machine)
    keeping = tuple(
        replace(problem, objective=Nothing(), held=(*problem.held, Held(objective, value)))
        for value in (target, best.value * (1.0 + SPARE))
    )
    coarse = [uniform(stretch, INTERVALS) for stretch in problem.free]
    steering = controls(formulate(keeping[0], coarse))
    if steering is None or not all(c.order == 3 and np.isfinite(c.cap) for c in steering):
        return None
    return Quest(state, problem, best, target, tuple(steering), keeping)


def explored(quest: Quest, box: Box, turns: int = TURNS) -> Box:
    """Hulls and rows in turn, each from what the other has shown, while it is worth it.

    All laws are asked at first, and before it is given up.
    """
    among = every = tuple(range(len(quest.problem.free)))
    for _ in range(turns):
        if box.lower >= quest.target or not box.grids or quest.state.left() <= 0.0:
            break
        before, lair = box.lair.of(among).width, _narrower(quest, box, among)
        if lair is None:
            return climbed(quest, box) if quest.state.left() > 0.0 else box
        if lair.empty:
            return replace(box, lower=quest.target)
        box = climbed(quest, replace(box, lair=lair))
        idle = lair.of(among).width > WORTH * before
        if idle and among == every:
            break
        among = every if idle else _breaking(quest, box.lair) or every
    return box


def _breaking(quest: Quest, lair: Lair) -> tuple[int, ...]:
    """The laws of the last answer that break limits: narrower hulls of others do not exclude it."""
    guess, free = lair.guess, quest.problem.free
    if guess is None:
        return ()
    x, hulled = np.linspace(0.0, 1.0, SAMPLES + 1), {position for position, _ in lair.hulls}
    laws = ((k, free[k].with_law(guess.laws[k].curve())) for k in hulled)
    return tuple(
        sorted(k for k, law in laws if np.max(_excess(quest.problem, law, x, guess.size)) > 0.0)
    )


def _narrower(quest: Quest, box: Box, among: Collection[int]) -> Lair | None:
    """The box's lair, narrowed with the best value held for which its few knots are enough.

    ``among``: positions of the laws that are asked.
    """
    grids, lair = box.grids, box.lair
    asked = left = frozenset(among)
    for problem in (*quest.keeping, quest.keeping[-1]):
        bare = tuple(Grid(grid.space, grid.space.breaks) for grid in grids)
        seconds = quest.state.left()
        if seconds <= 0.0 or not left or lair.empty:
            break
        lair, left = narrowed(formulate(problem, bare), quest.steering, lair, left, seconds)
        if problem is quest.keeping[-1]:
            halved = all_halved(problem, grids, [np.zeros(0)] * len(grids))
            both = zip(grids, halved, strict=True)
            grids = tuple(h if k in left else g for k, (g, h) in enumerate(both))
    return None if left == asked else lair


def finished(quest: Quest, boxes: list[Box]) -> Box:
    """The lowest box in the end: where rows gain nothing more, finer knots still may."""
    lowest = min(boxes, key=lambda box: box.lower)
    while lowest.lower < quest.target and quest.state.left() > 0.0:
        better = climbed(quest, lowest, patient=True)
        if better.lower <= lowest.lower + GAIN * (quest.target - lowest.lower):
            break
        boxes = [better if box is lowest else box for box in boxes]
        lowest = min(boxes, key=lambda box: box.lower)
    return lowest


def climbed(quest: Quest, box: Box, *, patient: bool = False) -> Box:
    """Cone programs with the implied rows, on finer knots where these are what is missing.

    ``patient``: on finer knots even where it is rows that leave more.
    """
    # a cam grows in its last size variable: left open above, there is a cam to every row
    grown = (box.lair.sizes[-1][0], quest.problem.sizing.bounds[-1][1])
    inside = replace(quest.problem.sizing, bounds=(*box.lair.sizes[:-1], grown))
    problem = replace(quest.problem, sizing=inside)
    grids = _coarse(quest, box)
    for number in range(ROUNDS):
        grids = tuple(Grid(grid.space, grid.space.breaks) for grid in grids)
        relaxed = formulate(problem, grids)
        plan = with_rows(relaxed, box.lair.rows(relaxed, sparing=True))
        solution = solve(plan.program, quest.state.left())
        rows = box.lair.between(plan, SPREAD, sparing=True)
        between = Spreading.of(plan, rows, SPREAD)
        ends = ends_priced(plan, solution, heard(plan, solution), 3)
        dense = replace(solution, multipliers=between.masses(solution.multipliers, ends))
        if solution.stopped is Stopped.INFEASIBLE:
            box = _raised(box, _excluded(between.plan, dense, ends))
            if box.lower >= quest.target or quest.state.left() <= 0.0:
                break
            grids = all_halved(problem, grids, [np.zeros(0)] * len(grids))
            continue
        if solution.stopped not in USABLE:
            return box
        lower = bound(between.plan, dense, ends)
        if not lower.switching:
            return box
        laws, size = plan.recover(solution.x)
        box = replace(_raised(box, lower), lair=replace(box.lair, guess=Guess(tuple(laws), size)))
        if number <= FEW:
            box = replace(box, grids=grids)
        found = settle(problem, laws, size, keep_hint=True)
        box = replace(box, relaxed=Relaxed(found, grids, lower))
        # knots are what is missing where this family has no better cam any more
        if box.lower >= quest.target or quest.state.left() <= 0.0:
            break
        left = quest.target - found.value
        few = number >= FEW or found.value - lower.value < ENOUGH * left
        if left > 0.0 and few and not patient:
            break
        grids = finer(problem, grids, found, lower, [np.zeros(0)] * len(grids))
    return box


def _coarse(quest: Quest, box: Box) -> tuple[Grid, ...]:
    """Few knots, some of them where rows begin and end."""
    chosen = []
    for position, stretch in enumerate(quest.problem.free):
        hulls = (hull for (law, _), hull in box.lair.hulls.items() if law == position)
        ends = np.unique([end for hull in hulls for part in hull.parts for end in part])
        breaks = uniform(stretch, INTERVALS).space.breaks
        chosen.append(
            over(stretch, merged(breaks, ends, stretch.free.knots if stretch.free else ()))
        )
    return tuple(chosen)


def _raised(box: Box, lower: Bound) -> Box:
    return replace(box, lower=lower.value, over=lower.over) if lower.value > box.lower else box


def _excluded(plan: Plan, solution: ConeSolution, ends: Sequence[Array]) -> Bound:
    """What multipliers say that exclude every spline of a plan: as large as one likes."""
    found = []
    for scale in RAYS:
        ray = replace(solution, multipliers=scale * solution.multipliers)
        found.append(bound(plan, ray, [scale * price for price in ends]))
    return max(found, key=lambda lower: lower.value)


def halves(box: Box) -> list[Box]:
    """The box cut in two across the widest of its sizes.

    Not across the last while there is another: a cam grows in it, so that it bounds nothing.
    """
    sizes = box.lair.sizes
    widths = [high - low for low, high in sizes]
    axis = int(np.argmax(widths[:-1] if any(widths[:-1]) else widths))
    low, high = sizes[axis]
    middle = 0.5 * (low + high)
    found = []
    for part in ((low, middle), (middle, high)):
        inside = (*sizes[:axis], part, *sizes[axis + 1 :])
        found.append(replace(box, lair=box.lair.inside(inside)))
    return found


def improved(quest: Quest, box: Box) -> Quest:
    """The quest about a better cam, if a local search from a box that resists finds one.

    Its knots are where the law that switches at once would have its own inside the box: fewer of
    them do more than those that the search without curvature ended with.
    """
    state, relaxed = quest.state, box.relaxed
    if relaxed is None:
        return quest
    nowhere = [np.zeros(0)] * len(relaxed.grids)
    state.grids = finer(state.problem, relaxed.grids, relaxed.cam, relaxed.lower, nowhere)
    missed, _ = misses(state, relaxed.cam)
    state.grids = tuple(g.with_points(x) for g, x in zip(state.grids, missed, strict=True))
    improve_from(state, relaxed.cam)
    assert state.best is not None
    if state.best.value >= quest.best.value:
        return quest
    return asked(state, state.best) or quest
