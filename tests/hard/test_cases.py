"""Every hard case: what must come out does, and the independent verifier confirms it."""

from __future__ import annotations

import pytest
from pydantic import ValidationError

from synthesis import DesignSpec, synthesise
from synthesis.errors import TimeBudgetExceeded
from tests.hard.cases import CASES, Case
from tests.hard.verifier import verify
from tests.hard.witnesses import contradictions

ACCEPTED = {"optimal": ("optimal",), "certified": ("optimal", "feasible")}


def judge(case: Case) -> str | None:
    """What is wrong, or None."""
    expect, _, named = case.expect.partition(": ")
    try:
        spec = DesignSpec.model_validate(case.spec)
        design = synthesise(spec).model_dump(mode="json")
    except ValidationError as error:
        types = [one["type"] for one in error.errors()]
        return None if expect == "error" and named in types else f"spec error {types}: {error}"
    except TimeBudgetExceeded as late:
        if expect == "late" and late.best is not None:
            found = late.best.model_dump(mode="json")
            return "; ".join(verify(found["spec"], found)) or None
        return None if expect == "late" else f"late, best {late.best}"
    question, status = design["spec"], design["status"]
    complaints = [*verify(question, design), *contradictions(question, design)]
    if complaints:
        return "; ".join(complaints)
    if expect == "refused":
        reasons = [*(design["conflict"] or {"limits": []})["limits"]]
        if status in ("infeasible", "unsolved") and any(named in reason for reason in reasons):
            return None
        return f"{status}, for {reasons}"
    if status not in ACCEPTED.get(expect, ()):
        return f"{status}, gap {design['certificate']['gap']}, conflict {design['conflict']}"
    value = design["certificate"]["value"]
    if case.value is not None:
        tolerance = case.spec["tolerance"]
        if not case.value * (1 - 1e-9) <= value <= case.value * (1 + tolerance):
            return f"value {value}, exactly {case.value}"
        if not design["certificate"]["lower_bound"] <= case.value * (1 + 1e-9):
            return f"bound {design['certificate']['lower_bound']}, exactly {case.value}"
    return None


def test_there_are_enough_of_them() -> None:
    assert len(CASES) >= 60


@pytest.mark.usefixtures("members_only")
@pytest.mark.parametrize("name", CASES)
def test_hard_case(name: str) -> None:
    wrong = judge(CASES[name])
    assert wrong is None, f"{name} ({CASES[name].why}): {wrong}"
