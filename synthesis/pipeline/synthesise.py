"""synthesise(spec) -> Design: the whole way through on one page.

    DesignSpec -> Problem -> laws and size -> Motion -> certificate -> Design

The optimiser proposes, the certificate disposes: a cam that it does not certify is never called
feasible. ``largest_radius`` says in which order questions are put to the optimiser, ``attempt`` how
one of them is solved and certified, ``conflict`` why nothing fits.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

from synthesis.design.design import Design, SmoothnessCost, StageReport
from synthesis.errors import SolverFailed, TimeBudgetExceeded
from synthesis.numerics import clock
from synthesis.optimise.state.warm_start import WarmStart
from synthesis.pipeline.assembly import (
    design,
    in_wire_units,
    proofs,
    smoothness_cost,
    with_free_parameters,
)
from synthesis.pipeline.attempt import Goal
from synthesis.pipeline.conflict import explain
from synthesis.pipeline.largest_radius import solve
from synthesis.spec.design_spec import DesignSpec


@dataclass(frozen=True, eq=False)
class Neighbour:
    """What a design leaves to a neighbouring one: its id, and where its local search ended."""

    id: str
    search: WarmStart


def synthesise(spec: DesignSpec, *, deadline: float | None = None) -> Design:
    """Design the cam that a spec asks for.

    Args:
        spec: what is asked.
        deadline: ``time.monotonic()`` at which to stop; the spec's own budget counts as well.

    Returns:
        the design; where nothing fits its status is ``infeasible`` and ``conflict`` says why.

    Raises:
        TimeBudgetExceeded: time ran out before the tolerance was reached; carries the best.
        SolverFailed: no stage gave a usable point, and not even why could be found.
    """
    return synthesise_from_neighbour(spec, None, deadline=deadline)[0]


def synthesise_from_neighbour(
    spec: DesignSpec, near: Neighbour | None, *, deadline: float | None = None
) -> tuple[Design, Neighbour | None]:
    """The same, begun where a neighbouring design ended, if that helps; and what this one leaves.

    A design that was begun so has ``started_from`` and another id than the spec alone gives: its
    values may differ from that one's, within what its certificate says.

    Raises:
        TimeBudgetExceeded, SolverFailed: as ``synthesise``.
    """
    if spec.load is not None and spec.load.free_spring:
        from synthesis.optimise.parameters.spring_design import design_with_spring

        return design_with_spring(spec, lambda given: synthesise(given, deadline=deadline)), None
    began, budget = time.perf_counter(), clock.seconds_left(spec.time_budget_s, deadline)
    stages, stop = list[StageReport](), clock.now() + budget
    goal = Goal(stop, None if near is None else near.search)
    # 1. Solve and certify.
    run, smallest = solve(spec, goal, stages)
    question, attempt = run.question, run.attempt
    late = clock.now() >= stop
    if not attempt.certified and late and not (smallest and smallest.excludes):
        raise TimeBudgetExceeded(budget)
    # 2. Without a certified cam: why.
    conflict = None if attempt.certified else explain(run, smallest, stop)
    # 3. Values, bounds and gaps in the units of the wire; the status follows from them.
    built = question.to_physical(attempt.built)
    bounds = in_wire_units(question, attempt.built, attempt.bounds)
    objective_proofs = [] if attempt.cam is None else proofs(built, attempt.cam, bounds)
    seconds = time.perf_counter() - began
    found = design(
        built, attempt.cam, attempt.extremes, objective_proofs, stages, seconds, conflict
    ).for_spec(question.physical)
    found = with_free_parameters(found, spec, run.numbers)
    if spec.report_smoothness_cost:
        price = _smoothness_cost(found, spec, stop)
        found = found.model_copy(update={"smoothness_cost": price})
    if near is not None and any(tried.warm_started for tried in attempt.searches):
        found = found.with_warm_start(near.id)
    if late and found.status == "feasible":
        raise TimeBudgetExceeded(budget, found)
    behind = attempt.searches[0].local_optimum if attempt.searches else None
    return found, None if behind is None else Neighbour(found.id, behind)


def _smoothness_cost(found: Design, question: DesignSpec, stop: float) -> SmoothnessCost:
    """What splines smoother than C2 cost: the same question for those, solved too."""
    proof, rough = found.certificate, question.with_c2_splines()
    if rough is question:
        return smoothness_cost(proof, proof, "no spline smoother than C2 is asked for")
    if not found.motion or clock.now() >= stop:
        why = "this question has no cam" if not found.motion else "the time budget had ended"
        return smoothness_cost(proof, None, why)
    try:
        other = synthesise(rough, deadline=stop)
    except TimeBudgetExceeded as error:
        if error.best is None:
            return smoothness_cost(proof, None, "the time budget ended before there was a C2 cam")
        other = error.best
    except SolverFailed as error:
        return smoothness_cost(proof, None, str(error))
    if other.status == "infeasible":
        return smoothness_cost(proof, None, "no C2 cam was certified, although this one is")
    return smoothness_cost(proof, other.certificate, "")
