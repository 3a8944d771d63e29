"""What the random specs have found: kept as they were, so that it stays mended."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from synthesis import DesignSpec, synthesise
from synthesis.pipeline.conflict import UNTRIED
from synthesis.pipeline.oracle import Oracle
from tests.hard.cases import ANGLES, CASES, jerk, scene
from tests.hard.run import outcome
from tests.hard.verifier import objectives

FOUND = json.loads((Path(__file__).parent / "found.json").read_text(encoding="utf-8"))


@pytest.mark.usefixtures("short_diagnosis")
@pytest.mark.parametrize("found", FOUND, ids=lambda found: found["why"])
def test_it_stays_mended(found: dict[str, Any]) -> None:
    judged = outcome(0, found["spec"])
    assert judged.complaints == ()
    assert not judged.status.startswith(("crash", "missed", "spec error", "late, without"))
    assert (1.0 if judged.gap is None else judged.gap) <= found.get("gap", 1.0)


def test_every_objective_has_a_proof_even_if_it_was_not_reached() -> None:
    spec = next(one["spec"] for one in FOUND if one["why"].startswith("ordered"))
    design = synthesise(DesignSpec.model_validate(spec))
    assert len(design.certificate.other_objectives) == len(objectives(spec)) - 1
    unproven = [proof for proof in design.certificate.other_objectives if proof.gap is None]
    assert design.status == "feasible" or not unproven


def test_a_diagnosis_stops_when_its_time_is_over(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Oracle, "is_late", lambda oracle: True)
    found = synthesise(DesignSpec.model_validate(scene(ANGLES, jerk(28.8)))).conflict
    assert found is not None
    assert found.limits
    assert UNTRIED in found.evidence
    assert all(relaxation.needed is None for relaxation in found.relaxations)


def test_a_cam_that_is_given_in_full_has_a_value() -> None:
    design = synthesise(DesignSpec.model_validate(CASES["dwell as sharp as asked"].spec))
    assert design.objectives == {"base_radius_mm": pytest.approx(40.0)}
