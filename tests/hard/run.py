"""Question after question, judged; ``make hard ARGS="KIND …"``.

    random       sensible and mad specs, against the independent verifier (the default)
    loaded       specs with a load
    mixed        units and sizes mixed, limits met exactly, idle limits, up to twelve segments
    bounds       another optimiser tries to beat every bound and to satisfy what is refused
    transformed  questions made of others, whose answers must be related
    own          questions that an answer satisfies by construction

With ``--kept FILE`` every outcome is kept, a line for each number: a number that is in it is not
judged again, and the report is of all that it holds. One file for each kind.

What may come out: a certified design that the verifier confirms, a refusal with its reason that
no cam of the verifier's own contradicts, a spec error, or the end of the time budget with the
best so far. Everything else is a fault, and is printed with its spec.

The verifier knows nothing of forces. Of specs with a load the judge reads what the certificate
itself says, and takes the documented errors of ``synthesise`` for answers: what may not come out
is any other exception.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
import warnings
from collections import Counter
from collections.abc import Callable, Iterable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from synthesis import DesignSpec, synthesise
from synthesis.errors import SolverFailed, TimeBudgetExceeded
from synthesis.numerics import clock
from tests.hard import loaded_specs, mixed_specs, random_specs
from tests.hard.adversary.attack import is_modelled, refutation
from tests.hard.families import FAMILIES as SCENES
from tests.hard.families import random_scene
from tests.hard.loaded_specs import loaded_spec
from tests.hard.mixed_specs import mixed_spec
from tests.hard.own_numbers import scene_outcomes, solved
from tests.hard.random_specs import random_spec
from tests.hard.transformed import pairs
from tests.hard.verifier import verify
from tests.hard.witnesses import contradictions

BUDGET_S = 5.0
HANG_S = 15.0  # beyond the budget: stages that end late, and what a slower machine adds


@dataclass(frozen=True)
class Family:
    """Random specs of one kind: the spec of a number, and how many there are."""

    spec: Callable[[int], dict[str, Any]]
    count: int


FAMILIES = {
    "random": Family(random_spec, random_specs.COUNT),
    "loaded": Family(loaded_spec, loaded_specs.COUNT),
    "mixed": Family(mixed_spec, mixed_specs.COUNT),
}
ATTACKED = 400  # questions whose bounds are attacked: scenes of families and mixed specs in turn
SCENE_COUNT = 200  # that are transformed, each in some fifteen ways
OWN_COUNT = 250  # scenes whose answers' numbers are put back, each in some eight ways
TWICE, INSTANT_S = 2.0, 0.1  # the open question's time that an answer may take, and what is added
FIRST_SCENE = 100  # of a family: those before it are other tests'


@dataclass(frozen=True)
class Outcome:
    """What one spec came to."""

    number: int
    kind: str
    status: str
    seconds: float
    gap: float | None
    complaints: tuple[str, ...]
    body: dict[str, Any] | None = None


def outcome(number: int, body: dict[str, Any] | None = None, family: str = "random") -> Outcome:
    """Design the cam of a spec and judge what comes out; nothing is raised.

    Args:
        number: of the spec in its family. body: the spec itself, where it is of no family.
    """
    body = FAMILIES[family].spec(number) if body is None else body
    body = {"time_budget_s": BUDGET_S, "proof": "quick", **body}
    start = time.process_time()
    status, gap, complaints = "crash", None, list[str]()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            spec = DesignSpec.model_validate(body)
            try:
                design = synthesise(spec).model_dump(mode="json")
                status = design["status"]
            except TimeBudgetExceeded as late:
                status = "late, without a design" if late.best is None else "late, with a design"
                design = None if late.best is None else late.best.model_dump(mode="json")
        seconds = time.process_time() - start
        if design is not None and body.get("load") is not None:
            gap = design["certificate"]["gap"]
            complaints += _inconsistent(design)
        elif design is not None:
            question = json.loads(json.dumps(design["spec"]))
            gap = design["certificate"]["gap"]
            complaints += verify(question, design)
            refuted = contradictions(question, design)
            if refuted and status == "unsolved":  # it claims nothing; a cam was missed
                status = "missed: no cam was found, though there is one"
            else:
                complaints += refuted
            if status == "feasible" and design["certificate"]["lower_bound"] is None:
                status = "feasible, without a bound"
    except ValidationError as wrong:
        status, seconds = "spec error", time.process_time() - start
        complaints += _unreasoned(wrong)
    except SolverFailed as failed:
        status, seconds = "solver failed", time.process_time() - start
        if body.get("load") is None:
            complaints.append(f"SolverFailed: {failed}")
    except Exception as error:  # a crash is what is looked for
        seconds = time.process_time() - start
        complaints.append(f"{type(error).__name__}: {error}")
    if seconds > BUDGET_S + HANG_S:
        complaints.append(f"hangs: {seconds:.1f} s with a budget of {BUDGET_S} s")
    return Outcome(number, body["follower"]["kind"], status, seconds, gap, tuple(complaints), body)


def attacked(number: int, seconds: float) -> Outcome:
    """A question answered, and its claims attacked for some seconds of processor time."""
    body = mixed_spec(number // 2)
    if number % 2 == 0:
        body = random_scene(*_scene(number // 2))
    kind = body["follower"]["kind"]
    try:
        status, design, needed = solved({"time_budget_s": BUDGET_S, **body})
        if design is None:
            return Outcome(number, kind, status.split(":")[0], needed, None, (), body)
        wire = design.model_dump(mode="json")
        question = json.loads(json.dumps(wire["spec"]))
        bound, gap = wire["certificate"]["lower_bound"], wire["certificate"]["gap"]
        claims = status in ("infeasible", "unsolved") or bound is not None
        if not claims or not is_modelled(question):
            return Outcome(number, kind, f"{status}, not attacked", needed, gap, (), body)
        beaten = refutation(question, wire, seconds, number)
    except Exception as error:  # of the adversary too
        return Outcome(
            number, kind, "crash", 0.0, None, (f"{type(error).__name__}: {error}",), body
        )
    if beaten and status == "unsolved":  # it claims nothing; a cam was missed
        return Outcome(
            number, kind, "missed: unsolved, though there is a cam", needed, gap, (), body
        )
    return Outcome(number, kind, status, needed, gap, (beaten,) if beaten else (), body)


def related(number: int) -> list[Outcome]:
    """A scene transformed in every way."""
    family, scene = _scene(number)
    return [
        Outcome(number, f"{family}: {other.kind.split(' ')[0]}", answer.status, answer.seconds,
                answer.gap, tuple(f"{other.kind}: {text}" for text in wrong), other.body)
        for other, answer, wrong in pairs(family, scene)
    ]  # fmt: skip


def own(number: int) -> list[Outcome]:
    """Every question that the answer of a scene satisfies by construction."""
    family, scene = _scene(number)
    _, outcomes = scene_outcomes(family, scene)
    found = []
    for one in outcomes:
        complaints, status = list[str](), one.status
        if one.false or one.needed is not None:
            complaints.append(f"{one.question.kind}: a cam is denied that exists")
        elif status == "unsolved":
            status = "missed: unsolved, though there is a cam"
        if one.seconds > TWICE * one.open_seconds + INSTANT_S:
            status += ", slower than twice the open question"
        found.append(
            Outcome(number, family, status, one.seconds, one.gap,
                    tuple(complaints), one.question.body)
        )  # fmt: skip
    return found


def _scene(number: int) -> tuple[str, int]:
    """Family and number of the scenes that no other test has, the families in turn."""
    names = list(SCENES)
    return names[number % len(names)], FIRST_SCENE + number // len(names)


def _inconsistent(design: dict[str, Any]) -> Iterable[str]:
    """What a certificate says against itself: limits not kept, a bound above the value."""
    certified = design["status"] in ("optimal", "feasible")
    if certified and not all(extreme["holds"] for extreme in design["extremes"]):
        yield "certified, though a limit is said not to hold"
    if not certified and design["conflict"] is None:
        yield "no cam, and no reason"
    proof = design["certificate"]
    for one in (proof, *proof["other_objectives"]):
        value, bound = one["value"], one["lower_bound"]
        if certified and None not in (value, bound) and bound > value + 1e-9 * abs(value):
            yield f"bound {bound} above the value {value}"


def _unreasoned(wrong: ValidationError) -> Iterable[str]:
    for error in wrong.errors():
        if not error["msg"]:
            yield f"refused without a word: {error['type']}"


def report(found: list[Outcome]) -> str:
    """Counts by follower and status, the slowest, and every complaint."""
    lines = []
    counts = Counter((one.kind, one.status) for one in found)
    for kind in sorted({one.kind for one in found}):
        parts = [f"{status} {n}" for (k, status), n in sorted(counts.items()) if k == kind]
        lines.append(f"{kind}: {', '.join(parts)}")
    total = Counter(one.status for one in found)
    lines.append("all: " + ", ".join(f"{status} {n}" for status, n in sorted(total.items())))
    slow = sorted(found, key=lambda one: -one.seconds)[:8]
    lines.append("slowest: " + ", ".join(f"#{o.number} {o.seconds:.1f} s {o.status}" for o in slow))
    lines.append(f"mean {sum(o.seconds for o in found) / len(found):.3f} s")
    faults = [one for one in found if one.complaints]
    missed = [one.number for one in found if one.status.startswith("missed")]
    lines.append(f"missed: {', '.join(f'#{number}' for number in missed) or 'none'}")
    lines.append(f"{len(found)} specs, {len(faults)} with a complaint")
    for one in faults:
        lines += [f"  #{one.number} {one.kind} {one.status}: {text}" for text in one.complaints]
    return "\n".join(lines)


def main() -> int:
    """Judge what is asked for; print counts, and every fault with its spec as JSON."""
    kinds = {
        **{
            name: (partial(outcome, family=name), family.count) for name, family in FAMILIES.items()
        },
        "bounds": (attacked, ATTACKED),
        "transformed": (related, SCENE_COUNT),
        "own": (own, OWN_COUNT),
    }
    parser = argparse.ArgumentParser(
        "tests.hard.run", description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("kind", nargs="?", default="random", choices=kinds)
    parser.add_argument("range", nargs="*", type=int, metavar="first end step")
    parser.add_argument("--seconds", type=float, default=30.0, help="of an attack on one bound")
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    parser.add_argument("--kept", type=Path, help="file of outcomes, not judged again")
    given = parser.parse_intermixed_args()
    judge, count = kinds[given.kind]
    if given.kind == "bounds":
        judge = partial(attacked, seconds=given.seconds)
    kept = _read(given.kept)
    numbers = range(*given.range, *(0, count, 1)[len(given.range) :])
    numbers = [number for number in numbers if number not in kept]
    with ProcessPoolExecutor(given.jobs, initializer=_budgets_of_processor_time) as pool:
        for number, done in zip(numbers, pool.map(judge, numbers), strict=True):
            outcomes = done if isinstance(done, list) else [done]
            kept[number] = [one if one.complaints else replace(one, body=None) for one in outcomes]
            if given.kept is not None:
                with given.kept.open("a") as file:
                    print(json.dumps([number, list(map(asdict, kept[number]))]), file=file)
            for one in outcomes:
                if one.complaints:
                    print(f"#{one.number} {one.kind} {one.status}: {one.complaints}")
                    print(f"    {json.dumps(one.body)}", flush=True)
    found = [one for outcomes in kept.values() for one in outcomes]
    print(report(found))
    return 1 if any(one.complaints for one in found) else 0


def _read(kept: Path | None) -> dict[int, list[Outcome]]:
    """The outcomes of earlier runs, by number."""
    lines = kept.read_text().splitlines() if kept is not None and kept.exists() else []
    return {number: [Outcome(**one) for one in found] for number, found in map(json.loads, lines)}


def _budgets_of_processor_time() -> None:
    """As in the tests here: what a spec comes to is the same on a busy machine."""
    clock.now = time.process_time


if __name__ == "__main__":
    sys.exit(main())
