"""The third rung as a stage of a search: local optima under limits that are not convex."""

from __future__ import annotations

import time
from collections.abc import Sequence
from math import inf

from synthesis.formulations.cams.candidate import Candidate, mended, settle
from synthesis.formulations.cone.convex import formulate
from synthesis.formulations.cone.cuts import Region
from synthesis.formulations.cone.rows import Drawn
from synthesis.formulations.nonconvex.successive import approach
from synthesis.formulations.nonconvex.warm import from_neighbour
from synthesis.formulations.question.grid import SettledLaw
from synthesis.formulations.rounds.missed import ALLOWED, misses
from synthesis.formulations.rounds.neighbour import Neighbour
from synthesis.formulations.rounds.search import Search, Stage
from synthesis.numerics.piecewise import Array
from synthesis.objectives.rms_acceleration import RmsAcceleration
from synthesis.objectives.rms_jerk import RmsJerk
from synthesis.solvers.clarabel import solve
from synthesis.solvers.statuses import USABLE, Stopped

FAR = 1.5  # of the bound: a cam this large is not taken for a start without a look at another
GROWN = 0.1  # of the tolerance: what may be left to growing, for it saves a run of IPOPT
SLACK = 0.08  # of the tolerance: what tangents may leave to growing
EXCHANGES = 3  # of rows between whose points something was missed


def nonlinear(state: Search) -> None:
    """From a neighbour's, the relaxation's cam grown out of the limits, or a gentler one."""
    if from_neighbour(state):
        return
    if state.best is None or state.best.value > FAR * state.lower:
        gentle(state)
    start = state.best or state.relaxed or state.last
    if start is not None:
        improve_from(state, start)


def improve_from(state: Search, start: Candidate) -> None:
    """A local optimum on the present knots: by tangents, and by IPOPT where these do not end."""
    if by_tangents(state, start) or state.left() <= 0.0:
        return
    start = state.best or start
    for _ in range(EXCHANGES):
        missed, excess = _improved(state, start)
        if excess <= ALLOWED or state.problem.curved or state.left() <= 0.0:
            break
        # rows that the size cannot mend, a counter cam's, were missed between their points
        state.margin = 1.1 * (state.margin + excess)
        both = zip(state.grids, missed, strict=True)
        state.grids = tuple(grid.with_points(more) for grid, more in both)


def by_tangents(state: Search, start: Candidate) -> bool:
    """Cone programs under the limits' tangents; whether they came to a cam's local optimum."""
    if state.problem.objective.norm(state.problem.machine) is None:
        return False  # what growing costs is not known
    started, close = time.perf_counter(), SLACK * state.tolerance
    drawn = Drawn(state.tighten, state.margin)
    plan = formulate(state.problem, state.grids, 0.0, drawn, Region())
    found = approach(plan, start, state.deadline, close)
    kept = found.cam is not None and _kept(state, found.cam.laws, found.cam.size)[1] <= ALLOWED
    if kept and found.cam is not None:
        x = plan.point(found.cam.laws, found.cam.size)
        state.left_behind = Neighbour.of(plan, state.grids, (), x, (None, None))
    state.stages.append(
        Stage(
            "tangents", f"{found.rounds} SOCPs", "Clarabel", plan.program.matrix.shape[1],
            found.rows, found.iterations, time.perf_counter() - started,
            (Stopped.SOLVED if found.settled else Stopped.INACCURATE).value,
        )
    )  # fmt: skip
    return found.settled and kept


def _kept(
    state: Search, laws: Sequence[SettledLaw], size: tuple[float, ...]
) -> tuple[list[Array], float]:
    """Offer the cam of a local optimum; where its rows were missed between their points."""
    least: tuple[list[Array], float] = [], inf
    for keep_hint in (True, False):
        found = settle(state.problem, laws, size, keep_hint=keep_hint)
        found = mended(found) if keep_hint and not state.problem.curved else found
        missed = misses(state, found)
        least = min(least, missed, key=lambda each: each[1])
        if missed[1] <= ALLOWED:
            state.accept(found)
    return least


def _improved(state: Search, start: Candidate) -> tuple[list[Array], float]:
    """One run of IPOPT; where its rows were missed between their points, and how far."""
    from synthesis.formulations.nonconvex.nonlinear import (  # CasADi where it is needed
        accuracies,
        improve,
    )

    started = time.perf_counter()
    drawn = Drawn(state.tighten, state.margin)
    plan = formulate(state.problem, state.grids, 0.0, drawn, Region())  # smooth forms say more
    asked = accuracies(state.tolerance)
    began, growth = plan.point(start.laws, start.size), GROWN * state.tolerance
    solution = improve(plan, began, state.deadline, *asked, growth=growth)
    least = _kept(state, *plan.recover(solution.x))
    if least[1] <= ALLOWED:
        state.left_behind = solution.left(plan, state.grids)
    state.stages.append(
        Stage(
            "nonlinear", "NLP", "IPOPT", len(solution.x), solution.rows, solution.iterations,
            time.perf_counter() - started, solution.stopped.value,
        )
    )  # fmt: skip
    return least


def gentle(state: Search) -> Candidate | None:
    """Another cam to start from: the law of least mean square jerk, grown until limits hold.

    Where accelerations may jump, of least mean square acceleration.

    Returns:
        the cam as it was before that, whatever limits it breaks; None where there is no such law.

    The relaxation's own law uses its freedom to the full, and may be bent so sharply that only
    a huge cam could carry it.
    """
    if not state.problem.free:
        return None
    roughest = min(stretch.free.smoothness for stretch in state.problem.free if stretch.free)
    quiet = state.problem.with_objective(RmsJerk() if roughest > 1 else RmsAcceleration())
    plan = formulate(quiet, state.grids, 0.0, Drawn(state.tighten, state.margin))
    solution = solve(plan.program, state.left())
    if solution.stopped not in USABLE:
        return None
    laws, size = plan.recover(solution.x)
    found = settle(state.problem, laws, size)
    if misses(state, found)[1] <= ALLOWED:
        state.accept(found)
    return found
