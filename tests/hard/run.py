"""One random spec after another, judged; ``make hard`` runs all of them.

What may come out: a certified design that the verifier confirms, a refusal with its reason that
no cam of the verifier's own contradicts (where one does, and the refusal says that it is not
proven, the cam was missed: counted, and no false claim), a spec error, or the end of the time
budget with the best so far. Everything else is a fault.

The verifier knows nothing of forces. Of specs with a load, ``make hard ARGS=loaded``, the judge
reads what the certificate itself says, and takes the documented errors of ``synthesise`` for
answers: what may not come out is any other exception.
"""

from __future__ import annotations

import json
import sys
import time
import warnings
from collections import Counter
from collections.abc import Callable, Iterable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from typing import Any

from pydantic import ValidationError

from synthesis import DesignSpec, synthesise
from synthesis.errors import SolverFailed, TimeBudgetExceeded
from synthesis.numerics import clock
from tests.hard import loaded_specs, random_specs
from tests.hard.loaded_specs import loaded_spec
from tests.hard.random_specs import random_spec
from tests.hard.verifier import verify
from tests.hard.witnesses import contradictions

BUDGET_S = 5.0
HANG_S = 15.0  # beyond the budget: 5 s of diagnosis, and what the slower of two machines adds


@dataclass(frozen=True)
class Family:
    """Random specs of one kind: the spec of a number, and how many there are."""

    spec: Callable[[int], dict[str, Any]]
    count: int


FAMILIES = {
    "random": Family(random_spec, random_specs.COUNT),
    "loaded": Family(loaded_spec, loaded_specs.COUNT),
}


@dataclass(frozen=True)
class Outcome:
    """What one spec came to."""

    number: int
    kind: str
    status: str
    seconds: float
    gap: float | None
    complaints: tuple[str, ...]


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
            asked = json.loads(json.dumps(design["spec"]))
            gap = design["certificate"]["gap"]
            complaints += verify(asked, design)
            refuted = contradictions(asked, design)
            if refuted and _only_not_found(design):
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
    return Outcome(number, body["follower"]["kind"], status, seconds, gap, tuple(complaints))


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


def _only_not_found(design: dict[str, Any]) -> bool:
    """Whether a refusal says itself that it is no proof: then it is a miss, no false claim."""
    conflict = design["conflict"]
    return conflict is not None and "not proven" in conflict["evidence"]


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
    """``[FAMILY] [first [end [step]]]``: random is the family where none is named."""
    given = sys.argv[1:]
    name = given.pop(0) if given and given[0] in FAMILIES else "random"
    first, last, step = [*map(int, given), *(0, FAMILIES[name].count, 1)[len(given) :]]
    found, judged = [], partial(outcome, family=name)
    with ProcessPoolExecutor(2, initializer=_budgets_of_processor_time) as pool:
        for done in pool.map(judged, range(first, last, step), chunksize=4):
            found.append(done)
            if done.complaints:
                print(f"#{done.number} {done.kind} {done.status}: {done.complaints}", flush=True)
    print(report(found))
    return 1 if any(one.complaints for one in found) else 0


def _budgets_of_processor_time() -> None:
    """As in the tests here: what a spec comes to is the same on a busy machine."""
    clock.now = time.process_time


if __name__ == "__main__":
    sys.exit(main())
