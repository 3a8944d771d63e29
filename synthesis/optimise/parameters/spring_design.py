"""A cam whose closing spring is left free: motion and size first, then the spring, then both.

The spring has no say in the cam unless a limit on forces gives it one. So the cam is designed
without these limits, the best spring of its motion is a linear program, and the cam is designed
again with that spring and all limits; where they change it, spring and cam once more.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from typing import Final

from synthesis.catalogue.limits.forces import ContactForce
from synthesis.design.design import Certificate, Design, Proof, StageReport
from synthesis.design.identity import design_id
from synthesis.optimise.parameters.spring_program import ChosenSpring, SpringProgram
from synthesis.spec.design_spec import DesignSpec

ROUNDS: Final = 3  # of cam and spring
SAME: Final = 1e-3  # of the peak force: two springs that are as good as one
Solver = Callable[[DesignSpec], Design]
Numbers = dict[str, float]


def design_with_spring(question: DesignSpec, solve: Solver) -> Design:
    """The cam and its spring.

    Args:
        question: with a load whose spring is free. solve: designs a cam with everything given.
    """
    kept = [limit for limit in question.limits if not limit.needs_load]
    first = solve(_given(question, _least(question)).model_copy(update={"limits": kept}))
    if not first.motion:
        return _answer(question, _least(question), first, first, [])
    found, peak, chosen, stages = first, float("inf"), _least(question), list[StageReport]()
    for _ in range(ROUNDS):
        spring = _best(question, found)
        if found is not first and spring.peak >= peak * (1.0 - SAME):
            break
        tried = solve(_given(question, _wire(question, spring)))
        if found is not first and tried.status == "infeasible":
            break
        found, chosen, peak = tried, _wire(question, spring), spring.peak
        stages.append(StageReport(**asdict(spring.stage)))
        if len(kept) == len(question.limits) or not found.certificate.certified:
            break
    return _answer(question, chosen, found, first, stages)


def _least(question: DesignSpec) -> Numbers:
    """The free numbers of the spring at their least."""
    assert question.load is not None
    return {name: low for name, (low, _) in question.load.free_spring.items()}


def _given(question: DesignSpec, numbers: Numbers) -> DesignSpec:
    """The question with these numbers for its spring."""
    assert question.load is not None
    return question.model_copy(update={"load": question.load.with_spring(numbers)})


def _best(question: DesignSpec, found: Design) -> ChosenSpring:
    """The best spring for the motion of a cam."""
    built = found.completed_spec.model_copy(update={"load": question.load})
    machine = built.machine()
    load = built.load
    assert load is not None
    assert load.spring is not None
    assert machine.load is not None
    unit = _units(built)
    ranges = (
        (low * each, high * each)
        for (low, high), each in zip(load.spring.ranges, unit, strict=True)
    )
    rates, preloads = ranges
    forces = (limit for limit in question.limits if isinstance(limit, ContactForce))
    floor = max((limit.min_n or 0.0 for limit in forces), default=0.0)
    size = tuple(found.size)
    return SpringProgram(found.curve, machine, machine.load, size, rates, preloads, floor).chosen()


def _units(built: DesignSpec) -> tuple[float, float]:
    """Rate and preload along the displacement of one unit of each on the wire [N/mm, N]."""
    load = built.load
    assert load is not None
    assert load.spring is not None
    one = load.with_spring(dict.fromkeys(load.spring.requested, 1.0))
    reduced = one.reduced(built.follower, 1.0)
    return reduced.rate, reduced.preload


def _wire(question: DesignSpec, spring: ChosenSpring) -> Numbers:
    """The numbers that were free, in the units of the wire."""
    load = question.load
    assert load is not None
    assert load.spring is not None
    found = zip(load.spring.requested, (spring.rate, spring.preload), _units(question), strict=True)
    free = load.free_spring
    told = {name: value / unit for name, value, unit in found if name in free}
    return {name: min(max(told[name], low), high) for name, (low, high) in free.items()}


def _answer(
    question: DesignSpec, numbers: Numbers, found: Design, first: Design, stages: list[StageReport]
) -> Design:
    """The cam as the answer to the question, with bounds that hold for every spring."""
    fields = {f"load/spring/{name}": value for name, value in numbers.items()}
    proofs = [found.certificate, *found.certificate.other_objectives]
    bounds = [first.certificate, *first.certificate.other_objectives]
    # in the order of the objectives; of no cam there is a single proof, which has no value
    for_all = [_for_all(one, other) for one, other in zip(proofs, bounds, strict=False)]
    certificate = Certificate(
        certified=found.certificate.certified,
        other_objectives=for_all[1:],
        **for_all[0].model_dump(),
    )
    close = all(p.gap is not None and p.gap <= question.tolerance for p in for_all)
    status = found.status
    if status == "optimal" and not close:
        status = "feasible"
    report = found.report.model_copy(
        update={
            "stages": [*(first.report.stages if stages else ()), *stages, *found.report.stages],
            "seconds": found.report.seconds + (first.report.seconds if stages else 0.0),
        }
    )
    return found.model_copy(
        update={
            "id": design_id(question), "spec": question,
            "free_parameters": {**found.free_parameters, **fields},
            "certificate": certificate, "status": status, "report": report,
        }
    )  # fmt: skip


def _for_all(proof: Proof, without: Proof) -> Proof:
    """A proof with the bound that was found without limits on forces: it holds for any spring."""
    value, lower = proof.value, without.lower_bound
    told = Proof.model_validate(proof.model_dump(include=set(Proof.model_fields)))
    if value is None or lower is None or proof.lower_bound == lower:
        return told
    gap = max(value - lower, 0.0) / max(abs(value), 1e-300)
    over = f"{without.bound_valid_for}, any spring, without limits on forces"
    return told.model_copy(
        update={"lower_bound": min(lower, value), "gap": gap, "bound_valid_for": over}
    )
