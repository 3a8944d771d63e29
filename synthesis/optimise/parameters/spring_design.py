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
SAME: Final = 1e-3  # of the peak force: springs nearer than this are as good as one
Solver = Callable[[DesignSpec], Design]
Numbers = dict[str, float]


def design_with_spring(spec: DesignSpec, solve: Solver) -> Design:
    """The cam and its spring.

    Args:
        spec: with a load whose spring is free. solve: designs a cam with everything given.
    """
    load = spec.load
    assert load is not None

    def given(numbers: Numbers) -> DesignSpec:
        return spec.model_copy(update={"load": load.with_spring(numbers)})

    # 1. The cam without limits on forces: the spring, at its least, has no say in it.
    kept = [limit for limit in spec.limits if not limit.needs_load]
    numbers = {name: low for name, (low, _) in load.free_spring.items()}
    first = solve(given(numbers).model_copy(update={"limits": kept}))
    design, peak, stages = first, float("inf"), list[StageReport]()
    for _ in range(ROUNDS if first.motion else 0):
        # 2. The best spring for its motion; the end where that is no better than the last one.
        spring, chosen = _best_spring(spec, design)
        if design is not first and spring.peak >= peak * (1.0 - SAME):
            break
        # 3. The cam with this spring and all limits.
        candidate = solve(given(chosen))
        if design is not first and candidate.status == "infeasible":
            break
        design, numbers, peak = candidate, chosen, spring.peak
        stages.append(StageReport(**asdict(spring.stage)))
        if len(kept) == len(spec.limits) or not design.certificate.certified:
            break
    return _answer(spec, numbers, design, first, stages)


def _best_spring(spec: DesignSpec, design: Design) -> tuple[ChosenSpring, Numbers]:
    """The best spring for the motion of a cam, and its numbers that were free, as on the wire."""
    complete = design.completed_spec.model_copy(update={"load": spec.load})
    machine, load = complete.machine(), complete.load
    assert load is not None
    assert load.spring is not None
    assert machine.load is not None
    # Rate and preload along the displacement of one unit of each on the wire [N/mm, N].
    names = load.spring.requested
    reduced = load.with_spring(dict.fromkeys(names, 1.0)).reduced(complete.follower, 1.0)
    units = (reduced.rate, reduced.preload)
    rates, preloads = (
        (low * unit, high * unit)
        for (low, high), unit in zip(load.spring.ranges, units, strict=True)
    )
    forces = (limit for limit in spec.limits if isinstance(limit, ContactForce))
    floor = max((limit.min_n or 0.0 for limit in forces), default=0.0)
    size = tuple(design.size)
    program = SpringProgram(design.curve, machine, machine.load, size, rates, preloads, floor)
    spring = program.chosen()
    values = dict(zip(names, (spring.rate / units[0], spring.preload / units[1]), strict=True))
    free = load.free_spring.items()
    return spring, {name: min(max(values[name], low), high) for name, (low, high) in free}


def _answer(
    spec: DesignSpec, numbers: Numbers, design: Design, first: Design, stages: list[StageReport]
) -> Design:
    """The cam as the answer to the spec, with bounds that hold for every spring."""
    fields = {f"load/spring/{name}": value for name, value in numbers.items()}
    proofs = [design.certificate, *design.certificate.other_objectives]
    bounds = [first.certificate, *first.certificate.other_objectives]
    # in the order of the objectives; of no cam there is a single proof, which has no value
    for_all = [_for_all(one, other) for one, other in zip(proofs, bounds, strict=False)]
    certificate = Certificate(
        certified=design.certificate.certified,
        other_objectives=for_all[1:],
        **for_all[0].model_dump(),
    )
    close = all(p.gap is not None and p.gap <= spec.tolerance for p in for_all)
    status = design.status
    if status == "optimal" and not close:
        status = "feasible"
    report = design.report.model_copy(
        update={
            "stages": [*(first.report.stages if stages else ()), *stages, *design.report.stages],
            "seconds": design.report.seconds + (first.report.seconds if stages else 0.0),
        }
    )
    return design.model_copy(
        update={
            "id": design_id(spec), "spec": spec,
            "free_parameters": {**design.free_parameters, **fields},
            "certificate": certificate, "status": status, "report": report,
        }
    )  # fmt: skip


def _for_all(proof: Proof, without: Proof) -> Proof:
    """A proof with the bound that was found without limits on forces: it holds for any spring."""
    value, lower = proof.value, without.lower_bound
    own = Proof.model_validate(proof.model_dump(include=set(Proof.model_fields)))
    if value is None or lower is None or proof.lower_bound == lower:
        return own
    gap = max(value - lower, 0.0) / max(abs(value), 1e-300)
    over = f"{without.bound_valid_for}, any spring, without limits on forces"
    return own.model_copy(
        update={"lower_bound": min(lower, value), "gap": gap, "bound_valid_for": over}
    )
