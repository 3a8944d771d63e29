"""Design: what is delivered. It is the response body; files are made from it alone."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from synthesis.catalogue.fields import CHECKED_ONCE, AnswerModel, Rotation, doc
from synthesis.catalogue.motion import Motion, PlacedSegment, SegmentKind
from synthesis.design.identity import design_id, question_id
from synthesis.design.jupyter import ShownByJupyter
from synthesis.design.summary import CamGeometry, MotionSummary
from synthesis.design.warnings import DesignWarning, Severity
from synthesis.numerics.bspline import SplineSpace
from synthesis.spec.design_spec import DesignSpec


class ForcePeak(AnswerModel):
    """A largest or smallest value, proven for every cam angle."""

    value: float = doc("The value.")
    angle_deg: float = doc("Cam angle where it is reached.")
    width: float = doc("Width of the proven enclosure of the value.")


class FlankForces(AnswerModel):
    """What one flank of the cam bears."""

    flank: str = doc("Name of the flank; empty where the cam has one.")
    largest_n: ForcePeak | None = doc("Largest contact force; null where it is infinite.")
    smallest_n: ForcePeak | None = doc(
        "Smallest contact force: where it is not positive, this flank does not touch."
    )
    largest_pressure_mpa: ForcePeak | None = doc(
        "Largest Hertz pressure; null where it is infinite or no line contact is given."
    )


class Torque(AnswerModel):
    """Torque on the camshaft at constant speed, positive where the cam has to be driven."""

    largest_n_m: ForcePeak | None = doc("Largest torque; null where it is infinite.")
    smallest_n_m: ForcePeak | None = doc(
        "Smallest torque, negative where the cam drives its shaft."
    )
    mean_n_m: float = doc("Mean over the turn.")
    rms_n_m: float = doc("Root mean square over the turn.")
    power_w: float = doc("Mean power at the camshaft.")
    work_j: float = doc("Work of the camshaft in one turn: mean torque times 2π.")
    process_work_j: float = doc("Work done against the process force in one turn.")
    loss_j: float = doc("Work lost to damping and friction in one turn.")
    balance_error_j: float = doc("What these three differ by: rounding, and nothing else.")


class FloatArc(AnswerModel):
    """Where a force-closed follower leaves its cam: the contact force would have to be negative."""

    start_deg: float = doc("Cam angle where contact is lost.")
    end_deg: float = doc("Cam angle where the force is positive again.")
    lowest_n: float = doc("Lowest contact force on the way, which the spring lacks.")
    angle_deg: float = doc("Cam angle of the lowest.")


class RollerLife(AnswerModel):
    """How a roller turns, and how long its bearing lasts."""

    path: str = doc("Which roller; empty where there is one.")
    mean_speed_rpm: float = doc("Mean speed on its pin, rolling without slip.")
    largest_speed_rpm: float = doc("Largest speed on its pin.")
    equivalent_load_n: float | None = doc("Constant load of the same life; null: no bearing given.")
    life_million_turns: float | None = doc("L10 in million turns of the roller.")
    life_hours: float | None = doc("L10 in hours.")


class Forces(AnswerModel):
    """Rigid-body forces of the finished cam at its speed."""

    flanks: list[FlankForces] = doc("What each flank bears.")
    torque: Torque = doc("Torque on the camshaft.")
    floats: list[FloatArc] = doc("Where the follower leaves its cam; empty where it never does.")
    float_onset_rpm: float | None = doc(
        "Lowest speed from which it leaves its cam somewhere; null: at none up to a million times "
        "the cam's, or it is pushed both ways."
    )
    changes_flank_deg: list[float] = doc(
        "Cam angles at which a follower that is pushed both ways changes from one flank to the "
        "other."
    )
    rollers: list[RollerLife] = doc("The rollers.")


Status = Literal["optimal", "feasible", "unsolved", "infeasible"]
WITHOUT_CAM: tuple[Status, ...] = ("unsolved", "infeasible")
"""Statuses of answers that have no cam on which every limit holds."""


class SplineCurve(AnswerModel):
    """A B-spline in normalised form: x = (θ − start)/angle in [0, 1], g(x) from 0 to 1.

    s = s_start + unit · g(x), where the unit is s_end − s_start unless it is given: a table has its
    own, and g ends at (s_end − s_start)/unit. Knots are without repetition; both ends are clamped.
    """

    degree: int = doc("Polynomial degree p; p + 1 equal knots stand at either end.")
    knots: list[float] = doc("Knots in x from 0 to 1, each once.")
    coefficients: list[float] = doc("B-spline coefficients of g: knots − 1 + degree of them.")
    unit_mm: float | None = Field(None, description="Length of g = 1 in a table; null: the lift.")
    unit_deg: float | None = Field(None, description="The same of a follower on an arm.")


class SegmentMotion(AnswerModel):
    """One segment of the motion as it came out."""

    kind: SegmentKind = doc("What the follower does; `table` where it moves both ways.")
    start_deg: float = doc("Cam angle where the segment starts.")
    angle_deg: float = doc("Cam angle of the segment.")
    s_start_mm: float | None = Field(
        None, description="Displacement at its start, measured from the lowest position."
    )
    s_end_mm: float | None = Field(None, description="Displacement at its end.")
    s_start_deg: float | None = Field(
        None, description="The same of a follower on an arm: the angle that it has swung."
    )
    s_end_deg: float | None = Field(None, description="Angle that it has swung at its end.")
    law: str = doc("Name of the law; `spline` where it was chosen here, `table` if smoothed.")
    spline: SplineCurve | None = Field(None, description="The law where it was chosen here.")

    @property
    def levels(self) -> tuple[float, float]:
        """Displacement at its start and end, in the unit of the follower's travel."""
        start = self.s_start_deg if self.s_start_mm is None else self.s_start_mm
        end = self.s_end_deg if self.s_end_mm is None else self.s_end_mm
        return start or 0.0, end or 0.0


