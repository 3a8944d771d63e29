"""Questions that lie beyond a proven bound: whether that is proven, and what their conflict says.

    python -m tests.hard.beyond FIRST LAST [--families WORD] [--seconds S] [--kept FILE] [--proof P]
                                           [--budget S] [--even]

asks those of the scenes FIRST to LAST of each family whose name holds the word, until S seconds of
processor time are over. FILE keeps every outcome, a line each: what is in it is not asked again,
and the shares at the end are those of all that it holds.

An open question of a family is solved, and its proven bound becomes a limit that is tightened by
0.1 to 20 %, drawn evenly or, by default, so that their logarithms are: then 43 % are below 1 %. So
there is no cam, and of the conflict four things can be tried: each ``needed`` put back has a cam,
each ``at_least`` put back a little nearer to the request has none, and without any one of the
members there is a cam again. Changes of the program are put back as well.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from copy import deepcopy
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from synthesis import DesignSpec
from synthesis.design.design import Extreme, Relaxation
from synthesis.numerics import clock
from synthesis.pipeline.goal import Goal
from synthesis.pipeline.largest_radius import solve_with_maximum
from synthesis.pipeline.oracle import Trial
from synthesis.pipeline.relaxable import relaxable_numbers, without
from tests.hard.families import FAMILIES, Spec, random_scene
from tests.hard.own_numbers import BUDGET_S, solved

SOON_S = 5.0  # the time budget of a question that has little of it
LATE_S = 0.5  # processor time after a budget: what is written down of what is known by then
LEAST_BEYOND, MOST_BEYOND = 1e-3, 0.2  # relative
FLOOR = 1e-2  # strokes: a smaller base radius may be bounded by the end of the search alone
ROOM = 0.1  # relative: of a largest base radius above the answer's own
NEARER = 1e-3  # relative: towards the request, where a value below ``at_least`` is tried

# a limit by its kind: the objective that makes it small, and the name of its value in an answer
TWINS = {
    "jerk": ("peak_jerk", "max_{}_per_s3"), "acceleration": ("peak_acceleration", "max_{}_per_s2"),
}  # fmt: skip
ANY_CAM = {"kind": "peak_acceleration"}  # an objective that has a best cam whatever is limited
CONVEX = (
    "slide, centred", "slide, offset", "slide, laws given", "slide, laws given, centred",
    "slide, one law given", "slide, acceleration", "slide, velocity", "slide, window",
    "slide, splines", "slide, all three", "face, ",
)  # fmt: skip
CHOSEN = "at the chosen numbers alone"  # of what such a bound is valid for
BINDS = 1e-2  # of the base radius: a least radius of curvature has less to spare where it binds


@dataclass(frozen=True)
class Question:
    """A spec without any cam.

    Attributes:
        beyond: by how much, relatively, a limit is out of reach.
        curved: whether the best cam of the open question is at its least radius of curvature. Of a
            roller's cam that is not convex in law and size, of a flat face's it is linear.
    """

    family: str
    number: int
    kind: str
    body: Spec
    beyond: float
    curved: bool = False

    @property
    def convex(self) -> bool:
        """Whether all limits that bind are convex in law and size together."""
        return self.family.startswith(CONVEX) and not self.curved


@dataclass
class Outcome:
    """What a question came to.

    Attributes:
        seconds: processor time of the answer with its conflict.
        in_time: whether it is proven within SOON_S, where the question has no more time than that.
        sufficient: of every value needed, whether it was. distances: of ``at_least`` and
            ``needed``, as shares of the value and of the way from the request; None where one of
            them is not known. curved: of each of these, whether the cam with the value needed is at
            its least radius of curvature.
        changes: of every change of the program, whether it sufficed.
        necessary: of every member, whether the others alone have a cam.
    """

    question: Question
    status: str
    seconds: float
    proven: bool = False
    in_time: bool = False
    sufficient: list[bool] = field(default_factory=list)
    distances: list[tuple[float, float] | None] = field(default_factory=list)
    curved: list[bool] = field(default_factory=list)
    changes: list[bool] = field(default_factory=list)
    necessary: list[bool] = field(default_factory=list)
    complaints: list[str] = field(default_factory=list)

    def ways(self, *, convex: bool) -> list[float]:
        """How far ``at_least`` is from ``needed``, where all that binds there is convex, or is not.

        A limit that is relaxed may let another bind: a smaller cam is more sharply curved.
        """
        curved = self.curved or [False] * len(self.distances)
        both = [
            (self.question.convex and not x, y) for x, y in zip(curved, self.distances, strict=True)
        ]
        return [distance[1] for is_convex, distance in both if distance and is_convex is convex]


def questions(family: str, number: int, *, even: bool = False) -> Iterator[Question]:
    """A scene's own bound as a limit, and the least peak of a limit on its motion.

    ``even``: how by how much they lie beyond it is drawn.
    """
    random = np.random.default_rng([number, len(family)])
    body = random_scene(family, number)
    unit = "deg" if "lift_deg" in body["program"][0] else "mm"
    _, answer, _ = solved(body)
    if answer is None or not answer.certificate.certified:
        return
    if answer.certificate.bound_valid_for.endswith(CHOSEN):
        return  # with other numbers there may be smaller cams
    radius, rolls = answer.dimensions["base_radius_mm"], _rolls(body)
    # 1. The smallest cam.
    bound = answer.certificate.lower_bound
    stroke = answer.completed_spec.stroke()
    if answer.certificate.objective == "base_radius_mm" and bound and bound > FLOOR * stroke:
        beyond = _beyond(random, even=even)
        most = {"max": bound * (1.0 - beyond)}
        tighter = {**body, "base_radius_mm": most}
        curved = rolls and _is_curved(answer.extremes, radius)
        yield Question(family, number, "base radius", tighter, beyond, curved)
    # 2. The gentlest motion of a cam that is little larger.
    for position, limit in enumerate(body["limits"]):
        if limit["kind"] not in TWINS:
            continue
        objective, name = TWINS[limit["kind"]]
        gentle = deepcopy(body)
        # a radius that is the end of the search itself is no number of a question
        gentle["base_radius_mm"] = {"max": max(radius * (1.0 + ROOM), FLOOR * stroke)}
        gentle["limits"][position] = limit
        least = deepcopy(gentle)
        del least["limits"][position]
        least["objective"] = {"kind": objective}
        _, best, _ = solved(least)
        if best is None or not best.certificate.lower_bound:
            continue
        beyond = _beyond(random, even=even)
        value = best.certificate.lower_bound * (1.0 - beyond)
        gentle["limits"][position] = {"kind": limit["kind"], name.format(unit): value}
        curved = _is_curved(best.extremes, best.dimensions["base_radius_mm"])
        yield Question(family, number, limit["kind"], gentle, beyond, rolls and curved)


def _rolls(body: Spec) -> bool:
    """Whether a curvature limit is not convex; of a flat face's cam it is linear."""
    return str(body["follower"]["kind"]).endswith("roller")


