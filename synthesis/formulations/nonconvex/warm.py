"""A local search begun where that of a neighbouring question ended: its law, multipliers, points.

The cam so found is a local optimum as good as any other, and is judged as any other; but it
depends on the neighbour, in its last digits or, where there are several local optima, in more.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace

from synthesis.formulations.cams.candidate import mended, settle
from synthesis.formulations.cams.spots import Spots
from synthesis.formulations.cone.convex import formulate
from synthesis.formulations.cone.cuts import Region
from synthesis.formulations.cone.rows import Drawn
from synthesis.formulations.question.grid import Grid
from synthesis.formulations.question.problem import Problem
from synthesis.formulations.rounds.missed import ALLOWED, misses
from synthesis.formulations.rounds.search import Search, Stage

STAGE = "nonlinear, from a neighbour"


def from_neighbour(state: Search) -> bool:
    """The local search begun at the neighbour's; whether that gave a cam.

    It does not where the neighbour's knots are fewer than the bound's rounds ask for here, or its
    program has other rows.
    """
    # CasADi only where it is needed
    from synthesis.formulations.nonconvex.nonlinear import accuracies, exchanged
    from synthesis.solvers.ipopt import Guess

    near, started = state.near, time.perf_counter()
    if near is None or near.rows is None or not _as_fine(near.grids, state.grids):
        return False
    plan = formulate(state.problem, near.grids, 0.0, Drawn(state.tighten, state.margin), Region())
    if plan.program.matrix.shape != near.shape:
        return False
    guess = Guess(plan.point(near.laws, near.size), near.rows, near.bounds)
    spots = here(near.spots, state.problem)
    found = exchanged(plan, spots, guess, state.deadline, *accuracies(state.tolerance))
    cam = settle(state.problem, *plan.recover(found.x), keep_hint=True)
    cam = cam if state.problem.curved else mended(cam)
    good = misses(state, cam)[1] <= ALLOWED
    before = state.best
    if good:
        state.accept(cam)
    state.stages.append(
        Stage(
            STAGE, "NLP", "IPOPT", len(found.x), found.rows, found.iterations,
            time.perf_counter() - started, found.stopped.value,
        )
    )  # fmt: skip
    if state.best is before:
        return False
    state.grids = near.grids
    state.left_behind = found.left(plan, near.grids)
    state.from_near = True
    return True


def _as_fine(grids: Sequence[Grid], wanted: Sequence[Grid]) -> bool:
    """Whether every law has the degree and at least the knots that are wanted."""
    return len(grids) == len(wanted) and all(
        grid.space.degree == other.space.degree and grid.space.size >= other.space.size
        for grid, other in zip(grids, wanted, strict=True)
    )


def here(spots: Sequence[Spots], problem: Problem) -> list[Spots]:
    """Points of the neighbour; on laws that are given, with this question's displacements."""
    return [_moved(spot, problem) for spot in spots]


def _moved(spot: Spots, problem: Problem) -> Spots:
    stretch = problem.stretches[spot.position]
    if stretch.law is None:
        return spot
    curve, theta = stretch.placed(), stretch.start + spot.x * stretch.angle
    return replace(spot, s=curve.jet(theta, curve.piece_of(theta), 3))
