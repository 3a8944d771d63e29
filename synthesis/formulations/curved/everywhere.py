"""A bound over all laws and all sizes where motion and size together make limits not convex.

With the pivot of an arm free, the pressure angle holds products of the size and of the swing's sine
and cosine; so do all limits of a face that swings. Over a box of sizes and a tube of laws they
imply rows; every better cam lies in such a box, bounded by the same rows, and where one box leaves
too much it is cut in two. The knots that the bound asks for are those on which a better cam is
looked for.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import replace
from math import isfinite

from synthesis.formulations.cams.candidate import Candidate
from synthesis.formulations.curved.known import Known, climbed, explored, narrowed, near_to_binding
from synthesis.formulations.nonconvex.local import improve_from
from synthesis.formulations.rounds.search import Search, Stage

TURNS = 4  # the region narrowed with the rows that the wider one gave
QUICK = 2  # of them where a cam is at hand that is a local optimum already
WORTH = 0.15  # of the gap: what a turn must gain for another one
MOST_BOXES = 15
Near = Mapping[int, tuple[float, float]]


def enclose(state: Search, *, thorough: bool) -> None:
    """Bound a search over all laws and sizes, and polish its best cam on the way.

    Args:
        state: the search, with a best cam; without one there is nothing that a better cam keeps.
        thorough: cut boxes in two as long as one leaves more than the tolerance.
    """
    best = state.best
    if best is None or not state.problem.free or state.close(best) or state.left() <= 0.0:
        return
    started = time.perf_counter()
    near = {k: part for k, s in enumerate(state.problem.free) if (part := near_to_binding(best, s))}
    if not near and isfinite(state.lower):
        return  # nothing that is not convex binds
    root = _rooted(state, near, QUICK if state.problem.rigid and not thorough else TURNS)
    leaves = _split(state, near, root) if thorough and root.sizes else [root]
    lowest = min(leaves, key=lambda leaf: leaf.lower)
    state.raise_to(lowest.lower, lowest.over)
    state.stages.append(
        Stage(
            "implied rows", f"cone programs in {len(leaves)} boxes", "Clarabel", 0, 0, 0,
            time.perf_counter() - started, "solved",
            "what a better cam keeps to, and the rows that its limits imply there",
        )
    )  # fmt: skip


def _rooted(state: Search, near: Near, turns: int) -> Known:
    """All sizes at once: region and rows in turn, each from what the other has shown."""
    known = Known(state.problem, state.lower, state.over, state.grids)
    for _ in range(turns):
        best, before = _best(state), known.lower
        lair = narrowed(state, best, near, known)
        if lair is None or state.left() <= 0.0:
            break
        known = climbed(state, best, lair)
        state.raise_to(known.lower, known.over)
        if known.grids != state.grids:
            state.grids = known.grids
            improve_from(state, best)
        left = _best(state).value - known.lower
        if state.close(state.best) or known.lower - before < WORTH * left:
            break
    return known


def _best(state: Search) -> Candidate:
    assert state.best is not None
    return state.best


def _split(state: Search, near: Near, root: Known) -> list[Known]:
    """The boxes that are left once the worst was cut in two again and again."""
    leaves, boxes = [root], 1
    while boxes < MOST_BOXES and state.left() > 0.0:
        worst = min(leaves, key=lambda leaf: leaf.lower)
        if state.close_to(_best(state), worst.lower):
            break
        leaves.remove(worst)
        leaves += [explored(state, _best(state), near, half) for half in _halves(worst)]
        boxes += 2
    return leaves


def _halves(leaf: Known) -> list[Known]:
    """The box cut in two across the widest range of its sizes."""
    axis = max(range(len(leaf.sizes)), key=lambda k: leaf.sizes[k][1] - leaf.sizes[k][0])
    low, high = leaf.sizes[axis]
    found = []
    for part in ((low, 0.5 * (low + high)), (0.5 * (low + high), high)):
        bounds, sizes = list(leaf.problem.sizing.bounds), list(leaf.sizes)
        bounds[axis] = sizes[axis] = part
        inside = replace(leaf.problem.sizing, bounds=tuple(bounds))
        problem = replace(leaf.problem, sizing=inside)
        found.append(replace(leaf, problem=problem, sizes=tuple(sizes)))
    return found