def _is_curved(extremes: Sequence[Extreme], radius: float) -> bool:
    """Whether a profile of a base radius [mm] is somewhere at its least radius of curvature."""
    radii = [each.margin for each in extremes if each.limit == "profile_radius"]
    return min((each for each in radii if each is not None), default=np.inf) < BINDS * radius


def _beyond(random: np.random.Generator, *, even: bool) -> float:
    if even:
        return float(random.uniform(LEAST_BEYOND, MOST_BEYOND))
    return float(np.exp(random.uniform(np.log(LEAST_BEYOND), np.log(MOST_BEYOND))))


def ask(question: Question, proof: str, budget: float) -> Outcome:
    """Put a question with a ``proof`` and a time of its own, and try what its conflict says."""
    body = {"time_budget_s": budget, **question.body, "proof": proof}
    status, design, seconds = solved(body)
    outcome = Outcome(question, status, seconds)
    conflict = None if design is None else design.conflict
    if conflict is None:
        if design is not None:
            outcome.complaints.append("a cam, where none should be")
        return outcome
    outcome.proven = outcome.in_time = conflict.proven
    if seconds > SOON_S:
        outcome.in_time = _is_proven_soon(body)
    for each in conflict.relaxations:
        _try_values(outcome, each, budget)
    for name in dict.fromkeys(each.limit for each in conflict.program_changes):
        changed = question.body
        for each in conflict.program_changes:
            if each.limit == name and each.needed is not None:
                changed = put(changed, each.field, each.needed)
        outcome.changes.append(_has_cam(changed))
        if not outcome.changes[-1]:
            outcome.complaints.append(f"the change of {name} does not suffice")
    named = {each.limit for each in conflict.relaxations}
    for member, others in without_each(question.body, named):
        shown = _has_cam(others)
        outcome.necessary.append(shown)
        words = member.replace("_", " ")
        if not shown and not any(each.startswith(words) for each in conflict.unconfirmed):
            outcome.complaints.append(f"the other members alone, without {member}: no cam either")
    return outcome


