"""Arms whose pressure angle is not limited: the smallest cam has its arm on the line of centres.

There the prime radius is |l − d|, plain geometry, and nothing drives the arm any more: it is come
near to, and not reached.
"""

from __future__ import annotations

from math import radians
from typing import Any

import pytest

from synthesis import Design, synthesise
from tests.optimise.arms import ARM, OMEGA, RISE, SENSES, SWING, scene

OUT_OF_THE_WAY = {"min": 112.7, "max": 140.1}


def sized(distance: Any, sense: str = "same", **more: Any) -> Design:
    design = synthesise(scene(distance=distance, sense=sense, law="cycloidal", **more))
    assert design.certificate.certified
    assert design.status == "optimal"
    return design


@pytest.mark.parametrize("distance", [117.3, 171.9, OUT_OF_THE_WAY, {"min": 112.7}])
def test_the_roller_comes_as_near_to_the_axis_as_the_arm_lets_it(distance: Any) -> None:
    found = sized(distance).dimensions
    nearest = distance["min"] if isinstance(distance, dict) else distance
    assert found["prime_radius_mm"] == pytest.approx(abs(nearest - ARM), rel=2e-8)
    assert found["centre_distance_mm"] == pytest.approx(nearest, rel=1e-9)
    assert 0.0 < found["initial_angle_deg"] < 0.01


def test_a_base_radius_asked_for_decides_where_it_is_larger() -> None:
    found = sized(OUT_OF_THE_WAY, base_radius_mm={"min": 41.3}).dimensions
    assert found["base_radius_mm"] == pytest.approx(41.3, rel=1e-6)
    assert found["centre_distance_mm"] >= OUT_OF_THE_WAY["min"]


@pytest.mark.parametrize("sense", SENSES)
def test_the_least_distance_takes_nothing_from_a_bound_over_all_laws(sense: str) -> None:
    """Peak jerk of two free laws: 32 h/β³ of the faster one, whatever the pivot."""
    question = {
        "objective": {"kind": "peak_jerk"},
        "base_radius_mm": {"max": 60.0},
        "tolerance": 5e-3,
    }
    design = synthesise(scene(distance=OUT_OF_THE_WAY, sense=sense, **question))
    exact = 32.0 * SWING / radians(RISE) ** 3 * OMEGA**3
    assert design.status == "optimal"
    assert design.objectives["peak_jerk_deg_per_s3"] == pytest.approx(exact, rel=5e-3)
    assert design.certificate.lower_bound == pytest.approx(exact, rel=1e-3)
    assert design.dimensions["centre_distance_mm"] >= OUT_OF_THE_WAY["min"] * (1.0 - 1e-9)
