"""Many random questions and changed files: python -m tests.checker.run 100 [--mutants 1000].

Prints how many claims are proven, kind by kind, and every file that is wrongly accepted or refused.
"""

import argparse
import contextlib
import io
import json
import random
import time
from collections import Counter
from typing import Any

from synthesis import DesignSpec, proof, synthesise
from synthesis.design.design import Design
from synthesis.errors import TimeBudgetExceeded
from synthesis.pipeline.proof_file.checker import checker
from tests.checker.mutations import mutated
from tests.checker.questions import question
from tests.checker.truth import contradiction


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


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("count", type=int)
    parser.add_argument("--mutants", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1)
    wanted = parser.parse_args()
    chance = random.Random(wanted.seed)
    proofs, tally, sizes, seconds, gaps = [], Counter[str](), [], [], []
    while len(proofs) < wanted.count:
        body = question(chance)
        try:
            design = synthesise(DesignSpec.model_validate(body))
        except TimeBudgetExceeded:
            continue
        document = json.loads(json.dumps(proof(design)))
        started = time.process_time()
        code, said = verdict(document)
        seconds.append(time.process_time() - started)
        sizes.append(len(json.dumps(document, separators=(",", ":"))))
        if code or (false := contradiction(document)):
            print("REFUSED" if code else f"FALSE {false}", said, json.dumps(body))
        tally[design.status] += 1
        for claim in document["claims"]:
            place = claim["place"].split("/")[0]
            if place == "objective":
                place += " " + kinds(document["question"])
            tally[
                f"{design.status} {place} {'proven' if claim['proven'] else claim['reason']}"
            ] += 1
            answer = _bound(design, claim["place"]) if "at_least" in claim else None
            if answer:
                gaps.append(1.0 - claim["at_least"] / answer)
        proofs.append(document)
    for name, count in sorted(tally.items()):
        print(f"{count:6d} {name}")
    print(f"bytes at most {max(sizes)}, seconds at most {max(seconds):.2f}")
    print(
        "below the answer's bound by",
        sorted(f"{gap:.1e}" for gap in gaps)[-5:],
        max(gaps, default=0.0),
    )
    accepted = Counter[str]()
    for _ in range(wanted.mutants):
        original = chance.choice(proofs)
        document = mutated(original, proofs, chance)
        code, said = verdict(document)
        accepted[f"exit {code}"] += 1
        if code == 0 and (false := contradiction(document, original)):
            accepted["WRONGLY ACCEPTED"] += 1
            print(f"WRONGLY ACCEPTED {false}", json.dumps(document)[:300])
        if sum(accepted.values()) % 100 == 0:
            print(dict(accepted), flush=True)
    print(dict(accepted))


if __name__ == "__main__":
    main()
