"""Design: what is delivered. It is the response body; files are made from it alone."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from functools import cache, cached_property
from importlib.metadata import version
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidatorFunctionWrapHandler, WrapValidator

from synthesis.fields import Rotation
from synthesis.forces.told import Forces
from synthesis.motion import Motion, Stretch, StretchKind
from synthesis.numerics.bspline import SplineSpace
from synthesis.spec import DesignSpec

Status = Literal["optimal", "feasible", "infeasible"]


class Part(BaseModel):
    """A part of an answer: frozen, and nothing in it that the contract does not name."""

    model_config = ConfigDict(frozen=True, extra="forbid")


def told(description: str) -> Any:
    """A required field with its description in the contract."""
    return Field(description=description)


class SplineCurve(Part):
    """A B-spline in normalised form: x = (θ − start)/angle in [0, 1], g(x) from 0 to 1.

    s = s_start + unit · g(x), where the unit is s_end − s_start unless it is told: a table has its
    own, and g ends at (s_end − s_start)/unit. Knots are without repetition; both ends are clamped.
    """

    degree: int = told("Polynomial degree p; p + 1 equal knots stand at either end.")
    knots: list[float] = told("Knots in x from 0 to 1, each once.")
    coefficients: list[float] = told("B-spline coefficients of g: knots − 1 + degree of them.")
    unit_mm: float | None = Field(None, description="Length of g = 1 in a table; null: the lift.")
    unit_deg: float | None = Field(None, description="The same of a follower on an arm.")


class SegmentMotion(Part):
    """One segment of the motion as it came out."""

    kind: StretchKind = told("What the follower does; `table` where it moves both ways.")
    start_deg: float = told("Cam angle where the segment starts.")
    angle_deg: float = told("Cam angle of the segment.")
    s_start_mm: float | None = Field(
        None, description="Displacement at its start, measured from the lowest position."
    )
    s_end_mm: float | None = Field(None, description="Displacement at its end.")
    s_start_deg: float | None = Field(
        None, description="The same of a follower on an arm: the angle that it has swung."
    )
    s_end_deg: float | None = Field(None, description="Angle that it has swung at its end.")
    law: str = told("Name of the law; `spline` where it was chosen here, `table` if smoothed.")
    spline: SplineCurve | None = Field(None, description="The law where it was chosen here.")

    @property
    def levels(self) -> tuple[float, float]:
        """Displacement at its start and end, in the unit of the follower's travel."""
        start = self.s_start_deg if self.s_start_mm is None else self.s_start_mm
        end = self.s_end_deg if self.s_end_mm is None else self.s_end_mm
        return start or 0.0, end or 0.0


class Extreme(Part):
    """One limit on the finished cam: how far it is used, where, and how that is known."""

    limit: str = told("The limit; one of the spec's, or one that every cam must keep.")
    value: float | None = told("Extreme over all cam angles; null: none, or infinite.")
    unit: str = told("Unit of value, bound, margin and width.")
    angle_deg: float = told("Cam angle where the extreme occurs.")
    bound: float | None = told("What the spec allows.")
    margin: float | None = told("Distance to the bound, negative where it is broken.")
    width: float = told("Width of the proven enclosure of the extreme.")
    holds: bool = told("Margin not below the enclosure's width: proven at every cam angle.")
    evidence: str = told("How the extreme was enclosed.")
    field: str = told("Field of the spec that sets the bound.")


class Proof(Part):
    """How far one objective is from the best possible."""

    objective: str = told("Name of the objective's value, with its unit.")
    value: float | None = told("Value of the finished cam.")
    lower_bound: float | None = told("No cam of the family in bound_over is better than this.")
    bound_over: str = told("The family of cams that the bound covers.")
    gap: float | None = told("(value − lower_bound) / value.")


class Certificate(Proof):
    """What was proven of the answer, for the first objective and in `also` for the others."""

    certified: bool = told("Every limit holds at every cam angle.")
    also: list[Proof] = Field(
        [],
        description="Later objectives of an ordered list; their bounds hold for cams that keep "
        "the earlier ones.",
    )


class SmoothnessPrice(Part):
    """What splines smoother than C2 cost, by the first objective."""

    objective: str = told("Name of the objective's value, with its unit.")
    value: float | None = told("Value of this cam.")
    c2_value: float | None = told(
        "Value of the certified cam that the same question has with splines of class C2."
    )
    price: float | None = told("value − c2_value: what smoothness costs as far as cams were found.")
    relative: float | None = told("The same, of c2_value.")
    at_most: float | None = told(
        "Value − the lower bound of the C2 question: no C2 cam of that family saves more."
    )
    note: str = Field("", description="Why there is no price, or what it is worth.")


class StageReport(Part):
    """One stage of the ladder: what was modelled and what it cost."""

    stage: str = told("closed form, convex (with the round's number) or nonlinear.")
    model: str = told("Class of the model: half-planes, LP, QP, SOCP or NLP.")
    solver: str = told("Which solver, if any.")
    unknowns: int = told("Number of unknowns.")
    rows: int = told("Number of rows, those of cones included.")
    iterations: int = told("Iterations of the solver, all calls of the stage.")
    seconds: float = told("Wall time of the stage.")
    status: str = told("Why the solver stopped; the certificate alone says what that is worth.")
    note: str = Field("", description="Anything else worth knowing.")