class Extreme(AnswerModel):
    """One limit on the finished cam: how far it is used, where, and how that is known."""

    limit: str = doc("The limit; one of the spec's, or one that every cam must keep.")
    value: float | None = doc("Extreme over all cam angles; null: none, or infinite.")
    unit: str = doc("Unit of value, bound, margin and width.")
    angle_deg: float = doc("Cam angle where the extreme occurs.")
    bound: float | None = doc("What the spec allows.")
    margin: float | None = doc("Distance to the bound, negative where it is broken.")
    width: float = doc("Width of the proven enclosure of the extreme.")
    holds: bool = doc("Margin not below the enclosure's width: proven at every cam angle.")
    evidence: str = doc("How the extreme was enclosed.")
    field: str = doc("Field of the spec that sets the bound.")


class Proof(AnswerModel):
    """How far one objective is from the best possible."""

    objective: str = doc("Name of the objective's value, with its unit.")
    value: float | None = doc("Value of the finished cam.")
    lower_bound: float | None = doc("No cam of the family in bound_valid_for is better than this.")
    bound_valid_for: str = doc("The family of cams that the bound covers.")
    gap: float | None = doc("(value − lower_bound) / value.")
    infimum: bool = Field(
        False,
        description="Whether the base radius is open below and lower_bound is its open end. No cam "
        "has that base radius; there are cams at least as near to it as this one, so that the "
        "infimum lies between lower_bound and value. Then the gap says nothing.",
    )


def all_close(proven: Sequence[Proof], spec: DesignSpec) -> bool:
    """Whether the gap of every objective of a spec is within what that may lose."""
    machine, tolerance = spec.machine(), spec.tolerance
    allowed = {o.name_on_wire(machine): o.allowed_gap(tolerance) for o in spec.objectives()}
    return all(p.gap is not None and p.gap <= allowed[p.objective] for p in proven)


class Certificate(Proof):
    """What was proven of the first objective, and in `other_objectives` of the others.

    Where none is named, of the base radius first.
    """

    certified: bool = doc("Every limit holds at every cam angle.")
    other_objectives: list[Proof] = Field(
        [],
        description="Later objectives of an ordered list; their bounds hold for cams that keep "
        "the earlier ones. Where no objective is named, the rms jerk that the base radius leaves.",
    )


