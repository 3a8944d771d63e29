"""The checker, as the judge of what a proof file may call proven."""

from __future__ import annotations

import json
from collections import Counter
from functools import cache
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from typing import Any

PLACES = (
    Path(__file__).resolve().parents[3] / "checker" / "check.py",  # a checkout
    Path(__file__).with_name("check.py"),  # an installation
)

OTHER = (ArithmeticError, AttributeError, LookupError, TypeError, ValueError)
"""What the checker meets in files that are of another form than it reads."""


@cache
def checker_path() -> Path:
    """Where the checker is."""
    return next(path for path in PLACES if path.is_file())


@cache
def checker() -> Any:
    """The checker's module, which imports the standard library alone."""
    spec = spec_from_file_location("camwright_checker", checker_path())
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def as_bytes(body: Any) -> bytes:
    """A part of a proof file as the checker reads it."""
    return json.dumps(body, separators=(",", ":")).encode()


def objections(proof: bytes, spent: Counter[str]) -> dict[str, str]:
    """Why the checker does not accept the claims of a proof file, by place; empty where it does.

    Each is judged as if those refused were not there. ``spent``: the work that claims accepted
    before take; that of the accepted ones is added, as a file may take so much for all together.
    """
    judge = checker()
    judge.spent.clear()
    body, cam, found = judge.read(proof), None, dict[str, str]()
    judge.spent.update(spent)
    for claim in body["claims"]:
        place, before = claim["place"], judge.spent.copy()
        try:
            if place == "infeasible" or place.startswith("objective/"):
                judge.excluded(body["question"], place, claim, body["cam"])
            else:
                question = judge.Question(body["question"], body["cam"].get("program", ()))
                cam = cam or judge.Cam(question, body["cam"])
                cam.check(place)
        except (judge.Failure, *OTHER) as failure:
            found[place] = str(failure.args[0])
            judge.spent.clear()
            judge.spent.update(before)
        else:
            found[place] = ""
    spent.update(
        {what: judge.spent[what] - spent[what] for what in judge.spent if what != "numbers"}
    )
    return found


def not_covered(question: bytes, chosen: bytes) -> str:
    """What of a question the checker does not know; empty where it knows all.

    ``chosen``: numbers of its program that a cam has where the question leaves ranges.
    """
    judge = checker()
    judge.spent.clear()
    try:
        judge.Question(judge.read(question), judge.read(chosen))
    except (judge.Failure, *OTHER) as failure:
        return f"this question is not covered: {failure.args[0]}"
    return ""


def places(question: bytes, *, has_cam: bool) -> list[str]:
    """Everything that a proof file of a question has to speak of."""
    judge = checker()
    judge.spent.clear()
    found: list[str] = judge.places(judge.read(question), {} if has_cam else None)
    return found
