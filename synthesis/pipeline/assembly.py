"""The Design out of a cam, its certificate and its bounds: units and names of the wire."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import accumulate
from math import inf, isfinite
from typing import TypeVar

from synthesis.catalogue.motion import Motion, PlacedSegment
from synthesis.catalogue.objectives import Objective
from synthesis.certify import (
    certify,
    certify_size,
    measure_objective,
    report_forces,
    summarise_geometry,
    summarise_motion,
)
from synthesis.certify.quantities import MeasuredCam
from synthesis.design.assumptions import assumptions
from synthesis.design.design import (
    Certificate,
    Conflict,
    Design,
    Effort,
    Extreme,
    Proof,
    Report,
    SegmentMotion,
    SmoothnessCost,
    SplineCurve,
    Status,
    all_close,
)
from synthesis.design.identity import design_id, engine_version
from synthesis.optimise.problem.nondimensional import NondimensionalSpec
from synthesis.optimise.problem.problem import ObjectiveCap, Problem, formulate_problem
from synthesis.optimise.recovery.candidate import project_size
from synthesis.optimise.recovery.junction_repair import Splines, repair_junctions
from synthesis.spec.design_spec import DesignSpec
from synthesis.spec.program import Segment
from synthesis.units import Travel

Vector = tuple[float, ...]
ProofLine = TypeVar("ProofLine", bound=Proof)


@dataclass(frozen=True, eq=False)
class Cam:
    """A finished cam: segments with their laws, the splines of free ones by index, the size."""

    segments: tuple[PlacedSegment, ...]
    splines: Splines
    size: Vector

    @cached_property
    def motion(self) -> Motion:
        """The joined motion: bit for bit what ``Design.curve`` makes of the splines."""
        return Motion.of(self.segments)


@dataclass(frozen=True)
class Bounded:
    """An objective with the lower bound that was found [problem units; ``in_wire_units``: wire].

    ``valid_for``: the cams that it covers. ``infimum``: whether the bound is the open end of the
    size, and the cam as near to it as was sought.
    """

    objective: Objective
    lower: float
    valid_for: str
    infimum: bool = False


def to_physical_cam(question: NondimensionalSpec, solved_spec: DesignSpec, cam: Cam) -> Cam:
    """A cam in its question's own units, put into the wire's.

    Laws are kept, but for what joins them to the last digits; program and dimensions that are given
    are those of the spec.

    Args:
        question: the spec in both units. solved_spec: what was solved, in its own units.
        cam: its cam.
    """
    spec = question.to_physical(solved_spec)
    placed = tuple(
        replace(segment, law=own.law, free=own.free) if own.index in cam.splines else segment
        for segment, own in zip(spec.placed_segments(), cam.segments, strict=True)
    )
    joined = repair_junctions(placed, cam.splines)
    laws = {index: space.curve(coefficients) for index, (space, coefficients) in joined.items()}
    segments = tuple(s.with_law(laws[s.index]) if s.index in laws else s for s in placed)
    physical = Cam(segments, {**cam.splines, **joined}, ())
    return with_size(question, spec, physical, cam.size)


def with_size(question: NondimensionalSpec, spec: DesignSpec, cam: Cam, size: Vector) -> Cam:
    """A cam in the wire's units at a size in its question's own; dimensions that are given stay.

    Args:
        question: the spec in both units. spec: what was solved, on the wire.
        cam: its cam. size: size variables in the question's units.
    """
    problem = formulate_problem(spec, spec.objectives()[0], (), cam.segments, 0.0)
    return Cam(cam.segments, cam.splines, project_size(problem, question.size_to_physical(size)))


def in_wire_units(
    question: NondimensionalSpec, final_spec: DesignSpec, bounds: Iterable[Bounded]
) -> list[Bounded]:
    """Bounds [problem units] of a cam of the final spec, on the wire."""
    machine, converted = final_spec.machine(), list[Bounded]()
    for each in bounds:
        objective, known = each.objective, isfinite(each.lower)
        unit = question.units.of_field(objective.name_on_wire(machine))
        lower = unit * objective.to_wire(each.lower, machine) if known else -inf
        if known and objective.norm(machine) is not None:
            lower = max(lower, 0.0)  # of a base radius; conversions may round it below
        converted.append(replace(each, lower=lower))
    return converted


def restate_problem(
    question: NondimensionalSpec, solved_spec: DesignSpec, solved: Problem
) -> Problem:
    """A problem that was solved in its question's own units, in the core's of what was asked.

    Args:
        question: the spec in both units. solved_spec: what was solved, on the wire.
        solved: the problem.
    """
    held, machine = list[ObjectiveCap](), solved_spec.machine()
    for each in solved.objective_caps:
        unit = question.units.of_field(each.objective.name_on_wire(machine))
        value = unit * each.objective.to_wire(each.value, solved.machine)
        held.append(ObjectiveCap(each.objective, each.objective.from_wire(value, machine)))
    own = {segment.index: segment for segment in solved.segments}
    segments = [
        replace(s, law=own[s.index].law, free=own[s.index].free)
        if s.law is None and s.index in own
        else s
        for s in solved_spec.placed_segments()
    ]
    return formulate_problem(solved_spec, solved.objective, tuple(held), segments, 0.0)


def certify_cam(spec: DesignSpec, cam: Cam, final_spec: DesignSpec | None = None) -> list[Extreme]:
    """Every limit, every dimension and every promise of the motion, measured on the cam.

    ``final_spec`` is the spec with what was chosen after the size; None: nothing was.
    """
    motion, final_spec = cam.motion, final_spec or spec
    return [
        *certify(
            motion, final_spec.machine(), cam.size, final_spec.all_limits(), final_spec.continuity
        ),
        *certify_size(spec, cam.size, final_spec.follower),
    ]


def proofs(spec: DesignSpec, cam: Cam, bounds: Iterable[Bounded]) -> list[Proof]:
    """Value, bound and gap of every objective, in the wire's units."""
    machine, motion, proven = spec.machine(), cam.motion, []
    for bounded in bounds:
        objective = bounded.objective
        value = objective.to_wire(
            measure_objective(objective.quantity, motion, machine, cam.size).upper, machine
        )
        known = isfinite(bounded.lower)
        lower = _valid_bound(bounded.lower, value) if known else None
        gap = None if lower is None else relative_gap(value, lower)
        proven.append(
            Proof(
                objective=objective.name_on_wire(machine),
                value=value if isfinite(value) else None,
                lower_bound=lower,
                bound_valid_for=bounded.valid_for,
                gap=gap,
                infimum=bounded.infimum and lower is not None,
            )
        )
    return proven


