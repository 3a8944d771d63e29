"""What splines smoother than C2 cost, against closed forms of the C2 question."""

from __future__ import annotations

from functools import lru_cache
from math import radians, sqrt
from typing import Any

import pytest

from synthesis import Design, DesignSpec, synthesise
from synthesis.design.design import SmoothnessCost
from tests.hard.families import random_scene

LIFT, RISE, RETURN, OMEGA = 17.3, 71.3, 113.7, 7.9
UNIT = LIFT * (OMEGA / radians(RISE)) ** 3


def question(kind: str, smoothness: int, **changes: Any) -> DesignSpec:
    law = {"kind": "spline", "smoothness": smoothness}
    return DesignSpec.model_validate({
        "speed_rpm": OMEGA * 60.0 / radians(360.0),
        "program": [
            {"kind": "rise", "angle_deg": RISE, "lift_mm": LIFT, "law": law},
            {"kind": "dwell", "angle_deg": 37.9},
            {"kind": "return", "angle_deg": RETURN, "lift_mm": LIFT, "law": law},
            {"kind": "dwell", "angle_deg": 137.1},
        ],
        "follower": {"kind": "translating_roller", "roller_radius_mm": 4.1, "offset_mm": 0.0},
        "base_radius_mm": 519.0,
        "objective": {"kind": kind},
        "tolerance": 1e-3,
        "report_smoothness_cost": True,
    } | changes)  # fmt: skip


@lru_cache(maxsize=8)
def designed(kind: str, smoothness: int) -> Design:
    return synthesise(question(kind, smoothness))


def price(kind: str, smoothness: int) -> SmoothnessCost:
    found = designed(kind, smoothness).smoothness_cost
    assert found is not None
    return found


def test_the_least_peak_jerk_costs_more_the_smoother_it_is() -> None:
    """C2: 32 h/β³ exactly; smoother ones need ramps where the best jerk switches."""
    rougher = [price("peak_jerk", smoothness) for smoothness in (3, 4)]
    for found, smoothness in zip(rougher, (3, 4), strict=True):
        assert found.c2_value == pytest.approx(32.0 * UNIT, rel=1e-6)
        assert found.value == designed("peak_jerk", smoothness).certificate.value
        assert found.price == pytest.approx(found.value - found.c2_value, rel=1e-12)
        assert found.relative == pytest.approx(found.value / (32.0 * UNIT) - 1.0, abs=1e-6)
        # the bound of the C2 question is 32 to within the tolerance, and not above it
        assert 0.0 < found.price <= found.at_most <= found.value - 32.0 * UNIT * (1.0 - 1e-3)
    assert rougher[0].price < rougher[1].price
    # uniform quintic splines on eight intervals: 33.3913
    assert rougher[1].value < 33.3913 * UNIT


def test_what_it_costs_at_most_is_counted_from_the_exact_optimum() -> None:
    """Least mean square jerk between rests: 720 h²/β⁵, which the C2 question's bound meets."""
    found = price("rms_jerk", 4)
    slower = RETURN / RISE
    exact = UNIT * sqrt(720.0 * (1.0 + slower**-5) * radians(RISE) / radians(360.0))
    assert found.at_most == pytest.approx(found.value - exact, abs=1e-6 * exact)
    assert exact <= found.c2_value <= exact * 1.001
    # within the tolerance either of the two cams may be the better one
    assert 0.0 <= found.price < found.at_most


def test_of_c2_splines_the_price_is_nothing() -> None:
    found = price("peak_jerk", 2)
    assert (found.price, found.c2_value) == (0.0, found.value)
    assert "no spline smoother" in found.note


def test_it_is_told_only_where_it_is_asked_for() -> None:
    assert (
        synthesise(question("peak_jerk", 3, report_smoothness_cost=False)).smoothness_cost is None
    )


def test_continuity_is_smoothness_too() -> None:
    """A C2 spline that has to be C3 because the whole turn has to."""
    found = synthesise(question("peak_jerk", 2, continuity=3)).smoothness_cost
    assert found is not None
    assert found.price == pytest.approx(price("peak_jerk", 3).price, rel=1e-6)


def test_without_time_left_there_is_no_price() -> None:
    from synthesis.pipeline import synthesise as pipeline

    found = designed("peak_jerk", 3)
    late = pipeline._smoothness_cost(found, question("peak_jerk", 3), stop=0.0)
    assert (late.price, late.c2_value, late.at_most) == (None, None, None)
    assert "time budget" in late.note


@pytest.mark.parametrize(
    ("family", "number", "tolerance"),
    [
        ("slide, all three, splines of class C3", 1, 5e-3),
        ("slide, acceleration, splines of class C3", 22, 2e-2),
    ],
)
def test_where_curvature_binds_c3_laws_make_a_cam_as_small(
    family: str, number: int, tolerance: float
) -> None:
    """A C3 law comes as near to a C2 law as one likes: the infimum of both questions is the same.

    The first is lost where rows that break between their points are given a margin at once, the
    second where the trust region shrinks although new points alone cut a step short.
    """
    body = random_scene(family, number) | {"proof": "quick", "tolerance": tolerance}
    spec = DesignSpec.model_validate(body)
    smooth, rough = (
        synthesise(each).dimensions["base_radius_mm"] for each in (spec, spec.with_c2_splines())
    )
    assert smooth <= rough * 1.002
