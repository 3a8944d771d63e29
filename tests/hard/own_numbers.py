"""An answer's own numbers put back as limits: the cam at hand satisfies them, so one must be found.

``make hard ARGS=own`` asks all questions. A question counts only where the certificate confirms
that the answer's own cam, or the same cam a little larger, keeps every limit of it.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from copy import deepcopy
from dataclasses import dataclass

from synthesis import DesignSpec, synthesise
from synthesis.catalogue.constraints import enlarged
from synthesis.certify import certify, certify_size
from synthesis.design.design import Design
from synthesis.errors import TimeBudgetExceeded
from tests.hard.families import Spec, random_scene

BUDGET_S = 15.0
SCENES = 2
SPARE = (0.0, 1e-6, 1e-4, 5e-2)  # relative: by how much a maximum lies above the answer's own value
LARGER = 0.02  # relative: a fixed base radius above the answer's own
ROUNDING = 1e-9  # relative: what an extreme as a limit needs for enclosures and units


@dataclass(frozen=True)
class Question:
    """A spec that a known cam satisfies; ``value`` is the base radius of that cam [mm]."""

    family: str
    number: int
    kind: str
    body: Spec
    value: float


@dataclass(frozen=True)
class Outcome:
    """What a question came to; ``needed``: a least base radius named below what was asked."""

    question: Question
    status: str
    seconds: float
    gap: float | None
    open_seconds: float
    needed: float | None = None

    @property
    def false(self) -> bool:
        """Whether a cam is denied that exists."""
        return self.status == "infeasible"


def solved(body: Spec) -> tuple[str, Design | None, float]:
    """Status, design and processor time of a spec."""
    start = time.process_time()
    design: Design | None
    try:
        design = synthesise(DesignSpec.model_validate({"time_budget_s": BUDGET_S, **body}))
        status: str = design.status
    except TimeBudgetExceeded as late:
        status, design = "late", late.best
    except Exception as error:  # reported as a row of its own
        status, design = f"{type(error).__name__}: {error}", None
    return status, design, time.process_time() - start


def questions(family: str, number: int, body: Spec, answer: Design) -> Iterator[Question]:
    """Every question of a scene that its answer's own cam is known to satisfy."""
    size = tuple(answer.size)
    radius = answer.dimensions["base_radius_mm"]
    request: list[tuple[str, Spec, tuple[float, ...]]] = []
    for spare in SPARE:
        most = {"max": radius * (1.0 + spare)}
        request.append((f"maximum +{spare:g}", {**body, "base_radius_mm": most}, size))
    request.append(("fixed", {**body, "base_radius_mm": radius}, size))
    larger = enlarged(size, LARGER * radius)
    fixed = answer.completed_spec.follower.dimensions(larger)["base_radius_mm"]
    request.append(("fixed, larger", {**body, "base_radius_mm": fixed}, larger))
    tight = _extremes_as_limits(body, answer)
    request.append(("extremes", tight, size))
    both = {**tight, "base_radius_mm": {"max": radius * (1.0 + 1e-3)}}
    request.append(("extremes and maximum", both, size))
    for kind, question, known in request:
        if _keeps(answer, DesignSpec.model_validate(question), known):
            yield Question(family, number, kind, question, radius)


def _extremes_as_limits(body: Spec, answer: Design) -> Spec:
    """The scene with every limit's number at the extreme that the answer's cam comes to."""
    found = deepcopy(body)
    reached: dict[str, float] = {}
    for extreme in answer.extremes:
        if extreme.field.startswith("limits/") and extreme.value is not None:
            *_, name = extreme.field.split("/")
            sign = -1.0 if name.startswith("min_") else 1.0
            value = sign * (abs(extreme.value) * sign + extreme.width) * (1.0 + sign * ROUNDING)
            worst = reached.get(extreme.field, value)
            reached[extreme.field] = sign * max(sign * worst, sign * value)
    for field, value in reached.items():
        _, position, name = field.split("/")
        limit = found["limits"][int(position)]
        if isinstance(limit.get(name), (int, float)) and value > 0.0:
            limit[name] = min(value, limit[name]) if not name.startswith("min_") else value
    return found


def _keeps(answer: Design, question: DesignSpec, size: tuple[float, ...]) -> bool:
    """Whether the certificate confirms the answer's laws at this size under other limits."""
    update = {"limits": question.limits, "base_radius_mm": question.base_radius_mm}
    built = answer.completed_spec.model_copy(update=update)
    extremes = certify(answer.curve, built.machine(), size, built.all_limits(), built.continuity)
    extremes += certify_size(built, size, built.follower)
    return all(extreme.holds for extreme in extremes)


def ask(question: Question, open_seconds: float) -> Outcome:
    """Put a question."""
    status, design, seconds = solved(question.body)
    conflict = None if design is None else design.conflict
    gap = None if design is None else design.certificate.gap
    needed = None
    if conflict is not None:
        below = [
            relaxation.needed
            for relaxation in conflict.relaxations
            if relaxation.field == "base_radius_mm/max" and relaxation.needed is not None
            and relaxation.needed < relaxation.requested
        ]  # fmt: skip
        needed = min(below, default=None)
    return Outcome(question, status, seconds, gap, open_seconds, needed)


def scene_outcomes(family: str, number: int) -> tuple[str, list[Outcome]]:
    """The status of a scene's answer, and what every question that it satisfies came to."""
    body = random_scene(family, number)
    status, answer, seconds = solved(body)
    if answer is None or not answer.certificate.certified:
        return status, []
    return status, [ask(one, seconds) for one in questions(family, number, body, answer)]
