"""What is left free of a spatial cam is chosen, proven and measured; what cannot be says why."""

from __future__ import annotations

import math
from typing import Any

import pytest
from pydantic import ValidationError
from scipy.optimize import brentq

from synthesis.machines.spatial.design import SpatialDesign
from synthesis.machines.spatial.pipeline import synthesise_spatial
from synthesis.machines.spatial.spec import SpatialCamSpec
from tests.machines.spatial.sizes import INNER, TURN, WIDTH, globoidal, jerk, pressure_angle

CYCLOIDAL = {"kind": "cycloidal"}


def designed(body: dict[str, Any]) -> SpatialDesign:
    return synthesise_spatial(SpatialCamSpec.model_validate(body))


@pytest.fixture(scope="module")
def sized() -> SpatialDesign:
    """Law and centre distance free; rollers small enough for walls to have no say."""
    return designed(globoidal(pressure_angle(44.3), jerk(1.6), hand="left"))


@pytest.fixture(scope="module")
def bulging() -> SpatialDesign:
    """Large rollers: how walls bulge decides, and how round they may be."""
    limits = (pressure_angle(51.0), jerk(2.9), {"kind": "wall_radius", "min_mm": 2.3})
    return designed(globoidal(*limits, roller_radius_mm=17.9) | {"tolerance": 0.01})


def extreme(found: SpatialDesign, quantity: str) -> Any:
    return next(each for each in found.extremes if each.quantity == quantity)


def test_law_and_centre_distance_come_out_together_with_their_proof(sized: SpatialDesign) -> None:
    proof = sized.certificate
    assert sized.status == "optimal"
    assert proof.certified
    assert proof.objective == "centre_distance_mm"
    assert proof.value == sized.dimensions["centre_distance_mm"]
    assert proof.lower_bound is not None
    assert proof.value is not None
    assert proof.gap is not None
    assert 0.0 < proof.gap <= 1e-3
    assert proof.gap == pytest.approx(1.0 - proof.lower_bound / proof.value)
    assert "all motion laws" in proof.bound_valid_for
    assert extreme(sized, "pressure_angle").value == pytest.approx(44.3, abs=0.01)
    assert extreme(sized, "pressure_angle").field == "limits/0/max_deg"
    assert extreme(sized, "jerk").holds


def test_the_law_is_told_to_the_last_digit(sized: SpatialDesign) -> None:
    again = SpatialDesign.model_validate_json(sized.model_dump_json())
    assert again.motion[0].spline is not None
    q, q1 = again.curve.derivatives([math.radians(TURN)], 1, "left")[:, 0]
    assert q == pytest.approx(math.radians(60.0), rel=1e-12)
    assert abs(q1) < 1e-9
    assert again.cam.sizes == {
        name: sized.dimensions[name] for name in sized.spec.machine.size_fields
    }


def test_no_law_of_the_books_needs_less_room(sized: SpatialDesign) -> None:
    given = designed(globoidal(pressure_angle(44.3), law=CYCLOIDAL, hand="left"))
    slope, beta = math.tan(math.radians(44.3)), math.radians(TURN)
    expected = (INNER + WIDTH) * (1.0 + 2.0 * math.radians(60.0) / (beta * slope))
    assert given.dimensions["centre_distance_mm"] == pytest.approx(expected, rel=3e-5)
    assert given.status == "optimal"
    assert sized.dimensions["centre_distance_mm"] < 0.93 * expected


def test_walls_that_bulge_bend_the_law(bulging: SpatialDesign) -> None:
    assert bulging.certificate.certified
    assert 2.3 < extreme(bulging, "convex_radius").value < 2.33
    assert bulging.certificate.gap is not None
    assert 0.0 < bulging.certificate.gap < 0.01
    # the law that is best for the pressure angle alone was not it
    assert [stage.stage for stage in bulging.report.stages].count("fastest run") == 2


def test_rollers_are_as_near_as_ribs_let_them_and_as_large_as_walls(sized: SpatialDesign) -> None:
    rib = {"kind": "rib_thickness", "min_mm": 9.1}
    found = designed(globoidal(
        pressure_angle(44.3), rib, law=CYCLOIDAL,
        roller_radius_mm={"min": 9.7, "max": 23.0}, roller_inner_mm={"min": 20.0},
    ))  # fmt: skip
    assert found.status in ("optimal", "feasible")
    assert extreme(found, "rib_thickness").value >= 9.1 - 1e-6
    inner = found.dimensions["roller_inner_mm"]
    # at rest, from a contact to the next roller: 2 (ρ sin a − Rr cos a) cos a
    rest = 2.0 * (inner * 0.5 - 9.7 * math.sqrt(0.75)) * math.sqrt(0.75)
    assert inner == 20.0 or rest == pytest.approx(9.1, rel=1e-3)
    larger = designed(globoidal(
        pressure_angle(44.3), law=CYCLOIDAL, roller_radius_mm={"max": 31.0},
    ))  # fmt: skip
    assert 11.2 < larger.dimensions["roller_radius_mm"] <= 31.0
    assert larger.certificate.certified


def test_rollers_grow_only_as_far_as_ribs_in_motion_let_them() -> None:
    rib = {"kind": "rib_thickness", "min_mm": 6.0}
    found = designed(globoidal(
        pressure_angle(45.0), rib, law=CYCLOIDAL,
        roller_radius_mm=None, roller_inner_mm={"min": 50.0, "max": 90.0},
    ))  # fmt: skip
    assert found.status == "optimal"
    assert 6.0 <= extreme(found, "rib_thickness").value < 6.1


