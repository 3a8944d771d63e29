"""Local optima under limits that are not convex by cone programs, as a stage of a search."""

from __future__ import annotations

import time
from collections.abc import Sequence
from math import inf

from synthesis.formulations.cams.candidate import mended, settle
from synthesis.formulations.cone.convex import formulate
from synthesis.formulations.cone.cuts import Region
from synthesis.formulations.cone.rows import Drawn
from synthesis.formulations.nonconvex.successive import approach
from synthesis.formulations.question.grid import SettledLaw
from synthesis.formulations.rounds.missed import ALLOWED, misses
from synthesis.formulations.rounds.neighbour import Neighbour
from synthesis.formulations.rounds.search import Search, Stage
from synthesis.numerics.piecewise import Array
from synthesis.solvers.statuses import Stopped

Vector = tuple[float, ...]
SLACK = 0.08  # of the tolerance: what tangents may leave to growing
MOST = 4e-4  # of a value: the same, whatever the tolerance


def by_tangents(
    state: Search, laws: Sequence[SettledLaw], size: Vector, stage: str = "tangents"
) -> bool:
    """A local optimum on the present knots, sought from laws and a size; whether it was found."""
    if state.problem.objective.norm(state.problem.machine) is None:
        return False  # what growing costs is not known
    started, close = time.perf_counter(), min(SLACK * state.tolerance, MOST)
    drawn = Drawn(state.tighten, state.margin)
    plan = formulate(state.problem, state.grids, 0.0, drawn, Region())
    found = approach(plan, laws, size, state.deadline, close)
    cam, keeps = found.cam, False
    if cam is not None:
        keeps = kept(state, cam.laws, cam.size, cam.value * (1.0 + close))[1] <= ALLOWED
        state.left_behind = Neighbour(state.grids, cam.laws, cam.size)
    state.stages.append(
        Stage(
            stage, f"{found.rounds} SOCPs", "Clarabel", plan.program.matrix.shape[1],
            found.rows, found.iterations, time.perf_counter() - started,
            (Stopped.SOLVED if found.settled else Stopped.INACCURATE).value,
        )
    )  # fmt: skip
    return found.settled and keeps


def kept(
    state: Search, laws: Sequence[SettledLaw], size: Vector, enough: float = -inf
) -> tuple[list[Array], float]:
    """Offer the cam of a local optimum; where its rows were missed between their points.

    Its laws with the size that is best for them, too; one of both if it has a value that does.
    """
    least: tuple[list[Array], float] = [], inf
    for keep_hint in (False, True):
        found = settle(state.problem, laws, size, keep_hint=keep_hint)
        found = mended(found) if keep_hint and not state.problem.curved else found
        missed = misses(state, found)
        least = min(least, missed, key=lambda each: each[1])
        if missed[1] <= ALLOWED:
            state.accept(found)
        if missed[1] <= ALLOWED and state.best is not None and state.best.value <= enough:
            break
    return least