class SmoothnessCost(AnswerModel):
    """What splines smoother than C2 cost, by the first objective."""

    objective: str = doc("Name of the objective's value, with its unit.")
    value: float | None = doc("Value of this cam.")
    c2_value: float | None = doc(
        "Value of the certified cam that the same question has with splines of class C2."
    )
    price: float | None = doc("value − c2_value: what smoothness costs as far as cams were found.")
    relative: float | None = doc("The same, of c2_value.")
    at_most: float | None = doc(
        "Value − the lower bound of the C2 question: no C2 cam of that family saves more."
    )
    note: str = Field("", description="Why there is no price, or what it is worth.")


class Effort(AnswerModel):
    """One stage: what was modelled, what it cost, and the gap that was left after it."""

    stage: str = doc(
        "What was done: a closed form; convex (the relaxation on one mesh, with its number); "
        "tangents or nonlinear (local searches); implied rows (branch and bound); others by name."
    )
    model: str = doc("Class of the model: half-planes, LP, QP, SOCP or NLP.")
    solver: str = doc("Which solver, if any.")
    unknowns: int = doc("Number of unknowns.")
    rows: int = doc("Number of rows, those of cones included.")
    iterations: int = doc("Iterations of the solver, all calls of the stage.")
    seconds: float = doc("Wall time of the stage, without that of stages inside it.")
    status: str = doc("Why the solver stopped; the certificate alone says what that is worth.")
    note: str = Field("", description="Anything else worth knowing.")
    nodes: int = Field(
        0, description="Nodes of the branch and bound processed; 0: the domain was not divided."
    )
    gap: float | None = Field(
        None, description="Gap of the best cam to the best bound after it; null: one is not known."
    )
    exit: str = Field(
        "",
        description="Why the search ended, in its last stage: tolerance (the gap is within it), "
        "budget of the proof (see `proof`), node limit, time, or what else there was nothing to "
        "do for. Empty: it went on.",
    )


class Report(AnswerModel):
    """What was bought with what time: stage by stage, and the whole."""

    stages: list[Effort] = doc("In the order they ran.")
    seconds: float = doc("Wall time of the whole design in the core.")


class Relaxation(AnswerModel):
    """What one number of the spec would have to be, all others kept."""

    limit: str = doc("Name of the limit.")
    field: str = doc("Where its value stands in the spec.")
    unit: str = doc("Unit of requested and needed.")
    requested: float = doc("What the spec says.")
    needed: float | None = doc(
        "A value that suffices: the spec with it in place of the requested one has a certified "
        "cam. The nearest to the requested one that was found; null where none was, or there was "
        "no time."
    )
    at_least: float | None = Field(
        None,
        description="No value between the requested one and this suffices: proven for all laws, "
        "sizes and free numbers. Null where nothing is proven.",
    )
    note: str = Field("", description="Why there is no value, or what it is worth.")


class Conflict(AnswerModel):
    """Numbers of the spec that have no cam together, and what each would have to be."""

    limits: list[str] = doc(
        "Limits and dimensions with which no cam was found, though without any one of them one "
        "was; and limits that every cam must keep."
    )
    relaxations: list[Relaxation] = doc(
        "For each of them that the spec sets: what it would have to be."
    )
    program_changes: list[Relaxation] = Field(
        [],
        description="Changes of the program or the speed, by a half or less, that mend the "
        "conflict with all limits as they are: a segment's angle at a dwell's cost, all lifts in "
        "proportion, an end of a range. Those of one `limit` change together.",
    )
    evidence: str = doc("How the conflict is known, and what a proof of it covers.")
    proven: bool = doc(
        "Whether a theorem excludes every cam: all laws that are free, all sizes, all free "
        "numbers. If not, the status is `unsolved`: no cam was found."
    )
    unconfirmed: list[str] = Field(
        [],
        description="Those of `limits` that may be idle: without one of them, neither a cam was "
        "found nor a proof that there is none.",
    )


