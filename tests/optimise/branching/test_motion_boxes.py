"""Limits on motion and size together, on arms and swinging faces: boxes of both close the gap."""

from __future__ import annotations

import pytest

from synthesis import DesignSpec, synthesise
from tests.hard.families import random_scene

SCENES = (
    ("swinging face, laws free", 1),  # the centre distance given
    ("arm, conjugate", 4),
    ("arm, pivot free", 0),
    ("no objective, swinging face", 100),  # the rms jerk held
)
TOLERANCE = 9e-3


@pytest.mark.parametrize(("family", "number"), SCENES)
def test_the_gap_is_closed_over_all_laws_and_sizes(family: str, number: int) -> None:
    body = {**random_scene(family, number), "proof": "auto", "tolerance": TOLERANCE}
    answer = synthesise(DesignSpec.model_validate(body))
    proof, stages = answer.certificate, answer.report.stages
    assert answer.status == "optimal"
    assert proof.bound_valid_for == "all motion laws with a bounded jerk"
    assert proof.value is not None
    assert proof.lower_bound is not None
    assert (1.0 - TOLERANCE) * proof.value <= proof.lower_bound <= proof.value
    (last,) = (k for k, one in enumerate(stages) if one.stage == "implied rows")
    before = stages[last - 1].gap  # None with the pivot free: nothing is known by then
    assert before is None or before > 0.01
    assert stages[last].nodes <= 3


def test_a_quick_proof_bounds_all_pivots() -> None:
    body = {**random_scene("arm, pivot free", 6), "proof": "quick", "tolerance": TOLERANCE}
    proof = synthesise(DesignSpec.model_validate(body)).certificate
    assert proof.gap is not None
    assert proof.gap <= TOLERANCE
    assert proof.bound_valid_for == "all motion laws with a bounded jerk"
