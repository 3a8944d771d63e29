"""Answers do not change without a new engine number, which is part of every id."""

from __future__ import annotations

import json
from typing import Any

import pytest

from service.contract.examples import examples
from service.resources.records import RESOURCES
from synthesis.design import identity
from synthesis.design.identity import ENGINE_NUMBER
from synthesis.studies.sweeps import SweepSpec
from synthesis.studies.sweeps.spec import sweep_id
from tests.service.conftest import Running
from tests.service.contract.kept_answers import EXAMPLES, KEPT, summary_of

TOLERANCE = 1e-6  # relative: machines differ by 1e-8 in what is compared
RENEW = "python -m tests.service.contract.kept_answers"


def kept() -> dict[str, Any]:
    document: dict[str, Any] = json.loads(KEPT.read_text(encoding="utf-8"))
    return document


def differences(old: dict[str, Any], new: dict[str, Any]) -> list[str]:
    """What of one answer has changed, in words."""
    found = [name for name in ("status", "fields") if old[name] != new[name]]
    for path in sorted(old["numbers"].keys() | new["numbers"].keys()):
        (n, size, mean), (m, now_size, now_mean) = (
            each["numbers"].get(path, (0, 0.0, 0.0)) for each in (old, new)
        )
        off = max(abs(size - now_size), abs(mean - now_mean))
        if n != m or off > TOLERANCE * max(size, now_size):
            found.append(f"{path}: sum of sizes {size:.10g}, now {now_size:.10g}")
    return found


def test_the_kept_answers_are_of_this_engine() -> None:
    assert kept()["engine"] == ENGINE_NUMBER, f"Renew the kept answers: {RENEW}"


@pytest.mark.parametrize(
    ("path", "name"), [(path, name) for path, names in EXAMPLES.items() for name in names]
)
def test_answers_change_with_the_engine_number_only(
    path: str, name: str, real_service: Running
) -> None:
    """Asked of the service, which may have the answer since another test asked for it."""
    body = examples(RESOURCES[path].examples)[name]["value"]
    answer = real_service.client.post(path, json=body).json()
    changed = differences(kept()["answers"][f"{path}/{name}"], summary_of(answer))
    assert not changed, (
        f"The answer to {path}/{name} has changed, so answers that are stored must not be served "
        "any more. Raise ENGINE_NUMBER in synthesis/design/identity.py by 1, then renew the kept "
        f"answers: {RENEW}\n" + "\n".join(changed)
    )


def test_every_kind_of_answer_is_watched() -> None:
    assert EXAMPLES.keys() == RESOURCES.keys()


def test_small_changes_are_noticed() -> None:
    """A field renamed, a status, a number by 1e-5 of itself."""
    answer = {
        "status": "optimal",
        "dimensions": {"base_radius_mm": 30.0},
        "extremes": [{"value": 3.0}],
    }
    old = summary_of(answer)
    assert differences(old, summary_of({**answer, "status": "feasible"})) == ["status"]
    assert "fields" in differences(old, summary_of({**answer, "dimensions": {"base_mm": 30.0}}))
    for value, count in ((3.00003, 1), (3.0 + 1e-9, 0), (-3.0, 1)):
        now = summary_of({**answer, "extremes": [{"value": value}]})
        assert len(differences(old, now)) == count


def test_every_id_depends_on_the_engine_number(monkeypatch: pytest.MonkeyPatch) -> None:
    question: list[tuple[Any, Any]] = []
    for resource in RESOURCES.values():
        example = next(iter(examples(resource.examples).values()))["value"]
        question.append((resource.id_of, resource.spec.model_validate(example)))
    sweep = next(iter(examples("sweeps").values()))["value"]
    question.append((sweep_id, SweepSpec.model_validate(sweep)))
    before = [id_of(spec) for id_of, spec in question]
    assert len(set(before)) == len(before)
    monkeypatch.setattr(identity, "ENGINE_NUMBER", ENGINE_NUMBER + 1)
    assert not {id_of(spec) for id_of, spec in question} & set(before)
