"""Local optima under limits that are not convex by cone programs, as a stage of a search."""

from __future__ import annotations

import time
from collections.abc import Sequence
from math import inf

from synthesis.formulations.cams.candidate import mended, settle
from synthesis.formulations.cone.convex import formulate
from synthesis.formulations.cone.cuts import Region
from synthesis.formulations.cone.rows import Drawn
from synthesis.formulations.nonconvex.successive import Approach, Sought, approach
from synthesis.formulations.question.grid import SettledLaw
from synthesis.formulations.rounds.missed import ALLOWED, misses
from synthesis.formulations.rounds.neighbour import Neighbour
from synthesis.formulations.rounds.search import Search, Stage
from synthesis.numerics.piecewise import Array
from synthesis.solvers.statuses import Stopped

Vector = tuple[float, ...]
SLACK = 0.08  # of the tolerance: what tangents may leave to growing
MOST = 4e-4  # of a value: the same, whatever the tolerance
MENDED = 2.0  # times as much: what rows between their points may cost besides
DRAWN = 1e-6  # relative: by how much limits are drawn in at spots
RETRIES, DRAWN_MORE = (
    2,
    0.5,
)  # of what may be left to growing: the same where growing does not mend all


def by_tangents(
    state: Search, laws: Sequence[SettledLaw], size: Vector, stage: str = "tangents"
) -> bool:
    """A local optimum on the present knots, sought from laws and a size; whether it was found.

    Where growing breaks what it does not mend, a contact's least force or a counter cam's rows,
    once more with limits drawn in, and more points for rows that were missed between theirs.
    """
    if state.problem.objective.norm(state.problem.machine) is None:
        return False  # what growing costs is not known
    close = min(SLACK * state.tolerance, MOST)
    for sought in (Sought(close, DRAWN), *RETRIES * [Sought(close, DRAWN_MORE * close, anew=True)]):
        found = _approached(state, laws, size, sought, stage)
        cam = found.cam
        if cam is None:
            return False
        missed = kept(state, cam.laws, cam.size, cam.value * (1.0 + close))
        state.left_behind = Neighbour(state.grids, cam.laws, cam.size)
        if state.best is not None and state.best.value <= cam.value * (1.0 + MENDED * close):
            return found.settled
        if not found.settled or state.left() <= 0.0:
            return False
        more_points(state, missed)
        laws, size = cam.laws, cam.size
    return False


def _approached(
    state: Search, laws: Sequence[SettledLaw], size: Vector, sought: Sought, stage: str
) -> Approach:
    """One approach, reported."""
    started, drawn = time.perf_counter(), Drawn(state.tighten, state.margin)
    plan = formulate(state.problem, state.grids, 0.0, drawn, Region())  # smooth forms say more
    found = approach(plan, laws, size, state.deadline, sought)
    state.stages.append(
        Stage(
            stage, f"{found.rounds} SOCPs", "Clarabel", plan.program.matrix.shape[1],
            found.rows, found.iterations, time.perf_counter() - started,
            (Stopped.SOLVED if found.settled else Stopped.INACCURATE).value,
        )
    )  # fmt: skip
    return found


def more_points(state: Search, missed: tuple[list[Array], float]) -> bool:
    """Rows at more points, where they were missed by so much; whether there is any use in that."""
    points, excess = missed
    if excess <= ALLOWED or state.problem.curved or state.left() <= 0.0:
        return False
    # rows that the size cannot mend, a counter cam's, were missed between their points
    state.margin = 1.1 * (state.margin + excess)
    both = zip(state.grids, points, strict=True)
    state.grids = tuple(grid.with_points(more) for grid, more in both)
    return True


def kept(
    state: Search, laws: Sequence[SettledLaw], size: Vector, enough: float = -inf
) -> tuple[list[Array], float]:
    """Offer the cam of a local optimum; where its rows were missed between their points.

    First its laws with the size that is best for them: that does if its value is ``enough``.
    """
    for keep_hint in (False, True):
        found = settle(state.problem, laws, size, keep_hint=keep_hint)
        found = mended(found) if keep_hint and not state.problem.curved else found
        missed = misses(state, found)
        if missed[1] <= ALLOWED:
            state.accept(found)
        if missed[1] <= ALLOWED and state.best is not None and state.best.value <= enough:
            break
    return missed
