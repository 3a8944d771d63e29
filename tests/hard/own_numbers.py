"""An answer's own numbers put back as limits: the cam at hand satisfies them, so one must be found.

``python -m tests.hard.own_numbers`` asks all questions; arguments: scenes of each family (2), a
word that the names of the families hold (all). A question counts only where the certificate
confirms that the answer's own cam, or the same cam a little larger, keeps every limit of it.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from copy import deepcopy
from dataclasses import dataclass

from synthesis import DesignSpec, synthesise
from synthesis.catalogue.constraints import enlarged
from synthesis.certify import certify, certify_size
from synthesis.design.design import WITHOUT_CAM, Design
from synthesis.errors import TimeBudgetExceeded
from synthesis.numerics import clock
from tests.hard.families import FAMILIES, Spec, random_scene

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


def scene_outcomes(scene: tuple[str, int]) -> tuple[str, list[Outcome]]:
    """The answer of a scene, in words, and every question that it satisfies."""
    clock.now = time.process_time  # the same answers on a busy machine
    body = random_scene(*scene)
    status, answer, seconds = solved(body)
    if answer is None or not answer.certificate.certified:
        return status, []
    return status, [ask(one, seconds) for one in questions(*scene, body, answer)]


def report(found: list[Outcome]) -> str:
    """Questions and false answers by family, and by kind of question."""
    lines = [f"{'family':40s} {'asked':>5s} {'false':>5s} {'s':>7s} {'open s':>7s}  statuses"]
    for family in FAMILIES:
        mine = [one for one in found if one.question.family == family]
        counts = Counter(one.status for one in mine)
        words = ", ".join(f"{status} {count}" for status, count in sorted(counts.items()))
        mean = sum(one.seconds for one in mine) / max(len(mine), 1)
        alone = sum(one.open_seconds for one in mine) / max(len(mine), 1)
        false = sum(one.false for one in mine)
        lines.append(f"{family:40s} {len(mine):5d} {false:5d} {mean:7.2f} {alone:7.2f}  {words}")
    for kind in sorted({one.question.kind for one in found}):
        mine = [one for one in found if one.question.kind == kind]
        false = sum(one.false for one in mine)
        ratio = sum(one.seconds for one in mine) / sum(one.open_seconds for one in mine)
        lines.append(
            f"{kind}: {len(mine)} asked, {false} false, {ratio:.2f} times the open question's time"
        )
    false, low = sum(one.false for one in found), sum(one.needed is not None for one in found)
    unsolved = sum(one.status == "unsolved" for one in found)
    other = sum(one.status not in ("optimal", "feasible", *WITHOUT_CAM) for one in found)
    lines.append(
        f"{len(found)} questions, {false} false ({false / max(len(found), 1):.1%}), "
        f"{unsolved} unsolved, {low} with a "
        f"needed value below what was asked, {other} without an answer"
    )
    return "\n".join(lines)


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.hard.own_numbers")
    parser.add_argument("scenes", type=int, nargs="?", default=SCENES, help="of each family")
    parser.add_argument("word", nargs="?", default="", help="that the names of the families hold")
    given = parser.parse_args(arguments)
    families = [family for family in FAMILIES if given.word in family]
    scenes = [(family, number) for family in families for number in range(given.scenes)]
    found: list[Outcome] = []
    with ProcessPoolExecutor(2) as pool:
        for scene, (status, outcomes) in zip(scenes, pool.map(scene_outcomes, scenes), strict=True):
            found += outcomes
            wrong = [one for one in outcomes if one.status not in ("optimal", "feasible")]
            for one in wrong:
                body = json.dumps(one.question.body)
                print(f"{scene} {one.question.kind}: {one.status} {body}", flush=True)
            if not outcomes:
                print(f"{scene}: no question, {status}", flush=True)
    print(report(found))
    return 1 if any(one.false for one in found) else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
