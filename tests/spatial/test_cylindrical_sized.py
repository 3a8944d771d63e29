"""Cylinders made small: against closed forms, and where undercut decides."""

from __future__ import annotations

import math
from typing import Any

import pytest
from scipy.optimize import brentq

from synthesis.spatial.design import SpatialDesign
from synthesis.spatial.pipeline import synthesise_spatial
from tests.spatial.drums import BACK, LIFT, RISE, SAMPLES, SIZES

RPM, WIDTH = 83.0, SIZES["roller_width_mm"]


def sized(law: str, *limits: dict[str, Any]) -> SpatialDesign:
    """The slide's cam with its cylinder free; the rise is the harder of its two ways."""
    sample = SAMPLES["slide in a groove"]
    steps = [step | ({"law": {"kind": law}} if "law" in step else {})
             for step in sample.body["program"]]  # fmt: skip
    machine = sample.body["machine"] | {"cylinder_radius_mm": {"min": 15.0, "max": 300.0}}
    return synthesise_spatial(
        sample.spec(program=steps, machine=machine, limits=list(limits), speed_rpm=RPM)
    )


def pressure_angle(degrees: float) -> dict[str, Any]:
    return {"kind": "pressure_angle", "max_deg": degrees}


def radius(peak: float, degrees: float) -> float:
    """Of the cylinder, for a rise whose peak velocity is so large: R = w + Cv h/(β tan α)."""
    return WIDTH + peak * LIFT / (math.radians(RISE) * math.tan(math.radians(degrees)))


def test_of_a_given_law_it_is_the_closed_form() -> None:
    found = sized("cycloidal", pressure_angle(27.3))
    assert found.status == "optimal"
    assert found.certificate.lower_bound == pytest.approx(radius(2.0, 27.3), rel=1e-9)
    assert found.certificate.value == pytest.approx(radius(2.0, 27.3), rel=1e-4)


def test_of_a_free_law_it_is_that_of_the_least_velocity_under_the_jerk_cap() -> None:
    """Peak V of a rest-to-rest law under |j| ≤ J: V (1 − 2 √(V/J)) = 1."""
    times = 1.7
    seconds = RISE / (6.0 * RPM)
    jerk = {"kind": "jerk", "max_mm_per_s3": times * 32.0 * LIFT / seconds**3}
    assert (BACK / RISE) ** 3 > 1.7  # the way back needs less of it
    found = sized("spline", pressure_angle(31.9), jerk)
    j = 32.0 * times
    peak = brentq(lambda v: v * (1.0 - 2.0 * math.sqrt(v / j)) - 1.0, 1.0, j / 9.0)
    best = radius(float(peak), 31.9)
    assert found.status == "optimal"
    assert found.certificate.lower_bound is not None
    assert found.certificate.value is not None
    assert found.certificate.lower_bound <= best * (1.0 + 1e-9)
    assert found.certificate.value >= best * (1.0 - 1e-9)
    assert found.certificate.value == pytest.approx(best, rel=1e-3)


def test_where_undercut_decides_the_cylinder_is_as_large_as_it_has_to_be() -> None:
    found = sized("modified_sine", pressure_angle(76.0))
    undercut = next(each for each in found.extremes if each.quantity == "undercut")
    assert found.status == "feasible"
    assert undercut.value is not None
    assert 0.0 < undercut.value < 1e-5
    assert found.certificate.gap is not None
    assert found.certificate.gap > 0.05  # the bound knows the pressure angle only
