"""The third rung as a stage of a search: local optima under limits that are not convex."""

from __future__ import annotations

import time

from synthesis.formulations.cams.candidate import Candidate, settle
from synthesis.formulations.cone.convex import formulate
from synthesis.formulations.cone.cuts import Region
from synthesis.formulations.cone.rows import Drawn
from synthesis.formulations.nonconvex.by_tangents import (
    by_tangents,
    kept,
    more_points,
)
from synthesis.formulations.nonconvex.warm import from_neighbour
from synthesis.formulations.rounds.missed import ALLOWED, misses
from synthesis.formulations.rounds.neighbour import Neighbour
from synthesis.formulations.rounds.search import Search, Stage
from synthesis.numerics.piecewise import Array
from synthesis.objectives.rms_acceleration import RmsAcceleration
from synthesis.objectives.rms_jerk import RmsJerk
from synthesis.solvers.clarabel import solve
from synthesis.solvers.statuses import USABLE

FAR = 1.5  # of the bound: a cam this large is not taken for a start without a look at another
EXCHANGES = 3  # of rows between whose points something was missed
GROWN = 0.1  # of the tolerance: what may be left to growing, for it saves a run of IPOPT


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
    if by_tangents(state, start.laws, start.size) or state.left() <= 0.0:
        return
    start = state.best or start
    for _ in range(EXCHANGES):
        if not more_points(state, _improved(state, start)):
            break


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
    laws, size = plan.recover(solution.x)
    least = kept(state, laws, size)
    if least[1] <= ALLOWED:
        state.left_behind = Neighbour(state.grids, tuple(laws), size)
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