def measured(answer: Design, objectives: Iterable[Objective]) -> dict[str, float]:
    """Values of further objectives on a finished design, by their names on the wire.

    What is infinite, as the peak jerk of a law that jumps, is left out.
    """
    if not answer.motion:
        return {}
    machine, values = answer.completed_spec.machine(), dict[str, float]()
    for objective in objectives:
        value = measure_objective(
            objective.quantity, answer.curve, machine, tuple(answer.size)
        ).value
        if isfinite(value):
            values[objective.name_on_wire(machine)] = objective.to_wire(value, machine)
    return values


def smoothness_cost(smooth: Proof, rough: Proof | None, note: str) -> SmoothnessCost:
    """What smoothness costs, from the first objective's proofs with it and without.

    A rougher cam that came out worse, within the tolerance, says that the price is not above 0.
    """
    value, other = smooth.value, None if rough is None else rough.value
    price = relative = at_most = None
    if value is not None and other is not None:
        price = max(value - other, 0.0)
        relative = 0.0 if price == 0.0 else price / max(abs(other), 1e-300)
    if rough is not None and value is not None and rough.lower_bound is not None:
        at_most = max(value - rough.lower_bound, 0.0)
    return SmoothnessCost(
        objective=smooth.objective, value=value, c2_value=other, price=price, relative=relative,
        at_most=at_most, note=note,
    )  # fmt: skip


def _valid_bound(lower: float, value: float) -> float | None:
    """The bound, if it is one: above the value it may lie by rounding only."""
    if not (isfinite(lower) and isfinite(value)) or lower > value + 1e-7 * abs(value):
        return None
    return min(lower, value)


def relative_gap(value: float, lower: float) -> float:
    """(value − lower)/|value|, 0 where both are 0."""
    return 0.0 if value == lower else max(value - lower, 0.0) / max(abs(value), 1e-300)


def segment_motions(
    program: Sequence[Segment],
    travel: Travel,
    placed_segments: Sequence[PlacedSegment],
    splines: Splines,
) -> list[SegmentMotion]:
    """The motion on the wire: by segment of the program, with its spline where it has one."""
    starts = accumulate((segment.degrees for segment in program), initial=0.0)
    s_start, s_end, unit = (f"{name}_{travel.unit}" for name in ("s_start", "s_end", "unit"))
    motions = []
    for placed, segment, start_deg in zip(placed_segments, program, starts, strict=False):
        spline = None
        if placed.index in splines:
            space, coefficients = splines[placed.index]
            spline = SplineCurve(
                degree=space.degree,
                knots=space.breaks.tolist(),
                coefficients=coefficients.tolist(),
                **{} if placed.table is None else {unit: placed.scale / travel.per_unit},
            )
        motions.append(
            SegmentMotion(
                kind=placed.kind,
                start_deg=start_deg,
                angle_deg=segment.degrees,
                law=segment.law_name,
                spline=spline,
                **{
                    s_start: placed.s_start / travel.per_unit,
                    s_end: placed.s_end / travel.per_unit,
                },
            )
        )
    return motions


