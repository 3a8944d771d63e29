"""The gap that curvature leaves: no better cam lies anywhere, shown box by box.

The relaxation leaves limits out that are not convex, and its bound with them. But a cam that is
better by more than the tolerance keeps the relaxation's rows and its own value; so its size lies in
a box and what draws its curves in hulls, which duality bounds over all laws. Within these the limit
implies rows (a nearly known curve is nearly linear); they narrow box and hulls, and so on in turn,
until nothing is left or nothing moves. Then the box is split, in sizes or in the value: cams that
are nearly as good as the bound at hand are nearly known. (McCormick's under-estimators with bound
tightening, in a search that takes the worst box first.)
"""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np

from synthesis import clock
from synthesis.formulations.cams.candidate import Candidate
from synthesis.formulations.cone.control import controls
from synthesis.formulations.cone.convex import formulate
from synthesis.formulations.curved import resting
from synthesis.formulations.curved.exploring import (
    SAMPLES,
    TURNS,
    Box,
    Quest,
    climbed,
    explored,
    holding,
)
from synthesis.formulations.curved.lair import Parts, unknown
from synthesis.formulations.nonconvex.local import improve_from
from synthesis.formulations.question.grid import snapped, uniform
from synthesis.formulations.rounds.knots import finer
from synthesis.formulations.rounds.missed import misses
from synthesis.formulations.rounds.search import Search, Stage
from synthesis.limits import Limit
from synthesis.motion import Stretch

INTERVALS = 20  # of the laws whose caps are read
CLOSE_BY = 0.08  # of a law: parts that are no farther apart are one
AIM = 0.985  # of the tolerance: the gap that is to be proven
FEW_TURNS = 2  # where the proof need not be thorough
SPARED = 0.5  # of the time that is left, if the proof was not asked for
FIRST_TURNS = 3  # before a better cam is looked for
GAIN = 0.1  # of what is missing: less is not worth another climb
MOST_BOXES = 21
FEW_BOXES, WIDE = 3, 0.05  # where the proof need not be thorough, and a share of the value is open
THICK = 0.4  # of the sizes' widths: values of a box farther apart than that are cut first


def close(state: Search, *, thorough: bool) -> None:
    """Narrow the gap of a search that limits which are not convex have left open.

    ``thorough``: to the tolerance, whatever the limit; else a little, where forces press.
    """
    best = state.best
    if best is None or state.close(best) or state.left() <= 0.0:
        return
    if state.problem.objective.fractional or not state.problem.free:
        return
    if not thorough and not any(_weighs(state, limit) for limit in state.problem.limits):
        return
    parts = {k: near for k, s in enumerate(state.problem.free) if (near := binding(state, s))}
    if not parts and not resting.binding(best.problem, best.size):
        return
    quest = asked(state, best)
    if quest is None:
        return
    state.taken_in = {limit.kind for limit in state.problem.limits if _traced(state, limit)}
    started, until = time.perf_counter(), state.deadline
    if not thorough:
        state.deadline = min(until, clock.now() + SPARED * state.left())
    lair = unknown(quest.problem, quest.steering, parts)
    box = climbed(quest, Box(lair, state.lower, state.over))
    for turns in (FIRST_TURNS, TURNS) if thorough else (FEW_TURNS,):
        box = explored(quest, box, turns)
        if box.lower >= quest.target or state.left() <= 0.0 or not thorough:
            break
        quest = improved(quest, box)
    most = MOST_BOXES if thorough else FEW_BOXES
    wide = box.lower < (1.0 - WIDE) * quest.target
    boxes, count = divided(quest, box, most if thorough or wide else 1)
    lowest = finished(quest, boxes) if thorough else min(boxes, key=_lower)
    state.deadline = until
    state.raise_to(min(lowest.lower, quest.target), lowest.over)
    state.stages.append(
        Stage(
            "implied rows", f"linear and cone programs in {count} boxes", "HiGHS, Clarabel",
            0, 0, 0, time.perf_counter() - started, "solved",
            "what a better cam keeps to, and the rows that its curvature implies there",
        )
    )  # fmt: skip


def _traced(state: Search, limit: Limit) -> bool:
    """Whether a limit implies rows where a traced point is nearly known."""
    return any(limit.traced(s, state.problem.machine) for s in state.problem.stretches)


