"""Arms whose pivot is free and whose initial angle is asked for: only the distance is open."""

from __future__ import annotations

from math import radians, sin
from typing import Any

import pytest

from synthesis import Design, DesignSpec, synthesise
from tests.optimise.arms import ARM, SENSES, angles, body

ROUNDING = 1e-9  # deg


def designed(angle: Any, *limits: dict[str, Any], **more: Any) -> Design:
    question = body(*limits, **more)
    question["follower"]["initial_angle_deg"] = angle
    return synthesise(DesignSpec.model_validate(question))


@pytest.mark.parametrize(
    ("angle", "law"),
    [
        (31.7, "cycloidal"), ({"min": 31.7}, "spline"),
        ({"min": 31.7, "max": 80.3}, "cycloidal"),
    ],
)  # fmt: skip
def test_the_smallest_cam_has_its_axis_across_from_the_arm(angle: Any, law: str) -> None:
    """With the pressure angle not limited: of all pivots the one at a right angle, l sin ψ0."""
    found = designed(angle, law=law)
    assert found.status == "optimal"
    assert found.dimensions["initial_angle_deg"] == pytest.approx(31.7, rel=1e-6)
    least = ARM * sin(radians(31.7))
    assert found.dimensions["prime_radius_mm"] == pytest.approx(least, rel=1e-3)


@pytest.mark.usefixtures("unexplained")
@pytest.mark.parametrize("sense", SENSES)
def test_with_a_pressure_angle_no_distance_has_a_smaller_cam(sense: str) -> None:
    question = {"law": "cycloidal", "sense": sense}
    found = designed(38.3, angles(), **question)
    assert found.certificate.certified
    assert found.dimensions["initial_angle_deg"] == pytest.approx(38.3, abs=ROUNDING)
    best = found.dimensions["centre_distance_mm"]
    for share in (0.95, 1.05):
        other = designed(38.3, angles(), distance=share * best, **question)
        value = other.dimensions["base_radius_mm"]
        assert not other.certificate.certified or value >= found.objectives["base_radius_mm"]


def test_an_angle_above_the_best_costs_no_more_than_it_must() -> None:
    free = designed(None, angles(), law="cycloidal").dimensions["initial_angle_deg"]
    wide = designed({"min": free + 2.0}, angles(), law="cycloidal")
    assert wide.certificate.certified
    assert wide.dimensions["initial_angle_deg"] >= free + 2.0 - ROUNDING
    given = designed(free + 2.0, angles(), law="cycloidal").objectives["base_radius_mm"]
    assert wide.objectives["base_radius_mm"] <= given * (1.0 + 1e-3)
