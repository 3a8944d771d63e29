"""One random spec after another, judged; ``make hard`` runs all of them.

What may come out: a certified design that the verifier confirms, a refusal with its reason that
no cam of the verifier's own contradicts (where one does, and the refusal says that it is not
proven, the cam was missed: counted, and no false claim), a spec error, or the end of the time
budget with the best so far. Everything else is a fault.
"""

from __future__ import annotations

import json
import sys
import time
import warnings
from collections import Counter
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from typing import Any

from pydantic import ValidationError

from synthesis import DesignSpec, synthesise
from synthesis.errors import TimeBudgetExceeded
from tests.hard.random_specs import COUNT, random_spec
from tests.hard.verifier import verify
from tests.hard.witnesses import contradictions

BUDGET_S = 5.0
HANG_S = 15.0  # beyond the budget: 5 s of diagnosis, and what the slower of two machines adds


@dataclass(frozen=True)
class Outcome:
    """What one spec came to."""

    number: int
    kind: str
    status: str
    seconds: float
    gap: float | None
    complaints: tuple[str, ...]


def outcome(number: int, body: dict[str, Any] | None = None) -> Outcome:
    """Design the cam of a spec and judge what comes out; nothing is raised."""
    body = random_spec(number) if body is None else body
    body = {"time_budget_s": BUDGET_S, **body}
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
        if design is not None:
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
    except Exception as error:  # a crash is what is looked for
        seconds = time.process_time() - start
        complaints.append(f"{type(error).__name__}: {error}")
    if seconds > BUDGET_S + HANG_S:
        complaints.append(f"hangs: {seconds:.1f} s with a budget of {BUDGET_S} s")
    return Outcome(number, body["follower"]["kind"], status, seconds, gap, tuple(complaints))


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
    given = [int(value) for value in sys.argv[1:4]]
    first, last, step = [*given, *(0, COUNT, 1)[len(given) :]]
    found = []
    with ProcessPoolExecutor(2) as pool:
        for done in pool.map(outcome, range(first, last, step), chunksize=4):
            found.append(done)
            if done.complaints:
                print(f"#{done.number} {done.kind} {done.status}: {done.complaints}", flush=True)
    print(report(found))
    return 1 if any(one.complaints for one in found) else 0


if __name__ == "__main__":
    sys.exit(main())
