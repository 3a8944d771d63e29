"""Limits on motion and size together, on arms and swinging faces: boxes of both close the gap."""

from __future__ import annotations

import pytest

from synthesis import Design, DesignSpec, synthesise
from tests.hard.families import random_scene

SCENES = (
    ("swinging face, laws free", 1),  # the centre distance given
    ("arm, conjugate", 1),
    ("arm, pivot free", 2),
)


def design(family: str, number: int, proof: str) -> Design:
    more = {"proof": proof, "tolerance": 9e-3}
    spec = DesignSpec.model_validate({**random_scene(family, number), **more})
    return synthesise(spec)


@pytest.mark.parametrize(("family", "number"), SCENES)
def test_the_gap_is_closed_over_all_laws_and_sizes(family: str, number: int) -> None:
    quick = design(family, number, "quick").certificate
    answer = design(family, number, "auto")
    proof = answer.certificate
    assert answer.status == "optimal"
    assert proof.bound_valid_for == "all motion laws with a bounded jerk"
    assert quick.gap is not None
    assert quick.gap > 0.01
    assert quick.lower_bound is not None
    assert quick.value is not None
    assert proof.value is not None
    assert proof.lower_bound is not None
    assert quick.lower_bound < proof.lower_bound <= proof.value
    # neither cam is below either bound
    assert proof.value <= quick.value
    (stage,) = (one for one in answer.report.stages if one.stage == "implied rows")
    assert stage.nodes <= 3
