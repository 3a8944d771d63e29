"""Many random questions and changed files: python -m tests.checker.run 100 [--mutants 1000].

Every question has its number, and what it comes to depends on the seed and the number alone, but
for the other files from which a changed one may take a part: those of the questions before it.
Prints how many claims are proven, kind by kind, and every file that is wrongly accepted or refused.

With ``--kept FILE`` what each question came to is kept, a line for each: a question that is in it
is not asked again, and the report is of all that it holds. One file for each seed.
"""

import argparse
import contextlib
import hashlib
import io
import json
import random
import sys
import time
from collections import Counter, deque
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from synthesis import DesignSpec, proof, synthesise
from synthesis.design.design import Design
from synthesis.errors import TimeBudgetExceeded
from synthesis.pipeline.proof_file.checker import checker, checker_path
from tests.checker.mutations import mutated
from tests.checker.questions import question
from tests.checker.schema import conforms
from tests.checker.truth import contradiction

OTHERS = 10  # files before one, from which changed ones may take a part


@dataclass
class Outcome:
    """What one question came to.

    Attributes:
        claims: how many of each kind are proven, or why not. mutants: changed files by the
            checker's exit code. faults: what is false and accepted, or true and refused.
        size, seconds: of the file [bytes], and of its checking [s of processor time].
        gap: of the bound in the file below the answer's own, relative. checker: its digest.
    """

    number: int
    checker: str
    size: int = 0
    seconds: float = 0.0
    gap: float = 0.0
    claims: Counter[str] = field(default_factory=Counter)
    mutants: Counter[str] = field(default_factory=Counter)
    faults: list[str] = field(default_factory=list)


def verdict(document: Any) -> tuple[int, str]:
    """The checker's exit code and what it says."""
    judge, said = checker(), io.StringIO()
    judge.spent.clear()
    with contextlib.redirect_stdout(said):
        code = judge.check(json.dumps(document).encode())
    return code, said.getvalue()


def kinds(question: Any) -> str:
    """What is minimised, in order."""
    aims = question["objective"]
    return ", then ".join(each["kind"] for each in (aims if isinstance(aims, list) else [aims]))


def _bound(design: Design, place: str) -> float | None:
    """The answer's own lower bound of an objective."""
    spec, proven = design.spec, design.certificate
    name = spec.objectives()[int(place[10:])].name_on_wire(spec.machine())
    known = {each.objective: each.lower_bound for each in (*proven.other_objectives, proven)}
    return known.get(name)


def outcome(number: int, seed: int, mutants: int, others: deque[Any]) -> Outcome:
    """Ask a question, check its file, and change it; the file is added to the others."""
    chance = random.Random(f"{seed}/{number}")
    found = Outcome(number, hashlib.sha256(checker_path().read_bytes()).hexdigest()[:8])
    body = question(chance)
    try:
        design = synthesise(DesignSpec.model_validate(body))
    except (TimeBudgetExceeded, ValidationError) as error:
        found.claims[f"no design: {type(error).__name__}"] += 1
        return found
    document = json.loads(json.dumps(proof(design)))
    started = time.process_time()
    code, said = verdict(document)
    found.seconds = time.process_time() - started
    found.size = len(json.dumps(document, separators=(",", ":")))
    schema = json.loads(checker_path().with_name("proof.schema.json").read_text("utf-8"))
    if code or not conforms(document, schema, schema):
        found.faults.append(f"refused, or of another form: {said} {json.dumps(body)}")
    elif false := contradiction(document):
        found.faults.append(f"false: {false} {json.dumps(body)}")
    found.claims[design.status] += 1
    for claim in document["claims"]:
        place = claim["place"].split("/")[0]
        if place == "objective":
            place += " " + kinds(document["question"])
        result = "proven" if claim["proven"] else claim["reason"]
        found.claims[f"{design.status} {place} {result}"] += 1
        answer = _bound(design, claim["place"]) if "at_least" in claim else None
        if answer:
            found.gap = max(found.gap, 1.0 - claim["at_least"] / answer)
    for _ in range(mutants):
        changed = mutated(document, list(others), chance)
        code, _ = verdict(changed)
        found.mutants[f"exit {code}"] += 1
        if code == 0 and (false := contradiction(changed, document)):
            found.faults.append(f"wrongly accepted: {false} {json.dumps(changed)}")
    others.append(document)
    return found


def read(kept: Path | None) -> dict[int, Outcome]:
    """The outcomes of earlier runs, by number."""
    lines = kept.read_text("utf-8").splitlines() if kept is not None and kept.exists() else []
    found = [Outcome(**json.loads(line)) for line in lines]
    return {each.number: each for each in found}


def report(found: list[Outcome]) -> str:
    """All outcomes together."""
    claims, mutants = Counter[str](), Counter[str]()
    for each in found:
        claims.update(each.claims)
        mutants.update(each.mutants)
    gaps = sorted(each.gap for each in found)
    judged = Counter(each.checker for each in found)
    lines = [f"{count:6d} {name}" for name, count in sorted(claims.items())]
    lines += [
        f"{len(found)} questions, by the checker's digest {dict(judged)}",
        f"bytes at most {max((each.size for each in found), default=0)}, seconds at most "
        f"{max((each.seconds for each in found), default=0.0):.2f}",
        f"below the answer's bound by {', '.join(f'{gap:.1e}' for gap in gaps[-5:])} at most",
        f"{sum(mutants.values())} changed files: {dict(sorted(mutants.items()))}",
        f"{sum(len(each.faults) for each in found)} faults",
    ]
    return "\n".join(lines)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("count", type=int)
    parser.add_argument("--first", type=int, default=0, help="number of the first question")
    parser.add_argument("--mutants", type=int, default=0, help="changed files, of all together")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kept", type=Path, help="file of outcomes, not asked again")
    wanted = parser.parse_args()
    kept, others = read(wanted.kept), deque[Any](maxlen=OTHERS)
    for number in range(wanted.first, wanted.count):
        if number in kept:
            continue
        found = outcome(number, wanted.seed, -(-wanted.mutants // wanted.count), others)
        kept[number] = found
        for fault in found.faults:
            print(f"#{number} {fault}", flush=True)
        if wanted.kept is not None:
            with wanted.kept.open("a", encoding="utf-8") as file:
                print(json.dumps(vars(found)), file=file)
    print(report(list(kept.values())))
    return 1 if any(each.faults for each in kept.values()) else 0


if __name__ == "__main__":
    sys.exit(main())
