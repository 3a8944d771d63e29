"""synthesise(spec) -> Design: the whole way through on one page.

    DesignSpec -> Problem -> laws and size -> Motion -> certificate -> Design

The optimiser proposes, the certificate disposes: a cam that it does not certify is never called
feasible. ``attempt`` solves and certifies one question, ``largest_radius`` says which questions
come before and after it, ``conflict`` why nothing fits.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

from synthesis.design.design import Design, Effort, SmoothnessCost
from synthesis.errors import TimeBudgetExceeded
from synthesis.numerics import clock
from synthesis.optimise.state import WarmStart
from synthesis.pipeline.advice import with_warnings
from synthesis.pipeline.assembly import (
    design,
    in_wire_units,
    proofs,
    smoothness_cost,
    with_free_parameters,
)
from synthesis.pipeline.conflict import explain
from synthesis.pipeline.free_numbers import prove_over_free_numbers
from synthesis.pipeline.goal import Goal
from synthesis.pipeline.largest_radius import complete, first_attempt
from synthesis.spec.design_spec import DesignSpec


@dataclass(frozen=True, eq=False)
class Neighbour:
    """What a design leaves to a neighbouring one: its id, and where its local search ended."""

    id: str
    search: WarmStart


def synthesise(
    spec: DesignSpec, *, deadline: float | None = None, neighbours: list[Neighbour] | None = None
) -> Design:
    """Design the cam that a spec asks for.

    Args:
        spec: what is asked.
        deadline: ``time.monotonic()`` at which to stop; the spec's own budget counts as well.
        neighbours: designs made before: the search begins where the last one's ended, if that
            helps, and this design is appended. A design begun so has ``started_from`` and another
            id than the spec alone gives: its values may differ from that one's, within what its
            certificate says.

    Returns:
        the design. Its status is ``infeasible`` where that no cam fits is proven, and ``unsolved``
        where none was found; ``conflict`` says why.

    Raises:
        TimeBudgetExceeded: time ran out before the tolerance was reached; carries the best.
        SolverFailed: the spec leaves its spring free, and the linear program of the spring failed.
    """
    if spec.load is not None and spec.load.free_spring:
        from synthesis.optimise.parameters.spring_design import design_with_spring

        return design_with_spring(spec, lambda given: synthesise(given, deadline=deadline))
    began, budget = time.perf_counter(), clock.seconds_left(spec.time_budget_s, deadline)
    stages, stop = list[Effort](), clock.now() + budget
    near = neighbours[-1] if neighbours else None
    goal = Goal(stop, None if near is None else near.search)
    # 1. Solve and certify. A maximum of the base radius is compared with the smallest cam.
    first, known = first_attempt(spec, goal, stages)
    attempt, smallest = complete(spec, first, known, goal, stages)
    late = clock.now() >= stop
    if not attempt.certified and late and not (smallest and smallest.excludes):
        raise TimeBudgetExceeded(budget)
    # 2. Without a certified cam: why.
    conflict = None if attempt.certified else explain(spec, attempt, smallest, stop)
    if conflict is not None:
        conflict = prove_over_free_numbers(conflict, spec, attempt, smallest, goal, stages)
    # 3. Values, bounds and gaps in the units of the wire; the status follows from them.
    #    Questions on the way had objectives, tolerances and proofs of their own.
    question = attempt.question
    own = {name: getattr(question.physical, name) for name in ("objective", "tolerance", "proof")}
    final_spec = question.to_physical(attempt.final_spec).model_copy(update=own)
    bounds = in_wire_units(question, attempt.final_spec, attempt.bounds)
    objective_proofs = [] if attempt.cam is None else proofs(final_spec, attempt.cam, bounds)
    seconds = time.perf_counter() - began
    answer = design(
        final_spec, attempt.cam, attempt.extremes, objective_proofs, stages, seconds, conflict
    ).for_spec(question.physical)
    # What is proven of all numbers is of the question itself, whatever came after it.
    number_bounds = [] if first.number_bound is None else [first.number_bound]
    over_numbers = in_wire_units(question, attempt.final_spec, number_bounds)
    answer = with_free_parameters(answer, spec, attempt.chosen_values, over_numbers)
    if spec.report_smoothness_cost:
        cost = _smoothness_cost(answer, spec, stop)
        answer = answer.model_copy(update={"smoothness_cost": cost})
    if near is not None and any(state.warm_started for state in attempt.searches):
        answer = answer.with_warm_start(near.id)
    # 4. What an engineer would say of the cam.
    answer = with_warnings(answer)
    #    The report tells the time of the whole, that of summaries and warnings included.
    report = answer.report.model_copy(update={"seconds": time.perf_counter() - began})
    answer = answer.model_copy(update={"report": report})
    if late and answer.status == "feasible":
        raise TimeBudgetExceeded(budget, answer)
    local_optimum = attempt.searches[0].local_optimum if attempt.searches else None
    if neighbours is not None and local_optimum is not None:
        neighbours.append(Neighbour(answer.id, local_optimum))
    return answer


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
    if not other.motion:
        return smoothness_cost(proof, None, "no C2 cam was certified, although this one is")
    return smoothness_cost(proof, other.certificate, "")
