"""Rollers on an arm in grooves, in rings and with a counter arm: measured against dense points."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from synthesis import Analysis, Design, DesignSpec, analyse, synthesise
from synthesis.catalogue.profile import cam_profile
from tests.pipeline.breaches import broken

THETA = 2.0 * np.pi * (np.arange(20_000) + 0.5) / 20_000
PAIR = {"kind": "conjugate", "roller_radius_mm": 11.3, "arm_mm": 71.9}
CLOSURES: dict[str, dict[str, Any]] = {
    "ring": {"kind": "force", "contact": "inside"},
    "groove": {"kind": "groove", "clearance_mm": 0.12},
    "pair": PAIR | {"angle_deg": 97.3},
}
LIMITS = [
    {"kind": "pressure_angle", "rise_deg": 70.0, "return_deg": 71.0},
    {"kind": "profile_radius", "min_mm": 1.0},
    {"kind": "cutter_radius", "radius_mm": 35.0},
    {"kind": "outer_radius", "max_mm": 140.0},
]


def spec(closure: dict, sense: str = "opposite", limits: list = LIMITS) -> DesignSpec:
    return DesignSpec.model_validate(
        {
            "program": [
                {"kind": "rise", "angle_deg": 83.0, "lift_deg": 18.7, "law": {"kind": "cycloidal"}},
                {"kind": "dwell", "angle_deg": 37.0},
                {"kind": "return", "angle_deg": 121.0, "lift_deg": 18.7,
                 "law": {"kind": "modified_sine"}},
                {"kind": "dwell", "angle_deg": 119.0},
            ],
            "follower": {
                "kind": "oscillating_roller", "roller_radius_mm": 9.7, "arm_mm": 83.1,
                "centre_distance_mm": 107.9, "sense": sense, "pivot_direction_deg": 21.0,
                "closure": closure,
            },
            "base_radius_mm": 61.7,
            "limits": limits,
        }
    )  # fmt: skip


def extreme(found: Design | Analysis, limit: str):
    return next(e for e in found.extremes if e.limit == limit)


@pytest.mark.parametrize("sense", ["opposite", "same"])
@pytest.mark.parametrize("closure", CLOSURES)
def test_every_claim_is_what_dense_points_show(closure: str, sense: str) -> None:
    question = spec(CLOSURES[closure], sense)
    found, design = analyse(question), synthesise(question)
    assert design.dimensions["base_radius_mm"] == pytest.approx(61.7)
    follower = question.follower
    for flank in follower.flanks:
        p = cam_profile(design.curve, follower, tuple(design.size), "ccw", THETA, "right", flank)
        label = f"_{flank.name}" if flank.name else ""
        convex = np.min(p.radius[p.radius > 0.0], initial=np.inf)
        reported = extreme(found, f"profile_radius{label}").value
        if reported is not None and reported > 0.0 and np.isfinite(convex):
            assert reported == pytest.approx(convex, rel=1e-4)
        if np.any(p.radius < -flank.distance):
            hollow = -np.max(p.radius[p.radius < -flank.distance])
            assert extreme(found, f"cutter_radius{label}").value == pytest.approx(hollow, rel=1e-4)
        path = f"_{flank.path}" if flank.path else ""
        rising = np.radians(83.0) > THETA
        steepest = np.degrees(np.max(abs(p.pressure_angle[rising])))
        reported = abs(extreme(found, f"pressure_angle_rise{path}").value)
        assert reported == pytest.approx(steepest, abs=1e-5)
    edge = cam_profile(
        design.curve, follower, tuple(design.size), "ccw", THETA, "right", follower.flanks[-1]
    )
    path = f"_{follower.flanks[-1].path}" if follower.flanks[-1].path else ""
    largest = np.max(np.hypot(edge.x, edge.y))
    assert extreme(found, f"outer_radius{path}").value == pytest.approx(largest, rel=1e-7)


@pytest.mark.parametrize("sense", ["opposite", "same"])
@pytest.mark.parametrize(
    ("limit", "name"),
    [
        ({"kind": "pressure_angle", "rise_deg": 37.0, "return_deg": 60.0},
         "pressure_angle_rise_counter"),
        ({"kind": "counter_base_radius", "min_mm": 47.7}, "counter_base_radius"),
        ({"kind": "profile_radius", "min_mm": 22.7}, "profile_radius_counter"),
    ],
)  # fmt: skip
def test_the_angle_between_the_arms_is_no_larger_than_a_limit_asks(limit, name, sense) -> None:
    rest = [{"kind": "pressure_angle", "rise_deg": 70.0, "return_deg": 71.0}]
    limits = [limit] if limit["kind"] == "pressure_angle" else [limit, *rest]
    design = synthesise(spec(PAIR, sense, limits))
    mine = {e.limit: e for e in design.extremes if "counter" in e.limit}
    assert all(e.holds for e in mine.values()), [e for e in mine.values() if not e.holds]
    assert abs(mine[name].margin) <= 1e-4 * abs(mine[name].bound)
    angle = design.dimensions["counter_angle_deg"]
    assert name in broken(spec(PAIR | {"angle_deg": angle * (1.0 - 1e-4)}, sense, limits))


def test_a_range_of_angles_that_ends_too_early_is_told_with_what_would_do(
    explain_only: Callable[[str], None],
) -> None:
    explain_only("follower/closure/angle_deg/max")
    limits = [{"kind": "pressure_angle", "rise_deg": 37.0, "return_deg": 60.0}]
    enough = synthesise(spec(PAIR, "opposite", limits)).dimensions["counter_angle_deg"]
    most = 0.9 * enough
    refused = synthesise(spec(PAIR | {"angle_deg": {"max": most}}, "opposite", limits))
    assert refused.status == "infeasible"
    assert refused.dimensions["counter_angle_deg"] <= most
    (reported,) = [r for r in refused.conflict.relaxations if r.limit == "counter_angle"]
    assert reported.field == "follower/closure/angle_deg/max"
    assert (reported.requested, reported.unit) == (most, "deg")
    assert most < reported.needed <= enough * (1.0 + 1e-6)
    given = {"angle_deg": {"max": reported.needed}}
    assert synthesise(spec(PAIR | given, "opposite", limits)).certificate.certified


@pytest.mark.parametrize("closure", ["ring", "groove", "pair"])
def test_arms_are_sized_together_with_their_law_and_their_closure(closure: str) -> None:
    body = spec(CLOSURES[closure] | ({"angle_deg": None} if closure == "pair" else {}))
    moves = [
        segment | ({"law": {"kind": "spline"}} if segment["kind"] != "dwell" else {})
        for segment in body.model_dump(mode="json", exclude_none=True)["program"]
    ]
    question = body.model_dump(mode="json", exclude_none=True) | {
        "program": moves, "base_radius_mm": None, "speed_rpm": 120.0, "tolerance": 1e-2,
        "proof": "quick",
        "limits": [
            {"kind": "pressure_angle", "rise_deg": 36.0, "return_deg": 37.0},
            {"kind": "jerk", "max_deg_per_s3": 2.1e6},
            {"kind": "profile_radius", "min_mm": 2.0},
        ],
    }  # fmt: skip
    design = synthesise(DesignSpec.model_validate(question))
    assert design.certificate.certified, [e for e in design.extremes if not e.holds]
    assert design.certificate.lower_bound <= design.dimensions["base_radius_mm"]
    follower, z = design.completed_spec.follower, tuple(design.size)
    for flank in follower.flanks:
        p = cam_profile(design.curve, follower, z, "ccw", THETA, "right", flank)
        assert np.min(p.radius[p.radius > 0.0], initial=np.inf) >= 2.0 * (1.0 - 1e-6)
        moving = abs(p.s[1]) > 0.0
        assert np.degrees(np.max(abs(p.pressure_angle[moving]))) <= 37.0 * (1.0 + 1e-6)
        assert not np.any((p.radius < 0.0) & (p.radius > -flank.distance))