def design(
    spec: DesignSpec,
    cam: Cam | None,
    extremes: Sequence[Extreme],
    objective_proofs: Sequence[Proof],
    stages: Sequence[Effort],
    seconds: float,
    conflict: Conflict | None,
) -> Design:
    """The Design; its status follows from the certificate, the gaps and the conflict's proof."""
    certified = cam is not None and all(extreme.holds for extreme in extremes)
    close = bool(objective_proofs) and all_close(objective_proofs, spec)
    status: Status = "optimal" if close else "feasible"
    if not certified:
        status = "infeasible" if conflict is not None and conflict.proven else "unsolved"
    # Where no objective is named, the size is what is asked for, and the rms jerk its condition.
    shown = objective_proofs if spec.objective is not None else objective_proofs[::-1]
    first = shown[0] if shown else _unproven(spec)
    body = None if spec.body is None else spec.body.on_shaft(spec.shaft_diameter_mm)
    finished = None if cam is None else MeasuredCam.of(cam.motion, spec.machine(), cam.size)
    return Design(
        id=design_id(spec),
        name=spec.name,
        engine_version=engine_version(),
        status=status,
        rotation=spec.rotation,
        speed_rpm=spec.speed_rpm,
        follower=spec.follower.kind,
        dimensions={} if cam is None else dimensions(spec, cam),
        size=[] if cam is None else list(cam.size),
        objectives={p.objective: p.value for p in objective_proofs if p.value is not None},
        motion=[]
        if cam is None
        else segment_motions(spec.program, spec.follower.travel, cam.segments, cam.splines),
        extremes=list(extremes),
        motion_summary=None if finished is None else summarise_motion(finished),
        geometry=None if finished is None else summarise_geometry(finished, spec.rotation, body),
        forces=None if cam is None else report_forces(cam.motion, spec.machine(), cam.size),
        certificate=Certificate(
            certified=certified, other_objectives=list(shown[1:]), **first.model_dump()
        ),
        conflict=conflict,
        report=Report(stages=list(stages), seconds=seconds),
        spec=spec,
        assumptions=assumptions(spec),
    )


def with_free_parameters(
    answer: Design, question: DesignSpec, numbers: Sequence[float], over_numbers: Sequence[Bounded]
) -> Design:
    """The answer to a question that leaves numbers free, from that with them in place.

    ``over_numbers``: bounds of the first objectives over all numbers [wire]. Those of the others
    say nothing of other numbers, so that with such a one it is feasible and no more.
    """
    if not numbers:
        return answer
    searched = question.free_parameters.parameters
    chosen = {parameter.field: value for parameter, value in zip(searched, numbers, strict=True)}
    proof = answer.certificate
    each = [proof, *proof.other_objectives]
    proven = [_with_bound_over_numbers(*pair) for pair in zip(each, over_numbers, strict=False)]
    first, *others = (*proven, *map(_limited_to_values, each[len(proven) :]))
    covered = [p.bound_valid_for for p in (first, *others)] == [b.valid_for for b in over_numbers]
    close = covered and all_close(proven, question)
    solved = answer.status in ("optimal", "feasible")
    return answer.model_copy(
        update={
            "id": design_id(question),
            "spec": question,
            "free_parameters": chosen,
            "assumptions": assumptions(question),
            "status": ("optimal" if close else "feasible") if solved else answer.status,
            "certificate": first.model_copy(update={"other_objectives": others}),
        }
    )


def _with_bound_over_numbers(proof: ProofLine, bounded: Bounded) -> ProofLine:
    """A proof with the bound over all numbers in place of that at those chosen."""
    lower = None if proof.value is None else _valid_bound(bounded.lower, proof.value)
    if lower is None or proof.value is None:
        return _limited_to_values(proof)
    infimum = proof.infimum and proof.lower_bound is not None and lower >= proof.lower_bound
    gap = relative_gap(proof.value, lower)
    changes = {"lower_bound": lower, "gap": gap, "bound_valid_for": bounded.valid_for}
    return proof.model_copy(update={**changes, "infimum": infimum})


def _limited_to_values(proof: ProofLine) -> ProofLine:
    """A proof whose bound was found with numbers chosen."""
    own = proof.bound_valid_for
    limited = f"{own}, at the chosen numbers alone" if own else ""
    return proof.model_copy(update={"bound_valid_for": limited})


def dimensions(spec: DesignSpec, cam: Cam) -> dict[str, float]:
    """Those of the size, and those that the motion asks for."""
    more = spec.follower.motion_dimensions(cam.motion, cam.size)
    return {**spec.follower.dimensions(cam.size), **more}


def _unproven(spec: DesignSpec) -> Proof:
    name = spec.main_objective().name_on_wire(spec.machine())
    return Proof(objective=name, value=None, lower_bound=None, bound_valid_for="", gap=None)
