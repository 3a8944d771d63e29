"""The answers to some examples, kept in short for the engine's number that gave them.

    python -m tests.service.contract.kept_answers

writes them anew, for when the number has been raised.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from service.contract.examples import examples
from service.resources.records import RESOURCES
from service.workers.tasks import solve_design
from synthesis.design.identity import ENGINE_NUMBER

KEPT = Path(__file__).with_name("kept_answers.json")
BUDGET_S = 300.0
# What each takes: at most 0.4 s of CPU time, but for the train with 3 s.
EXAMPLES: Mapping[str, tuple[str, ...]] = {
    "/v1/designs": (
        "conjugate", "constant-velocity", "example-13-6-sized", "fixed-laws", "flat-face",
        "grooved", "infeasible-on-purpose", "no-residual-vibration", "oscillating-flat-face",
        "spring-chosen", "table", "undercut-limit", "windows-and-points",
    ),
    "/v1/cam-sets": ("feeder-and-press",),
    "/v1/analyses": ("p2-as-given",),
    "/v1/profile-analyses": ("spare-roller",),
    "/v1/spatial-cams": ("cylindrical-groove", "cylindrical-sized"),
    "/v1/train-responses": ("press-feeder",),
    "/v1/linkages/six-bar-shapers": ("p5", "impossible-on-purpose"),
    "/v1/linkages/palletising-arms": ("irb-660",),
}  # fmt: skip
# Not compared: what differs from run to run or follows from the spec; differences of numbers that
# are as good as equal; places of an extreme that is reached several times; spline coefficients, of
# which other numbers are functions; and the flight of a mass, which amplifies rounding.
LEFT_OUT = frozenset(
    {"id", "links", "engine_version", "report", "spec", "seconds"}
    | {"gap", "margin", "width", "balance_error_j", "angle_deg", "coefficients", "flight"}
)
DIGITS = 9  # kept of a number
Summary = dict[str, Any]


def fields(answer: Any, path: str = "") -> Iterator[tuple[str, Any]]:
    """Every value of a JSON document with its path; the entries of a list have the same path."""
    if isinstance(answer, dict):
        if (answer.get("bound") or 0.0) < 0.0 and answer.get("value") is not None:
            # The extreme of a limit on both sides: rounding decides which of two equal peaks it is.
            answer = {**answer, "bound": -answer["bound"], "value": -answer["value"]}
        for name, value in answer.items():
            if name not in LEFT_OUT:
                yield from fields(value, f"{path}/{name}")
    elif isinstance(answer, list):
        for value in answer:
            yield from fields(value, f"{path}/*")
    else:
        yield path, answer


def summary_of(answer: Any) -> Summary:
    """An answer in short: a digest of its fields' names and texts, and its numbers by path.

    The numbers of one path are kept as their count, the sum of their sizes, and a weighted sum
    that depends on signs and order.
    """
    numbers: dict[str, list[float]] = {}
    names: set[str] = set()
    for path, value in fields(answer):
        if isinstance(value, int | float) and not isinstance(value, bool):
            numbers.setdefault(path, []).append(float(value))
        names.add(path)
    digest = hashlib.sha256("\n".join(sorted(names)).encode()).hexdigest()[:16]
    sums = {
        path: [
            len(values),
            rounded(sum(abs(value) for value in values)),
            rounded(sum(value / (1.0 + 0.01 * i) for i, value in enumerate(values))),
        ]
        for path, values in numbers.items()
    }
    return {"status": answer.get("status"), "fields": digest, "numbers": sums}


def rounded(value: float) -> float:
    """To as many significant digits as are kept."""
    return float(f"{value:.{DIGITS}g}")


def answer_to(path: str, name: str) -> Any:
    """What the engine answers to an example now."""
    kind = RESOURCES[path]
    spec = kind.spec.model_validate(examples(kind.examples)[name]["value"])
    return json.loads((kind.task or solve_design)(spec.model_dump_json().encode(), BUDGET_S).body)


def current() -> dict[str, Summary]:
    """The summaries of all examples now."""
    return {
        f"{path}/{name}": summary_of(answer_to(path, name))
        for path, names in EXAMPLES.items()
        for name in names
    }


def _lines(document: dict[str, Any]) -> str:
    """The document with a line for each number, so that differences can be read."""
    text = json.dumps(document, indent=1, sort_keys=True)
    return re.sub(r"\[[^\[\]]*\]", lambda found: " ".join(found[0].split()), text) + "\n"


if __name__ == "__main__":
    document = {"engine": ENGINE_NUMBER, "answers": current()}
    KEPT.write_text(_lines(document), encoding="utf-8")
    print(f"{KEPT} written.")