class Design(AnswerModel, ShownByJupyter):
    """The answer to a DesignSpec."""

    id: str = doc("Hash of the spec and the engine's version.")
    name: str = doc("Name from the spec.")
    engine_version: str = doc("Version of Camwright that made it.")
    status: Status = doc(
        "optimal: certified, every gap within the tolerance or its allowance; feasible: certified; "
        "unsolved: no cam was found, and none is excluded; infeasible: proven that there is none."
    )
    severity: Severity = Field(
        "none",
        description="That of the worst warning. `stop`: the cam cannot work, whatever the status "
        "says of the question as it was put.",
    )
    warnings: list[DesignWarning] = Field(
        [], description="What an engineer would say of the cam, the most severe first."
    )
    rotation: Rotation = doc("Sense in which the cam turns.")
    speed_rpm: float = doc("Cam speed.")
    follower: str = doc("Kind of the follower.")
    dimensions: dict[str, float] = doc("Base radius, prime radius, offset, … by name and unit.")
    size: list[float] = doc("The follower's size variables; their names: /v1/followers.")
    objectives: dict[str, float] = doc("Value of every objective asked.")
    motion: list[SegmentMotion] = doc("The motion, segment by segment.")
    extremes: list[Extreme] = doc("Every limit, measured on the finished cam.")
    motion_summary: MotionSummary | None = Field(
        None, description="Peaks, rms, coefficients and jumps; null without a cam."
    )
    geometry: CamGeometry | None = Field(
        None, description="Radii, perimeter, area, mass properties; null without a cam."
    )
    forces: Forces | None = Field(
        None, description="Forces of the finished cam, where the spec tells its load."
    )
    certificate: Certificate = doc("What was proven.")
    smoothness_cost: SmoothnessCost | None = Field(
        None, description="What smoothness costs, where the spec asks for it."
    )
    conflict: Conflict | None = Field(None, description="Why nothing fits, where nothing does.")
    report: Report = doc("What was modelled and what it cost.")
    spec: Annotated[DesignSpec, CHECKED_ONCE] = doc("The question.")
    assumptions: list[str] = Field(
        [], description="What was assumed where the spec says nothing, and how to ask otherwise."
    )
    free_parameters: dict[str, float] = Field(
        {}, description="Angles, lifts and lengths that the spec leaves free: path and number."
    )
    started_from: str | None = Field(
        None,
        description="In a sweep with warm starts: id of the design at which the local search "
        "began. Values may then differ from those of the spec alone, within the gap; the id is "
        "that of the spec begun so.",
    )
    links: dict[str, str] = Field({}, description="Where to find its files.")

    def with_warm_start(self, other: str) -> Design:
        """The same design with the id of the design that its search started from."""
        name = question_id(self.spec, "begun at", other)
        return self.model_copy(update={"id": name, "started_from": other})

    def for_spec(self, spec: DesignSpec) -> Design:
        """The same design as the answer to a spec with more free values."""
        if spec is self.spec or spec == self.spec:
            return self
        return self.model_copy(update={"spec": spec, "id": design_id(spec)})

    @cached_property
    def completed_spec(self) -> DesignSpec:
        """The resolved spec with what is chosen after the size, as a counter roller's place."""
        return self.resolved_spec.with_deferred(self.dimensions)

    @cached_property
    def resolved_spec(self) -> DesignSpec:
        """The spec with the chosen values of its free parameters."""
        chosen = self.free_parameters
        if not chosen:
            return self.spec
        fields = [parameter.field for parameter in self.spec.free_parameters.parameters]
        spec = self.spec.with_values([chosen[field] for field in fields])
        if spec.load is None:
            return spec
        spring = {name: chosen.get(f"load/spring/{name}") for name in spec.load.free_spring}
        known = {name: value for name, value in spring.items() if value is not None}
        return spec.model_copy(update={"load": spec.load.with_spring(known)})

    @cached_property
    def curve(self) -> Motion:
        """The motion, rebuilt to the last bit from the spec and the spline coefficients."""
        return rebuild_motion(self.resolved_spec.placed_segments(), self.motion)


def rebuild_motion(segments: Sequence[PlacedSegment], delivered: Sequence[SegmentMotion]) -> Motion:
    """The motion of placed segments with the splines of an answer, to the last bit."""
    placed = []
    for segment, answer in zip(segments, delivered, strict=True):
        if answer.spline is not None:
            space = SplineSpace(answer.spline.degree, np.array(answer.spline.knots))
            segment = segment.with_law(space.curve(np.array(answer.spline.coefficients)))
        placed.append(segment)
    return Motion.of(placed)