def _is_proven_soon(body: Spec) -> bool:
    """Whether a question with little time is proven to have no cam."""
    start = clock.now()
    proof = _answered(body, SOON_S).proof  # a conflict comes after it, with the time that is left
    if proof and clock.now() - start <= SOON_S + LATE_S:
        return True
    _, design, seconds = solved({**body, "time_budget_s": SOON_S})
    short = None if design is None else design.conflict
    return short is not None and short.proven and seconds <= SOON_S + LATE_S


def _answered(body: Spec, seconds: float) -> Trial:
    """The answer of ``synthesise`` without its conflict, which takes far longer than the rest."""
    spec, goal = DesignSpec.model_validate(body), Goal(clock.now() + seconds)
    return Trial(*solve_with_maximum(spec, goal, []), on_time=True)


def _try_values(outcome: Outcome, each: Relaxation, budget: float) -> None:
    """Put back what is needed, with the question's own time, and a little less than at least."""
    body, at_least = outcome.question.body, each.at_least
    distance, curved = None, False
    if each.needed is not None:
        own_time = max(budget, BUDGET_S)
        again = {**put(body, each.field, each.needed), "time_budget_s": own_time}
        trial = _asked(again, seconds=own_time)
        outcome.sufficient.append(trial.certified)
        if trial.attempt.cam is not None:
            least = trial.attempt.question.physical.requested_radii()[1]
            curved = _rolls(body) and _is_curved(trial.attempt.extremes, least)
        if not trial.certified:
            outcome.complaints.append(f"{each.field} = {each.needed!r} does not suffice")
    if at_least is not None:
        less = at_least + NEARER * (each.requested - at_least)
        # a proof finds no cam that the local search has missed but by chance, and takes long
        if at_least != each.requested and _has_cam(put(body, each.field, less), ["quick"]):
            outcome.complaints.append(f"{each.field} = {less!r} suffices, below {at_least!r}")
    if each.needed is not None and at_least is not None:
        apart, way = abs(each.needed - at_least), abs(each.needed - each.requested)
        distance = apart / abs(each.needed), apart / way
        if apart > 0.0 and (each.needed - at_least) * (each.needed - each.requested) < 0.0:
            outcome.complaints.append(f"{each.field}: at_least {at_least} beyond {each.needed}")
    outcome.distances.append(distance)
    outcome.curved.append(curved)


def without_each(body: Spec, members: set[str]) -> Iterator[tuple[str, Spec]]:
    """For each member of a conflict: the question with the other members alone.

    A conflict is irreducible if its members have no cam together, but have one without any single
    one. Numbers that are no members are left out too: with them there may be another conflict, so
    that no cam is found without a member of this one. What is made small is changed: without a
    limit there may be cams, but no smallest one.
    """
    spec = DesignSpec.model_validate(body)
    for member in sorted(members):
        left_out = [one for one in relaxable_numbers(spec) if one.limit not in members - {member}]
        others = without(spec, left_out).model_dump(mode="json", exclude_none=True)
        yield member, {**others, "objective": ANY_CAM}


def _has_cam(body: Spec, proofs: Sequence[str] = ("quick", "auto")) -> bool:
    return _asked(body, proofs).certified


def _asked(
    body: Spec, proofs: Sequence[str] = ("quick", "auto"), seconds: float = BUDGET_S
) -> Trial:
    """What a question comes to, with a proof as short or as long as it may have."""
    for proof in proofs:
        trial = _answered({**body, "proof": proof}, seconds)
        if trial.certified or trial.proof:
            break
    return trial


def put(body: Spec, path: str, value: float) -> Spec:
    """The spec with another value at a path; of a number that is given, a range between both."""
    changed = deepcopy(body)
    *parents, last = path.split("/")
    at: Any = changed
    for step in parents:
        at = at[int(step)] if isinstance(at, list) else at[step]
    given = parents[:1] not in (["limits"], ["program"]) and last in at
    if given and last not in ("min", "max", "speed_rpm"):
        at[last] = {"min": min(at[last], value), "max": max(at[last], value)}
    else:
        at[last] = value
    return changed