def test_what_cannot_be_says_what_is_in_the_way_and_what_would_do(sized: SpatialDesign) -> None:
    least = sized.dimensions["centre_distance_mm"]
    question = globoidal(
        pressure_angle(44.3), law=CYCLOIDAL, centre_distance_mm={"max": 0.9 * least},
    )  # fmt: skip
    found = designed(question)
    assert found.status == "infeasible"
    assert found.conflict is not None
    needed = {each.field: each.needed for each in found.conflict.relaxations}
    enough = needed["machine/centre_distance_mm/max"]
    assert enough is not None
    assert "centre distance" in " ".join(found.conflict.limits)
    again = designed(
        question | {"machine": question["machine"] | {"centre_distance_mm": {"max": enough}}}
    )
    assert again.status == "optimal"
    assert again.dimensions["centre_distance_mm"] > 0.995 * enough


def cylinder(law: dict[str, Any], **machine: Any) -> dict[str, Any]:
    """A slide that goes 41.3 mm out in 113° and back in 97°; the cylinder's radius left free."""
    move = {"lift_mm": 41.3, "law": law}
    return {
        "speed_rpm": 60.0,
        "program": [
            {"kind": "rise", "angle_deg": 113.0} | move, {"kind": "dwell", "angle_deg": 70.0},
            {"kind": "return", "angle_deg": 97.0} | move, {"kind": "dwell", "angle_deg": 80.0},
        ],
        "machine": {"kind": "cylindrical_translating", "roller_radius_mm": 9.3,
                    "roller_width_mm": 14.7} | machine,
        "limits": [pressure_angle(34.1)],
    }  # fmt: skip


def test_a_cylinder_is_as_small_as_its_pressure_angle_lets_it() -> None:
    beta, slope = math.radians(97.0), math.tan(math.radians(34.1))
    given = designed(cylinder(CYCLOIDAL))
    expected = 14.7 + 2.0 * 41.3 / (beta * slope)
    assert given.dimensions["cylinder_radius_mm"] == pytest.approx(expected, rel=3e-5)
    free = cylinder({"kind": "spline"})
    cap = 1.35 * 32.0 * 41.3 / (97.0 / 360.0) ** 3
    free["limits"].append({"kind": "jerk", "max_mm_per_s3": cap})
    found = designed(free)
    # least peak velocity under that cap: V (1 − 2 √(V/J)) = 1
    peak = brentq(lambda v: v * (1.0 - 2.0 * math.sqrt(v / (1.35 * 32.0))) - 1.0, 1.0, 4.79)
    best = 14.7 + peak * 41.3 / (beta * slope)
    assert found.status == "optimal"
    assert found.certificate.lower_bound is not None
    assert found.certificate.lower_bound <= best <= found.dimensions["cylinder_radius_mm"]
    assert found.dimensions["cylinder_radius_mm"] < 1.001 * best


def test_under_an_arm_a_free_law_needs_a_smaller_cylinder_than_a_given_one() -> None:
    arm = {"kind": "cylindrical_oscillating", "arm_mm": 107.0, "pivot_distance_mm": 105.0,
           "initial_angle_deg": -9.3, "roller_radius_mm": 9.3, "roller_width_mm": 14.7}  # fmt: skip
    bodies = [cylinder(law) | {"machine": arm} for law in (CYCLOIDAL, {"kind": "spline"})]
    for body in bodies:
        for segment in body["program"]:
            if segment.pop("lift_mm", None):
                segment["lift_deg"] = 23.1
    bodies[1]["limits"].append({"kind": "acceleration", "max_deg_per_s2": 23.1 * 6.5 / 0.2694**2})
    given, free = (designed(body) for body in bodies)
    for found in (given, free):
        assert found.certificate.certified
        assert extreme(found, "pressure_angle").value == pytest.approx(34.1, abs=0.01)
        assert found.certificate.lower_bound is not None
        assert found.certificate.lower_bound <= found.dimensions["cylinder_radius_mm"]
    assert free.certificate.gap is not None
    assert free.certificate.gap < 0.01
    assert free.dimensions["cylinder_radius_mm"] < 0.9 * given.dimensions["cylinder_radius_mm"]


@pytest.mark.parametrize(("changes", "error"), [
    ({"limits": []}, "nothing_keeps_large"),
    ({"objective": {"kind": "cylinder_radius"}}, "objective_does_not_suit"),
    ({"limits": [{"kind": "velocity", "max_mm_per_s": 100.0}]}, "limit_unit_does_not_suit"),
    ({"machine": {"roller_radius_mm": None, "roller_inner_mm": None}}, "rollers_vanish"),
    ({"machine": {"crown_radius_mm": 160.0, "roller_radius_mm": {"max": 20.0}}}, "rollers_vanish"),
    ({"machine": {"crown_radius_mm": 30.0}, "limits": [pressure_angle(22.0)]}, "crown_leans"),
])  # fmt: skip
def test_questions_without_an_answer_are_refused(changes: dict[str, Any], error: str) -> None:
    body = globoidal(pressure_angle(40.0))
    machine = body["machine"] | changes.get("machine", {})
    with pytest.raises(ValidationError) as refused:
        SpatialCamSpec.model_validate(body | changes | {"machine": machine})
    assert error in [each["type"] for each in refused.value.errors()]