class Report(Part):
    """Stage by stage, and the whole."""

    stages: list[StageReport] = told("In the order they ran.")
    seconds: float = told("Wall time of the whole design in the core.")


class Relaxation(Part):
    """The least change of one limit, the others kept, that would make the scene possible."""

    limit: str = told("Name of the limit.")
    field: str = told("Where its value stands in the spec.")
    unit: str = told("Unit of asked and needed.")
    asked: float = told("What the spec says.")
    needed: float | None = told("Least sufficient value; null where it alone cannot help.")
    note: str = Field("", description="Why there is no value, or what it is worth.")


class Conflict(Part):
    """Why nothing fits, and what would."""

    limits: list[str] = told("The limits that cannot hold together.")
    relaxations: list[Relaxation] = told("For each limit, what it would have to be.")
    evidence: str = told("How the conflict is known, and whether it is proven.")


def _checked_once(value: Any, check: ValidatorFunctionWrapHandler) -> Any:
    """A spec that has been made is in order: placing its program once more would prove nothing."""
    return value if type(value) is DesignSpec else check(value)


class Design(Part):
    """The answer to a DesignSpec."""

    id: str = told("Hash of the spec and the engine's version.")
    name: str = told("Name from the spec.")
    engine_version: str = told("Version of Camwright that made it.")
    status: Status = told(
        "optimal: certified, every gap within the tolerance; feasible: certified; "
        "infeasible: no certified cam."
    )
    rotation: Rotation = told("Sense in which the cam turns.")
    speed_rpm: float = told("Cam speed.")
    follower: str = told("Kind of the follower.")
    dimensions: dict[str, float] = told("Base radius, prime radius, offset, … by name and unit.")
    size: list[float] = told("The follower's size variables; their names: /v1/followers.")
    objectives: dict[str, float] = told("Value of every objective asked.")
    motion: list[SegmentMotion] = told("The motion, segment by segment.")
    extremes: list[Extreme] = told("Every limit, measured on the finished cam.")
    forces: Forces | None = Field(
        None, description="Forces of the finished cam, where the spec tells its load."
    )
    certificate: Certificate = told("What was proven.")
    smoothness_price: SmoothnessPrice | None = Field(
        None, description="What smoothness costs, where the spec asks for it."
    )
    conflict: Conflict | None = Field(None, description="Why nothing fits, where nothing does.")
    report: Report = told("What was modelled and what it cost.")
    spec: Annotated[DesignSpec, WrapValidator(_checked_once)] = told("The question.")
    chosen: dict[str, float] = Field(
        {}, description="Angles, lifts and lengths that the spec leaves free: path and number."
    )
    started_from: str | None = Field(
        None,
        description="In a sweep with warm starts: id of the design at which the local search "
        "began. Values may then differ from those of the spec alone, within the gap; the id is "
        "that of the spec begun so.",
    )
    links: dict[str, str] = Field({}, description="Where to find its files.")

    def begun_at(self, other: str) -> Design:
        """The same design, told to have begun at another one."""
        name = question_id(self.spec, "begun at", other)
        return self.model_copy(update={"id": name, "started_from": other})

    def asked_as(self, spec: DesignSpec) -> Design:
        """The same design as the answer to a spec that left more open."""
        if spec is self.spec or spec == self.spec:
            return self
        return self.model_copy(update={"spec": spec, "id": design_id(spec)})

    @cached_property
    def built(self) -> DesignSpec:
        """The question with what was settled after the size, such as a counter roller's place."""
        return self.numbered.built(self.dimensions)

    @cached_property
    def numbered(self) -> DesignSpec:
        """The question with the numbers in place that it leaves free."""
        openings = self.spec.openings.free if self.chosen else ()
        numbers = [self.chosen[opening.field] for opening in openings]
        spec = self.spec.with_numbers(numbers) if numbers else self.spec
        if spec.load is None or not self.chosen:
            return spec
        named = {name: f"load/spring/{name}" for name in spec.load.free}
        spring = {name: self.chosen[key] for name, key in named.items() if key in self.chosen}
        return spec.model_copy(update={"load": spec.load.with_spring(spring)})

    @cached_property
    def curve(self) -> Motion:
        """The motion, rebuilt to the last bit from the spec and the spline coefficients."""
        return rebuilt(self.numbered.stretches(), self.motion)


def rebuilt(stretches: Sequence[Stretch], told: Sequence[SegmentMotion]) -> Motion:
    """The motion of a program from what an answer tells of it, to the last bit."""
    settled: list[Stretch] = []
    for stretch, segment in zip(stretches, told, strict=True):
        if segment.spline is None:
            settled.append(stretch)
            continue
        space = SplineSpace(segment.spline.degree, np.array(segment.spline.knots))
        curve = space.curve(np.array(segment.spline.coefficients))
        settled.append(stretch.with_law(curve))
    return Motion.of(settled)


@cache
def engine_version() -> str:
    """Version of the installed distribution."""
    return version("camwright")


def design_id(spec: DesignSpec) -> str:
    """The design's id on this engine."""
    return question_id(spec)


def question_id(spec: BaseModel, *kind: str) -> str:
    """Hash of a question and the engine's version: the same question has the same name.

    ``kind`` keeps questions of different kinds apart.
    """
    lines = "\n".join((*kind, engine_version(), spec.model_dump_json()))
    return hashlib.sha256(lines.encode()).hexdigest()[:32]