def report(found: list[Outcome]) -> str:
    """The shares, in all and by family."""
    lines = []
    for family in FAMILIES:
        mine = [one for one in found if one.question.family == family]
        if mine:
            counts = Counter(one.status for one in mine)
            words = ", ".join(f"{status} {count}" for status, count in sorted(counts.items()))
            lines.append(f"{family:40s} {words}; {_shares(mine)}")
    convex = [one for one in found if one.question.convex]
    others = [one for one in found if not one.question.convex]
    for name, some in (("convex", convex), ("others", others), ("all", found)):
        lines.append(f"{name}: {len(some)} questions, {_shares(some)}")
    for name, is_convex in (("convex", True), ("not convex", False)):
        ways = [way for one in found for way in one.ways(convex=is_convex)]
        lines.append(
            f"at_least where what binds at the value needed is {name}: within 0.1 % of the way "
            f"{_share([way <= 1e-3 for way in ways])}, 1 % {_share([way <= 1e-2 for way in ways])}"
        )
    return "\n".join(lines)


def _shares(some: list[Outcome]) -> str:
    proven = [one.proven for one in some]
    in_time = [one.in_time for one in some]
    enough = [each for one in some for each in one.sufficient]
    changes = [each for one in some for each in one.changes]
    rows = [each for one in some for each in one.distances]
    known = [each for each in rows if each is not None]
    irreducible = [all(one.necessary) for one in some if one.necessary]
    return (
        f"proven {_share(proven)}, within {SOON_S:g} s {_share(in_time)}; needed named "
        f"{len(enough)} of {len(rows)}, suffices {_share(enough)}; at_least named {len(known)}, "
        f"within 0.1 % of the value {_share([v <= 1e-3 for v, _ in known])}, "
        f"1 % {_share([v <= 1e-2 for v, _ in known])}, of the way "
        f"{_share([w <= 1e-3 for _, w in known])}, {_share([w <= 1e-2 for _, w in known])}; "
        f"irreducible {_share(irreducible)}; changes of the program {_share(changes)}; mean "
        f"{sum(one.seconds for one in some) / max(len(some), 1):.2f} s"
    )


def _share(some: list[bool]) -> str:
    return f"{sum(some)}/{len(some)}"


def _read(kept: Path | None) -> list[Outcome]:
    """The outcomes of earlier runs."""
    lines = kept.read_text().splitlines() if kept is not None and kept.exists() else []
    bodies = map(json.loads, lines)
    return [Outcome(Question(**body.pop("question")), **body) for body in bodies]


def main(arguments: list[str]) -> int:
    """Ask, print what is wrong as it comes, and the shares at the end."""
    parser = argparse.ArgumentParser(prog="python -m tests.hard.beyond")
    parser.add_argument("first", type=int)
    parser.add_argument("last", type=int)
    parser.add_argument("--families", default="")
    parser.add_argument("--seconds", type=float, default=600.0)
    parser.add_argument("--kept", type=Path)
    parser.add_argument("--proof", default="auto")
    parser.add_argument("--budget", type=float, default=20.0, help="of a question [s]")
    parser.add_argument("--even", action="store_true", help="draw 0.1 to 20 %% evenly")
    given = parser.parse_args(arguments)
    clock.now = time.process_time  # the same answers on a busy machine
    found = _read(given.kept)
    known = {(one.question.family, one.question.number) for one in found}
    for number in range(given.first, given.last + 1):
        for family in (family for family in FAMILIES if given.families in family):
            if time.process_time() > given.seconds or (family, number) in known:
                continue
            asked = questions(family, number, even=given.even)
            answers = [_judged(question, given.proof, given.budget) for question in asked]
            found += answers
            if given.kept is not None:  # a scene at once: one that was cut off is asked again
                with given.kept.open("a") as file:
                    file.writelines(json.dumps(asdict(one)) + "\n" for one in answers)
    print(report(found))
    return 1 if any(one.complaints for one in found) else 0


def _judged(question: Question, proof: str, budget: float) -> Outcome:
    """What a question came to, printed."""
    outcome = ask(question, proof, budget)
    print(f"{question.family} {question.number} {question.kind} {question.beyond:.2%}: "
          f"{outcome.status}, {_shares([outcome])}", flush=True)  # fmt: skip
    for complaint in outcome.complaints:
        print(f"  {complaint}: {json.dumps(question.body)}", flush=True)
    return outcome


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
