"""Rings, grooves and conjugate cams designed: every limit bites on every flank, and truly.

Laws are given, so that the least base radius (or the least distance of the counter roller) is one
number: a hair less must break the limit that is said to bind, by a measure taken from reported
points, and by the certificate of the analysis.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from synthesis import Analysis, Design, DesignSpec, analyse, synthesise
from synthesis.catalogue.profile import cam_profile
from synthesis.errors import InputError
from tests.pipeline.breaches import broken

pytestmark = pytest.mark.usefixtures("coarse_conflicts")

TURN = 2.0 * np.pi
ROLLER = 7.3
THETA = TURN * (np.arange(20_000) + 0.5) / 20_000
GROOVE = {"kind": "groove", "clearance_mm": 0.2}
RING = {"kind": "force", "contact": "inside"}
PAIR = {"kind": "conjugate", "roller_radius_mm": 6.1, "offset_mm": -2.3}
MILD = {"kind": "pressure_angle", "rise_deg": 61.0, "return_deg": 67.0}


def law(inflection: float = 0.5) -> dict[str, Any]:
    return {"kind": "cycloidal", "inflection": inflection}


def spec(closure: dict, *limits: dict, inflection: float = 0.5, **changes: Any) -> DesignSpec:
    steep = any(limit["kind"] == "pressure_angle" for limit in limits)
    body: dict[str, Any] = {
        "speed_rpm": 87.0,
        "program": [
            {"kind": "rise", "angle_deg": 71.0, "lift_mm": 23.7, "law": law(inflection)},
            {"kind": "dwell", "angle_deg": 23.0},
            {"kind": "return", "angle_deg": 64.0, "lift_mm": 23.7, "law": law(1.0 - inflection)},
            {"kind": "dwell", "angle_deg": 202.0},
        ],
        "follower": {
            "kind": "translating_roller", "roller_radius_mm": ROLLER, "offset_mm": 3.9,
            "closure": closure,
        },
        "limits": [*([] if steep else [MILD]), *limits],
        "tolerance": 1e-4,
    }  # fmt: skip
    return DesignSpec.model_validate(body | changes)


def extreme(found: Design | Analysis, limit: str):
    return next(e for e in found.extremes if e.limit == limit)


def points(design: Design, name: str):
    """The flank at dense angles, with what the certificate never saw: the reported radius."""
    follower = design.completed_spec.follower
    flank = next(f for f in follower.flanks if f.name == name)
    return cam_profile(
        design.curve, follower, tuple(design.size), design.rotation, THETA, "right", flank
    )


def given(design: Design, **changes: float) -> DesignSpec:
    """The same machine given in full, with other dimensions."""
    body = design.spec.model_dump(mode="json", exclude_none=True)
    reported = design.dimensions | changes
    body["base_radius_mm"] = reported["base_radius_mm"]
    if "counter_distance_mm" in reported:
        body["follower"]["closure"]["distance_mm"] = reported["counter_distance_mm"]
    return DesignSpec.model_validate(body)


CONVEX = {"kind": "profile_radius", "min_mm": 8.9}
WHEEL = {"kind": "cutter_radius", "radius_mm": 60.0}
SHAPES = {
    "convex ring": (RING, CONVEX, "profile_radius", "", 0.5),
    "wheel in a ring": (RING, WHEEL, "cutter_radius", "", 0.5),
    "convex inner flank": (GROOVE, CONVEX, "profile_radius_inner", "inner", 0.7),
    "convex outer flank": (GROOVE, CONVEX, "profile_radius_outer", "outer", 0.3),
    "wheel in an inner flank": (
        GROOVE, {"kind": "cutter_radius", "radius_mm": 44.0}, "cutter_radius_inner", "inner", 0.25,
    ),
    "wheel in an outer flank": (GROOVE, WHEEL, "cutter_radius_outer", "outer", 0.5),
}  # fmt: skip


@pytest.mark.parametrize("scene", SHAPES)
def test_a_limit_of_shape_bites_on_its_flank(scene: str) -> None:
    closure, limit, name, flank, inflection = SHAPES[scene]
    without = synthesise(spec(closure, inflection=inflection, tolerance=1e-2))
    design = synthesise(spec(closure, limit, inflection=inflection, tolerance=1e-3))
    assert design.certificate.certified
    assert design.dimensions["base_radius_mm"] > without.dimensions["base_radius_mm"] * 1.005
    binding = extreme(design, name)
    assert 0.0 <= binding.margin <= 1e-6 * binding.bound
    # from points: positive radii are the material's convex ones, negative its hollows
    radius = points(design, flank).radius
    hollow = limit["kind"] == "cutter_radius"
    sharpest = -np.max(radius[radius < 0.0]) if hollow else np.min(radius[radius > 0.0])
    assert sharpest == pytest.approx(binding.value, rel=1e-5)
    smaller = given(design, base_radius_mm=design.dimensions["base_radius_mm"] * (1.0 - 1e-5))
    assert broken(smaller) == [name]


@pytest.mark.parametrize(
    ("closure", "flank", "rim"), [(RING, "", 0.0), (GROOVE, "outer", 0.0), (GROOVE, "outer", 5.7)]
)
def test_the_outer_radius_is_the_outer_flank_s_and_its_rim(closure, flank, rim) -> None:
    limit = {"kind": "outer_radius", "max_mm": 80.0}
    design = synthesise(
        spec(closure | {"rim_mm": rim}, limit, objective={"kind": "peak_pressure_angle"})
    )
    binding = extreme(design, "outer_radius")
    assert design.certificate.certified
    assert binding.value == pytest.approx(80.0, rel=1e-6)
    p = points(design, flank)
    assert np.max(np.hypot(p.x, p.y)) + rim == pytest.approx(binding.value, rel=1e-7)


COUNTERS = {
    "rises": ({"kind": "pressure_angle", "rise_deg": 29.0, "return_deg": 61.0},
              "pressure_angle_rise_counter"),
    "returns": ({"kind": "pressure_angle", "rise_deg": 61.0, "return_deg": 31.0},
                "pressure_angle_return_counter"),
    "dwells": ({"kind": "pressure_angle", "dwell_deg": 5.5}, "pressure_angle_dwell_counter"),
    "convex": ({"kind": "profile_radius", "min_mm": 14.9}, "profile_radius_counter"),
    "wheel": ({"kind": "cutter_radius", "radius_mm": 58.0}, "cutter_radius_counter"),
    "base": ({"kind": "counter_base_radius", "min_mm": 33.3}, "counter_base_radius"),
}  # fmt: skip


@pytest.mark.parametrize("scene", COUNTERS)
def test_the_counter_roller_stands_no_farther_than_a_limit_of_its_cam_asks(scene: str) -> None:
    limit, name = COUNTERS[scene]
    question = spec(PAIR, limit, base_radius_mm=64.0)
    design = synthesise(question)
    assert design.certificate.certified, [e for e in design.extremes if not e.holds]
    assert design.spec == question
    binding = extreme(design, name)
    assert 0.0 <= binding.margin <= 1e-5 * abs(binding.bound), binding
    nearer = design.dimensions["counter_distance_mm"] * (1.0 - 1e-4)
    assert broken(given(design, counter_distance_mm=nearer)) == [name]
    same = analyse(given(design))
    assert same.holds, same.broken
    assert same.dimensions["counter_distance_mm"] == design.dimensions["counter_distance_mm"]


def test_the_distance_does_not_weigh_on_the_main_cam() -> None:
    alone = synthesise(spec({"kind": "force"}))
    pair = synthesise(spec(PAIR))
    assert pair.size == alone.size
    assert pair.certificate.lower_bound == alone.certificate.lower_bound
    assert pair.id != alone.id


def test_a_range_that_ends_too_early_reshapes_the_main_cam() -> None:
    free = {"program": [
        {"kind": "rise", "angle_deg": 71.0, "lift_mm": 23.7},
        {"kind": "dwell", "angle_deg": 23.0},
        {"kind": "return", "angle_deg": 64.0, "lift_mm": 23.7},
        {"kind": "dwell", "angle_deg": 202.0},
    ]}  # fmt: skip
    limits = (
        {"kind": "pressure_angle", "rise_deg": 29.0, "return_deg": 33.0},
        {"kind": "jerk", "max_mm_per_s3": 48.0 * 23.7 * (87.0 * np.pi / 30.0) ** 3},
    )
    open_ = synthesise(spec(PAIR, *limits, **free, tolerance=5e-3))
    most = open_.dimensions["counter_distance_mm"] - 2.5
    near = synthesise(spec(PAIR | {"distance_mm": {"max": most}}, *limits, **free, tolerance=5e-3))
    assert near.certificate.certified
    assert near.dimensions["counter_distance_mm"] <= most * (1.0 + 1e-12)
    assert near.dimensions["base_radius_mm"] > open_.dimensions["base_radius_mm"]
    assert near.certificate.lower_bound <= near.dimensions["base_radius_mm"]
    assert extreme(near, "counter_distance").bound == most


@pytest.mark.parametrize(
    ("end", "base", "status"),
    [("", 64.0, "infeasible"), ("/max", None, "unsolved")],  # a range is not proven
)
def test_a_conflict_says_how_far_the_counter_roller_would_have_to_be(
    end: str, base: float | None, status: str, explain_only: Callable[[str], None]
) -> None:
    field = f"follower/closure/distance_mm{end}"
    explain_only(field)

    def designed(distance: float | None) -> Design:
        place = distance if distance is None or not end else {"max": distance}
        limit = {"kind": "pressure_angle", "rise_deg": 29.0, "return_deg": 61.0}
        return synthesise(spec(PAIR | {"distance_mm": place}, limit, base_radius_mm=base))

    enough = designed(None).dimensions["counter_distance_mm"]
    refused = designed(0.8 * enough)
    assert refused.status == status
    (reported,) = (r for r in refused.conflict.relaxations if r.limit == "counter_distance")
    assert reported.field == field
    assert reported.requested == pytest.approx(0.8 * enough)
    assert 0.8 * enough < reported.needed <= enough * (1.0 + 1e-6)
    assert designed(reported.needed).certificate.certified


def test_a_range_on_the_wrong_side_of_the_axis_fits_nothing(
    explain_only: Callable[[str], None],
) -> None:
    explain_only("follower/closure/distance_mm/max")
    refused = synthesise(spec(PAIR | {"distance_mm": {"max": 21.0}}, base_radius_mm=64.0))
    assert refused.status == "infeasible"
    assert refused.dimensions.get("counter_distance_mm", 21.0) == 21.0
    assert any(r.limit == "counter_distance" for r in refused.conflict.relaxations)


def test_the_peak_pressure_angle_is_that_of_both_cams() -> None:
    objective = {"kind": "peak_pressure_angle"}
    design = synthesise(spec(PAIR, base_radius_mm=64.0, objective=objective))
    both = max(
        np.max(abs(np.degrees(points(design, name).pressure_angle[abs(speed) > 0.0])))
        for name in ("main", "counter")
        for speed in [design.curve.derivatives(THETA)[1]]
    )
    assert design.objectives["peak_pressure_angle_deg"] == pytest.approx(both, rel=1e-6)


@pytest.mark.usefixtures("unexplained")
def test_an_outer_radius_brings_the_counter_roller_nearer() -> None:
    loose = synthesise(spec(PAIR, {"kind": "outer_radius", "max_mm": 400.0}))
    assert extreme(loose, "outer_radius_counter").holds
    assert extreme(loose, "outer_radius_main").holds
    p = points(loose, "counter")
    largest = np.max(np.hypot(p.x, p.y))
    assert largest == pytest.approx(extreme(loose, "outer_radius_counter").value, rel=1e-7)
    tight = synthesise(spec(PAIR, {"kind": "outer_radius", "max_mm": 0.8 * largest}))
    assert tight.status == "infeasible"  # with these laws given, the pressure angle forbids it
    assert tight.conflict is not None


@pytest.mark.usefixtures("unmended")
def test_undercut_names_its_flank_and_angle() -> None:
    question = spec(GROOVE, inflection=0.3, base_radius_mm=8.0)
    found = analyse(question)
    assert found.undercut is not None
    assert found.undercut.flank == "outer"
    assert {"profile_radius_inner", "profile_radius_outer"} & set(found.violated)
    broken = extreme(found, "profile_radius_outer")
    assert not broken.holds
    assert found.undercut.angle_deg == pytest.approx(broken.angle_deg, abs=1e-6)
    assert found.undercut.pitch_radius_mm < ROLLER + 0.1


def test_a_ring_s_curves_are_told_as_its_material_sees_them() -> None:
    question = spec(RING, base_radius_mm=58.0)
    found = analyse(question)
    reported = {curve.curve: curve for curve in found.curves if curve.over == "turn"}
    size = (3.9, float(np.sqrt((58.0 - ROLLER) ** 2 - 3.9**2)))
    p = cam_profile(synthesise(question).curve, question.follower, size, "ccw", THETA)
    hollow, convex = -np.max(p.radius[p.radius < 0.0]), np.min(p.radius[p.radius > 0.0])
    assert reported["hollow_radius"].smallest.value == pytest.approx(hollow, rel=1e-6)
    assert reported["convex_radius"].smallest.value == pytest.approx(convex, rel=1e-5)
    assert found.dimensions["prime_radius_mm"] == pytest.approx(58.0 - ROLLER)


@pytest.mark.parametrize(
    ("closure", "changes", "error"),
    [
        (GROOVE, {"roller_radius_mm": 0.0}, "groove_needs_roller"),
        ({"kind": "force", "rim_mm": 3.0}, {}, "rim_without_ring"),
        (RING, {"roller_radius_mm": 70.0}, "roller_fills_ring"),
    ],
)
def test_what_makes_no_sense_is_refused(closure, changes, error) -> None:
    body = spec({"kind": "force"}, base_radius_mm=60.0).model_dump(mode="json", exclude_none=True)
    body["follower"] |= {"closure": closure, **changes}
    with pytest.raises(ValueError, match=error):
        DesignSpec.model_validate(body)


def test_an_analysis_asks_for_the_counter_roller_s_place() -> None:
    with pytest.raises(InputError, match="/follower/closure/distance_mm"):
        analyse(spec(PAIR, base_radius_mm=64.0))


@pytest.mark.usefixtures("unexplained")
def test_a_ring_smaller_than_its_roller_fits_nowhere() -> None:
    with pytest.raises(ValueError, match="outer_radius_too_small"):
        spec(RING, {"kind": "outer_radius", "max_mm": 7.2})
    refused = synthesise(spec(RING, {"kind": "outer_radius", "max_mm": 9.1}))
    assert refused.status == "infeasible"
    assert refused.conflict is not None


def test_a_counter_base_radius_suits_conjugate_cams_only() -> None:
    with pytest.raises(ValueError, match="limit_does_not_suit"):
        spec(GROOVE, {"kind": "counter_base_radius", "min_mm": 10.0})
