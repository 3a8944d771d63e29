"""Why nothing fits, for a question that came out without a certified cam."""

from __future__ import annotations

from collections.abc import Sequence

from synthesis.catalogue.limits import Claim
from synthesis.catalogue.ranges import ends
from synthesis.design.design import Conflict, Extreme, Relaxation
from synthesis.numerics import clock
from synthesis.optimise.parameters.table_smoothing import smooth_tables
from synthesis.optimise.problem.nondimensional import NondimensionalSpec
from synthesis.optimise.recovery.smooth_limits import extremes_at
from synthesis.optimise.state.solve_state import SolveState
from synthesis.pipeline.assembly import restated
from synthesis.pipeline.attempt import TIGHTENINGS, solve_once
from synthesis.spec.design_spec import DesignSpec

DIAGNOSIS_S = 5.0  # for finding out why nothing fits; what is not known by then is said to be so


def explain(
    question: NondimensionalSpec,
    posed: DesignSpec,
    last: SolveState,
) -> Conflict:
    """Why nothing fits, with what the largest cam of the relaxation comes to: in wire units.

    Args:
        question: what was asked. posed: what was solved, in the question's own units.
        last: the search that found no cam, or none that the certificate accepts.
    """
    from synthesis.optimise.infeasibility.diagnosis import diagnose

    posed = question.to_physical(posed)
    problem = restated(question, posed, last.problem)

    def largest(claim: Claim) -> float | None:
        follower = last.problem.machine.follower
        if last.relaxed is None or claim.quantity != "pitch_curvature":
            return None
        if claim.path in follower.active_closure.counter_paths:
            return None  # a larger main cam leaves the counter cam no more room
        low, high = extremes_at(last.relaxed.problem, last.relaxed.size, claim.path)
        return (high if claim.upper is not None else low) / question.units.length

    until = min(last.deadline, clock.now() + DIAGNOSIS_S)
    found = diagnose(posed, problem, last.grids, largest, until)
    known = problem.base_circle_conflict or last.infeasibility_proof or last.undecided
    if known:
        found = found.model_copy(update={"evidence": f"{known}; {found.evidence}"})
    farther = _farther(question.physical, until)
    return found.model_copy(update={"relaxations": [*found.relaxations, *farther]})


def with_refusal(conflict: Conflict, extremes: Sequence[Extreme]) -> Conflict:
    """The conflict with the limits that the certificate refused on the cam at hand."""
    refused = [extreme for extreme in extremes if not extreme.holds]
    if not refused:
        return conflict
    values = ", ".join(f"{e.limit} {e.value} {e.unit} at {e.angle_deg:.3f}°" for e in refused)
    evidence = f"{conflict.evidence}; the certificate refused the cam at hand: {values}"
    names = [extreme.limit.replace("_", " ") for extreme in refused]
    new = [name for name in names if not any(one.startswith(name) for one in conflict.limits)]
    return conflict.model_copy(update={"evidence": evidence, "limits": [*conflict.limits, *new]})


def _farther(spec: DesignSpec, until: float) -> list[Relaxation]:
    """Where a counter roller would have to stand for the cam that is best without it."""
    opened = spec.with_free_deferred()
    if opened == spec:
        return []
    question = NondimensionalSpec.of(opened)
    tables = smooth_tables(question.scaled.placed_segments(), until)
    attempt = solve_once(question, tables, until, TIGHTENINGS[0], closely=True)
    if not attempt.certified or attempt.cam is None:
        return []
    built = question.to_physical(attempt.built)
    told, found = built.follower.dimensions(attempt.cam.size), list[Relaxation]()
    for place, (name, asked) in spec.follower.active_closure.counter_dimensions().items():
        low, high = ends(asked)
        if high < told[name]:
            found.append(
                Relaxation(
                    limit=name.rpartition("_")[0],
                    field=f"follower/{place}" + ("" if low == high else "/max"),
                    unit=name.rpartition("_")[2], requested=high, needed=told[name],
                    note="enough for the cam that is best without the counter cam",
                )
            )  # fmt: skip
    return found
