"""One box of cams explored: hulls and the rows that they imply in turn, until nothing is left.

What is to be proven of a box is that it holds no better cam; or at least, below what all of its
cams lie.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from math import inf, isfinite

import numpy as np

from synthesis.formulations.bounds.bound import Bound, bound
from synthesis.formulations.bounds.multipliers import ends_priced, heard
from synthesis.formulations.bounds.spreading import Spreading
from synthesis.formulations.cams.candidate import Candidate, settle
from synthesis.formulations.cone.control import Control
from synthesis.formulations.cone.convex import Plan, formulate, with_rows
from synthesis.formulations.cone.rows import Block, Scales
from synthesis.formulations.curved.farther import beyond
from synthesis.formulations.curved.lair import Guess, Lair
from synthesis.formulations.curved.narrowing import narrowed
from synthesis.formulations.curved.resting import excess, resting, risen
from synthesis.formulations.question.grid import Grid, merged, over, uniform
from synthesis.formulations.question.problem import Held, Nothing, Problem
from synthesis.formulations.rounds.knots import all_halved, finer
from synthesis.formulations.rounds.search import Search
from synthesis.numerics.piecewise import Array
from synthesis.solvers.clarabel import ConeSolution, solve
from synthesis.solvers.statuses import USABLE, Stopped

INTERVALS = 20  # of the first laws of every climb
FEW = 2  # times at most that these are refined for the laws that say where better cams lie
ENOUGH = 0.25  # of what rows must still gain: a loss to coarse knots that does not matter yet
SAMPLES = 200
SPARE = 1e-9
TURNS = 8  # of hulls and rows in a box
WORTH = 0.85  # of the hulls' width: what a turn must leave at most for another one
ROUNDS = 5  # of finer knots
SPREAD = 14  # points between two rows over which multipliers are spread
RAYS = (1e2, 1e4, 1e6)


@dataclass(frozen=True, eq=False)
class Quest:
    """What is to be proven: no cam is better than ``target`` [core units].

    Attributes:
        problem: the question, its laws free to jump in their third derivative: all laws are.
        best: the best cam. steering: caps of the free laws.
    """

    state: Search
    problem: Problem
    best: Candidate
    target: float
    steering: tuple[Control, ...]

    def keeping(self, box: Box) -> tuple[Problem, Problem]:
        """The question with nothing asked for and a box's largest value held, or a little more.

        That little is what the best value is above the target.
        """
        most = self.most(box)
        more = most + (1.0 + SPARE) * self.best.value - self.target
        return holding(self.problem, most), holding(self.problem, more)

    def most(self, box: Box) -> float:
        """The largest value of cams of a box that are of interest."""
        return min(box.most, self.target)

    def closed(self, box: Box) -> bool:
        """Whether a box holds none of them."""
        return box.lower >= self.most(box)


def holding(problem: Problem, value: float) -> Problem:
    """The question with nothing asked for, and its objective's value held."""
    held = (*problem.held, Held(problem.objective, value))
    return replace(problem, objective=Nothing(), held=held)


@dataclass(frozen=True, eq=False)
class Relaxed:
    """The answer of a cone program with implied rows, on its knots, and the bound it gave."""

    cam: Candidate
    grids: tuple[Grid, ...]
    lower: Bound


@dataclass(frozen=True, eq=False)
class Box:
    """A box of sizes and values: what its better cams keep to, and what none of them is below.

    Attributes:
        grids: few knots, where the bound asks for them. relaxed: its last cone program.
        least, most: its cams' values, as far as better ones are not in another box.
        fresh: not explored yet.
    """

    lair: Lair
    lower: float
    over: str
    grids: tuple[Grid, ...] = ()
    relaxed: Relaxed | None = None
    least: float = -inf
    most: float = inf
    fresh: bool = False


def explored(quest: Quest, box: Box, turns: int = TURNS) -> Box:
    """Hulls and rows in turn, each from what the other has shown, while it is worth it.

    All laws are asked at first, and before it is given up.
    """
    among = every = tuple(range(len(quest.problem.free)))
    for _ in range(turns):
        if quest.closed(box) or not box.grids or quest.state.left() <= 0.0:
            break
        before, lair = box.lair.of(among).width, _narrower(quest, box, among)
        if lair is None:
            return climbed(quest, box) if quest.state.left() > 0.0 else box
        if lair.empty:
            return replace(box, lower=quest.most(box))
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
        sorted(
            k
            for k, law in laws
            if np.max(excess(quest.problem, law, law.start + law.angle * x, guess.size)) > 0.0
        )
    )


def _narrower(quest: Quest, box: Box, among: Collection[int]) -> Lair | None:
    """The box's lair, narrowed with the best value held for which its few knots are enough.

    ``among``: positions of the laws that are asked.
    """
    grids = box.grids
    lair = box.lair.inside(risen(quest.problem, box.lair.sizes))
    if lair.empty:
        return lair
    asked = left = frozenset(among)
    keeping = quest.keeping(box)
    for problem in (*keeping, keeping[-1]):
        bare = tuple(Grid(grid.space, grid.space.breaks) for grid in grids)
        seconds = quest.state.left()
        if seconds <= 0.0 or not left or lair.empty:
            break
        plan = formulate(problem, bare)
        plan = with_rows(plan, _of_sizes(quest, replace(box, lair=lair), plan.scales))
        lair, left = narrowed(plan, quest.steering, lair, left, seconds)
        if problem is keeping[-1]:
            halved = all_halved(problem, grids, [np.zeros(0)] * len(grids))
            both = zip(grids, halved, strict=True)
            grids = tuple(h if k in left else g for k, (g, h) in enumerate(both))
    return None if left == asked else lair


def _of_sizes(quest: Quest, box: Box, scales: Scales) -> list[Block]:
    """Rows on the size alone that all cams of a box keep, but for those that laws imply."""
    found = list(resting(quest.problem, box.lair.sizes, scales))
    norm = quest.problem.objective.norm(quest.problem.machine)
    if norm is not None and isfinite(box.least):
        found += beyond(norm, box.least, box.lair.sizes, scales)
    return found


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
        given = list(resting(problem, box.lair.sizes, relaxed.scales))
        plan = with_rows(relaxed, [*given, *box.lair.rows(relaxed, sparing=True)])
        solution = solve(plan.program, quest.state.left())
        rows = box.lair.between(plan, SPREAD, sparing=True)
        between = Spreading.of(plan, rows, SPREAD)
        ends = ends_priced(plan, solution, heard(plan, solution), 3)
        dense = replace(solution, multipliers=between.masses(solution.multipliers, ends))
        if solution.stopped is Stopped.INFEASIBLE:
            box = _raised(box, _excluded(between.plan, dense, ends))
            if quest.closed(box) or quest.state.left() <= 0.0:
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
        if quest.closed(box) or quest.state.left() <= 0.0:
            break
        left = quest.most(box) - found.value
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
