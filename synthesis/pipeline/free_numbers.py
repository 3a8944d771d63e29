"""What is proven of questions that leave angles and lifts free, over all their values.

A conflict is found with the numbers in place that were chosen. A cam that it names answers the
question with free numbers too; its proofs do not, for other numbers might do. Two proofs cover all
of them: the least base radius is larger than its maximum, and the least peak of a capped derivative
is larger than its cap. Each least value is bounded over all numbers, laws and sizes
(``optimise.parameters.number_search``).
"""

from __future__ import annotations

from collections.abc import Iterator

from synthesis.catalogue.limits.motion import DerivativeLimit
from synthesis.design.design import Conflict, Effort
from synthesis.pipeline.assembly import in_wire_units
from synthesis.pipeline.attempt import Attempt, prepare
from synthesis.pipeline.goal import Goal
from synthesis.pipeline.largest_radius import Smallest
from synthesis.pipeline.outwards import OBJECTIVE_OF
from synthesis.spec.design_spec import DesignSpec

ROUNDING = 1e-9  # relative: what a bound must lie above a limit by to exclude every cam
ROUGH = 2e-2  # tolerance of a search for a least peak: most caps are missed by more


def prove_over_free_numbers(
    conflict: Conflict,
    spec: DesignSpec,
    attempt: Attempt,
    smallest: Smallest | None,
    goal: Goal,
    stages: list[Effort],
) -> Conflict:
    """The conflict of a question, with what is proven over all of its free numbers.

    Args:
        conflict: found at the numbers chosen. spec: the question, its numbers free.
        attempt: what it came to. smallest: its smallest cam, where a maximum was compared with it.
        goal: when to stop. stages: appended to.
    """
    if not attempt.chosen_values:
        return conflict
    proof = next(_proofs(spec, smallest, goal, stages), "")
    fields = (parameter.field for parameter in spec.free_parameters.parameters)
    chosen = zip(fields, attempt.chosen_values, strict=True)
    words = ", ".join(f"{field} = {value:.6g}" for field, value in chosen)
    at_chosen = f"with {words}, the best numbers that were found: {conflict.evidence}"
    evidence = f"{proof}; {at_chosen}" if proof else at_chosen
    return conflict.model_copy(update={"proven": bool(proof), "evidence": evidence})


def _proofs(
    spec: DesignSpec, smallest: Smallest | None, goal: Goal, stages: list[Effort]
) -> Iterator[str]:
    """Why no numbers at all have a cam, as sentences."""
    if smallest is not None and smallest.excludes:
        least = f"{smallest.lower:.6g} mm ({smallest.valid_for})"
        yield f"proven: no cam has a base radius below {least}"
    capped = [limit for limit in spec.limits if isinstance(limit, DerivativeLimit)]
    for kind in ("jerk", "acceleration"):
        objective, caps = OBJECTIVE_OF[kind], [limit for limit in capped if limit.kind == kind]
        if not caps:
            continue
        others = [limit for limit in spec.limits if limit not in caps]
        changes = {"limits": others, "objective": objective, "tolerance": ROUGH, "proof": "auto"}
        prepared = prepare(spec.model_copy(update=changes), goal, stages)
        if prepared.number_bound is None:
            continue
        (bounded,) = in_wire_units(prepared.question, prepared.final_spec, [prepared.number_bound])
        most = min(limit.bound for limit in caps)
        if bounded.lower > most * (1.0 + ROUNDING):
            unit = spec.machine().derivative_unit(caps[0].order)
            yield (
                f"proven: the peak {kind} is {bounded.lower:.6g} {unit} at least "
                f"({bounded.valid_for})"
            )