def _weighs(state: Search, limit: Limit) -> bool:
    """Whether it does and is about forces."""
    return limit.of_forces and _traced(state, limit)


def divided(quest: Quest, box: Box, most: int) -> tuple[list[Box], int]:
    """The boxes that are left when the worst has been split again and again.

    ``most``: boxes that are explored, the first one among them; how many were comes back, too.
    """
    boxes, count = [settled(quest, box)], 1
    while count < most and quest.state.left() > 0.0:
        worst = min(boxes, key=_lower)
        if worst.lower >= quest.target or not worst.lair.divisible:
            break
        boxes.remove(worst)
        halved = [worst] if worst.fresh else halves(quest, worst)
        for half in halved:
            # one of better cams than the other's comes first, and may be all there is time for
            later = half.fresh and len(halved) > 1
            boxes.append(half if later else settled(quest, explored(quest, _begun(half))))
            count += not later
    return boxes, count


def _lower(box: Box) -> float:
    return box.lower


def _begun(box: Box) -> Box:
    return replace(box, fresh=False)


def binding(state: Search, free: Stretch) -> Parts:
    """The parts of a free law on which limits with implied rows are near to binding, or broken.

    In the best cam, or in that of the relaxation.
    """
    x = np.linspace(0.0, 1.0, SAMPLES + 1)
    worst = np.full(len(x), -np.inf)
    for cam in (state.best, state.relaxed):
        if cam is not None:
            (stretch,) = (s for s in cam.problem.stretches if s.index == free.index)
            theta = stretch.start + stretch.angle * x
            worst = np.maximum(worst, resting.excess(cam.problem, stretch, theta, cam.size))
    where = np.flatnonzero(worst > resting.NEAR)
    if not len(where):
        return ()
    runs = np.split(where, np.flatnonzero(np.diff(where) > CLOSE_BY * SAMPLES) + 1)
    ends = np.array([[x[run[0]] - 2.0 / SAMPLES, x[run[-1]] + 2.0 / SAMPLES] for run in runs])
    places = snapped(np.clip(ends, 0.0, 1.0))  # there will be knots
    return tuple((float(low), float(high)) for low, high in places)


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
    coarse = [uniform(stretch, INTERVALS) for stretch in problem.free]
    steering = controls(formulate(holding(problem, target), coarse))
    if steering is None or not all(c.order == 3 and np.isfinite(c.cap) for c in steering):
        return None
    return Quest(state, problem, best, target, tuple(steering))


def finished(quest: Quest, boxes: list[Box]) -> Box:
    """The lowest box in the end: where rows gain nothing more, finer knots still may."""
    lowest = min(boxes, key=lambda box: box.lower)
    while lowest.lower < quest.target and quest.state.left() > 0.0:
        better = settled(quest, climbed(quest, lowest, patient=True))
        if better.lower <= lowest.lower + GAIN * (quest.target - lowest.lower):
            break
        boxes = [better if box is lowest else box for box in boxes]
        lowest = min(boxes, key=lambda box: box.lower)
    return lowest


def settled(quest: Quest, box: Box) -> Box:
    """The box as it counts: one without a cam of interest has none below the target."""
    return replace(box, lower=quest.target) if quest.closed(box) else box


def halves(quest: Quest, box: Box) -> list[Box]:
    """The box cut in two across the widest of its sizes, or in the value where this is wide.

    Not across the last size while there is another: a cam grows in it, so that it bounds nothing.
    """
    sizes = box.lair.sizes
    widths = [high - low for low, high in sizes]
    among = widths[:-1] if any(widths[:-1]) else widths
    low, high = max(box.least, box.lower), quest.most(box)
    if _of_size(quest) and high - low > THICK * max(widths[:-1], default=0.0):
        middle = 0.5 * (low + high)
        return [
            replace(box, least=low, most=middle),
            replace(box, least=middle, lower=max(box.lower, middle), fresh=True),
        ]
    axis = int(np.argmax(among))
    low, high = sizes[axis]
    middle = 0.5 * (low + high)
    found = []
    for part in ((low, middle), (middle, high)):
        inside = (*sizes[:axis], part, *sizes[axis + 1 :])
        found.append(replace(box, lair=box.lair.inside(inside)))
    return found


def _of_size(quest: Quest) -> bool:
    """Whether the value is a norm of the size."""
    return quest.problem.objective.norm(quest.problem.machine) is not None


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
